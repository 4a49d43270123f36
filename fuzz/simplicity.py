"""Define "simpler": the order of failures, and the cost of their numbers."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from decimal import Decimal
from typing import NamedTuple

from sim.options.run import DEFAULT_TIME_STEP
from sim.scenario import Scenario
from worldgen.lattice import in_cells
from worldgen.world import DEFAULT_ROBOT_RADIUS, DEFAULT_ROBOT_SPEED, World

_LEADING = {1: 1, 2: 2, 5: 3}  # cost of a number's only digit; other digits cost 4
_EIGHTH = math.pi / 4
_EQUAL = 1e-9  # tolerance for headings: multiples of pi/4 are not exact floats


class Case(NamedTuple):
    """The subject of shrinking: a world and the run in it."""

    world: World
    scenario: Scenario


class Measure(NamedTuple):
    """A measure that is lower for simpler failures.

    Args:
        name: Short name.
        says: One line that describes it.
        of: Function that computes it.
    """

    name: str
    says: str
    of: Callable[[Case], int]


class FailureOrder(NamedTuple):
    """A failure's place among others, the simplest first; only equal files have equal places.

    Args:
        size: All measures of :data:`ORDER`.
        digest: SHA-256 of the failure's file, in hex; it decides between equally simple ones.
    """

    size: tuple[int, ...]
    digest: str


def number_cost(value: float, usual: float = 0.0) -> int:
    """Return how complicated a number is: 0 for the usual value, 1 to 4 for one digit.

    Among single digits, 1, 2 and 5 are the simplest. Each further digit costs 10.
    """
    if value == usual:
        return 0
    digits = Decimal(repr(float(value))).normalize().as_tuple().digits
    return 10 * (len(digits) - 1) + _LEADING.get(digits[0] if len(digits) == 1 else 0, 4)


def rounder(value: float, usual: float = 0.0, *, up: bool = True) -> Iterator[float]:
    """Yield numbers that are simpler than the given one, simplest first.

    Args:
        value: A positive number.
        usual: The simplest number of all.
        up: Allow numbers above ``value``.
    """
    # Candidates: round numbers of the same magnitude, and the value rounded to a few digits.
    power = Decimal(1).scaleb(Decimal(repr(float(value))).adjusted())
    steps = (Decimal("0.5"), *map(Decimal, (1, 2, 5, 10)))
    near = [float(step * power) for step in steps]
    near += [float(f"{value:.{digits}g}") for digits in (1, 2, 3)]
    near += [math.floor(value / float(power)) * float(power)]

    # Keep only the values that are actually simpler; among equally simple ones, the nearest comes
    # first.
    better = {number for number in near if number_cost(number, usual) < number_cost(value, usual)}
    kept = sorted(better, key=lambda number: (number_cost(number, usual), abs(number - value)))
    yield from (number for number in [usual, *kept] if number != value and (up or number <= value))


def turned(heading: float) -> int:
    """Return 0 for a multiple of a quarter turn, 1 for an eighth, 2 for a sixteenth, else 3."""
    for cost, part in enumerate((2 * _EIGHTH, _EIGHTH, _EIGHTH / 2)):
        if abs(heading / part - round(heading / part)) < _EQUAL:
            return cost
    return 3


def _off_centre(case: Case) -> int:
    places = [place for robot in case.world.robots for point in robot.places for place in point]
    return sum(in_cells(place, case.world.cell_size) % 1 * 2 != 1 for place in places)


def _covered(case: Case) -> int:
    return sum(
        math.dist(robot.places[0], robot.places[1]) < robot.radius + robot.goals[0].radius
        for robot in case.world.robots
    )


def _distance(case: Case) -> int:
    world = case.world
    pairs = [
        pair
        for robot in world.robots
        for one, two in itertools.pairwise(robot.places)
        for pair in zip(one, two, strict=True)
    ]
    cells = [[math.floor(in_cells(place, world.cell_size)) for place in pair] for pair in pairs]
    return sum(abs(a - b) for a, b in cells)


def _numbers(case: Case) -> int:
    world, scenario = case
    floats = [value for value in scenario.run.changed().values() if isinstance(value, float)]
    robots = sum(
        number_cost(robot.radius, DEFAULT_ROBOT_RADIUS)
        + number_cost(robot.speed, DEFAULT_ROBOT_SPEED)
        + sum(number_cost(goal.radius, world.cell_size / 2) for goal in robot.goals)
        for robot in world.robots
    )
    return (
        robots
        + number_cost(scenario.run.time_step, DEFAULT_TIME_STEP)
        + sum(map(number_cost, floats))
    )


ORDER: tuple[Measure, ...] = (
    Measure(
        "robots",
        "robots, and their waypoints",
        lambda case: sum(len(robot.goals) for robot in case.world.robots),
    ),
    Measure("cells", "cells of the grid", lambda case: case.world.walls.size),
    Measure("solid", "solid cells", lambda case: case.world.solid_cells),
    Measure("events", "events of the timeline", lambda case: len(case.world.timeline)),
    Measure("covered", "robots whose disc overlaps their first goal at the start", _covered),
    Measure(
        "heading",
        "0 for a quarter turn, 1 for an eighth, 2 for a sixteenth, else 3; summed over all robots",
        lambda case: sum(turned(robot.start.heading) for robot in case.world.robots),
    ),
    Measure(
        "off-centre",
        "coordinates of start and goals that are not in the middle of a cell",
        _off_centre,
    ),
    Measure(
        "distance", "cells from start to target, through all waypoints, along both axes", _distance
    ),
    Measure(
        "numbers",
        "cost of radius, speed, goals, time step and options: 0 for the usual number, 1 to 4 "
        "for one digit (1 before 2, 2 before 5, 5 before others), plus 10 per further digit",
        _numbers,
    ),
    Measure(
        "times",
        "cost of the events' times, computed in the same way; 0 s is the usual time",
        lambda case: sum(number_cost(event.time) for event in case.world.timeline),
    ),
)
"""The measures by which two failures are compared, most significant first.

Shrinking accepts an edit only if it lowers the tuple of these measures.
"""


def simplicity(case: Case) -> tuple[int, ...]:
    """Return all measures in order; a smaller tuple is a simpler failure.

    All of them are integers of at least 0, so shrinking always ends.
    """
    return tuple(measure.of(case) for measure in ORDER)
