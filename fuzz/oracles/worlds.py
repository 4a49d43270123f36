"""Build worlds that correspond to another one: turned, shifted, scaled, mirrored.

The coordinates are exact. The new worlds have no certificate.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from worldgen.lattice import exact
from worldgen.world import Pose, Robot, World

# The shift differs along the two axes, so that mixing them up shows.
_COLUMNS = 3
_ROWS = 5


def turned(world: World) -> World:
    """Return the world turned counter-clockwise by a quarter turn."""

    def turn(robot: Robot) -> Robot:
        start = robot.start
        target = robot.target
        return replace(
            robot,
            start=Pose(_across(world, world.height, start.y), start.x, start.heading + math.pi / 2),
            target=replace(
                target,
                x=_across(world, world.height, target.y),
                y=target.x,
                heading=None if target.heading is None else target.heading + math.pi / 2,
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
        target = robot.target
        return replace(
            robot,
            start=Pose(_across(world, world.width, start.x), start.y, math.pi - start.heading),
            target=replace(
                target,
                x=_across(world, world.width, target.x),
                heading=None if target.heading is None else math.pi - target.heading,
            ),
            footprint=tuple((x, -y) for x, y in robot.footprint),
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
        target = robot.target
        return replace(
            robot,
            start=replace(start, x=float(exact(start.x) + right), y=float(exact(start.y) + up)),
            target=replace(target, x=float(exact(target.x) + right), y=float(exact(target.y) + up)),
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
        target = robot.target
        return replace(
            robot,
            start=replace(start, x=2 * start.x, y=2 * start.y),
            target=replace(
                target,
                x=2 * target.x,
                y=2 * target.y,
                radius=2 * target.radius,
                arrival_speed=2 * target.arrival_speed,
            ),
            radius=2 * robot.radius,
            speed=2 * robot.speed,
            footprint=tuple((2 * x, 2 * y) for x, y in robot.footprint),
            drive=replace(robot.drive, turning_radius=2 * robot.drive.turning_radius),
        )

    robots = tuple(map(scale, world.robots))
    return replace(world.bare, robots=robots, cell_size=2 * world.cell_size)


def _across(world: World, cells: int, metres: float) -> float:
    """Return a coordinate measured from the opposite side."""
    return float(cells * exact(world.cell_size) - exact(metres))
