"""Single edits of a world: free cells, drop rows and columns, move the start. Pure geometry."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from worldgen.errors import InvalidWorld
from worldgen.lattice import exact
from worldgen.timeline import Timeline
from worldgen.world import Pose, Target, World

__all__ = ["bare", "drop_columns", "drop_events", "drop_rows", "free_cells", "with_start"]

_SMALLEST_SIDE = 1  # cells


def bare(world: World) -> World:
    """The world without certificate, provenance and failure: what edits work on."""
    return replace(world, certificate=None, provenance=None, failure=None)


def free_cells(world: World, cells: Iterable[tuple[int, int]]) -> World | None:
    """The world with the cells (ix, iy) freed; ``None`` if none of them was solid."""
    walls = world.walls.copy()
    for ix, iy in cells:
        walls[iy, ix] = False
    return None if np.array_equal(walls, world.walls) else replace(world, walls=walls)


def drop_rows(world: World, first: int, count: int) -> World | None:
    """The world without ``count`` rows from ``first`` up; what lies above moves down."""
    if world.height - count < _SMALLEST_SIDE:
        return None
    top = first + count
    walls = np.delete(world.walls, np.s_[first:top], axis=0)
    start = replace(world.start, y=_moved(world, world.start.y, top, count))
    target = replace(world.target, y=_moved(world, world.target.y, top, count))
    line = world.timeline
    keep = (line.iy < first) | (line.iy >= top)
    rows = np.where(line.iy >= top, line.iy - count, line.iy)
    return _rebuilt(
        world, walls, start, target, Timeline(line.times[keep], line.ix[keep], rows[keep], line.states[keep])
    )


def drop_columns(world: World, first: int, count: int) -> World | None:
    """The world without ``count`` columns from ``first`` on; what lies right of them moves left."""
    if world.width - count < _SMALLEST_SIDE:
        return None
    right = first + count
    walls = np.delete(world.walls, np.s_[first:right], axis=1)
    start = replace(world.start, x=_moved(world, world.start.x, right, count))
    target = replace(world.target, x=_moved(world, world.target.x, right, count))
    line = world.timeline
    keep = (line.ix < first) | (line.ix >= right)
    columns = np.where(line.ix >= right, line.ix - count, line.ix)
    timeline = Timeline(line.times[keep], columns[keep], line.iy[keep], line.states[keep])
    return _rebuilt(world, walls, start, target, timeline)


def drop_events(world: World, first: int, count: int) -> World | None:
    """The world without ``count`` events from ``first`` on."""
    line = world.timeline
    if first >= len(line):
        return None
    keep = np.ones(len(line), bool)
    keep[first : first + count] = False
    return replace(world, timeline=Timeline(line.times[keep], line.ix[keep], line.iy[keep], line.states[keep]))


def with_start(world: World, start: Pose) -> World | None:
    """The world with another start pose; ``None`` if it is the same or lies outside."""
    if start == world.start:
        return None
    return _rebuilt(world, world.walls, start, world.target, world.timeline)


def _moved(world: World, metres: float, edge: int, count: int) -> float:
    """A coordinate after ``count`` cells below ``edge`` are gone; one among those stays where it is."""
    side = exact(world.cell_size)
    return float(exact(metres) - count * side) if exact(metres) >= edge * side else metres


def _rebuilt(
    world: World, walls: npt.NDArray[np.bool_], start: Pose, target: Target, timeline: Timeline
) -> World | None:
    try:
        return replace(world, walls=walls, start=start, target=target, timeline=timeline)
    except InvalidWorld:  # the point fell off the grid
        return None
