"""Exact distances between points, segments and solid cells.

Unit of length: 1/1024 cell (:data:`worldgen.lattice.UNIT`), written *lu* below. Coordinates are
Python integers, or fractions for a start off the lattice; neither rounds nor overflows.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np

from worldgen._core import ffi
from worldgen.lattice import UNIT
from worldgen.support.arrays import Bools, Bytes
from worldgen.support.ccall import kept, pointer

# Grids up to this many cells are also kept as bytes, in which the next solid cell is found fastest.
_MOST_BYTES = 4_000_000

Number: TypeAlias = int | Fraction
Point: TypeAlias = tuple[int, int]
ExactPoint: TypeAlias = tuple[Number, Number]
Cell: TypeAlias = tuple[int, int]


@functools.lru_cache(maxsize=256)
def _in_units_sq(radius: Fraction) -> Fraction:
    return (radius * UNIT) ** 2


@functools.lru_cache(maxsize=256)
def described_disc(radius: Fraction) -> Any:
    """Return a disc of ``radius`` cells in the form that C uses for comparisons."""
    square = _in_units_sq(radius)
    return ffi.new("WgDisc *", (math.ceil(radius * UNIT), math.ceil(square), float(square)))


def described_walls(solid: Bools) -> Any:
    """Return solid cells, (height, width) bool, in the form that C reads."""
    cells = np.ascontiguousarray(solid)
    return kept(ffi, ffi.new("WgWalls *", (pointer(ffi, cells, np.bool_), *cells.shape)), cells)


class Walls:
    """The solid cells, and the ring of cells around the grid, for exact queries.

    Args:
        solid: (height, width) bool, True is solid.
        radius: Radius of the disc, cells.
    """

    def __init__(self, solid: Bools, radius: Fraction) -> None:
        self.solid = solid
        self.height, self.width = solid.shape
        self.radius = radius
        self._stride = self.width + 2

    @functools.cached_property
    def radius_sq(self) -> Fraction:
        """Square of the radius, lu."""
        return _in_units_sq(self.radius)

    @functools.cached_property
    def described(self) -> Any:
        """The cells in the form that C reads."""
        return described_walls(self.solid)

    @functools.cached_property
    def disc(self) -> Any:
        """The radius in the form that C uses for comparisons."""
        return described_disc(self.radius)

    @functools.cached_property
    def cells(self) -> Bytes:
        """(height + 2, width + 2) uint8, 1 is solid: the grid and the ring around it."""
        cells = np.ones((self.height + 2, self.width + 2), np.uint8)
        cells[1:-1, 1:-1] = self.solid
        return cells

    @functools.cached_property
    def _bytes(self) -> bytes:
        return self.cells.tobytes()

    def near(self, p: ExactPoint, q: ExactPoint, reach: int) -> Iterator[Cell]:
        """Yield solid cells (ix, iy) that may be within ``reach`` lu of segment pq.

        No closer cell is missing. Outside the grid, only the ring next to it is included, because
        other cells are never closer.
        """
        (px, py), (qx, qy) = (p, q) if p[1] <= q[1] else (q, p)
        first = max(-1, (py - reach) // UNIT - 1)
        last = min(self.height, (qy + reach) // UNIT + 1)
        rise = qy - py
        for iy in range(first, last + 1):
            low = px
            high = qx
            # x of the part of pq that is level with the row.
            if rise > 0:
                below = min(max(iy * UNIT - reach - py, 0), rise)
                above = min(max((iy + 1) * UNIT + reach - py, 0), rise)
                low = px + (qx - px) * below // rise
                high = px + (qx - px) * above // rise
            if low > high:
                low, high = high, low
            begin = max(-1, (low - 1 - reach) // UNIT - 1)
            end = min(self.width, (high + 1 + reach) // UNIT + 1) + 1
            # Go row by row, which avoids a second copy of everything.
            if self.solid.size > _MOST_BYTES:
                row = self.cells[iy + 1, begin + 1 : end + 1]
                yield from ((begin + ix, iy) for ix in np.flatnonzero(row).tolist())
                continue
            base = (iy + 1) * self._stride + 1
            at = base + begin
            end = base + end
            while (at := self._bytes.find(1, at, end)) >= 0:
                yield at - base, iy
                at += 1

    def blocker(self, p: ExactPoint, q: ExactPoint) -> Cell | None:
        """Return a solid cell within the radius of segment pq, or None if the disc may sweep it."""
        numerator = self.radius_sq.numerator
        denominator = self.radius_sq.denominator
        for cell in self.near(p, q, math.ceil(self.radius * UNIT)):
            distance, over = segment_box_sq(p, q, cell)
            if distance * denominator < numerator * over:
                return cell
        return None

    def is_clear(self, p: ExactPoint, q: ExactPoint) -> bool:
        """Return True if the disc may sweep from p to q."""
        return self.blocker(p, q) is None

    def nearest(self, p: ExactPoint) -> tuple[Cell, Number]:
        """Return the solid cell nearest to a point, and its squared distance in lu squared."""
        reach = UNIT
        while True:
            found = [(point_box_sq(p, cell), cell) for cell in self.near(p, p, reach)]
            if found and min(found)[0] <= reach * reach:
                return min(found)[1], min(found)[0]
            reach *= 2


def point_box_sq(p: ExactPoint, cell: Cell) -> Number:
    """Return the squared distance from a point to a closed cell, lu squared."""
    x0 = cell[0] * UNIT
    y0 = cell[1] * UNIT
    dx = max(x0 - p[0], 0, p[0] - x0 - UNIT)
    dy = max(y0 - p[1], 0, p[1] - y0 - UNIT)
    return dx * dx + dy * dy


def segment_box_sq(p: ExactPoint, q: ExactPoint, cell: Cell) -> tuple[Number, Number]:
    """Return the squared distance from segment pq to a closed cell, lu squared.

    It is exact: a numerator and a denominator.

    The smallest distance between two disjoint convex polygons is attained at a vertex of one of
    them.
    """
    ex = q[0] - p[0]
    ey = q[1] - p[1]
    # The segment is itself a box, as most pieces are: three times as fast.
    if ex == 0 or ey == 0:
        return _boxes_apart_sq(p, q, cell), 1
    # An end may be nearest.
    best = min(point_box_sq(p, cell), point_box_sq(q, cell))
    over = 1
    length_sq: Number = ex * ex + ey * ey
    if best == 0:
        return best, 1
    x0 = cell[0] * UNIT
    y0 = cell[1] * UNIT
    if segment_meets_box(p, q, x0, y0, UNIT):
        return 0, 1
    # Otherwise a corner of the cell is nearest to the interior of the segment.
    divisor: Number = over
    for cx, cy in ((x0, y0), (x0 + UNIT, y0), (x0, y0 + UNIT), (x0 + UNIT, y0 + UNIT)):
        ux = cx - p[0]
        uy = cy - p[1]
        side = ex * uy - ey * ux
        if 0 < ex * ux + ey * uy < length_sq and side * side * divisor < best * length_sq:
            best = side * side
            divisor = length_sq
    return best, divisor


def _boxes_apart_sq(p: ExactPoint, q: ExactPoint, cell: Cell) -> Number:
    squared: Number = 0
    for axis in (0, 1):
        low, high = (p[axis], q[axis]) if p[axis] < q[axis] else (q[axis], p[axis])
        base = cell[axis] * UNIT
        apart = base - high if high < base else low - base - UNIT
        if apart > 0:
            squared += apart * apart
    return squared


def segment_meets_box(p: ExactPoint, q: ExactPoint, x0: Number, y0: Number, side: Number) -> bool:
    """Return True if segment pq touches the closed square [x0, x0 + side] x [y0, y0 + side].

    Two convex shapes are disjoint exactly if an edge normal of one of them separates them.
    """
    if (
        max(p[0], q[0]) < x0
        or min(p[0], q[0]) > x0 + side
        or max(p[1], q[1]) < y0
        or min(p[1], q[1]) > y0 + side
    ):
        return False
    ex = q[0] - p[0]
    ey = q[1] - p[1]
    base = ex * (y0 - p[1]) - ey * (x0 - p[0])
    across = -ey * side
    up = ex * side
    sides = (base, base + across, base + up, base + across + up)
    return min(sides) <= 0 <= max(sides)
