"""Ways for a square as wide as the robot: coarse, but where it fits, the disc does."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from worldgen.jit import lazy_kernel

__all__ = ["free_windows", "shortest_way", "window_at"]

# Cells from which compiling pays: loading numba took 0.17 to 0.38 s, plain Python 0.16 s for an open square of
# 490,000 cells, compiled code 0.004 s.
COMPILE_FROM = 500_000


def free_windows(walls: npt.NDArray[np.bool_], width: int, height: int) -> npt.NDArray[np.bool_]:
    """Where a box of ``width`` x ``height`` cells is free: bool, shaped like ``walls``, at the box's first cell."""
    rows, columns = walls.shape
    windows = np.zeros(walls.shape, dtype=np.bool_)
    if width > columns or height > rows:
        return windows
    sums = np.zeros((rows + 1, columns + 1), dtype=np.int64)
    sums[1:, 1:] = walls.cumsum(axis=0).cumsum(axis=1)
    solid = sums[height:, width:] - sums[:-height, width:] - sums[height:, :-width] + sums[:-height, :-width]
    windows[: rows - height + 1, : columns - width + 1] = solid == 0
    return windows


def window_at(halves: int, side: int) -> int:
    """First cell, along one axis, of the square round a coordinate in half cells."""
    return (halves - side) // 2


def breadth_first(windows: Any, came: Any, queue: Any, start: int, goal: int, stride: int) -> None:
    """Fills ``came`` with the cell from which each was reached first, until the goal is.

    Args:
        windows: (n,) 1 where one may be; none on the rim, so that no step leaves the grid.
        came: (n,) -1, to be filled.
        queue: (n,) room for cells.
        start: Cell to begin at.
        goal: Cell to end at.
        stride: Cells a row.
    """
    came[start] = start
    queue[0] = start
    first, count = 0, 1
    while first < count and came[goal] < 0:
        at = queue[first]
        first += 1
        for way in range(4):
            if way == 0:
                there = at + 1
            elif way == 1:
                there = at + stride
            elif way == 2:
                there = at - 1
            else:
                there = at - stride
            if windows[there] != 0 and came[there] < 0:
                came[there] = at
                queue[count] = there
                count += 1


_breadth_first_compiled = lazy_kernel(breadth_first)


def shortest_way(windows: npt.NDArray[np.bool_], start: int, goal: int) -> list[int]:
    """Flat cells of a shortest way over free windows, both ends included; empty if there is none."""
    cells = windows.size
    came: Any
    if cells < COMPILE_FROM:
        came = [-1] * cells
        breadth_first(windows.tobytes(), came, [0] * cells, start, goal, windows.shape[1])
    else:
        came = np.full(cells, -1, dtype=np.int64)
        queue = np.zeros(cells, dtype=np.int64)
        _breadth_first_compiled(windows.view(np.uint8).ravel(), came, queue, start, goal, windows.shape[1])
    if came[goal] < 0:
        return []
    way = [goal]
    while way[-1] != start:
        way.append(int(came[way[-1]]))
    return way[::-1]
