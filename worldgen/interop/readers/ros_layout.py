"""How the grid of a world lies in the frame of a ROS map whose picture may be turned."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from worldgen.interop.format.foreign_map import ForeignRobot, check_sides
from worldgen.interop.geometry.turned_pixels import PixelFrame, bounds_of, cells_reached
from worldgen.interop.readers.ros_metadata import RosMetadata
from worldgen.lattice import exact
from worldgen.support.arrays import Bools

_NOWHERE = (Fraction(0), Fraction(0))
# Cells by which a rounded quarter turn may be off without a warning.
_WORTH_SAYING = 0.01


class RosLayout(NamedTuple):
    """How the grid of a world lies in the map's frame.

    Args:
        corner: x and y, m, of its lower-left corner in the frame that places are given in.
        side: Side of a cell, m.
        shape: Rows and columns.
        frame: Where the picture is in the grid.
        axes: The grid's own corner, m, and its turn, in the map's frame.
        is_picture: True if the cells are the picture's own although it is turned.
    """

    corner: tuple[float, float]
    side: float
    shape: tuple[int, int]
    frame: PixelFrame
    axes: tuple[float, float, int, float]
    is_picture: bool

    @classmethod
    def of(cls, metadata: RosMetadata, shape: tuple[int, int], frame: str) -> RosLayout:
        """Return the layout of a picture of this shape.

        Raises:
            FormatError: If the turned picture needs more cells than a world may have.
        """
        quarters, rest = metadata.turn(*shape)
        x, y = metadata.origin
        side = metadata.resolution
        if frame == "picture" and metadata.yaw != 0.0:
            return cls((0.0, 0.0), side, shape, PixelFrame(*_NOWHERE), (x, y, quarters, rest), True)
        turned = PixelFrame(*_NOWHERE, quarters=quarters, rest=rest)
        left, low, right, high = bounds_of(shape, turned)
        check_sides(right - left, high - low, remedy="use --frame picture, or turn the picture")
        corner = (float(exact(x) + left * exact(side)), float(exact(y) + low * exact(side)))
        turned = turned._replace(x=Fraction(-left), y=Fraction(-low))
        return cls(corner, side, (high - low, right - left), turned, (*corner, 0, 0.0), False)

    @property
    def rest(self) -> float:
        """Angle, rad, between the picture's pixels and the cells."""
        return self.frame.rest

    def cells(self, pixels: Bools) -> Bools:
        """Return the solid cells of the picture's solid pixels, row 0 the lowest."""
        if self.rest == 0.0:
            return np.ascontiguousarray(np.rot90(pixels, -self.frame.quarters))
        return cells_reached(pixels, self.frame, self.shape, outside=True)

    def other(self, metadata: RosMetadata, shape: tuple[int, int]) -> PixelFrame:
        """Return where the pixels of another map are in this grid."""
        x, y, quarters, rest = self.axes
        own_quarters, own_rest = metadata.turn(*shape)
        size = exact(self.side)
        dx, dy = exact(metadata.origin[0]) - exact(x), exact(metadata.origin[1]) - exact(y)
        # Whole quarter turns and equal angles leave the numbers exact.
        c, s = _direction(quarters, rest)
        turned = (dx * c + dy * s, dy * c - dx * s)
        difference = own_rest - rest if own_rest != rest else 0.0
        return PixelFrame(
            turned[0] / size, turned[1] / size, exact(metadata.resolution) / size,
            own_quarters - quarters, difference,
        )  # fmt: skip

    def placed(self, robot: ForeignRobot, metadata: RosMetadata) -> ForeignRobot:
        """Return a robot with its places measured from the grid's corner, along its axes."""
        if metadata.yaw == 0.0:
            return robot
        x, y, quarters, rest = self.axes
        c, s = _direction(quarters, rest)

        def moved(place: tuple[float, ...] | None, turn: float) -> tuple[float, ...] | None:
            if place is None:
                return None
            dx, dy = exact(place[0]) - exact(x), exact(place[1]) - exact(y)
            third = [value - turn for value in place[2:]]
            return (float(dx * c + dy * s), float(dy * c - dx * s), *third)

        turn = metadata.yaw if self.is_picture else 0.0
        goal = robot.goal
        if goal is not None and goal.heading is not None:
            goal = replace(goal, heading=goal.heading - turn)
        return robot._replace(
            start=moved(robot.start, turn), target=moved(robot.target, 0.0), goal=goal
        )

    def notes(self, metadata: RosMetadata) -> list[str]:
        """Return how places in the world and in the map belong together."""
        yaw = metadata.yaw
        x, y = metadata.origin if self.is_picture else self.corner
        if self.is_picture:
            c, s = math.cos(yaw), math.sin(yaw)
            return [
                f"cells and places are the picture's, which ROS shows turned by {yaw:g} rad: the "
                f"world's (x, y) is the map's ({x:g} + {c:.6g} x - {s:.6g} y, {y:g} + {s:.6g} x + "
                f"{c:.6g} y)".replace("- -", "+ ").replace("+ -", "- ")
            ]
        found = []
        if self.rest != 0.0:
            found.append(
                f"the picture is turned by {yaw:g} rad about its lower-left corner, as ROS shows it; "
                f"a cell is solid if anything solid of the picture, or the outside, reaches into it"
            )
        elif yaw != 0.0:
            quarters = self.frame.quarters
            found.append(
                f"the picture is turned by {quarters} quarters, according to its yaw of {yaw:g}"
            )
        if x != 0.0 or y != 0.0:
            found.append(
                f"the world's (0, 0) is the map's ({x:g}, {y:g}) m; add that to compare with ROS"
            )
        return found

    def warnings(self, metadata: RosMetadata) -> list[str]:
        """Return a warning if the yaw is only almost the quarter turn that was taken."""
        _, rest = metadata.turn(*self.shape)
        off = metadata.yaw - round(metadata.yaw / (math.pi / 2)) * math.pi / 2
        moved = abs(off) * math.hypot(*self.shape)
        if rest != 0.0 or self.is_picture or moved < _WORTH_SAYING:
            return []
        return [
            f"the yaw of {metadata.yaw:g} counts as a quarter turn, of which it is the rounding; "
            f"that moves cells by up to {moved:.2g} sides"
        ]


def _direction(quarters: int, rest: float) -> tuple[Fraction, Fraction]:
    """Return cosine and sine of an angle; whole quarter turns are exact."""
    c, s = Fraction(math.cos(rest)), Fraction(math.sin(rest))
    for _ in range(quarters % 4):
        c, s = -s, c
    return c, s
