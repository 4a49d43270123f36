"""A car's path as arcs and lines, for programs that drive it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

from worldgen.lattice import TURN, UNIT
from worldgen.support.arrays import Ints


class Stretch(NamedTuple):
    """A part of a path with one curvature and one gear.

    Args:
        x: Where it begins, m.
        y: The same.
        heading: Heading of the car there, rad.
        curvature: Turn per length driven, rad/m: positive if the heading increases.
        length: m.
        gear: 1 forwards, -1 backwards.
    """

    x: float
    y: float
    heading: float
    curvature: float
    length: float
    gear: int


def stretches_of(poses: Ints, turning_radius: float, cell_size: float) -> list[Stretch]:
    """Return a path's arcs and lines, as few as possible.

    Args:
        poses: (n, 3) int64, x and y in lu, heading in 1/65536 turn, as from a search.
        turning_radius: Radius of all arcs, m.
        cell_size: m.
    """
    unit = cell_size / UNIT
    found: list[Stretch] = []
    legs = ((leg_of(*leg), leg[0]) for leg in itertools.pairwise(poses.tolist()))
    kinds = itertools.groupby(
        legs, lambda leg: ((leg[0].turn > 0) - (leg[0].turn < 0), leg[0].gear)
    )
    for (side, gear), group in kinds:
        drives = list(group)
        x, y, heading = drives[0][1]
        length = unit * sum(leg.length for leg, _ in drives)
        if side:
            length = turning_radius * abs(sum(leg.turn for leg, _ in drives)) * math.tau / TURN
        heading *= math.tau / TURN
        found.append(Stretch(x * unit, y * unit, heading, side / turning_radius, length, gear))
    return found


class Leg(NamedTuple):
    """A drive from one pose to the next.

    Args:
        turn: 1/65536 turn, positive if the heading increases.
        length: lu.
        gear: 1 forwards, -1 backwards.
    """

    turn: int
    length: float
    gear: int


def leg_of(before: Sequence[int], after: Sequence[int]) -> Leg:
    """Return the leg between two poses, each x, y and heading."""
    turn = (after[2] - before[2] + TURN // 2) % TURN - TURN // 2
    along = (before[2] + turn / 2) * math.tau / TURN
    dx, dy = after[0] - before[0], after[1] - before[1]
    gear = 1 if dx * math.cos(along) + dy * math.sin(along) >= 0 else -1
    return Leg(turn, math.hypot(dx, dy), gear)
