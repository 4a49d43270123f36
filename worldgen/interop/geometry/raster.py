"""Rasterise the shapes of other worlds into cells.

A cell is solid if a shape reaches into it, so a path found here also exists there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from worldgen.domain import CELL_SIZES, MAX_SIDE
from worldgen.errors import FormatError, InvalidWorld
from worldgen.interop.format.foreign_map import MAX_CELLS
from worldgen.interop.geometry.boxes import merged_boxes
from worldgen.interop.geometry.section import Section, fill, slack
from worldgen.support.arrays import Bools, Floats, Ints

# Depth, cells, up to which a shape only touches a cell, because its coordinates were rounded.
_TOUCH = 1e-6
_MOST_PAINTED = (
    # Limit on the cells, counting each shape's window; more means an attack, or cells that are far
    # too small.
    500_000_000
)
# Limit on the corners; crossings grow with their square, and 500 random corners took minutes.
_MENDABLE = 8
# Half the width, cells, given to lines, because they stop robots too.
_LINE = 1e-3
# Number of cells painted in the time that one corner of one row takes.
_CORNER = 50
# Largest distance, cells; nothing beyond it is in any grid.
_FAR = 1e9
# Number of cells to aim for if we choose the cell size.
_MOST_SIDE = 2000
# Default cell size, m.
_USUAL = Fraction(1, 10)
_DIVISORS = [factor * 10**power for power in range(7) for factor in (1, 2, 5)]


class RasterBox(NamedTuple):
    """An axis-parallel rectangle, m, from the grid's corner, exact."""

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
        full: (height, width) bool: cells that are completely inside one shape.
    """

    def __init__(self, width: int, height: int, cell_size: Fraction) -> None:
        self.solid = np.zeros((height, width), np.bool_)
        self.full = np.zeros((height, width), np.bool_)
        self._cell_size = cell_size
        self._painted = 0

    @property
    def partly(self) -> int:
        """Number of solid cells that are not completely inside one shape."""
        return int(np.count_nonzero(self.solid & ~self.full))

    def box(self, box: RasterBox) -> None:
        """Paint an axis-parallel rectangle; its sides are exact."""
        left, low, right, high = (side / self._cell_size for side in box)
        if right <= left or high <= low:
            return
        outer = self._window(math.floor(left), math.floor(low), math.ceil(right), math.ceil(high))
        self.solid[outer] = True
        inner = self._window(math.ceil(left), math.ceil(low), math.floor(right), math.floor(high))
        self.full[inner] = True

    def picture(self, solid: Bools, across: Fraction, along: Fraction) -> None:
        """Paint a picture's solid pixels, bottom up, at a size in m, from the grid's corner."""
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

    def polygon(self, corners: Floats) -> None:
        """Paint a polygon of (n, 2) corners, m, or, if n is 2, a line without width."""
        # Nothing that far away is in the grid.
        points = corners / float(self._cell_size)
        if not np.abs(points).max() < _FAR:
            return
        shape = _prepared(points)
        window = self._around(*shape.bounds)
        # Charge for the work before it is done.
        self._spend(_CORNER * len(points) * (window[0].stop - window[0].start))
        inside, outside = _cut_into_rows(shape, *window)
        # Mark what the shape touches, and what it does not fill.
        solid = self.solid[window]
        full = np.ones_like(self.full[window])
        for row, first, end in inside.tolist():
            solid[row, first:end] = True
        for row, first, end in outside.tolist():
            full[row, first:end] = False
        self.full[window] |= full

    def section(self, section: Section) -> None:
        """Paint a section of bodies, m."""
        cells = Section(*(segments / float(self._cell_size) for segments in section))
        ends = np.concatenate([segments.reshape(-1, 2) for segments in cells])
        if not np.abs(ends).max() < _FAR:
            return
        # A sheet on a line blocks the cells on both sides of it.
        rows, columns = self._around(*(ends.min(axis=0) - _LINE), *(ends.max(axis=0) + _LINE))
        corner = np.array([columns.start, rows.start], np.float64)
        moved = Section(*(segments - corner for segments in cells))
        solid, full = fill(
            moved, columns.stop - columns.start, rows.stop - rows.start, slack(np.abs(ends).max())
        )
        self.solid[rows, columns] |= solid
        self.full[rows, columns] |= full

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
                "too-large", "the obstacles take too many cells", "use a larger cell_size"
            )


def _prepared(points: Floats) -> Any:
    """Return a valid shape of (n, 2) corners, in cells; two corners make a thin wall between them.

    Raises:
        InvalidWorld: If an outline of many corners crosses itself.
    """
    import shapely

    shape: Any = shapely.Polygon(points) if len(points) > 2 else shapely.LineString(points)
    if not shape.is_valid:
        if len(points) > _MENDABLE:
            raise InvalidWorld(
                "crosses-itself",
                "an outline of {corners} corners crosses itself",
                "draw it again, or as several",
                corners=len(points),
            )
        shape = shapely.make_valid(shape)
    if shape.area < _TOUCH:
        shape = shapely.buffer(shape, _LINE)
    shapely.prepare(shape)
    return shape


def _cut_into_rows(shape: Any, rows: slice, columns: slice) -> tuple[Ints, Ints]:
    """Return the cells of each row that the shape reaches into, and those left partly free.

    Args:
        shape: The shape, in cells.
        rows: Rows of the grid.
        columns: Columns of the grid.

    Returns:
        Two arrays (n, 3) int64 of row, first and end column, counted from the first row and column.
    """
    import shapely

    bands = shapely.box(
        columns.start,
        np.arange(rows.start, rows.stop),
        columns.stop,
        np.arange(rows.start, rows.stop) + 1,
    )
    inside = shapely.intersection(shape, bands)
    outside = shapely.difference(bands, shape)
    return _row_pieces(inside, columns), _row_pieces(outside, columns)


def _row_pieces(parts: npt.NDArray[np.object_], columns: slice) -> Ints:
    """Yield the row, the first and the end column of each piece of a row, without slivers."""
    import shapely

    pieces, index = shapely.get_parts(parts, return_index=True)
    # Collections contain the pieces.
    pieces, inner = shapely.get_parts(pieces, return_index=True)
    bounds = shapely.bounds(pieces)
    keep = (shapely.area(pieces) > _TOUCH**2) & (bounds[:, 3] - bounds[:, 1] > _TOUCH)
    first = np.floor(bounds[keep, 0] + _TOUCH).astype(np.int64)
    end = np.ceil(bounds[keep, 2] - _TOUCH).astype(np.int64)
    width = columns.stop - columns.start
    found = [
        index[inner][keep],
        np.clip(first - columns.start, 0, width),
        np.clip(end - columns.start, 0, width),
    ]
    return np.stack(found, axis=1)


def _distances(cells: Floats, at: float, far: bool) -> Floats:
    """Return the distances from a coordinate to the nearest, or farthest, point of each cell."""
    if far:
        return np.maximum(np.abs(cells - at), np.abs(cells + 1 - at))
    return np.maximum(np.maximum(cells - at, at - cells - 1), 0.0)


def natural_cell_size(
    width: Fraction, height: Fraction, boxes: Iterable[RasterBox]
) -> Fraction | None:
    """Return the side of the largest cells whose lines contain all sides of the boxes.

    That is probably the cell size the author had in mind. If no box is one such cell thick, the
    cells are a fraction of it, at most 0.1 m.

    Args:
        width: Width of the world, m.
        height: Height of the world, m.
        boxes: The world's walls.

    Returns:
        The side, m; None if there are no such cells, or too many.
    """
    # Find the largest length that divides all sides.
    common = _common(width, height)
    longest = max(width, height)
    thinnest = None
    for box in boxes:
        for side in box:
            common = _common(common, side)
        thinnest = min(thinnest or longest, box.right - box.left, box.high - box.low)
        if longest > MAX_SIDE * common:
            return None
    # If no wall is that thin, the author probably had larger cells in mind.
    if thinnest == common:
        return common
    size = next((common / divisor for divisor in _DIVISORS if common / divisor <= _USUAL), None)
    return size if size and longest <= _MOST_SIDE * size else None


def _common(a: Fraction, b: Fraction) -> Fraction:
    """Return the largest length that divides both."""
    return Fraction(
        math.gcd(a.numerator * b.denominator, b.numerator * a.denominator),
        a.denominator * b.denominator,
    )


def painted(
    extent: tuple[Fraction, Fraction], cell_size: Fraction, paint: Callable[[Raster], None]
) -> Raster:
    """Return a grid of this size after ``paint`` has put a file's shapes into it.

    Args:
        extent: Width and height of the world, m.
        cell_size: Side of a cell, m.
        paint: Paints the shapes.

    Raises:
        FormatError: If the cells are too small, too large or too many.
    """
    if not CELL_SIZES[0] <= cell_size <= CELL_SIZES[1]:
        raise FormatError(
            "out-of-range",
            "cells of {cell_size:g} m",
            "use {low:g} to {high:g} m",
            cell_size=float(cell_size),
            low=CELL_SIZES[0],
            high=CELL_SIZES[1],
        )
    width, height = (math.ceil(side / cell_size) for side in extent)
    if max(width, height) > MAX_SIDE or width * height > MAX_CELLS:
        raise FormatError(
            "wrong-size",
            "the world takes {width} x {height} cells of {cell_size:g} m",
            "use a larger cell_size",
            width=width,
            height=height,
            cell_size=float(cell_size),
        )
    raster = Raster(width, height, cell_size)
    try:
        paint(raster)
    except InvalidWorld as error:
        raise FormatError.of(error.message) from error
    return raster
