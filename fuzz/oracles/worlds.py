"""Build worlds that correspond to another one: turned, shifted, scaled, mirrored.

The coordinates are exact. The new worlds have no certificate.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from worldgen.lattice import exact
from worldgen.world import Pose, Target, World

__all__ = ["mirrored", "scaled", "shifted", "turned"]

# The shift differs along the two axes, so that mixing them up shows.
_COLUMNS = 3
_ROWS = 5


def turned(world: World) -> World:
    """Return the world turned counter-clockwise by a quarter turn."""
    start = world.start
    target = world.target
    line = world.timeline
    return replace(
        _bare(world),
        walls=world.walls.T[:, ::-1].copy(),
        start=Pose(_across(world, world.height, start.y), start.x, start.heading + math.pi / 2),
        target=Target(_across(world, world.height, target.y), target.x, target.radius),
        timeline=replace(line, ix=world.height - 1 - line.iy, iy=line.ix),
    )


def mirrored(world: World) -> World:
    """Return the world with left and right swapped."""
    start = world.start
    target = world.target
    line = world.timeline
    return replace(
        _bare(world),
        walls=world.walls[:, ::-1].copy(),
        start=Pose(_across(world, world.width, start.x), start.y, math.pi - start.heading),
        target=replace(target, x=_across(world, world.width, target.x)),
        timeline=replace(line, ix=world.width - 1 - line.ix),
    )


def shifted(world: World) -> World:
    """Return the world with three more solid columns on the left and five more solid rows below."""
    side = exact(world.cell_size)
    start = world.start
    target = world.target
    line = world.timeline
    right = _COLUMNS * side
    up = _ROWS * side
    return replace(
        _bare(world),
        walls=np.pad(world.walls, ((_ROWS, 0), (_COLUMNS, 0)), constant_values=True),
        start=replace(start, x=float(exact(start.x) + right), y=float(exact(start.y) + up)),
        target=replace(target, x=float(exact(target.x) + right), y=float(exact(target.y) + up)),
        timeline=replace(line, ix=line.ix + _COLUMNS, iy=line.iy + _ROWS),
    )


def scaled(world: World) -> World:
    """Return the world with every length and the top speed doubled; times stay the same."""
    start = world.start
    target = world.target
    return replace(
        _bare(world),
        cell_size=2 * world.cell_size,
        robot_radius=2 * world.robot_radius,
        robot_speed=2 * world.robot_speed,
        start=replace(start, x=2 * start.x, y=2 * start.y),
        target=Target(2 * target.x, 2 * target.y, 2 * target.radius),
    )


def _bare(world: World) -> World:
    return replace(world, certificate=None, provenance=None, failure=None)


def _across(world: World, cells: int, metres: float) -> float:
    """Return a coordinate measured from the opposite side."""
    return float(cells * exact(world.cell_size) - exact(metres))
