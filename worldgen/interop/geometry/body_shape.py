"""The shapes of a robot's body in files of simulators."""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

from worldgen.lattice import exact
from worldgen.robot import Robot


class BodyBox(NamedTuple):
    """A rectangle along the robot's axes, m: its middle, seen from the axle, and its sides."""

    ahead: Fraction
    left: Fraction
    length: Fraction
    width: Fraction


def body_box(robot: Robot) -> BodyBox | None:
    """Return a body that is a rectangle along its axes, exactly; None for any other body."""
    xs, ys = ({exact(corner[axis]) for corner in robot.footprint} for axis in (0, 1))
    if len(robot.footprint) != 4 or len(xs) != 2 or len(ys) != 2:
        return None
    return BodyBox(
        (max(xs) + min(xs)) / 2, (max(ys) + min(ys)) / 2, max(xs) - min(xs), max(ys) - min(ys)
    )
