"""Build worlds that correspond to another one: turned, shifted, scaled, mirrored.

The coordinates are exact. The new worlds have no certificate.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from worldgen.lattice import exact
from worldgen.world import Pose, Robot, Target, World

# The shift differs along the two axes, so that mixing them up shows.
_COLUMNS = 3
_ROWS = 5


def turned(world: World) -> World:
    """Return the world turned counter-clockwise by a quarter turn."""

    def turn(robot: Robot) -> Robot:
        start = robot.start
        return _with_goals(
            replace(
                robot,
                start=Pose(
                    _across(world, world.height, start.y), start.x, start.heading + math.pi / 2
                ),
            ),
            lambda goal: replace(
                goal,
                x=_across(world, world.height, goal.y),
                y=goal.x,
                heading=None if goal.heading is None else goal.heading + math.pi / 2,
            ),
        )

    return replace(
        world.bare,
        robots=tuple(map(turn, world.robots)),
        walls=world.walls.T[:, ::-1].copy(),
        timeline=world.timeline.moved(lambda ix, iy: (world.height - 1 - iy, ix)),
    )


def mirrored(world: World) -> World:
    """Return the world with left and right swapped."""

    def mirror(robot: Robot) -> Robot:
        start = robot.start
        return _with_goals(
            replace(
                robot,
                start=Pose(_across(world, world.width, start.x), start.y, math.pi - start.heading),
                footprint=tuple((x, -y) for x, y in robot.footprint),
            ),
            lambda goal: replace(
                goal,
                x=_across(world, world.width, goal.x),
                heading=None if goal.heading is None else math.pi - goal.heading,
            ),
        )

    return replace(
        world.bare,
        robots=tuple(map(mirror, world.robots)),
        walls=world.walls[:, ::-1].copy(),
        timeline=world.timeline.moved(lambda ix, iy: (world.width - 1 - ix, iy)),
    )


def shifted(world: World) -> World:
    """Return the world with three more solid columns on the left and five more solid rows below."""
    side = exact(world.cell_size)
    right = _COLUMNS * side
    up = _ROWS * side

    def shift(robot: Robot) -> Robot:
        start = robot.start
        return _with_goals(
            replace(
                robot,
                start=replace(start, x=float(exact(start.x) + right), y=float(exact(start.y) + up)),
            ),
            lambda goal: replace(goal, x=float(exact(goal.x) + right), y=float(exact(goal.y) + up)),
        )

    return replace(
        world.bare,
        robots=tuple(map(shift, world.robots)),
        walls=np.pad(world.walls, ((_ROWS, 0), (_COLUMNS, 0)), constant_values=True),
        timeline=world.timeline.moved(lambda ix, iy: (ix + _COLUMNS, iy + _ROWS)),
    )


def scaled(world: World) -> World:
    """Return the world with every length and every top speed doubled; times stay the same."""

    def scale(robot: Robot) -> Robot:
        start = robot.start
        return _with_goals(
            replace(
                robot,
                start=replace(start, x=2 * start.x, y=2 * start.y),
                radius=2 * robot.radius,
                speed=2 * robot.speed,
                footprint=tuple((2 * x, 2 * y) for x, y in robot.footprint),
                drive=replace(robot.drive, turning_radius=2 * robot.drive.turning_radius),
            ),
            lambda goal: replace(
                goal,
                x=2 * goal.x,
                y=2 * goal.y,
                radius=2 * goal.radius,
                arrival_speed=2 * goal.arrival_speed,
            ),
        )

    robots = tuple(map(scale, world.robots))
    return replace(world.bare, robots=robots, cell_size=2 * world.cell_size)


def _with_goals(robot: Robot, change: Callable[[Target], Target]) -> Robot:
    """Return a robot with all of its goals changed."""
    *waypoints, target = map(change, robot.goals)
    return replace(robot, target=target, waypoints=tuple(waypoints))


def _across(world: World, cells: int, metres: float) -> float:
    """Return a coordinate measured from the opposite side."""
    return float(cells * exact(world.cell_size) - exact(metres))
