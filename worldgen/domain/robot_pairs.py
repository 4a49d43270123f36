"""Rules for the robots of one world: no two may overlap at the start or block each other's target.

A world of several robots that breaks one of these rules is refused when it is built, so that code
that reads worlds need not handle the case.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from worldgen.errors import Message

if TYPE_CHECKING:
    from worldgen.world import Robot

# Pairs are compared in float64 first. The exact comparison decides only pairs within this fraction
# of the limit, which is far more than the rounding error of a few operations.
_DOUBT = 1e-6
# Lattice units per cell, as in `worldgen.lattice`, which checkers must not import.
_UNIT = 1024


def pair_fault(robots: Sequence[Robot], cell_size: float) -> Message | None:
    """Return what is wrong with the first pair of robots that cannot be in one world.

    Two discs may touch. Starts are checked both as the world's decimals give them and as the
    simulator rounds them to the lattice.

    Args:
        robots: All robots, in order.
        cell_size: Side of a cell, m.
    """
    radii = np.array([robot.radius for robot in robots])
    starts = np.array([(robot.start.x, robot.start.y) for robot in robots])
    targets = np.array([(robot.target.x, robot.target.y) for robot in robots])
    reaches = np.array([robot.target.radius for robot in robots])
    apart = radii[:, None] + radii[None, :]
    room = np.hypot(*(targets[:, None, :] - targets[None, :, :]).transpose(2, 0, 1))
    room += reaches[:, None] + reaches[None, :]
    gap = np.hypot(*(starts[:, None, :] - starts[None, :, :]).transpose(2, 0, 1))

    # Rounding to the lattice moves each start by at most half a unit in x and in y.
    slack = apart * _DOUBT + cell_size / 512
    doubtful = np.triu((gap < apart + slack) | (room < apart * (1 + _DOUBT)), 1)
    for first, second in np.argwhere(doubtful).tolist():
        message = _fault_of(first, second, robots, cell_size)
        if message is not None:
            return message
    return None


def _fault_of(first: int, second: int, robots: Sequence[Robot], cell_size: float) -> Message | None:
    one = robots[first]
    two = robots[second]
    apart = _exact(one.radius) + _exact(two.radius)
    size = _exact(cell_size)
    for is_rounded in (False, True):
        dx = _across(one.start.x, two.start.x, size, is_rounded)
        dy = _across(one.start.y, two.start.y, size, is_rounded)
        if dx * dx + dy * dy < (apart / size) ** 2:
            return Message(
                "robots-overlap",
                "robots {first} and {second} overlap at the start: their centres are {gap:.6g} m "
                "apart, and their radii add up to {radii:.6g} m",
                "move one of them",
                first=first + 1,
                second=second + 1,
                gap=float(np.hypot(one.start.x - two.start.x, one.start.y - two.start.y)),
                radii=float(apart),
            )

    # The two centres that are farthest apart are on the line through the centres of the targets.
    needed = apart - _exact(one.target.radius) - _exact(two.target.radius)
    dx = _exact(one.target.x) - _exact(two.target.x)
    dy = _exact(one.target.y) - _exact(two.target.y)
    if needed > 0 and dx * dx + dy * dy < needed * needed:
        return Message(
            "targets-exclude",
            "the targets of robots {first} and {second} exclude each other: the radii add up to "
            "{radii:.6g} m, but no two points in the targets are that far apart",
            "move one of them, or make one larger",
            first=first + 1,
            second=second + 1,
            radii=float(apart),
        )
    return None


def _exact(metres: float) -> Fraction:
    """Return the number given by its shortest decimal."""
    return Fraction(repr(float(metres)))


def _across(one: float, two: float, size: Fraction, is_rounded: bool) -> Fraction:
    """Return the distance between two coordinates, in cells, exact or rounded to the lattice."""
    first = _exact(one) / size
    second = _exact(two) / size
    if is_rounded:
        first = Fraction(math.floor(first * _UNIT + Fraction(1, 2)), _UNIT)
        second = Fraction(math.floor(second * _UNIT + Fraction(1, 2)), _UNIT)
    return first - second
