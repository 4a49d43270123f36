"""What every simulator needs of a world before it starts.

The disc in lattice numbers, events by step.
"""

from __future__ import annotations

import functools
import math
from fractions import Fraction

from worldgen.errors import InvalidWorld
from worldgen.lattice import UNIT, clear_distance_sq, exact, in_cells, radius_in_cells
from worldgen.timeline import Event
from worldgen.world import World

__all__ = ["disc_numbers", "event_step", "event_time", "start_overlaps", "target_sq"]


def disc_numbers(world: World) -> tuple[int, int]:
    """Squared clear distance of the robot's disc, lattice units squared, and its root, rounded up."""
    clear_sq = clear_distance_sq(radius_in_cells(world))
    return clear_sq, math.isqrt(clear_sq - 1) + 1


def target_sq(world: World) -> int:
    """Squared radius of the target, lattice units squared, rounded down."""
    within = in_cells(world.target.radius, world.cell_size) * UNIT
    return math.floor(within * within)


def start_overlaps(world: World) -> InvalidWorld:
    """The error for a robot that cannot stand at its start."""
    return InvalidWorld(
        "start-in-wall",
        "start ({x:g}, {y:g}) m: the robot of radius {robot_radius:g} m overlaps a wall there",
        "move the start or make the robot smaller",
        x=world.start.x,
        y=world.start.y,
        robot_radius=world.robot_radius,
    )


def event_step(event: Event, time_step: float) -> int:
    """The step at whose beginning an event counts: that in which it falls, at least the first."""
    return max(1, math.ceil(exact(event.time) / exact(time_step)))


def event_time(event: Event, time_step: float, unit: int) -> tuple[int, int]:
    """The step in which an event falls, from 1, and its time in that step, in ``unit``ths of it, rounded.

    One that falls between two steps belongs to the later one.
    """
    return _step_and_rest(event.time, time_step, unit)


@functools.lru_cache(maxsize=4096)  # a world whose cells are edited keeps its times: 10 us each
def _step_and_rest(time: float, time_step: float, unit: int) -> tuple[int, int]:
    steps = exact(time) / exact(time_step)
    whole, rest = divmod(math.floor(steps * unit + Fraction(1, 2)), unit)
    return whole + 1, rest
