"""Shapes of other worlds as cells.

Solid is what a shape reaches into, so what is reachable here is so there too.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from fractions import Fraction
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from worldgen.domain import MAX_SIDE
from worldgen.errors import InvalidWorld
from worldgen.interop.geometry.boxes import merged_boxes

__all__ = ["Raster", "RasterBox", "RasterDisc", "natural_cell_size"]

# cells; a shape that reaches less far into a cell only touches it: its coordinates were rounded.
_TOUCH = 1e-6
_MOST_PAINTED = (
    500_000_000  # cells, each shape's window counted; more is an attack, or cells far too small
)
_CORNER = 50  # cells that are painted while a corner is looked at in a row
_FAR = 1e9  # cells; what lies beyond is in no grid
_MOST_SIDE = 2000  # cells, where the cell size is ours to choose
_USUAL = Fraction(1, 10)  # m
_DIVISORS = [factor * 10**power for power in range(7) for factor in (1, 2, 5)]


class RasterBox(NamedTuple):
    """A rectangle along the axes, m, from the grid's corner, exactly."""

    left: Fraction
    low: Fraction
    right: Fraction
    high: Fraction


class RasterDisc(NamedTuple):
    """A disc: centre and radius, m, from the grid's corner."""

    x: float
    y: float
    radius: float


class Raster:
    """A grid into which shapes are painted.

    Args:
        width: Cells in x.
        height: Cells in y.
        cell_size: m.

    Attributes:
        solid: (height, width) bool: cells that a shape reaches into; row 0 is the lowest.
        full: Likewise, cells that lie whole in one shape.
    """

    def __init__(self, width: int, height: int, cell_size: Fraction) -> None:
        self.solid = np.zeros((height, width), np.bool_)
        self.full = np.zeros((height, width), np.bool_)
        self._cell_size = cell_size
        self._painted = 0

    @property
    def partly(self) -> int:
        """How many solid cells lie whole in no shape."""
        return int(np.count_nonzero(self.solid & ~self.full))

    def box(self, box: RasterBox) -> None:
        """Paint a rectangle along the axes; its sides count exactly."""
        left, low, right, high = (side / self._cell_size for side in box)
        if right <= left or high <= low:
            return
        outer = self._window(math.floor(left), math.floor(low), math.ceil(right), math.ceil(high))
        self.solid[outer] = True
        inner = self._window(math.ceil(left), math.ceil(low), math.floor(right), math.floor(high))
        self.full[inner] = True

    def picture(self, solid: npt.NDArray[np.bool_], across: Fraction, along: Fraction) -> None:
        """Paint a picture's solid pixels, lowest row first, at a size in m from the grid's corner."""
        if across == along == self._cell_size and solid.shape == self.solid.shape:
            self.solid |= solid
            self.full |= solid
            return
        for left, low, right, high in merged_boxes(solid).tolist():
            self.box(RasterBox(left * across, low * along, right * across, high * along))

    def circle(self, circle: RasterDisc) -> None:
        """Paint a disc."""
        x, y, radius = (value / float(self._cell_size) for value in circle)
        if not max(abs(x), abs(y), radius) < _FAR:
            return
        window = self._around(x - radius, y - radius, x + radius, y + radius)
        rows, columns = (np.arange(part.start, part.stop, dtype=np.float64) for part in window)
        near, far = (
            [_distances(line, at, far) for line, at in ((columns, x), (rows, y))]
            for far in (False, True)
        )
        self.solid[window] |= near[1][:, None] ** 2 + near[0] ** 2 < radius**2 - _TOUCH
        self.full[window] |= far[1][:, None] ** 2 + far[0] ** 2 <= radius**2 + _TOUCH

    def polygon(self, corners: npt.NDArray[np.float64]) -> None:
        """Paint a polygon of (n, 2) corners, m; or, where n is 2, a line without width."""
        from worldgen.interop.geometry.polygon_rows import cut_into_rows, prepared

        points = corners / float(self._cell_size)
        if not np.abs(points).max() < _FAR:
            return
        shape = prepared(points)
        window = self._around(*shape.bounds)
        self._spend(_CORNER * len(points) * (window[0].stop - window[0].start))
        inside, outside = cut_into_rows(shape, *window)
        solid = self.solid[window]
        full = np.ones_like(self.full[window])
        for row, first, end in inside.tolist():
            solid[row, first:end] = True
        for row, first, end in outside.tolist():
            full[row, first:end] = False
        self.full[window] |= full

    def _around(self, left: float, low: float, right: float, high: float) -> tuple[slice, slice]:
        return self._window(math.floor(left), math.floor(low), math.ceil(right), math.ceil(high))

    def _window(self, left: int, low: int, right: int, high: int) -> tuple[slice, slice]:
        """Return the part of the grid between columns and rows, ends exclusive."""
        height, width = self.solid.shape
        first = max(low, 0)
        last = min(max(high, 0), height)
        begin = max(left, 0)
        end = min(max(right, 0), width)
        self._spend(max(last - first, 0) * max(end - begin, 0))
        return slice(first, max(last, first)), slice(begin, max(end, begin))

    def _spend(self, work: int) -> None:
        self._painted += work
        if self._painted > _MOST_PAINTED:
            raise InvalidWorld(
                "too-large", "the obstacles take too many cells", "give a larger cell_size"
            )


def _distances(cells: npt.NDArray[np.float64], at: float, far: bool) -> npt.NDArray[np.float64]:
    """From a coordinate to the nearest, or farthest, point of each cell."""
    if far:
        return np.maximum(np.abs(cells - at), np.abs(cells + 1 - at))
    return np.maximum(np.maximum(cells - at, at - cells - 1), 0.0)


def natural_cell_size(
    width: Fraction, height: Fraction, boxes: Iterable[RasterBox]
) -> Fraction | None:
    """Return the side of the largest cells whose lines all sides of boxes lie on.

    As somebody may have meant them. Where no box is one such cell thick, the cells are a part of
    that, at most 0.1 m.

    Args:
        width: Of the world, m.
        height: Same as above.
        boxes: Its walls.

    Returns:
        m; None if there are no such cells, or too many.
    """
    common = _common(width, height)
    longest = max(width, height)
    thinnest = None
    for box in boxes:
        for side in box:
            common = _common(common, side)
        thinnest = min(thinnest or longest, box.right - box.left, box.high - box.low)
        if longest > MAX_SIDE * common:
            return None
    if thinnest == common:
        return common
    size = next((common / divisor for divisor in _DIVISORS if common / divisor <= _USUAL), None)
    return size if size and longest <= _MOST_SIDE * size else None


def _common(a: Fraction, b: Fraction) -> Fraction:
    """Return the largest length of which both are multiples."""
    return Fraction(
        math.gcd(a.numerator * b.denominator, b.numerator * a.denominator),
        a.denominator * b.denominator,
    )
