"""Turn polygons by any angle and rasterise them in integers, the same on every machine."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np

from worldgen.support.angles import SCALE, direction
from worldgen.support.arrays import Bools, Ints

Point: TypeAlias = tuple[int, int]
Polygon: TypeAlias = tuple[Point, ...]

FINE = 64  # units per cell
# Units by which slanted polygons are thickened. It exceeds (sqrt(2) - 1) / 2 cells, so a slanted
# strip of one cell has no holes, not even at corners.
_THICKER = 14


def box(x0: int, y0: int, x1: int, y1: int) -> Polygon:
    """Convert a box in cells to a counter-clockwise polygon in units."""
    return tuple((FINE * x, FINE * y) for x, y in ((x0, y0), (x1, y0), (x1, y1), (x0, y1)))


def turned(polygon: Sequence[Point], degrees: int) -> Polygon:
    """Turn a polygon counter-clockwise about the origin."""
    cos, sin = direction(degrees)
    half = SCALE // 2
    return tuple(
        ((x * cos - y * sin + half) // SCALE, (x * sin + y * cos + half) // SCALE)
        for x, y in polygon
    )


def to_frame(x: Ints, y: Ints, degrees: int) -> tuple[Ints, Ints]:
    """Convert points, in units, to a frame that is turned counter-clockwise about the origin."""
    cos, sin = direction(degrees)
    return (x * cos + y * sin) // SCALE, (y * cos - x * sin) // SCALE


def bounds(polygons: Sequence[Polygon]) -> tuple[int, int, int, int]:
    """Return the half-open range of cells that :func:`fill` can touch, as x0, y0, x1, y1."""
    thicker = 0 if all(_is_straight(polygon) for polygon in polygons) else _THICKER
    xs, ys = zip(*(point for polygon in polygons for point in polygon), strict=True)
    low = [(value - thicker) // FINE for value in (min(xs), min(ys))]
    high = [-((-value - thicker) // FINE) for value in (max(xs), max(ys))]
    return low[0], low[1], high[0], high[1]


def extents(polygons: Sequence[Polygon]) -> tuple[int, int]:
    """Return an upper bound on the columns and rows that :func:`fill` needs.

    The result holds wherever the polygons are, relative to the cells.
    """
    x0, y0, x1, y1 = bounds(polygons)
    if all(_is_straight(polygon) for polygon in polygons):
        return x1 - x0, y1 - y0
    xs, ys = zip(*(point for polygon in polygons for point in polygon), strict=True)
    columns, rows = (
        -(-(max(values) - min(values) + 2 * _THICKER) // FINE) + 1 for values in (xs, ys)
    )
    return columns, rows


def fill(polygons: Sequence[Polygon]) -> Bools:
    """Return the cells whose centres are in any of some convex polygons.

    If any polygon is slanted, all are slightly thickened, so that walls of one cell have no holes.

    Args:
        polygons: Convex and counter-clockwise, in units.

    Returns:
        (rows, columns) bool; the first cell is the first one of :func:`bounds`.
    """
    x0, y0, x1, y1 = bounds(polygons)
    thicker = 0 if all(_is_straight(polygon) for polygon in polygons) else _THICKER
    x = (np.arange(x0, x1, dtype=np.int64) * FINE + FINE // 2)[np.newaxis, :]
    y = (np.arange(y0, y1, dtype=np.int64) * FINE + FINE // 2)[:, np.newaxis]
    cells = np.zeros((y1 - y0, x1 - x0), dtype=np.bool_)
    for polygon in polygons:
        inside = np.ones_like(cells)
        for (ax, ay), (bx, by) in zip(polygon, (*polygon[1:], polygon[0]), strict=True):
            ux = bx - ax
            uy = by - ay
            inside &= ux * (y - ay) - uy * (x - ax) >= -thicker * math.isqrt(ux * ux + uy * uy)
        cells |= inside
    return cells


def _is_straight(polygon: Polygon) -> bool:
    """Return True if all sides are parallel to the axes."""
    return all(
        ax == bx or ay == by
        for (ax, ay), (bx, by) in zip(polygon, (*polygon[1:], polygon[0]), strict=True)
    )
