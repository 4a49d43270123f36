"""Find a path for a square as wide as the disc, over whole cells.

This is fast and takes one byte per cell, but it misses some paths. The half cells of a world of
20,000 x 20,000 would take 20 GB. If a square of whole cells at least as wide as the disc is free,
the disc is clear in its middle, and on straight lines between the middles of neighbouring squares.
So a path found here is a proof; if none is found, the half cells must still be searched.
"""

from __future__ import annotations

import itertools
import math

import numpy as np

from worldgen._core import ffi, lib
from worldgen.lattice import UNIT
from worldgen.reach.still.walls import ExactPoint, Walls
from worldgen.support.ccall import check, writable

FROM_CELLS = 4_000_000
"""Number of cells above which this search comes first.

Earlier versions made no larger worlds, so no seed's witness changes.
"""

_HALF = UNIT // 2
# Cells between two checks for Ctrl-C: 0.2 s.
_PORTION = 50_000_000


def coarse_path(walls: Walls, start: ExactPoint, goal: ExactPoint) -> list[ExactPoint]:
    """Return the points from one clear pose to another, lu, with clear lines between neighbours.

    The result is empty if the squares give no path.
    """
    side = max(1, math.ceil(2 * walls.radius))
    begin = _square_round(walls, start, side)
    end = _square_round(walls, goal, side)
    if begin is None or end is None:
        return []
    stride = walls.width + 2
    source, target = ((iy + 1) * stride + ix + 1 for ix, iy in (begin, end))
    way = walk_squares(walls, side, source, target)
    middles = [
        ((2 * (at % stride - 1) + side) * _HALF, (2 * (at // stride - 1) + side) * _HALF)
        for at in way
    ]
    return [start, *middles, goal] if middles else []


def _square_round(walls: Walls, point: ExactPoint, side: int) -> tuple[int, int] | None:
    """Return the first cell of a free square whose middle has a straight clear line to a point."""
    nearest = [round((value / _HALF - side) / 2) for value in point]
    for dx, dy in itertools.product((0, -1, 1), repeat=2):
        ix = nearest[0] + dx
        iy = nearest[1] + dy
        inside = 0 <= ix <= walls.width - side and 0 <= iy <= walls.height - side
        if not inside or walls.solid[iy : iy + side, ix : ix + side].any():
            continue
        if walls.is_clear(((2 * ix + side) * _HALF, (2 * iy + side) * _HALF), point):
            return ix, iy
    return None


def walk_squares(walls: Walls, side: int, source: int, goal: int) -> list[int]:
    """Search free squares breadth first.

    Args:
        walls: The walls.
        side: Side of the squares, cells.
        source: Start: (row + 1) * (width + 2) + column + 1 of a square's first cell.
        goal: End, in the same form.

    Returns:
        Squares from source to goal, without those in the middle of a straight line; none if there
        is no path.
    """
    made = ffi.new("WgSquares **")
    progress = ffi.new("WgProgress *")
    check(lib.wg_squares_new(walls.described, side, source, goal, made))
    try:
        while True:
            check(lib.wg_squares_advance(made[0], _PORTION, progress))
            if progress[0] != lib.WG_GOING:
                break
        way = np.empty(lib.wg_squares_way_length(made[0]), np.int64)
        lib.wg_squares_way(made[0], writable(ffi, way, np.int64))
    finally:
        lib.wg_squares_free(made[0])
    squares: list[int] = way.tolist()
    return squares
