"""Edits of a world's geometry: free cells, drop rows and columns, move the start, round a number.

None of them uses any facts about the run.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from sim.runners.edited import CellEdit, EditKind
from worldgen.errors import InvalidWorld
from worldgen.lattice import exact
from worldgen.world import Pose, Robot, Target, World

_SMALLEST_SIDE = 1  # cells

_Place = TypeVar("_Place", Pose, Target)


def free_cells(world: World, cells: Iterable[tuple[int, int]]) -> World | None:
    """Return the world with the cells (ix, iy) freed; ``None`` if none of them was solid."""
    walls = world.walls.copy()
    for ix, iy in cells:
        walls[iy, ix] = False
    return None if np.array_equal(walls, world.walls) else replace(world, walls=walls)


def drop_lines(world: World, first: int, count: int, axis: int) -> World | None:
    """Return the world without some rows or columns; those beyond move towards the origin.

    ``None`` if no grid is left.

    Args:
        world: The world.
        first: The first row or column to drop.
        count: How many to drop.
        axis: 0 for rows, 1 for columns, as for ``numpy.delete``.
    """
    if world.walls.shape[axis] - count < _SMALLEST_SIDE:
        return None
    name = "yx"[axis]
    end = first + count
    side = exact(world.cell_size)

    # A point within the dropped cells stays where it is.
    def moved(place: _Place) -> _Place:
        metres = exact(getattr(place, name))
        if metres < end * side:
            return place
        place_there: Any = {name: float(metres - count * side)}
        return replace(place, **place_there)

    robots = [
        replace(
            robot,
            start=moved(robot.start),
            target=moved(robot.target),
            waypoints=tuple(map(moved, robot.waypoints)),
        )
        for robot in world.robots
    ]
    walls = np.delete(world.walls, np.s_[first:end], axis=axis)
    timeline = world.timeline.without_cells(first, count, axis)
    return with_robots(world, robots, walls=walls, timeline=timeline)


def with_robots(world: World, robots: Sequence[Robot], **parts: Any) -> World | None:
    """Return the world with other robots and parts; ``None`` if that is invalid or unchanged."""
    if not parts and tuple(robots) == world.robots:
        return None
    try:
        return replace(world, robots=tuple(robots), **parts)
    except InvalidWorld:  # a robot is off the grid, or in another robot's place
        return None


def edited(world: World, edit: CellEdit) -> World | None:
    """Return the world after an edit of its cells; ``None`` if no grid is left, or no change."""
    if edit.kind in (EditKind.DROP_ROWS, EditKind.DROP_COLUMNS):
        return drop_lines(world, edit.a, edit.b, axis=int(edit.kind == EditKind.DROP_COLUMNS))
    # The remaining edits free solid cells: those in a box, in a run, or else on the rim.
    solid = np.argwhere(world.walls)
    iy, ix = solid.T
    if edit.kind == EditKind.FREE_BOX:
        solid = solid[
            (ix >= edit.a) & (ix < edit.a + edit.c) & (iy >= edit.b) & (iy < edit.b + edit.d)
        ]
    elif edit.kind == EditKind.FREE_RUN:
        solid = solid[edit.a : edit.a + edit.b]
    else:
        solid = solid[(ix == 0) | (iy == 0) | (ix == world.width - 1) | (iy == world.height - 1)]
    return free_cells(world, ((ix, iy) for iy, ix in solid.tolist()))
