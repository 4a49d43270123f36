"""NumPy's ``.npy`` files of cells.

Source: the format's documentation in numpy.lib.format, versions 1 to 3.
"""

from __future__ import annotations

import io
import re
import tokenize
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from worldgen.errors import FormatError
from worldgen.interop.format import Destination, Exported, Format
from worldgen.interop.format.foreign_map import ForeignMap, check_sides, read_bounded
from worldgen.support.arrays import Bools
from worldgen.support.rows import flip_rows
from worldgen.world import DEFAULT_CELL_SIZE, World

# NumPy parses a header as Python text, and, if that fails, once more as Python 2 text, by its
# tokens.
_HEADER_FAULTS = (
    ValueError, OSError, EOFError, UserWarning, SyntaxError, TypeError, RecursionError, MemoryError,
    tokenize.TokenError,
)  # fmt: skip


def read_numpy_map(path: Path, *, cell_size: float = DEFAULT_CELL_SIZE) -> ForeignMap:
    """Read a 2D array of bool or whole numbers; True and 1 are solid.

    Row 0 is the top row, as NumPy prints it.

    Args:
        path: The ``.npy`` file.
        cell_size: Side of a cell, m.

    Raises:
        FormatError: If the file holds anything else; objects are never unpickled.
    """
    # Read the header here, because NumPy only warns about headers that it should refuse.
    data = read_bounded(path)
    stream = io.BytesIO(data)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            version = np.lib.format.read_magic(stream)
            shape, by_columns, kind = _header(stream, version)
    except _HEADER_FAULTS as error:
        raise FormatError(
            "unknown-format", "is not a NumPy array file", "write it with numpy.save"
        ) from error
    # Only plain numbers are read, and never more than the header claims.
    if kind.hasobject or kind.kind not in "biu" or len(shape) != 2:
        raise FormatError(
            "wrong-shape",
            "holds a {kind} array of shape {shape}; a map has two axes of bool or whole numbers, 0 "
            "free and 1 solid",
            kind=kind,
            shape=shape,
        )
    height, width = shape
    check_sides(width, height)
    body = data[stream.tell() :]
    if len(body) != width * height * kind.itemsize:
        raise FormatError(
            "wrong-length",
            "{bytes} bytes of cells; {width} x {height} of {kind} take {needed}; the file is "
            "truncated or damaged, write it again",
            bytes=len(body),
            width=width,
            height=height,
            kind=kind,
            needed=width * height * kind.itemsize,
        )
    # Arrays may be stored by columns.
    cells = np.frombuffer(body, kind).reshape((height, width), order="F" if by_columns else "C")
    return ForeignMap(flip_rows(_solid(cells)), cell_size)


def _header(
    stream: io.BytesIO, version: tuple[int, int]
) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    if version == (1, 0):
        return np.lib.format.read_array_header_1_0(stream)
    # Later versions are written differently, and refused.
    return np.lib.format.read_array_header_2_0(stream)


def _solid(cells: npt.NDArray[Any]) -> Bools:
    strange = (cells != 0) & (cells != 1)
    if strange.any():
        row, column = np.argwhere(strange)[0]
        raise FormatError(
            "wrong-values",
            "{value} in row {row}, column {column}; 0 is free and 1 is solid, so save walls as "
            "True, as in numpy.save(file, cells == WALL)",
            value=cells[row, column],
            row=row,
            column=column,
        )
    return cells.astype(np.bool_)


def write_numpy_map(world: World, destination: Destination) -> Exported:
    """Return a bool array, True where solid, the top row first."""
    stream = io.BytesIO()
    np.lib.format.write_array(
        stream, np.ascontiguousarray(flip_rows(world.walls)), (1, 0), allow_pickle=False
    )
    return Exported({destination.name: stream.getvalue()})


npy = Format(
    "npy",
    "NumPy array of cells, .npy",
    (".npy",),
    re.compile(rb"\x93NUMPY"),
    read_numpy_map,
    write_numpy_map,
    client="NumPy",
)
