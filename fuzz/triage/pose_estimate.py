"""Find a robot's own estimate of its position in its state, and how far it is off.

A class that adds up its commands, or its odometry, believes it is somewhere. Where a wall holds the
robot, or its wheels slip, that is no longer the place where it is.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from sim.trace import Trace
from worldgen.support.arrays import Floats
from worldgen.support.plain_text import rounded
from worldgen.world import World

# Largest difference between a step of the estimate and the robot's, as a share of the robot's.
_ALIKE = 0.25

# Smallest share of the free steps that must be alike, and their smallest number, before the
# estimate is off and after that: a place that is only remembered for a while stays where it is.
_MOSTLY = 0.8
_FEWEST_BEFORE = 5
_FEWEST_AFTER = 10

# The longest step of an estimate, in the robot's fastest: what is added up never jumps, as what is
# copied from a sense does after a reset.
_LONGEST = 1.5

# A wall may hold a robot from the start on. Then this many steps must have the same direction, too.
_FEWEST_SAME = 20

# A robot that moves less than this share of its fastest step hardly moves.
_MOVES = 0.1

# Steps by which an estimate may be behind the robot, or ahead of it.
_LAGS = (0, 1, -1)

# An estimate is off by more than the robot's radius, and by more than this many steps.
_STEPS_OFF = 4.0

# Share of the error that must come from steps at walls for them to be named.
_NEARLY_ALL = 0.9


class PoseEstimate(NamedTuple):
    """Two numbers of a robot's state that follow its position, and depart from it.

    Args:
        names: Their names.
        since: Number of steps after which they are off by more than the robot's radius.
        off: By how much they are off at the end, m.
        at_walls: Share of the error that comes from steps that touch a wall.
    """

    names: tuple[str, str]
    since: int
    off: float
    at_walls: float

    def describe(self) -> str:
        """Return a clause: ``self.x and self.y follow its position for 57 steps, and are ...``."""
        first, second = self.names
        why = ", because of steps that touch a wall" if self.at_walls >= _NEARLY_ALL else ""
        return (
            f"{first} and {second} follow its position for {self.since:,} steps, and are "
            f"{rounded(self.off, 2)} m off at the end{why}"
        )


def pose_estimate(world: World, trace: Trace, numbers: Mapping[str, Floats]) -> PoseEstimate | None:
    """Return the estimate of its position that a robot keeps, if it departs from the true one.

    Two numbers next to each other are an estimate if they begin at the robot's start, or at zero,
    and their steps are as long as the robot's where no wall holds it, before and after they are
    off.

    Args:
        world: World of the run.
        trace: The run.
        numbers: By name, (n + 1,) each: the numbers of its state, at the start and after each time
            that it acted.
    """
    for (first, x), (second, y) in itertools.pairwise(numbers.items()):
        if len(x) == len(y):
            for lag in _LAGS:
                found = _estimate_in(world, trace, np.stack([x, y]), lag)
                if found is not None:
                    return found._replace(names=(first, second))
    return None


def _estimate_in(world: World, trace: Trace, own: Floats, lag: int) -> PoseEstimate | None:
    """Return the estimate that two numbers are, without their names, or None if they aren't one.

    Args:
        world: World of the run.
        trace: The run.
        own: (2, n + 1): the numbers, as in :func:`pose_estimate`.
        lag: Number of steps by which they may be ahead of the robot's position.
    """
    # Align the two: the robot's position in a step, and the estimate of it.
    count = min(own.shape[1], trace.steps + 1 - max(lag, 0))
    first = max(-lag, 0)
    if count - first <= _FEWEST_BEFORE + _FEWEST_AFTER or not np.isfinite(own).all():
        return None
    own = own[:, first:count]
    steps = slice(first + lag, count + lag)
    true = np.stack([trace.x[steps], trace.y[steps]])
    touches = trace.bump[steps]

    # Compare the lengths of their steps where nothing holds the robot.
    farthest = world.robot_speed * trace.time_step
    length = np.hypot(*np.diff(true))
    free = (length > _MOVES * farthest) & ~(touches[1:] | touches[:-1])
    reckoned = np.hypot(*np.diff(own))
    if reckoned.max() > _LONGEST * farthest:
        return None
    alike = np.abs(reckoned - length) <= _ALIKE * length
    limit = max(world.robot_radius, _STEPS_OFF * farthest)

    # Follow the error from the start on.
    for placed in _in_the_world(own, true, float(trace.heading[0]), farthest):
        error = placed - true
        off = np.hypot(*error)
        if off[-1] <= limit:
            continue
        since = int(np.argmax(off > limit))
        change = np.diff(error)
        same = (np.hypot(*change) <= _ALIKE * length)[free]
        before = alike[:since][free[:since]]
        after = alike[since:][free[since:]]
        begins = len(before) >= _FEWEST_BEFORE and before.mean() >= _MOSTLY
        if not begins and (len(same) < _FEWEST_SAME or same.mean() < _MOSTLY):
            continue
        if len(after) < _FEWEST_AFTER or after.mean() < _MOSTLY:
            continue
        # What comes from steps at walls, along the error that is left at the end.
        along = error[:, -1] @ change / off[-1] ** 2
        share = float(along[touches[1:] | touches[:-1]].sum())
        return PoseEstimate(("", ""), since + first, float(off[-1]), share)
    return None


def _in_the_world(own: Floats, true: Floats, heading: float, farthest: float) -> Iterator[Floats]:
    """Yield an estimate in the world's frame, in the ways in which it may be meant."""
    start = true[:, :1]
    if np.hypot(*(own[:, 0] - true[:, 0])) <= 2.0 * farthest:
        yield own
    # Its frame may begin at the robot's start, along the world's axes or the robot's heading.
    elif not own[:, 0].any():
        cos, sin = math.cos(heading), math.sin(heading)
        yield own + start
        yield np.array([[cos, -sin], [sin, cos]]) @ own + start
