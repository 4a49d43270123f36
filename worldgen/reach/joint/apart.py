"""Decide exactly whether two robots that move at the same time stay apart."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from worldgen.reach.still.walls import ExactPoint
from worldgen.support.arrays import Ints

# Two steps of one node each differ by at most 2 across and 2 up.
_LENGTHS_SQ = (1, 2, 4, 5, 8)


def conflict_limits(radii: list[Fraction], k: int) -> Ints:
    """Return the integers that C compares with squared distances of robots.

    Args:
        radii: Radius of each class, cells.
        k: Nodes per cell side.

    Returns:
        (classes, classes, 9) int64: smallest squared distance, in nodes, times the squared length.
    """
    limits = np.zeros((len(radii), len(radii), 9), np.int64)
    for i, one in enumerate(radii):
        for j, other in enumerate(radii):
            apart_sq = (k * (one + other)) ** 2
            for length_sq in _LENGTHS_SQ:
                limits[i, j, length_sq] = math.ceil(apart_sq * length_sq)
    return limits


def stay_apart(
    one: tuple[ExactPoint, ExactPoint], other: tuple[ExactPoint, ExactPoint], apart_sq: Fraction
) -> bool:
    """Return True if two robots stay apart while each goes straight from one point to another.

    Args:
        one: One robot's start and end.
        other: The other robot's start and end, in the same time.
        apart_sq: Square of the distance that they must keep.
    """
    (ax, ay), (bx, by) = one
    (cx, cy), (dx, dy) = other
    px = ax - cx
    py = ay - cy
    qx = bx - dx
    qy = by - dy
    if px * px + py * py < apart_sq or qx * qx + qy * qy < apart_sq:
        return False
    ex = qx - px
    ey = qy - py
    length_sq = ex * ex + ey * ey
    along = -(px * ex + py * ey)
    if not 0 < along < length_sq:
        return True
    side = px * ey - py * ex
    return side * side >= apart_sq * length_sq
