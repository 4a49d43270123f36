"""A way for a square as wide as the disc, over whole cells: quick, and one byte a cell, but not every way is one.

The half cells of a world of 20,000 x 20,000 would take 20 GB. A square of whole cells at least as wide as the disc that
is free leaves the disc clear in its middle, and on straight lines between the middles of neighbouring squares. So
what is found is a proof; what is not found has to be sought among the half cells after all.
"""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np

from worldgen.jit import lazy_kernel
from worldgen.lattice import UNIT
from worldgen.reach.walls import ExactPoint, Walls

__all__ = ["FROM_CELLS", "coarse_way", "walk_squares"]

FROM_CELLS = 4_000_000
"""Cells above which this way is sought first: families made no larger worlds before, so no seed's witness changes."""

_HALF = UNIT // 2


def coarse_way(walls: Walls, start: ExactPoint, goal: ExactPoint) -> list[ExactPoint]:
    """Points from one clear pose to another, lu, with a clear line between each two; empty if no square gets there."""
    side = max(1, math.ceil(2 * walls.radius))
    begin, end = _square_round(walls, start, side), _square_round(walls, goal, side)
    if begin is None or end is None:
        return []
    stride = walls.width + 2
    state = np.zeros((walls.height + 2) * stride, np.uint8)
    cells = np.ascontiguousarray(walls.solid).view(np.uint8)
    heights = np.zeros(walls.width, np.int32)
    source, target = ((iy + 1) * stride + ix + 1 for ix, iy in (begin, end))
    way = _walk_squares_compiled(cells, side, source, target, state, heights).tolist()
    middles = [((2 * (at % stride - 1) + side) * _HALF, (2 * (at // stride - 1) + side) * _HALF) for at in way]
    return [start, *middles, goal] if middles else []


def _square_round(walls: Walls, point: ExactPoint, side: int) -> tuple[int, int] | None:
    """The first cell of a free square from whose middle the disc may go straight to a point."""
    nearest = [round((value / _HALF - side) / 2) for value in point]
    for dx, dy in itertools.product((0, -1, 1), repeat=2):
        ix, iy = nearest[0] + dx, nearest[1] + dy
        inside = 0 <= ix <= walls.width - side and 0 <= iy <= walls.height - side
        if not inside or walls.solid[iy : iy + side, ix : ix + side].any():
            continue
        if walls.is_clear(((2 * ix + side) * _HALF, (2 * iy + side) * _HALF), point):
            return ix, iy
    return None


def walk_squares(solid: Any, side: Any, source: Any, goal: Any, state: Any, heights: Any) -> Any:
    """Breadth-first search over free squares.

    Args:
        solid: (height, width) uint8, 1 is solid.
        side: Of the squares, cells.
        source: Where to begin: (row + 1) * (width + 2) + column + 1 of a square's first cell.
        goal: Where to end.
        state: ((height + 2) * (width + 2),) uint8 zeros, for the squares.
        heights: (width,) int32 zeros.

    Returns:
        (n,) squares from source to goal, without those in the middle of a straight line; none if there is no way.
    """
    height, width = solid.shape
    stride = width + 2
    for iy in range(height):
        run = 0
        for ix in range(width):
            heights[ix] = heights[ix] + 1 if solid[iy, ix] == 0 else 0
            run = run + 1 if heights[ix] >= side else 0
            if run >= side:
                state[(iy - side + 2) * stride + ix - side + 2] = 1
    now, after = np.empty(1024, np.int32), np.empty(1024, np.int32)
    now[0], count = source, 1 if state[source] == 1 and state[goal] == 1 else 0
    state[source] = 6
    while count > 0 and state[goal] == 1:
        if 4 * count > len(after):
            after = np.empty(8 * count, np.int32)
        found = 0
        for i in range(count):
            at = np.int64(now[i])
            for step in range(4):
                there = at + (1 if step == 0 else stride if step == 1 else -1 if step == 2 else -stride)
                if state[there] == 1:
                    state[there] = 2 + step
                    after[found] = there
                    found += 1
        now, after, count = after, now, found
    corners, at, step = 0, goal, 0
    if state[goal] > 1:
        while step != 6:
            corners += state[at] != step
            step = int(state[at])
            at -= 1 if step == 2 else stride if step == 3 else -1 if step == 4 else -stride if step == 5 else 0
    way = np.empty(corners, np.int64)
    at, step = goal, 0
    while corners > 0:
        if state[at] != step:
            corners -= 1
            way[corners] = at
            step = int(state[at])
        at -= 1 if step == 2 else stride if step == 3 else -1 if step == 4 else -stride if step == 5 else 0
    return way


_walk_squares_compiled = lazy_kernel(walk_squares)
