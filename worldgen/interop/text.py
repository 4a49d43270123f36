"""Plain text drawings: a character a cell, as many generators print their mazes."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import numpy.typing as npt

from worldgen.errors import FormatError
from worldgen.interop.foreign_map import ForeignMap, check_sides, digest, read_bounded, shown
from worldgen.interop.format import Format
from worldgen.lattice import UNIT, lattice_to_metres
from worldgen.rows import flip_rows
from worldgen.world import DEFAULT_CELL_SIZE, Value

__all__ = ["cell_centre", "read_text_map", "text"]

_SOLID, _FREE, _START, _TARGET = b"#", b". ", b"S", b"GE"
_BAD = 2
_TABLE = np.full(256, _BAD, np.uint8)
_TABLE[list(_FREE + _START + _TARGET)] = 0
_TABLE[list(_SOLID)] = 1


def read_text_map(path: Path, *, cell_size: float = DEFAULT_CELL_SIZE) -> ForeignMap:
    """A drawing: ``#`` solid, ``.`` or space free, ``S`` the start, ``G`` or ``E`` the target; the top row first.

    The start is its cell's centre, the target the disc inscribed in its cell.

    Args:
        path: The file; LF or CRLF.
        cell_size: Side of a cell, m.

    Raises:
        FormatError: If rows differ in length, a character is none of these, or a place is there twice.
    """
    data, source = read_bounded(path), str(path)
    rows = [row.removesuffix(b"\r") for row in data.split(b"\n")]
    while rows and not rows[-1]:
        rows.pop()
    check_sides(len(rows[0]) if rows else 0, len(rows), line=1, source=source)
    for number, row in enumerate(rows, 1):
        if len(row) != len(rows[0]):
            raise FormatError(
                f"a row of {len(row)} cells; the first has {len(rows[0])}; every row has that many",
                line=number,
                source=source,
            )
    drawn = np.frombuffer(b"".join(rows), np.uint8).reshape(len(rows), -1)
    cells = _TABLE[drawn]
    if (cells == _BAD).any():
        row_index, column = divmod(int(np.argmax(cells == _BAD)), cells.shape[1])
        raise FormatError(
            f"{shown(rows[row_index][column : column + 1])} in column {column + 1} is no cell; "
            "# is solid, . or a space free, S the start, G or E the target",
            line=row_index + 1,
            source=source,
        )
    start = _place(drawn, _START, "start", cell_size, source)
    target = _place(drawn, _TARGET, "target", cell_size, source)
    params: dict[str, Value] = {"format": "text", "source": path.name, "sha256": digest(data)}
    return ForeignMap(
        flip_rows(cells == 1),
        cell_size,
        params,
        start=None if start is None else (*start, 0.0),
        target=None if target is None else (*target, lattice_to_metres(UNIT // 2, cell_size)),
    )


def cell_centre(column: int, row: int, cell_size: float) -> tuple[float, float]:
    """Centre of a cell, m; row 0 is the lowest."""
    half = UNIT // 2
    return lattice_to_metres(column * UNIT + half, cell_size), lattice_to_metres(row * UNIT + half, cell_size)


def _place(
    drawn: npt.NDArray[np.uint8], letters: bytes, name: str, cell_size: float, source: str
) -> tuple[float, float] | None:
    found = np.argwhere(np.isin(drawn, list(letters)))
    if len(found) > 1:
        raise FormatError(
            f"{len(found)} cells are the {name}; draw one, or none", line=int(found[1][0]) + 1, source=source
        )
    if not len(found):
        return None
    row, column = (int(index) for index in found[0])
    return cell_centre(column, drawn.shape[0] - 1 - row, cell_size)


text = Format(
    "text",
    "drawing with a character a cell, .txt",
    (".txt",),
    re.compile(rb"[ .SGE]*#[# .SGE]*\r?\n[# .SGE]+(\r?\n|\Z)"),
    read_text_map,
    holds=frozenset({"start", "heading", "target", "target_radius"}),
    client="people",
)
