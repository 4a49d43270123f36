"""Exact distances between segments and solid cells, in integers.

Unit of length: 1/1024 cell (:data:`worldgen.lattice.UNIT`), written *lu* below. A point is a pair of
integers. Python's integers do not overflow, so nothing here rounds.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from worldgen.lattice import UNIT

__all__ = ["Cell", "Point", "Walls", "point_box_sq", "segment_box_sq"]

Point = tuple[int, int]
Cell = tuple[int, int]


class Walls:
    """The solid cells with the ring of cells round the grid, for exact questions.

    Args:
        solid: (height, width) bool, True is solid.
        radius: Radius of the disc, cells.
    """

    def __init__(self, solid: npt.NDArray[np.bool_], radius: Fraction) -> None:
        self.height, self.width = solid.shape
        self.radius = radius
        self.radius_sq = (radius * UNIT) ** 2
        self._stride = self.width + 2
        self._cells = np.pad(solid, 1, constant_values=True).tobytes()

    def near(self, p: Point, q: Point, reach: int) -> Iterator[Cell]:
        """Solid cells (ix, iy) that may lie within ``reach`` lu of segment pq; none nearer is left out.

        Of the outside, only the ring next to the grid is listed: the rest is never nearer.
        """
        (px, py), (qx, qy) = (p, q) if p[1] <= q[1] else (q, p)
        first = max(-1, (py - reach) // UNIT - 1)
        last = min(self.height, (qy + reach) // UNIT + 1)
        rise = qy - py
        for iy in range(first, last + 1):
            low, high = px, qx
            if rise > 0:  # x of the part of pq that lies level with the row
                below = min(max(iy * UNIT - reach - py, 0), rise)
                above = min(max((iy + 1) * UNIT + reach - py, 0), rise)
                low, high = px + (qx - px) * below // rise, px + (qx - px) * above // rise
            if low > high:
                low, high = high, low
            base = (iy + 1) * self._stride + 1
            at = base + max(-1, (low - 1 - reach) // UNIT - 1)
            end = base + min(self.width, (high + 1 + reach) // UNIT + 1) + 1
            while (at := self._cells.find(1, at, end)) >= 0:
                yield at - base, iy
                at += 1

    def blocker(self, p: Point, q: Point) -> Cell | None:
        """A solid cell nearer than the radius to segment pq, or None when the disc may sweep it."""
        numerator, denominator = self.radius_sq.numerator, self.radius_sq.denominator
        for cell in self.near(p, q, math.ceil(self.radius * UNIT)):
            distance, over = segment_box_sq(p, q, cell)
            if distance * denominator < numerator * over:
                return cell
        return None

    def is_clear(self, p: Point, q: Point) -> bool:
        """Whether the disc may sweep from p to q."""
        return self.blocker(p, q) is None


def point_box_sq(p: Point, cell: Cell) -> int:
    """Squared distance from a point to a closed cell, lu squared."""
    x0, y0 = cell[0] * UNIT, cell[1] * UNIT
    dx = max(x0 - p[0], 0, p[0] - x0 - UNIT)
    dy = max(y0 - p[1], 0, p[1] - y0 - UNIT)
    return dx * dx + dy * dy


def segment_box_sq(p: Point, q: Point, cell: Cell) -> tuple[int, int]:
    """Squared distance from segment pq to a closed cell as (numerator, denominator), lu squared.

    The least distance between two disjoint convex polygons is attained at a vertex of one of them.
    """
    best, over = min(point_box_sq(p, cell), point_box_sq(q, cell)), 1
    ex, ey = q[0] - p[0], q[1] - p[1]
    length_sq = ex * ex + ey * ey
    if best == 0 or length_sq == 0:
        return best, 1
    x0, y0 = cell[0] * UNIT - p[0], cell[1] * UNIT - p[1]
    low = high = None
    for cx, cy in ((x0, y0), (x0 + UNIT, y0), (x0, y0 + UNIT), (x0 + UNIT, y0 + UNIT)):
        side = ex * cy - ey * cx
        low = side if low is None or side < low else low
        high = side if high is None or side > high else high
        if 0 < ex * cx + ey * cy < length_sq and side * side * over < best * length_sq:
            best, over = side * side, length_sq
    apart = max(0, ex) < x0 or min(0, ex) > x0 + UNIT or max(0, ey) < y0 or min(0, ey) > y0 + UNIT
    if not apart and low is not None and high is not None and low <= 0 <= high:
        return 0, 1
    return best, over
