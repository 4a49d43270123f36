"""Numbers that every simulator needs before a run: the disc on the lattice, and events by step."""

from __future__ import annotations

import functools
import math

import numpy as np

from worldgen.errors import InvalidParameter, InvalidWorld
from worldgen.lattice import (
    UNIT,
    clear_distance_sq,
    exact,
    footprint_on_lattice,
    in_cells,
    radius_in_cells,
)
from worldgen.robot_overrides import describe_body
from worldgen.support.arrays import Ints
from worldgen.timeline import Event
from worldgen.world import Robot, Target, World

# Parts of a step in which times are counted.
STEP_TIME = 1 << 32


def disc_numbers(world: World) -> tuple[int, int]:
    """Return the disc's squared clear distance, lattice units squared, and its root, rounded up.

    For a body, it is a disc about the axle that holds it at every heading.
    """
    body = body_of(world)
    if len(body):
        # The table of headings may put a corner a few thousandths of a unit farther away.
        reach = math.isqrt(int((body * body).sum(axis=1).max())) + 2
        return reach * reach, reach
    clear_sq = clear_distance_sq(radius_in_cells(world))
    return clear_sq, math.isqrt(clear_sq - 1) + 1


def body_of(world: World) -> Ints:
    """Return (k, 2) int64, the corners of the robot's body in lattice units; none for a disc."""
    footprint = world.robots[0].footprint
    if not footprint:
        return np.zeros((0, 2), np.int64)
    return footprint_on_lattice(footprint, world.cell_size)


def target_sq(goal: Target, cell_size: float) -> int:
    """Return the squared radius of a goal, lattice units squared, rounded down."""
    within = in_cells(goal.radius, cell_size) * UNIT
    return math.floor(within * within)


def start_overlaps(world: World) -> InvalidWorld:
    """Return the error for a robot that does not fit at its start."""
    if world.robots[0].footprint:
        return InvalidWorld(
            "start-in-wall",
            "start ({x:g}, {y:g}) m at heading {heading:.4g} rad: the robot's body overlaps a wall "
            "there",
            "move or turn the start, or make the body smaller",
            x=world.start.x,
            y=world.start.y,
            heading=world.start.heading,
        )
    return InvalidWorld(
        "start-in-wall",
        "start ({x:g}, {y:g}) m: the robot of radius {robot_radius:g} m overlaps a wall there",
        "move the start or make the robot smaller",
        x=world.start.x,
        y=world.start.y,
        robot_radius=world.robot_radius,
    )


def refuse_unless_plain(world: World, who: str, code: str) -> None:
    """Raise an error if some robot is not a disc that turns on the spot to touch its target.

    Args:
        world: The world.
        who: What is only for such robots, such as ``stepped``.
        code: The error's code.

    Raises:
        InvalidParameter: If there is such a robot.
    """
    for number, robot in enumerate(world.robots, start=1):
        if not robot.is_plain:
            raise InvalidParameter(
                code,
                "robot {number} is a {body}, and {who} is only for discs that turn on the spot, "
                "slide along walls and have to touch their targets",
                "use swept or endpoint in a world of one robot",
                number=number,
                body=describe_body(robot) + _own_goals(robot),
                who=who,
            )


def _own_goals(robot: Robot) -> str:
    if robot.waypoints:
        return " with waypoints"
    return "" if robot.target.is_plain else " with its own goal"


def event_step(event: Event, time_step: float) -> int:
    """Return the number of the step in which an event falls, at whose beginning it takes effect."""
    return max(1, math.ceil(exact(event.time) / exact(time_step)))


def event_time(event: Event, time_step: float, unit: int) -> tuple[int, int]:
    """Return the step in which an event falls, from 1, and its time within that step.

    The time is rounded to ``unit``ths of a step. An event between two steps belongs to the later.
    """
    return _step_and_rest(event.time, time_step, unit)


# Cached, because a world whose cells are edited keeps its times.
@functools.lru_cache(maxsize=4096)
def _step_and_rest(time: float, time_step: float, unit: int) -> tuple[int, int]:
    # In whole numbers: fractions take ten times as long, and a world may have a million events.
    event, of_event = _exact_ratio(time)
    step, of_step = _exact_ratio(time_step)
    divisor = of_event * step
    whole, rest = divmod((2 * event * of_step * unit + divisor) // (2 * divisor), unit)
    return whole + 1, rest


def _exact_ratio(value: float) -> tuple[int, int]:
    """Return the numerator and denominator of ``exact(value)``, perhaps not in lowest terms."""
    text = repr(float(value))
    if "e" in text:
        return exact(value).as_integer_ratio()
    whole, _, digits = text.partition(".")
    return int(whole + digits), 10 ** len(digits)
