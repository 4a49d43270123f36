"""Convert links between chambers to solid cells."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from worldgen import _core
from worldgen.families.parts.mazes.board import Links
from worldgen.support.ccall import check, pointer, writable

__all__ = ["cells_of", "pitch"]


def pitch(widths: list[int], wall: int) -> npt.NDArray[np.int64]:
    """Return the width of each strip of a plan, in cells.

    The strips are border, chamber, wall, chamber, ..., chamber, border.
    """
    strips = np.full(2 * len(widths) + 1, wall, dtype=np.int64)
    strips[1::2] = widths
    strips[0] = strips[-1] = 1
    return strips


def cells_of(
    links: Links, across: npt.NDArray[np.int64], up: npt.NDArray[np.int64]
) -> npt.NDArray[np.bool_]:
    """Return chambers, walls and border as cells, True is solid.

    Args:
        links: (rows, columns) links.
        across: (2 columns + 1,) widths of the strips in x, cells, from :func:`pitch`.
        up: (2 rows + 1,) heights of the strips in y, cells, from :func:`pitch`.
    """
    ffi = _core.ffi
    lib = _core.lib
    rows, columns = links.shape
    walls = np.empty((int(up.sum()), int(across.sum())), dtype=np.bool_)
    strips = (pointer(ffi, across, np.int64), pointer(ffi, up, np.int64))
    chambers = pointer(ffi, np.ascontiguousarray(links), np.int8)
    check(
        lib.wg_maze_cells(
            chambers, rows, columns, *strips, writable(ffi, walls, np.bool_), walls.size
        )
    )
    return walls
