"""What "simpler" means.

The order in which one failure is simpler than another, and what its numbers cost.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from decimal import Decimal
from typing import NamedTuple

from sim.options.run import DEFAULT_TIME_STEP
from sim.scenario import Scenario
from worldgen.lattice import in_cells
from worldgen.world import DEFAULT_ROBOT_RADIUS, DEFAULT_ROBOT_SPEED, World

__all__ = ["ORDER", "Case", "Measure", "number_cost", "rounder", "simplicity", "turned"]

_LEADING = {1: 1, 2: 2, 5: 3}  # cost of a number's first digit; 4 for the others
_EIGHTH = math.pi / 4
_EQUAL = 1e-9  # of headings: a multiple of an eighth turn is no exact float


class Case(NamedTuple):
    """What gets simpler: a world, and what runs in it."""

    world: World
    scenario: Scenario


class Measure(NamedTuple):
    """One thing of which less is simpler.

    Args:
        name: What is counted.
        says: One line about it.
        of: Counts it.
    """

    name: str
    says: str
    of: Callable[[Case], int]


def number_cost(value: float, usual: float = 0.0) -> int:
    """How far a number is from simple: 0 for the usual one; 1, 2, 5 before other digits.

    Each more digit costs 10.
    """
    if value == usual:
        return 0
    digits = Decimal(repr(float(value))).normalize().as_tuple().digits
    return 10 * (len(digits) - 1) + _LEADING.get(digits[0] if len(digits) == 1 else 0, 4)


def rounder(value: float, usual: float = 0.0, *, up: bool = True) -> Iterator[float]:
    """Simpler numbers than a positive one, simplest first.

    Args:
        value: Above 0.
        usual: The simplest of all.
        up: Whether it may grow.
    """
    power = Decimal(1).scaleb(Decimal(repr(float(value))).adjusted())
    steps = (Decimal("0.5"), *map(Decimal, (1, 2, 5, 10)))
    near = [float(step * power) for step in steps]
    near += [float(f"{value:.{digits}g}") for digits in (1, 2, 3)]
    near += [math.floor(value / float(power)) * float(power)]
    better = {number for number in near if number_cost(number, usual) < number_cost(value, usual)}
    kept = sorted(better, key=lambda number: (number_cost(number, usual), abs(number - value)))
    yield from (number for number in [usual, *kept] if number != value and (up or number <= value))


def turned(heading: float) -> int:
    """0 for a multiple of a quarter turn, 1 for one of an eighth, 2 for one of a sixteenth, else 3."""
    for cost, part in enumerate((2 * _EIGHTH, _EIGHTH, _EIGHTH / 2)):
        if abs(heading / part - round(heading / part)) < _EQUAL:
            return cost
    return 3


def _off_centre(case: Case) -> int:
    world = case.world
    places = (world.start.x, world.start.y, world.target.x, world.target.y)
    return sum(in_cells(place, world.cell_size) % 1 * 2 != 1 for place in places)


def _distance(case: Case) -> int:
    world = case.world
    pairs = ((world.start.x, world.target.x), (world.start.y, world.target.y))
    cells = [[math.floor(in_cells(place, world.cell_size)) for place in pair] for pair in pairs]
    return sum(abs(a - b) for a, b in cells)


def _numbers(case: Case) -> int:
    world, scenario = case
    options = [scenario.thesis.changed(), scenario.robot.changed()]
    floats = [value for option in options for value in option.values() if isinstance(value, float)]
    return (
        number_cost(world.robot_radius, DEFAULT_ROBOT_RADIUS)
        + number_cost(world.robot_speed, DEFAULT_ROBOT_SPEED)
        + number_cost(world.target.radius, world.cell_size / 2)
        + number_cost(scenario.time_step, DEFAULT_TIME_STEP)
        + sum(map(number_cost, floats))
    )


ORDER: tuple[Measure, ...] = (
    Measure("cells", "cells of the grid", lambda case: case.world.walls.size),
    Measure("solid", "solid cells", lambda case: case.world.solid_cells),
    Measure("events", "events of the timeline", lambda case: len(case.world.timeline)),
    Measure(
        "heading",
        "0 for a quarter turn, 1 for an eighth, 2 for a sixteenth, else 3",
        lambda case: turned(case.world.start.heading),
    ),
    Measure(
        "off-centre",
        "coordinates of start and target that are not in the middle of a cell",
        _off_centre,
    ),
    Measure("distance", "cells from start to target, along both axes", _distance),
    Measure(
        "numbers",
        "what radius, speed, target, time step and options cost: 0 for the usual number, 1 to 4 "
        "for one digit (1 before 2, 2 before 5, 5 before others), 10 for each digit more",
        _numbers,
    ),
    Measure(
        "times",
        "what the events' times cost, likewise; 0 is the usual one",
        lambda case: sum(map(number_cost, case.world.timeline.times.tolist())),
    ),
)
"""By what two failures are compared, the weightiest first.

An edit is taken only if it makes this tuple less.
"""


def simplicity(case: Case) -> tuple[int, ...]:
    """The measures in order; the less, the simpler.

    Whole numbers from 0 on, so shrinking comes to an end.
    """
    return tuple(measure.of(case) for measure in ORDER)
