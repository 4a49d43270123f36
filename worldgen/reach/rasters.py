"""Where a disc is clear, for every node and middle of a graph at once."""

from __future__ import annotations

import functools
import math
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from worldgen.jit import lazy_kernel

__all__ = ["disc_rasters", "disc_rasters_compiled", "rows_of_discs"]


@functools.lru_cache(maxsize=64)
def rows_of_discs(radius: Fraction, k: int) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], int]:
    """Which cells a disc round a point of each kind touches, row by row.

    Args:
        radius: cells.
        k: Points a cell side.

    Returns:
        (2 k² + 1,) where the rows of each kind begin: nodes and middles in turn, by x and then y within a cell.
        (n, 3) rows: cells up, first cell to the right, number of cells. And how far any of them is away.
    """
    m, begins, rows = 2 * k, [0], []
    limit = math.ceil((m * radius) ** 2)  # clear means: squared distance, in 1/m cell, >= limit
    reach = math.isqrt(limit - 1)
    for b, a in ((2 * (kind // (2 * k)) + kind % 2, 2 * (kind // 2 % k) + kind % 2) for kind in range(2 * k * k)):
        for up in range(-((reach + m - b) // m), (reach + b) // m + 1):
            dy = max(m * up - b, 0, b - m * up - m)
            across = math.isqrt(limit - dy * dy - 1)
            low, high = -((across + m - a) // m), (across + a) // m
            rows.append((up, low, high - low + 1))
        begins.append(len(rows))
    table = np.array(rows, np.int64)
    return (
        np.array(begins, np.int64),
        table,
        int(max(np.abs(table[:, :2]).max(), (table[:, 1] + table[:, 2]).max())) + 1,
    )


def disc_rasters(
    solid: Any, begins: Any, rows: Any, counts: Any, gaps: Any, line: Any, k: Any, clear: Any, middle: Any
) -> None:
    """Fills the rasters of a graph.

    Args:
        solid: (height, width) uint8, 1 is solid.
        begins: From :func:`rows_of_discs`.
        rows: Likewise.
        counts: (n,) the last column of ``rows``, of the type of ``gaps``: then 64 cells are compared at a time.
        gaps: (height + 2 pad, width + 2 pad) unsigned zeros; free cells from each cell on rightwards, as far as known.
        line: (width + 1,) uint8.
        k: Nodes a cell side.
        clear: (k height + 1, k width + 1) uint8 zeros; gets 1 where the disc is clear at the node.
        middle: Likewise, half a step right of and above the node.
    """
    height, width = solid.shape
    pad = (gaps.shape[0] - height) // 2
    most = 255 if gaps.itemsize == 1 else 65535
    for j in range(height):
        free = 0
        for i in range(width - 1, -1, -1):
            free = 0 if solid[j, i] != 0 else min(free + 1, most)
            gaps[pad + j, pad + i] = free
    for j in range(height + 1):
        for kind in range(2 * k * k):
            a, b, is_middle = kind // 2 % k, kind // (2 * k), kind % 2
            if j == height and (b > 0 or is_middle == 1):
                continue
            columns = width + 1 if a == 0 and is_middle == 0 else width
            for i in range(columns):
                line[i] = 1
            for row in range(begins[kind], begins[kind + 1]):
                first, count = pad + rows[row, 1], counts[row]
                there = gaps[pad + j + rows[row, 0], first : first + columns]
                for i in range(columns):
                    line[i] &= there[i] >= count
            if is_middle == 1:
                for i in range(columns):
                    middle[k * j + b, k * i + a] = line[i]
            else:
                for i in range(columns):
                    clear[k * j + b, k * i + a] = line[i]


disc_rasters_compiled = lazy_kernel(disc_rasters)
