"""Discs and outlines at poses, as other simulators have them, before they become cells."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np

from worldgen.interop.geometry.raster import Raster, RasterBox, RasterDisc
from worldgen.support.arrays import Floats

Point = tuple[Fraction, Fraction]

# Tolerance, rad; people write 1.57 for a quarter turn.
_NEAR_QUARTER = 1e-3


@dataclass
class Shapes:
    """The obstacles of a world, m; axis-parallel boxes are exact, the rest is in floating point."""

    boxes: list[RasterBox] = field(default_factory=list)
    circles: list[RasterDisc] = field(default_factory=list)
    polygons: list[Floats] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def disc(self, middle: Point, radius: Fraction, at: Point, heading: Fraction) -> None:
        """Add a disc that is fixed to a body at a pose."""
        if heading == 0 or not any(middle):
            x = float(middle[0] + at[0])
            y = float(middle[1] + at[1])
        else:
            x, y = turned(np.array([middle], np.float64), at, float(heading))[0].tolist()
        self.circles.append(RasterDisc(x, y, float(radius)))

    def outline(
        self, corners: Sequence[Point], at: Point, heading: Fraction, *, closed: bool = True
    ) -> None:
        """Add a polygon of a body at a pose, or the lines between its corners."""
        # A rectangle turned by whole quarters stays exact.
        quarters = round(float(heading) / (math.pi / 2))
        off = abs(float(heading) - quarters * math.pi / 2)
        sides = [sorted({corner[axis] for corner in corners}) for axis in (0, 1)]
        is_box = (
            closed
            and len(corners) == len(set(corners)) == 4
            and len(sides[0]) == len(sides[1]) == 2
        )
        if off < _NEAR_QUARTER and is_box:
            if off > 1e-6:
                self.notes.append(
                    f"a wall turned by {float(heading):g} rad counts as turned by {quarters} "
                    f"quarters"
                )
            (left, right), (low, high) = sides
            for _ in range(quarters % 4):
                left, low, right, high = -high, left, -low, right
            self.boxes.append(RasterBox(left + at[0], low + at[1], right + at[0], high + at[1]))
            return
        # Anything else becomes a polygon, or its sides.
        points = turned(np.array(corners, np.float64), at, float(heading))
        self.polygons.extend(
            [points] if closed else [points[index : index + 2] for index in range(len(points) - 1)]
        )

    def paint(self, raster: Raster) -> None:
        """Paint all of them."""
        for box in self.boxes:
            raster.box(box)
        for circle in self.circles:
            raster.circle(circle)
        for polygon in self.polygons:
            raster.polygon(polygon)


def turned(points: Floats, at: Point, heading: float) -> Floats:
    """Return the points of a body at a pose, (n, 2), m."""
    cos = math.cos(heading)
    sin = math.sin(heading)
    moved: Floats = points @ np.array([[cos, sin], [-sin, cos]]) + np.array(at, np.float64)
    return moved


def hull(points: Floats) -> Floats:
    """Return the corners of the smallest convex polygon around points, (n, 2), m."""
    import shapely

    around = shapely.convex_hull(shapely.multipoints(points))
    corners: Floats = shapely.get_coordinates(around)
    return corners[:-1] if len(corners) > 3 else corners
