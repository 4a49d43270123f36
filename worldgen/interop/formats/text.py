"""Plain text drawings, one character per cell, as many generators print their mazes."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from worldgen.errors import FormatError
from worldgen.interop.format import Destination, Exported, Format
from worldgen.interop.format.foreign_map import (
    ForeignMap,
    ForeignRobot,
    check_sides,
    read_bounded,
    unix_text,
)
from worldgen.lattice import UNIT, in_cells, lattice_to_metres
from worldgen.support.arrays import Bytes
from worldgen.support.rows import flip_rows
from worldgen.world import DEFAULT_CELL_SIZE, World

_SOLID = b"#"
_FREE = b". "
_START = b"S"
_TARGET = b"GE"
_BAD = 2
_TABLE = np.full(256, _BAD, np.uint8)
_TABLE[list(_FREE + _START + _TARGET)] = 0
_TABLE[list(_SOLID)] = 1


def read_text_map(path: Path, *, cell_size: float = DEFAULT_CELL_SIZE) -> ForeignMap:
    """Read a drawing: ``#`` solid, ``.`` or space free, ``S`` the start, ``G`` or ``E`` the target.

    The top row comes first. The start is the centre of its cell, the target the disc inscribed in
    its cell.

    Args:
        path: The file; LF or CRLF.
        cell_size: Side of a cell, m.

    Raises:
        FormatError: If rows differ in length, a character is unknown, or a place occurs twice.
    """
    # Read the rows.
    data = read_bounded(path)
    rows = text_rows(data)
    drawn = equal_rows(list(enumerate(rows, 1)))
    # Refuse unknown characters.
    cells = _TABLE[drawn]
    if (cells == _BAD).any():
        row_index, column = divmod(int(np.argmax(cells == _BAD)), cells.shape[1])
        raise FormatError(
            "unknown-sign",
            "{sign!q} in column {column} is not a cell; # is solid, . or a space free, S the start, G "
            "or E the target",
            sign=rows[row_index][column : column + 1],
            column=column + 1,
            line=row_index + 1,
        )
    # Find the start and the target.
    start = _place(drawn, _START, "start", cell_size)
    target = _place(drawn, _TARGET, "target", cell_size)
    return ForeignMap(
        flip_rows(cells == 1),
        cell_size,
        robots=(
            ForeignRobot(
                None if start is None else (*start, 0.0),
                None if target is None else (*target, lattice_to_metres(UNIT // 2, cell_size)),
            ),
        ),
    )


def text_rows(data: bytes) -> list[bytes]:
    """Return the lines of a text, without empty ones at its end."""
    rows = [row.removesuffix(b"\r") for row in unix_text(data).split(b"\n")]
    while rows and not rows[-1]:
        rows.pop()
    return rows


def equal_rows(rows: Sequence[tuple[int, bytes]]) -> Bytes:
    """Return the characters of rows that must all have one length.

    Args:
        rows: Line number in the file and text of each row.

    Returns:
        (rows, length) uint8.

    Raises:
        FormatError: If there are no rows, one is longer or shorter than the first, or there are too
            many.
    """
    width = len(rows[0][1]) if rows else 0
    check_sides(width, len(rows), line=1)
    for number, row in rows:
        if len(row) != width:
            raise FormatError(
                "ragged-rows",
                "a row of {cells} cells; every row must have {width}, like the first",
                cells=len(row),
                width=width,
                line=number,
            )
    return np.frombuffer(b"".join(row for _, row in rows), np.uint8).reshape(len(rows), width)


def cell_centre(column: int, row: int, cell_size: float) -> tuple[float, float]:
    """Return the centre of a cell, m; row 0 is the lowest."""
    half = UNIT // 2
    return lattice_to_metres(column * UNIT + half, cell_size), lattice_to_metres(
        row * UNIT + half, cell_size
    )


def cell_of(world: World, x: float, y: float) -> tuple[int, int]:
    """Return the column and row, from the top, of the cell that contains a point.

    A point on a cell's right or upper side belongs to the next cell.
    """
    ix, iy = (math.floor(in_cells(value, world.cell_size)) for value in (x, y))
    return min(ix, world.width - 1), world.height - 1 - min(iy, world.height - 1)


def end_cells(world: World) -> tuple[tuple[int, int], tuple[int, int], dict[str, str]]:
    """Return the column and row, from the top, of the cells stored as start and target.

    The last part is a sentence for each of them that is not the centre of its cell.
    """
    altered = {}
    points = (world.start.x, world.start.y), (world.target.x, world.target.y)
    start, target = (cell_of(world, *point) for point in points)
    for name, (column, row), point in zip(
        ("start", "target"), (start, target), points, strict=True
    ):
        if cell_centre(column, world.height - 1 - row, world.cell_size) != point:
            altered[name] = (
                f"the {name} is stored as the centre of the cell in column {column}, row {row} "
                f"from the top"
            )
    return start, target, altered


def _place(drawn: Bytes, letters: bytes, name: str, cell_size: float) -> tuple[float, float] | None:
    found = np.argwhere(np.isin(drawn, list(letters)))
    if len(found) > 1:
        raise FormatError(
            "twice",
            "{cells} cells are the {name}",
            "draw only one, or none",
            cells=len(found),
            name=name,
            line=int(found[1][0]) + 1,
        )
    if not len(found):
        return None
    row, column = (int(index) for index in found[0])
    return cell_centre(column, drawn.shape[0] - 1 - row, cell_size)


def write_text_map(world: World, destination: Destination) -> Exported:
    """Write a drawing, top row first: ``#`` solid, ``.`` free, ``S`` start, ``G`` target."""
    # Draw the marks on free cells.
    start, target, altered = end_cells(world)
    cells = np.where(flip_rows(world.walls), np.uint8(_SOLID[0]), np.uint8(_FREE[0]))
    marks = (("start", start, _START[0]), ("target", target, _TARGET[0]))
    for name, (column, row), letter in marks:
        if cells[row, column] == _FREE[0]:
            cells[row, column] = letter
        else:
            taken = "the start's" if target == start else "solid"
            altered[name] = f"the {name} is not drawn, because its cell is {taken}"
    # Report what gets lost.
    if world.start.heading != 0.0 or cells[start[1], start[0]] != _START[0]:
        altered["heading"] = f"the heading, {world.start.heading:g} rad, is not drawn"
    if world.target.radius != lattice_to_metres(UNIT // 2, world.cell_size):
        altered["target_radius"] = (
            f"the target's radius, {world.target.radius:g} m, is drawn as half a cell"
        )
    elif cells[target[1], target[0]] != _TARGET[0]:
        altered["target_radius"] = (
            f"the target's radius, {world.target.radius:g} m, is not drawn, because the target is "
            f"not"
        )
    rows = (row.tobytes() + b"\n" for row in cells)
    return Exported({destination.name: b"".join(rows)}, altered)


text = Format(
    "text",
    "drawing with one character per cell, .txt",
    (".txt",),
    re.compile(rb"(?=[ .SGE\r\n]*#)[# .SGE]+\r?\n[# .SGE]+(\r?\n|\Z)"),
    read_text_map,
    write_text_map,
    holds=frozenset({"start", "heading", "target", "target_radius"}),
    client="people",
)
