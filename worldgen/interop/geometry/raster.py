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
# Number of corners that take as long as a row of a shape takes besides its corners.
_BAND = 15
# Shapes with more corners are cut in half before they are cut into rows.
_MANY_CORNERS = 200
# Rows of shapes that are cut at a time.
_MOST_BANDS = 100_000
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
        if np.abs(points).max() < _FAR:
            self._check_sides(np.vstack([points, points[:1]]), np.zeros(len(points) + 1, np.intp))
            self.shapes([_prepared(points)])

    def shapes(self, shapes: Any) -> None:
        """Paint shapely geometries whose unit is a cell; those without an area are thin walls."""
        import shapely

        pieces = shapely.get_parts(np.asarray(shapes, np.object_))
        self._check_sides(*shapely.get_coordinates(shapely.get_rings(pieces), return_index=True))
        # Scaling may have rounded corners onto other sides.
        invalid = ~shapely.is_valid(pieces)
        pieces[invalid] = shapely.make_valid(
            pieces[invalid], method="structure", keep_collapsed=False
        )
        pieces = shapely.get_parts(pieces[~shapely.is_empty(pieces)])
        thin = (shapely.get_dimensions(pieces) < 2) | (shapely.area(pieces) < _TOUCH)
        pieces[thin] = shapely.buffer(pieces[thin], _LINE)
        height, width = self.solid.shape
        grid = shapely.box(0, 0, width, height)
        bounds = shapely.bounds(pieces)
        across = ~(
            (bounds[:, :2] >= 0).all(axis=1) & (bounds[:, 2:] <= (width, height)).all(axis=1)
        )
        pieces[across] = shapely.intersection(pieces[across], grid)
        pieces = _halved(pieces[~shapely.is_empty(pieces)])
        bounds = shapely.bounds(pieces)
        lows = np.floor(bounds[:, 1] + 0.0).astype(np.int64).clip(0, height)
        highs = np.ceil(bounds[:, 3]).astype(np.int64).clip(0, height)
        corners = shapely.get_num_coordinates(pieces)
        # Charge for all rows before the first is cut.
        self._spend(int(_CORNER * ((corners + _BAND) * (highs - lows)).sum()))
        begin = 0
        while begin < len(pieces):
            # Take as many as fit into memory.
            rows = np.cumsum(highs[begin:] - lows[begin:])
            end = begin + max(1, int(np.searchsorted(rows, _MOST_BANDS)))
            self._bands(pieces[begin:end], lows[begin:end], highs[begin:end])
            begin = end

    def _bands(self, shapes: Any, lows: Ints, highs: Ints) -> None:
        """Paint shapes row by row."""
        import shapely

        width = self.solid.shape[1]
        which = np.repeat(np.arange(len(shapes)), highs - lows)
        first = np.cumsum(highs - lows) - (highs - lows)
        rows = np.arange(len(which)) - first[which] + lows[which]
        bounds = shapely.bounds(shapes)[which]
        begins = np.floor(bounds[:, 0]).clip(0, width)
        ends = np.ceil(bounds[:, 2]).clip(0, width)
        self._spend(int((ends - begins).sum()))
        bands = shapely.box(begins, rows, ends, rows + 1)
        inside = _row_pieces(shapely.intersection(shapes[which], bands), width)
        outside = _row_pieces(shapely.difference(bands, shapes[which]), width)
        # Mark what the shapes touch, and what they fill.
        for band, begin, end in inside.tolist():
            self.solid[rows[band], begin:end] = True
        at = begins.astype(np.int64)
        for band, begin, end in outside[np.lexsort((outside[:, 1], outside[:, 0]))].tolist():
            self.full[rows[band], at[band] : begin] = True
            at[band] = max(at[band], end)
        for row, begin, end in zip(rows.tolist(), at.tolist(), ends.tolist(), strict=True):
            self.full[row, begin : int(end)] = True

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
        self._check(work)
        self._painted += work

    def _check_sides(self, points: Floats, ring: Ints) -> None:
        """Refuse rings whose sides are sure to cost too much, before anything looks for crossings.

        A side has a corner in each row that it spans, however the rings are cut into rows. Without
        this, a star of 20,000 rays was refused only after 23 s.
        """
        height, width = self.solid.shape
        x, y = points.T
        across = (x >= 0) & (x <= width)
        rows = np.floor(np.abs(np.diff(y.clip(0, height))))
        kept = (np.diff(ring) == 0) & across[1:] & across[:-1]
        self._check(int(_CORNER * rows[kept].sum()))

    def _check(self, work: int) -> None:
        if self._painted + work > _MOST_PAINTED:
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
    return shape


def _halved(shapes: Any) -> Any:
    """Return shapes of which none has many corners in many rows, because each row costs them all."""
    import shapely

    done = []
    while len(shapes):
        bounds = shapely.bounds(shapes)
        tall = bounds[:, 3] - bounds[:, 1]
        large = (shapely.get_num_coordinates(shapes) > _MANY_CORNERS) & (tall > 2)
        done.append(shapes[~large])
        left, low, right, high = bounds[large].T
        middle = np.floor((low + high) / 2)
        halves = [shapely.box(left, low, right, middle), shapely.box(left, middle, right, high)]
        cut = [shapely.intersection(shapes[large], half) for half in halves]
        parts = shapely.get_parts(np.concatenate(cut))
        shapes = parts[shapely.area(parts) > 0]
    return np.concatenate([*done, shapes])


def _row_pieces(parts: npt.NDArray[np.object_], width: int) -> Ints:
    """Return the band, the first and the end column of each piece of a band, without slivers."""
    import shapely

    pieces, index = shapely.get_parts(parts, return_index=True)
    # Collections contain the pieces.
    pieces, inner = shapely.get_parts(pieces, return_index=True)
    bounds = shapely.bounds(pieces)
    keep = (shapely.area(pieces) > _TOUCH**2) & (bounds[:, 3] - bounds[:, 1] > _TOUCH)
    first = np.floor(bounds[keep, 0] + _TOUCH).astype(np.int64)
    end = np.ceil(bounds[keep, 2] - _TOUCH).astype(np.int64)
    found = [index[inner][keep], np.clip(first, 0, width), np.clip(end, 0, width)]
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
