"""Build worlds that correspond to another one: turned, shifted, scaled, mirrored.

The coordinates are exact. The new worlds have no certificate.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from worldgen.lattice import exact
from worldgen.world import Pose, Robot, Target, World

__all__ = ["mirrored", "scaled", "shifted", "turned"]

# The shift differs along the two axes, so that mixing them up shows.
_COLUMNS = 3
_ROWS = 5


def turned(world: World) -> World:
    """Return the world turned counter-clockwise by a quarter turn."""
    line = world.timeline

    def turn(robot: Robot) -> Robot:
        start = robot.start
        target = robot.target
        return replace(
            robot,
            start=Pose(_across(world, world.height, start.y), start.x, start.heading + math.pi / 2),
            target=Target(_across(world, world.height, target.y), target.x, target.radius),
        )

    return _bare(world).with_robots(
        map(turn, world.robots),
        walls=world.walls.T[:, ::-1].copy(),
        timeline=replace(line, ix=world.height - 1 - line.iy, iy=line.ix),
    )


def mirrored(world: World) -> World:
    """Return the world with left and right swapped."""
    line = world.timeline

    def mirror(robot: Robot) -> Robot:
        start = robot.start
        target = robot.target
        return replace(
            robot,
            start=Pose(_across(world, world.width, start.x), start.y, math.pi - start.heading),
            target=replace(target, x=_across(world, world.width, target.x)),
        )

    return _bare(world).with_robots(
        map(mirror, world.robots),
        walls=world.walls[:, ::-1].copy(),
        timeline=replace(line, ix=world.width - 1 - line.ix),
    )


def shifted(world: World) -> World:
    """Return the world with three more solid columns on the left and five more solid rows below."""
    side = exact(world.cell_size)
    line = world.timeline
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

    return _bare(world).with_robots(
        map(shift, world.robots),
        walls=np.pad(world.walls, ((_ROWS, 0), (_COLUMNS, 0)), constant_values=True),
        timeline=replace(line, ix=line.ix + _COLUMNS, iy=line.iy + _ROWS),
    )


def scaled(world: World) -> World:
    """Return the world with every length and every top speed doubled; times stay the same."""

    def scale(robot: Robot) -> Robot:
        target = robot.target
        return Robot(
            replace(robot.start, x=2 * robot.start.x, y=2 * robot.start.y),
            Target(2 * target.x, 2 * target.y, 2 * target.radius),
            2 * robot.radius,
            2 * robot.speed,
        )

    return _bare(world).with_robots(map(scale, world.robots), cell_size=2 * world.cell_size)


def _bare(world: World) -> World:
    return replace(world, certificate=None, provenance=None, failure=None)


def _across(world: World, cells: int, metres: float) -> float:
    """Return a coordinate measured from the opposite side."""
    return float(cells * exact(world.cell_size) - exact(metres))
