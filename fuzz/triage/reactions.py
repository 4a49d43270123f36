"""Tabulate what a robot does by what is around it: how it turns and drives near walls, and in the open.

A sign error, a wrong frame or a gain that is too small shows here whatever language the controller
is written in.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from fuzz.facts.contacts import nearest_walls
from fuzz.triage.repeated_moves import reacts_at_once
from sim.trace import Trace
from worldgen.lattice import UNIT
from worldgen.support.arrays import Bools, Floats, Ints
from worldgen.support.plain_text import counted, in_degrees
from worldgen.world import World

# Robot radii between the robot's edge and a wall that counts as near.
_NEAR = 3.0

# Degrees between the heading and a wall or the target: up to the first it is ahead, up to the second
# on one side, and beyond it behind.
_AHEAD = 30.0
_BESIDE = 120.0

# Degrees: a smaller turn in a step counts as none.
_STRAIGHT = 0.02

# Below this share of its top speed, the robot counts as standing.
_STANDS = 0.02

# Steps of one run that are looked at, evenly spread.
_MOST_STEPS = 20_000

# Poses that are this close count once in a run, so that a robot that circles forever does not
# outnumber all others: a share of the radius, and degrees.
_SAME_PLACE = 0.2
_SAME_HEADING = 10.0

# Smallest share of a row's steps that is worth a word.
_LEAST_SHARE = 0.03

# Fewest steps of a row: a few are no habit.
_FEWEST = 3

COUNTED = "in the whole run (steps at nearly the same pose count once)"
"""Which steps of a run count; a sentence about what it repeats counts other ones."""

_SITUATIONS = ("touching a wall", "near a wall", "no wall near, target")
_SIDES = ("ahead", "on its left", "on its right", "behind")


class Reaction(NamedTuple):
    """What a robot does in one situation.

    Args:
        situation: Such as ``near a wall on its left``.
        steps: Number of steps, of which those at nearly the same pose in one run count once.
        turns: How it turns in a step, in words.
        moves: How it moves then, in words.
    """

    situation: str
    steps: int
    turns: str
    moves: str

    def text(self) -> str:
        """Return the row for the terminal."""
        steps = counted(self.steps, "step")
        return f"{self.situation} ({steps}): turns {self.turns}; {self.moves}"


@dataclass
class Reactions:
    """The turns and moves of some runs, by situation.

    Args:
        found: By situation and side, one (steps, 2) table for each run: the turn of each step,
            degrees, positive to the left, and the speed along the heading as a share of the top
            speed.
    """

    found: dict[tuple[str, str], list[Floats]] = field(default_factory=lambda: defaultdict(list))

    def add(self, world: World, trace: Trace) -> None:
        """Add a run of a single robot.

        Args:
            world: Its world; walls count as they are after the last event.
            trace: The run.

        Raises:
            OutOfTime: If there is no more time.
        """
        # The robot senses after a step, turns at once, and drives in the next step.
        late = 0 if reacts_at_once(trace) else 1
        last = trace.steps - 1 - late
        if last < 1:
            return
        steps = np.unique(np.linspace(1, last, min(last, _MOST_STEPS)).astype(np.int64))
        steps = _different(world, trace, steps, late)
        sensed = trace.heading[steps - 1 + late]
        after = steps + late
        turn = np.degrees(_wrapped(trace.heading[after] - trace.heading[after - 1]))
        heading = trace.heading[after]
        dx = trace.x[after + 1] - trace.x[after]
        dy = trace.y[after + 1] - trace.y[after]
        farthest = world.robot_speed * trace.time_step
        driven = (dx * np.cos(heading) + dy * np.sin(heading)) / farthest
        # Poses are on a lattice, which changes the length of a step at top speed a little.
        grain = 2.0 * world.cell_size / UNIT / farthest
        driven[np.abs(driven - 1.0) <= grain] = 1.0
        moves = np.column_stack((turn, driven))

        # Sort the steps by what is around the robot.
        gap, direction = nearest_walls(world, trace, steps, (1.0 + _NEAR) * world.robot_radius)
        wall = np.degrees(_wrapped(direction - sensed))
        # The goal that counts in each step: the target, unless there are waypoints.
        goals = np.array(world.robots[0].places[1:])
        x, y = goals[trace.passed[steps] if len(trace.passed) else np.zeros_like(steps)].T
        aim = np.arctan2(y - trace.y[steps], x - trace.x[steps])
        target = np.degrees(_wrapped(aim - sensed))
        touches = trace.bump[steps]
        near = ~touches & np.isfinite(gap)
        places = [(touches, wall), (near, wall)]
        # Without a target to reach, the open floor is one situation.
        if trace.task == "target":
            places.append((~touches & ~near, target))
        for situation, (chosen, bearing) in zip(_SITUATIONS, places, strict=False):
            for side, there in zip(_SIDES, _by_side(bearing), strict=True):
                if (chosen & there).any():
                    self.found[situation, side].append(moves[chosen & there])

    def rows(self) -> list[Reaction]:
        """Return what the robot does in each situation that occurred, in a fixed order."""
        rows = []
        for situation in _SITUATIONS:
            for side in _SIDES:
                parts = self.found.get((situation, side), [])
                taken = np.concatenate(parts) if parts else np.zeros((0, 2))
                if len(taken) >= _FEWEST:
                    turns = _turns(taken[:, 0], side)
                    moves = _moves(taken[:, 1])
                    rows.append(Reaction(f"{situation} {side}", len(taken), turns, moves))
        return rows


def _different(world: World, trace: Trace, steps: Ints, late: int) -> Ints:
    """Return those of some steps at which the robot's pose is unlike that at an earlier one."""
    side = _SAME_PLACE * world.robot_radius
    heading = np.degrees(_wrapped(trace.heading[steps - 1 + late]))
    poses = (trace.x[steps] / side, trace.y[steps] / side, heading / _SAME_HEADING)
    rows = np.column_stack((*map(np.rint, poses), trace.bump[steps]))
    return steps[np.sort(np.unique(rows, axis=0, return_index=True)[1])]


def _wrapped(angles: Floats) -> Floats:
    wrapped: Floats = angles - math.tau * np.round(angles / math.tau)
    return wrapped


def _by_side(degrees: Floats) -> tuple[Bools, Bools, Bools, Bools]:
    ahead = np.abs(degrees) <= _AHEAD
    behind = np.abs(degrees) > _BESIDE
    left = ~ahead & ~behind & (degrees > 0.0)
    return ahead, left, ~ahead & ~behind & ~left, behind


def _turns(turn: Floats, side: str) -> str:
    """Return how a robot turns in a step: ``away from it by 4.5 degrees in 98 %, ...``."""
    left, right = {
        "on its left": ("towards it", "away from it"),
        "on its right": ("away from it", "towards it"),
    }.get(side, ("left", "right"))
    ways = []
    for way, own in ((left, turn[turn > _STRAIGHT]), (right, turn[turn < -_STRAIGHT])):
        if len(own):
            ways.append((len(own), f"{way} by {in_degrees(float(np.median(np.abs(own))))}"))
    straight = int((np.abs(turn) <= _STRAIGHT).sum())
    if straight:
        ways.append((straight, "not at all"))
    ways.sort(reverse=True)
    if len(ways) == 1:
        return ways[0][1]
    ways = [one for one in ways if one[0] >= _LEAST_SHARE * len(turn)]
    return ", ".join(f"{way} in {_percent(count / len(turn))}" for count, way in ways)


def _moves(speed: Floats) -> str:
    """Return how a robot moves: ``drives at 50 % of its top speed``, ``stands``."""
    middle = float(np.median(speed))
    if abs(middle) < _STANDS:
        return "stands" if np.abs(speed).max() < _STANDS else "mostly stands"
    backwards = "backwards " if middle < 0.0 else ""
    return f"drives {backwards}at {_percent(abs(middle))} of its top speed"


def _percent(share: float) -> str:
    # A share is only 100 % or 0 % if it is exact.
    return f"{min(max(round(100 * share), 1), 100 if share >= 1.0 else 99)} %"
