"""From links between chambers to solid cells."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from worldgen.families._mazes.board import CORNER, EAST, NORTH, ROCK, Links
from worldgen.families._mazes.grow import worth_compiling
from worldgen.jit import lazy_kernel

__all__ = ["cells_of", "pitch"]


def pitch(widths: list[int], wall: int) -> npt.NDArray[np.int64]:
    """How wide each strip of a plan is, in cells: border, chamber, wall, chamber, ..., chamber, border."""
    strips = np.full(2 * len(widths) + 1, wall, dtype=np.int64)
    strips[1::2] = widths
    strips[0] = strips[-1] = 1
    return strips


def cells_of(
    links: Links, across: npt.NDArray[np.int64], up: npt.NDArray[np.int64], *, compiled: bool | None = None
) -> npt.NDArray[np.bool_]:
    """Chambers, walls and border as cells.

    Args:
        links: (rows, columns) links.
        across: (2 columns + 1,) widths of the strips in x, from :func:`pitch`.
        up: (2 rows + 1,) their heights.
        compiled: Whether to run compiled code; ``None``: where it is worth it. The cells are the same.
    """
    if compiled is None:
        compiled = worth_compiling(links.size, 1 << 62)  # NumPy needs 10 ms for the largest: not worth loading numba
    if compiled:
        walls = np.empty((int(up.sum()), int(across.sum())), dtype=np.bool_)
        strip_of = np.repeat(np.arange(len(across), dtype=np.int32), across)
        _compiled(np.ascontiguousarray(links), strip_of, up, np.empty(len(across), np.bool_), walls)
        return walls
    plan = np.ones((len(up), len(across)), dtype=np.bool_)
    plan[1::2, 1::2] = links & ROCK
    plan[1::2, 2::2] = (links & EAST) == 0
    plan[2::2, 1::2] = (links & NORTH) == 0
    plan[2::2, 2::2] = (links & CORNER) == 0
    return plan.repeat(up, axis=0).repeat(across, axis=1)


def _draw(links: Any, strip_of: Any, up: Any, line: Any, walls: Any) -> None:
    """The same row by row: each strip of the plan once, then as often as it is high."""
    rows, columns = links.shape
    y = 0
    for strip in range(2 * rows + 1):
        line[0] = True
        row, odd = (strip - 1) >> 1, strip & 1
        for column in range(columns):
            bits = ROCK if strip == 0 else links[row, column]
            if odd:
                line[2 * column + 1], line[2 * column + 2] = (bits & ROCK) != 0, (bits & EAST) == 0
            else:
                line[2 * column + 1], line[2 * column + 2] = (bits & NORTH) == 0, (bits & CORNER) == 0
        for x in range(len(strip_of)):
            walls[y, x] = line[strip_of[x]]
        for other in range(y + 1, y + up[strip]):
            for x in range(len(strip_of)):
                walls[other, x] = walls[y, x]
        y += up[strip]


_compiled = lazy_kernel(_draw)
