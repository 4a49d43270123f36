"""Find the cells of one grid that the solid pixels of another, turned and scaled one reach into."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from worldgen.support.arrays import Bools

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
    padded = np.pad(solid, 1, constant_values=outside)
    columns = shape[1]
    found = np.zeros(shape, np.bool_)
    step = max(1, _CHUNK // columns)
    for row in range(0, shape[0], step):
        _fill_turned(found[row : row + step], row, padded, frame)
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


def _fill_turned(found: Bools, first_row: int, padded: Bools, frame: PixelFrame) -> None:
    """Set the cells of some rows that share an area with a solid pixel.

    Two squares share an area if no line along a side of one of them separates them.

    Args:
        found: (rows, columns) bool, all False; changed in place.
        first_row: Number of its first row in the grid.
        padded: The pixels with one more around them.
        frame: Where the pixels are.
    """
    # Take each cell's centre into the picture, in pixels.
    rows, columns = found.shape
    c, s = frame.direction
    per_cell = 1.0 / float(frame.side)
    x = np.arange(columns) + (0.5 - float(frame.x))
    y = np.arange(first_row, first_row + rows)[:, None] + (0.5 - float(frame.y))
    u = (c * x + s * y) * per_cell
    v = (c * y - s * x) * per_cell
    left = np.floor(u).astype(np.int64)
    low = np.floor(v).astype(np.int64)
    height, width = (side - 2 for side in padded.shape)

    # Half the extent of both squares along a pixel's side and along a cell's side.
    spread = abs(c) + abs(s)
    along_pixel = 0.5 + 0.5 * per_cell * spread + _ROUNDING
    along_cell = 0.5 * per_cell + 0.5 * spread + _ROUNDING
    most = math.floor(along_pixel + 0.5)
    for dj in range(-most, most + 1):
        row = np.clip(low + dj, -1, height) + 1
        dv = low + (dj + 0.5) - v
        for di in range(-most, most + 1):
            du = left + (di + 0.5) - u
            meets = (np.abs(du) < along_pixel) & (np.abs(dv) < along_pixel)
            meets &= np.abs(c * du - s * dv) < along_cell
            meets &= np.abs(s * du + c * dv) < along_cell
            found |= meets & padded[row, np.clip(left + di, -1, width) + 1]
