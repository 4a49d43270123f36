"""Find the cells of one grid that the solid pixels of another, turned and scaled one reach into."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from worldgen.support.arrays import Bools, Floats, Ints

# Depth, cells, up to which a pixel only touches a cell: pixels along the grid's axes have rounded
# origins, and touch everywhere.
_TOUCH = Fraction(1, 1_000_000)
# Margin, pixels, above the error of float64 on the largest map. Turned pixels this close to a cell
# count as reaching into it, so that no solid pixel is ever missed.
_ROUNDING = 1e-9
# Cells computed at a time.
_CHUNK = 1 << 19


class PixelFrame(NamedTuple):
    """Where a picture's pixels are, measured in cells from the grid's lower-left corner.

    Args:
        x: The picture's lower-left corner.
        y: The same.
        side: Side of a pixel.
        quarters: Quarter turns, counter-clockwise, of the picture about its lower-left corner.
        rest: Angle, rad, by which it is turned in addition.
    """

    x: Fraction
    y: Fraction
    side: Fraction = Fraction(1)
    quarters: int = 0
    rest: float = 0.0

    @property
    def direction(self) -> tuple[float, float]:
        """Cosine and sine of the whole angle."""
        c, s = math.cos(self.rest), math.sin(self.rest)
        for _ in range(self.quarters % 4):
            c, s = -s, c
        return c, s

    @property
    def is_aligned(self) -> bool:
        """True if each pixel fills whole cells."""
        numbers = (self.x, self.y, self.side)
        return self.rest == 0.0 and all(abs(one - round(one)) <= _TOUCH for one in numbers)


def bounds_of(shape: tuple[int, int], frame: PixelFrame) -> tuple[int, int, int, int]:
    """Return the columns and rows of cells around a picture: left, low, right and high.

    Args:
        shape: Height and width, pixels.
        frame: Where the picture is.
    """
    height, width = (float(side * frame.side) for side in shape)
    c, s = frame.direction
    xs = [float(frame.x) + c * u - s * v for u in (0.0, width) for v in (0.0, height)]
    ys = [float(frame.y) + s * u + c * v for u in (0.0, width) for v in (0.0, height)]
    touch = float(_TOUCH)
    return (
        math.floor(min(xs) + touch),
        math.floor(min(ys) + touch),
        math.ceil(max(xs) - touch),
        math.ceil(max(ys) - touch),
    )


def cells_reached(
    solid: Bools, frame: PixelFrame, shape: tuple[int, int], *, outside: bool
) -> Bools:
    """Return the cells that share an area with a solid pixel.

    Args:
        solid: (height, width) bool, the pixels; row 0 is the lowest.
        frame: Where the pixels are.
        shape: Rows and columns of the grid.
        outside: True if everything around the picture counts as solid pixels.
    """
    if frame.rest == 0.0:
        return _along_axes(solid, frame, shape, outside)
    # Half the extent of a pixel and a cell along a pixel's side, and along a cell's side, pixels.
    c, s = frame.direction
    per_cell = 1.0 / float(frame.side)
    spread = abs(c) + abs(s)
    along_pixel = 0.5 + 0.5 * per_cell * spread + _ROUNDING
    along_cell = 0.5 * per_cell + 0.5 * spread + _ROUNDING
    reach = math.floor(along_pixel + 0.5)

    padded = np.pad(solid, reach + 1, constant_values=outside)
    near = _spread(padded, reach)
    found = np.zeros(shape, np.bool_)
    step = max(1, _CHUNK // shape[1])
    for row in range(0, shape[0], step):
        part = found[row : row + step]
        # Take each cell's centre into the picture, in pixels.
        x = np.arange(shape[1]) + (0.5 - float(frame.x))
        y = np.arange(row, row + len(part))[:, None] + (0.5 - float(frame.y))
        u = (c * x + s * y) * per_cell
        v = (c * y - s * x) * per_cell
        left = _clipped(u, solid.shape[1], reach)
        low = _clipped(v, solid.shape[0], reach)
        # The pixel at its centre certainly shares an area with it; few others need a closer look.
        part |= padded[low, left]
        places = np.nonzero(near[low, left] & ~part)
        part[places] = _meets(padded, (c, s), u[places], v[places], reach, along_pixel, along_cell)
    return found


def _spread(solid: Bools, reach: int) -> Bools:
    """Return which pixels have a solid one at most so many rows and columns away."""
    found = solid.copy()
    for axis in (0, 1):
        source = found.copy()
        for shift in range(1, reach + 1):
            ahead, behind = slice(shift, None), slice(None, -shift)
            here = (ahead, slice(None)) if axis == 0 else (slice(None), ahead)
            there = (behind, slice(None)) if axis == 0 else (slice(None), behind)
            found[here] |= source[there]
            found[there] |= source[here]
    return found


def _clipped(position: Floats, pixels: int, reach: int) -> Ints:
    """Return the index, in a padded picture, of the pixel at a position; or of one outside it."""
    index: Ints = np.clip(np.floor(position), -1, pixels).astype(np.int64) + reach + 1
    return index


def _meets(
    padded: Bools,
    direction: tuple[float, float],
    u: Floats,
    v: Floats,
    reach: int,
    along_pixel: float,
    along_cell: float,
) -> Bools:
    """Return which cells share an area with a solid pixel near their centre.

    Two squares share an area if no line along a side of one of them separates them.

    Args:
        padded: The pixels with more around them.
        direction: Cosine and sine of the angle between the two grids.
        u: (n,) The cells' centres, pixels.
        v: The same.
        reach: Pixels around the centre to look at.
        along_pixel: Half the extent of a pixel and a cell along a pixel's side, pixels.
        along_cell: The same along a cell's side.
    """
    c, s = direction
    height, width = (side - 2 * (reach + 1) for side in padded.shape)
    found = np.zeros(len(u), np.bool_)
    left, low = np.floor(u), np.floor(v)
    for dj in range(-reach, reach + 1):
        row = _clipped(low + dj, height, reach)
        dv = low + (dj + 0.5) - v
        for di in range(-reach, reach + 1):
            du = left + (di + 0.5) - u
            meets = (np.abs(du) < along_pixel) & (np.abs(dv) < along_pixel)
            meets &= np.abs(c * du - s * dv) < along_cell
            meets &= np.abs(s * du + c * dv) < along_cell
            found |= meets & padded[row, _clipped(left + di, width, reach)]
    return found


def _along_axes(solid: Bools, frame: PixelFrame, shape: tuple[int, int], outside: bool) -> Bools:
    """As :func:`cells_reached` for whole quarter turns: rows and columns are independent."""
    turned = np.rot90(solid, -frame.quarters)
    height, width = (side * frame.side for side in turned.shape)
    across, up = ((0, 0), (-width, 0), (-width, -height), (0, -height))[frame.quarters % 4]
    rows = _spans(turned.shape[0], frame.y + up, frame.side, shape[0])
    columns = _spans(turned.shape[1], frame.x + across, frame.side, shape[1])

    # Spread the pixels over the cells of their rows, then of their columns.
    high = np.zeros((shape[0], turned.shape[1]), np.bool_)
    for pixel, (low, end) in enumerate(rows):
        high[low:end] |= turned[pixel]
    found = np.zeros(shape, np.bool_)
    for pixel, (low, end) in enumerate(columns):
        found[:, low:end] |= high[:, pixel : pixel + 1]

    # Cells that the picture does not cover entirely reach out of it.
    if outside:
        inside = np.zeros(shape, np.bool_)
        inside[
            _covered(frame.y + up, height, shape[0]), _covered(frame.x + across, width, shape[1])
        ] = True
        found |= ~inside
    return found


def _spans(pixels: int, corner: Fraction, side: Fraction, cells: int) -> list[tuple[int, int]]:
    """Return the first cell of each pixel along one axis, and the one after its last."""
    edges = [corner + index * side for index in range(pixels + 1)]
    return [
        (min(max(math.floor(low + _TOUCH), 0), cells), min(max(math.ceil(high - _TOUCH), 0), cells))
        for low, high in itertools.pairwise(edges)
    ]


def _covered(corner: Fraction, length: Fraction, cells: int) -> slice:
    """Return the cells along one axis that lie within a picture."""
    first = max(math.ceil(corner - _TOUCH), 0)
    return slice(first, max(first, min(math.floor(corner + length + _TOUCH), cells)))
