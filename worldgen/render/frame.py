"""The map's place in the picture: metres to pixels, y up to y down."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from worldgen.parameters.bounds import check_between
from worldgen.support.arrays import Bools, Floats
from worldgen.world import World

DEFAULT_PIXELS = 900
# Smaller pictures are unreadable; larger ones take gigabytes.
MIN_PIXELS = 100
MAX_PIXELS = 8000
# px; cells at least this wide get a whole number of pixels, so that walls have sharp edges.
CRISP_CELL = 8
# Width of the wall around the map, units: everything outside the grid is solid.
BAND = 7.0
# Width of the white paper around the band, units.
MARGIN = 12.0
# Additional margin for the numbers of columns and rows, units.
NUMBERS = 14.0
# Minimum width of a picture, units, to fit the caption.
NARROWEST = 380.0


@dataclass(frozen=True, slots=True)
class Window:
    """A rectangle of cells; (x, y) is its lower left one."""

    x: int
    y: int
    width: int
    height: int


@dataclass(frozen=True, slots=True)
class Frame:
    """The map's place in a picture. Pixels count from the top left corner, x right, y down.

    Args:
        left: x of the map's left edge, px.
        top: y of the map's top edge, px.
        width: Width of the map, px.
        height: Height of the map, px.
        scale: px per m, the same in x and y.
        unit: Pixels per point of line width and type; grows with the picture.
        cell: Side of a cell, px; may be far below one.
        picture_width: Width of the whole picture, px.
        window: The cells that the map shows.
        world_width: Cells of the whole world across.
    """

    left: int
    top: int
    width: int
    height: int
    scale: float
    unit: float
    cell: float
    picture_width: int
    window: Window
    world_width: int

    @classmethod
    def of(
        cls,
        world: World,
        pixels: int = DEFAULT_PIXELS,
        *,
        is_numbered: bool = False,
        window: Window | None = None,
    ) -> Frame:
        """Return the frame of a world's picture with a map of at most ``pixels`` on either side.

        ``is_numbered`` leaves room for the numbers of columns and rows; ``window`` is the part of
        the world to show, all of it if omitted.

        Raises:
            InvalidParameter: If ``pixels`` is out of range.
        """
        check_between("pixels", pixels, MIN_PIXELS, MAX_PIXELS)
        window = window or Window(0, 0, world.width, world.height)
        longest = max(window.width, window.height)
        cell = pixels / longest
        # Whole pixels per cell keep the edges sharp; below a few pixels the map would shrink too
        # much.
        if cell >= CRISP_CELL:
            cell = float(math.floor(cell))
        unit = min(max(pixels / DEFAULT_PIXELS, 0.75), 6.0)
        width = max(1, round(window.width * cell))
        height = max(1, round(window.height * cell))
        edge = round((BAND + MARGIN + (NUMBERS if is_numbered else 0.0)) * unit)
        # A narrow map gets a wider picture, so that the caption has room.
        picture_width = max(width + 2 * edge, round(NARROWEST * unit))
        left = (picture_width - width) // 2
        return cls(
            left,
            edge,
            width,
            height,
            cell / world.cell_size,
            unit,
            cell,
            picture_width,
            window,
            world.width,
        )

    @property
    def bottom(self) -> int:
        """Bottom edge of the map: y, px."""
        return self.top + self.height

    @property
    def band(self) -> int:
        """Width of the wall around the map, px."""
        return round(BAND * self.unit)

    @property
    def margin(self) -> int:
        """Width of the white paper around the band, px."""
        return round(MARGIN * self.unit)

    def to_pixels(self, x: float, y: float) -> tuple[float, float]:
        """Convert a place in m to a point in the picture."""
        left, bottom = self._origin
        return left + x * self.scale, bottom - y * self.scale

    def points(self, metres: npt.ArrayLike) -> Floats:
        """Return a (n, 2) float64 array of px for (n, 2) places in m."""
        return _placed(metres, *self._origin, self.scale)

    def corners(self, cells: npt.ArrayLike) -> Floats:
        """Return a (n, 2) float64 array of px for (n, 2) cell corners; (0, 0) is lower left."""
        return _placed(cells, *self._origin, self.cell)

    @property
    def _origin(self) -> tuple[float, float]:
        """Where the world's lower left corner is, px, perhaps outside the picture."""
        return self.left - self.window.x * self.cell, self.bottom + self.window.y * self.cell

    def part(self, mask: Bools) -> Bools:
        """Return the part of a mask of the world's cells, or of equal parts of them, in the map."""
        times = mask.shape[1] // self.world_width
        x, y = self.window.x * times, self.window.y * times
        return mask[y : y + self.window.height * times, x : x + self.window.width * times]


def _placed(points: npt.ArrayLike, left: float, bottom: float, scale: float) -> Floats:
    moved = np.array(points, np.float64)
    moved *= (scale, -scale)
    moved += (left, bottom)
    return moved
