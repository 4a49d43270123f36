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

__all__ = [
    "changed",
    "drop_columns",
    "drop_events",
    "drop_robot",
    "drop_rows",
    "edited",
    "free_cells",
    "with_robots",
    "with_time",
]

_SMALLEST_SIDE = 1  # cells

_Place = TypeVar("_Place", Pose, Target)


def free_cells(world: World, cells: Iterable[tuple[int, int]]) -> World | None:
    """Return the world with the cells (ix, iy) freed; ``None`` if none of them was solid."""
    walls = world.walls.copy()
    for ix, iy in cells:
        walls[iy, ix] = False
    return None if np.array_equal(walls, world.walls) else replace(world, walls=walls)


def drop_rows(world: World, first: int, count: int) -> World | None:
    """Return the world without ``count`` rows from ``first`` up; the rows above move down."""
    return _drop(world, first, count, axis=0)


def drop_columns(world: World, first: int, count: int) -> World | None:
    """Return the world without ``count`` columns from ``first`` on; the rest moves left."""
    return _drop(world, first, count, axis=1)


def _drop(world: World, first: int, count: int, axis: int) -> World | None:
    """Return the world without rows (axis 0) or columns (axis 1); ``None`` if no grid is left."""
    if world.walls.shape[axis] - count < _SMALLEST_SIDE:
        return None
    name = "yx"[axis]
    end = first + count
    side = exact(world.cell_size)

    # A point within the dropped cells stays where it is.
    def moved(place: _Place) -> _Place:
        metres = exact(getattr(place, name))
        return (
            replace(place, **{name: float(metres - count * side)})
            if metres >= end * side
            else place
        )

    robots = [
        replace(robot, start=moved(robot.start), target=moved(robot.target))
        for robot in world.robots
    ]
    walls = np.delete(world.walls, np.s_[first:end], axis=axis)
    timeline = world.timeline.without_cells(first, count, axis)
    return with_robots(world, robots, walls=walls, timeline=timeline)


def drop_events(world: World, first: int, count: int) -> World | None:
    """Return the world without ``count`` events from ``first`` on."""
    if first >= len(world.timeline):
        return None
    return replace(world, timeline=world.timeline.without(first, count))


def with_time(world: World, event: int, time: float) -> World | None:
    """Return the world in which an event happens at another time, s.

    ``None`` if the events would then no longer be in order.
    """
    try:
        return replace(world, timeline=world.timeline.with_time(event, time))
    except InvalidWorld:
        return None


def changed(world: World, **parts: Any) -> World | None:
    """Return the world with other parts; ``None`` if that is invalid or changes nothing."""
    if "walls" not in parts and all(getattr(world, name) == part for name, part in parts.items()):
        return None
    try:
        return replace(world, **parts)
    except InvalidWorld:  # a point is off the grid
        return None


def with_robots(world: World, robots: Sequence[Robot], **parts: Any) -> World | None:
    """Return the world with other robots and parts; ``None`` if that is invalid or unchanged."""
    if not parts and tuple(robots) == world.robots:
        return None
    try:
        return world.with_robots(robots, **parts)
    except InvalidWorld:  # a robot is off the grid, or where another one stands
        return None


def drop_robot(world: World, index: int) -> World | None:
    """Return the world without one of its robots; ``None`` if it has only one."""
    if len(world.robots) < 2:
        return None
    return with_robots(world, [*world.robots[:index], *world.robots[index + 1 :]])


def edited(world: World, edit: CellEdit) -> World | None:
    """Return the world after an edit of its cells; ``None`` if no grid is left, or no change."""
    if edit.kind == EditKind.DROP_ROWS:
        return drop_rows(world, edit.a, edit.b)
    if edit.kind == EditKind.DROP_COLUMNS:
        return drop_columns(world, edit.a, edit.b)
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
