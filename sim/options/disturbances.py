"""Disturbances that move a robot in addition to its wheels, and whether it can still arrive.

Options write pushes and decoys as flat lists of numbers; this module reads them.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction

from sim.options.robot import RobotOptions
from worldgen.lattice import exact, in_cells
from worldgen.world import Witness, World


class Doubt(StrEnum):
    """Why a disturbed robot may fail whatever its controller does."""

    NO_WITNESS = "no-witness"
    CHANGING_WORLD = "changing-world"
    FAST_DRIFT = "fast-drift"
    SLOW_REACTION = "slow-reaction"
    PUSHED_AGAIN = "pushed-again"
    PUSHED_ON_THE_WITNESS = "pushed-on-the-witness"

    @property
    def sentence(self) -> str:
        """The reason in words."""
        return _DOUBTS[self]


_DOUBTS = {
    Doubt.NO_WITNESS: "no witness shows a path to the target",
    Doubt.CHANGING_WORLD: (
        "the world changes, and the witness's timing leaves no slack for disturbances"
    ),
    Doubt.FAST_DRIFT: "the drift is as fast as the robot",
    Doubt.SLOW_REACTION: "a robot that cannot turn or brake immediately may drift off the witness",
    Doubt.PUSHED_AGAIN: "a place may push the robot again after it has left the witness",
    Doubt.PUSHED_ON_THE_WITNESS: "the witness leads through a place that pushes the robot",
}

# Margin, m, added to places to allow for rounding.
_EDGE = 1e-9


@dataclass(frozen=True)
class Push:
    """A push of the robot at a time.

    Args:
        time: Time, s.
        dx: Displacement along x, m.
        dy: Displacement along y, m.
        turn: Turn, rad, counter-clockwise.
    """

    time: float
    dx: float
    dy: float
    turn: float


@dataclass(frozen=True)
class PushPlace:
    """A place that pushes the robot at the end of each step that its centre spends there.

    Args:
        x: x, m; the place is the whole cell of this point.
        y: y, m.
        dx: Displacement along x, m.
        dy: Displacement along y, m.
        turn: Turn, rad, counter-clockwise.
    """

    x: float
    y: float
    dx: float
    dy: float
    turn: float


@dataclass(frozen=True)
class Decoy:
    """Another source of the signal.

    Args:
        x: x, m.
        y: y, m.
        strength: How many times as strong as the target's signal.
    """

    x: float
    y: float
    strength: float


def _in_groups(numbers: Sequence[float], size: int) -> list[Sequence[float]]:
    return [numbers[k : k + size] for k in range(0, len(numbers), size)]


def pushes_of(robot: RobotOptions) -> list[Push]:
    """Return the pushes at given times, in order."""
    return [Push(*group) for group in _in_groups(robot.pushes, 4)]


def pushing_places_of(robot: RobotOptions) -> list[PushPlace]:
    """Return the places that push the robot."""
    return [PushPlace(*group) for group in _in_groups(robot.push_places, 5)]


def decoys_of(robot: RobotOptions) -> list[Decoy]:
    """Return the decoys."""
    return [Decoy(*group) for group in _in_groups(robot.decoys, 3)]


def delay_of(world: World, robot: RobotOptions) -> tuple[float, Fraction]:
    """Return how much disturbances can delay even a perfect robot.

    Returns:
        The seconds until the last push is over and its displacement is driven back, and the factor
        by which a drift against the robot lengthens its path; 1 if the drift is as fast as the
        robot.
    """
    pushed = sum(math.hypot(push.dx, push.dy) for push in pushes_of(robot))
    last = max((push.time for push in pushes_of(robot)), default=0.0)
    speed = exact(world.robot_speed)
    left = speed - exact(robot.drift)
    factor = speed / left if left > 0 else Fraction(1)
    return last + float(pushed / speed), factor


def why_arrival_is_not_certain(world: World, robot: RobotOptions) -> Doubt | None:
    """Return why a disturbed robot may fail whatever its controller does, or ``None``.

    A push at a given time moves the robot along a clear path, so in a static world it can drive
    back and take the witness from there. A robot that turns and changes its speed instantly, and is
    faster than a drift, can drive the witness against it. A place that pushes is harmless if the
    witness stays out of its cell. In all other cases arrival is uncertain.

    Args:
        world: The world, with its certificate.
        robot: Options of the robot in the run.
    """
    # Without a static world and a witness, nothing is certain.
    if not robot.moved:
        return None
    if not isinstance(world.certificate, Witness):
        return Doubt.NO_WITNESS
    if world.is_dynamic:
        return Doubt.CHANGING_WORLD
    # A drift must be slower than the robot, which must be able to correct it instantly.
    if robot.drift >= world.robot_speed:
        return Doubt.FAST_DRIFT
    if robot.drift > 0.0 and (robot.turn_limit or robot.acceleration or robot.friction):
        return Doubt.SLOW_REACTION
    # Places must not push it off the witness.
    if robot.push_places:
        if robot.pushes or robot.drift > 0.0:
            return Doubt.PUSHED_AGAIN
        if _crosses(world.certificate, world, pushing_places_of(robot)):
            return Doubt.PUSHED_ON_THE_WITNESS
    return None


def _crosses(witness: Witness, world: World, places: Sequence[PushPlace]) -> bool:
    """Return True if the witness's centre enters one of the places, or touches its edge."""
    side = world.cell_size
    points = list(zip(witness.x.tolist(), witness.y.tolist(), strict=True))
    pieces = list(itertools.pairwise(points)) or [(points[0], points[0])]
    # Widen the cell a little, so that rounding does not hide a crossing.
    for place in places:
        left = math.floor(in_cells(place.x, side)) * side - _EDGE
        low = math.floor(in_cells(place.y, side)) * side - _EDGE
        box = ((left, left + side + 2 * _EDGE), (low, low + side + 2 * _EDGE))
        if any(_meets(start, end, box) for start, end in pieces):
            return True
    return False


def _meets(
    start: tuple[float, float],
    end: tuple[float, float],
    box: tuple[tuple[float, float], tuple[float, float]],
) -> bool:
    """Return True if a segment meets a box, by clipping it to the two slabs.

    Source: Ericson, Real-Time Collision Detection (2005), 5.3.3.
    """
    enter = 0.0
    leave = 1.0
    # Narrow the shares of the segment that are inside both slabs.
    for p, q, (low, high) in zip(start, end, box, strict=True):
        if p == q:
            if not low <= p <= high:
                return False
            continue
        one = (low - p) / (q - p)
        other = (high - p) / (q - p)
        enter = max(enter, min(one, other))
        leave = min(leave, max(one, other))
    return enter <= leave
