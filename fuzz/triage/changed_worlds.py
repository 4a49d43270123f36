"""Causes that only a second run shows: the same scenario, in a world with a single change.

A robot whose gap is too narrow often repeats the same moves as a robot behind a wall. A smaller
robot distinguishes the two: it arrives in the first case.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction

from fuzz.triage.contacts import walls_at_the_end
from sim.episode import simulate
from sim.options.run import RunOptions
from sim.verdict import ARRIVALS
from worldgen.difficulty.bottleneck import narrowest_gap_sq
from worldgen.errors import WorldgenError
from worldgen.lattice import UNIT
from worldgen.reach.still.disc import target_disc
from worldgen.reach.still.walls import Walls
from worldgen.timeline import Timeline
from worldgen.world import World

Arrives = Callable[[World], bool]
"""Runs the scenario in another world, and returns True if the robot arrives there."""

# A place is a gap if two of the robots do not fit through it side by side, and at a wall if one of
# twice the radius does not fit there.
_GAP = 2.0

# Radii of smaller robots, as shares of the robot's own, the smallest first: most robots that no gap
# holds back fail at the first radius, which saves the other runs.
_SMALLER = (0.5, 0.6, 0.7, 0.8, 0.9)

# Number of smaller robots that must arrive. In a world that is hard for another reason, one or two
# robots may arrive by chance.
_FEWEST = 3


def arrives_in(controller: str, options: RunOptions) -> Arrives:
    """Return a function that runs a scenario in other worlds.

    Args:
        controller: Name of the controller.
        options: Options of the run.
    """

    def arrives(world: World) -> bool:
        try:
            return simulate(world, controller, options).verdict in ARRIVALS
        except WorldgenError:
            # The changed robot does not fit at the start, or its wheels would not fit the robot.
            return False

    return arrives


def fails_by_timing(world: World, arrives: Arrives) -> bool:
    """Return True if the robot arrives once all changes have happened before it starts.

    Then neither the final walls nor the initial ones stop it. It fails
    because a cell changes while it drives.
    """
    if not world.timeline:
        return False
    return arrives(
        replace(
            world,
            walls=walls_at_the_end(world),
            timeline=Timeline(),
            certificate=None,
            failure=None,
        )
    )


def needs_a_wider_gap(world: World, place: tuple[float, float], arrives: Arrives) -> bool:
    """Return True if the robot avoids narrow places although it fits through them.

    That is the case if every path from the place that it reaches is narrow,
    and all robots below some smaller radius arrive.

    Args:
        world: The world.
        place: x and y, cells.
        arrives: Runs the same scenario in changed worlds.
    """
    if not _has_little_room(world, place):
        return False
    changed = replace(world, certificate=None, failure=None)
    # The first robot that does not arrive decides, so no larger one is tried.
    arrived = itertools.takewhile(
        lambda share: arrives(replace(changed, robot_radius=share * world.robot_radius)), _SMALLER
    )
    return len(list(arrived)) >= _FEWEST


def _has_little_room(world: World, place: tuple[float, float]) -> bool:
    """Return True if every path from a place to the target has a gap or ends at a wall."""
    solid = walls_at_the_end(world)
    x, y = place
    height, width = solid.shape
    if not (0 <= x < width and 0 <= y < height) or solid[math.floor(y), math.floor(x)]:
        return False
    # The place itself may be next to a wall: that does not keep the robot from leaving it.
    target = target_disc(world)
    centre = (target.x, target.y)
    wide = _GAP * world.robot_radius / world.cell_size
    gap = narrowest_gap_sq(
        solid, (round(x * UNIT), round(y * UNIT)), centre, math.ceil((2.0 * wide) ** 2)
    )
    to_wall = math.sqrt(Walls(solid, Fraction(1)).nearest(centre)[1]) + target.radius
    return gap is not None or to_wall < wide * UNIT
