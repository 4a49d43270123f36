"""Place more robots in worlds that were drawn for one."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from hypothesis import reject
from hypothesis import strategies as st

from fuzz.unit.config import radius_next_to
from worldgen.errors import InvalidWorld
from worldgen.lattice import cell_middle
from worldgen.support.arrays import Ints
from worldgen.world import Pose, Robot, Target, World

_HEADINGS = 8  # headings to draw from, evenly spaced


def fleet_worlds(
    where: st.SearchStrategy[World], robots: int, like: World | None = None
) -> st.SearchStrategy[World]:
    """Draw worlds with more robots; the worlds themselves for a single robot.

    Half of the robots have to change places with an earlier one, because fleets typically fail when
    robots meet in a narrow place. The others start and end in arbitrary free cells, apart from the
    robots before them.

    Args:
        where: Worlds for one robot.
        robots: Number of robots in each world.
        like: World whose robots set the speed, the size relative to the first, and the size of the
            target of robots with the same number. All others are like the first robot.
    """
    return where if robots == 1 else _with_more_robots(where, robots, like)


@st.composite
def _with_more_robots(
    draw: st.DrawFn, where: st.SearchStrategy[World], robots: int, like: World | None
) -> World:
    world = draw(where)
    free = np.argwhere(~world.walls)
    placed = list(world.robots)
    unpaired = list(world.robots)
    while len(placed) < robots:
        model = _model(world, like, len(placed))
        heading = draw(st.integers(0, _HEADINGS - 1)) * (2 * math.pi / _HEADINGS)
        changes_places = bool(unpaired) and draw(st.booleans())
        if changes_places:
            # Two robots that changed places with the same one would start in the same place.
            earlier = draw(st.sampled_from(unpaired))
            unpaired.remove(earlier)
            place = (earlier.target.x, earlier.target.y)
            goal = (earlier.start.x, earlier.start.y)
            robot = _moved(model, place, heading, goal)
        else:
            starts = ((one.start.x, one.start.y, one.radius) for one in placed)
            # The centres of two robots may be anywhere in their targets.
            reach = model.radius - model.target.radius
            goals = ((one.target.x, one.target.y, one.radius - one.target.radius) for one in placed)
            place = _drawn_place(draw, free, world.cell_size, model.radius, starts)
            goal = _drawn_place(draw, free, world.cell_size, reach, goals)
            robot = _moved(model, place, heading, goal)
            unpaired.append(robot)
        placed.append(robot)
    try:
        return replace(world, robots=tuple(placed), certificate=None, provenance=None)
    except InvalidWorld:  # two of them start or end in the same place
        reject()


def _model(world: World, like: World | None, index: int) -> Robot:
    """Return a robot with the size and speed of the one with this index, from 0."""
    first = world.robots[0]
    if like is None or index >= len(like.robots):
        return first
    return replace(like.robots[index], radius=radius_next_to(first.radius, like, index + 1))


def _moved(
    model: Robot, place: tuple[float, float], heading: float, goal: tuple[float, float]
) -> Robot:
    return replace(model, start=Pose(*place, heading), target=Target(*goal, model.target.radius))


def _drawn_place(
    draw: st.DrawFn,
    free: Ints,
    side: float,
    reach: float,
    others: Iterable[tuple[float, float, float]],
) -> tuple[float, float]:
    """Draw the middle of a free cell, m, far enough from others.

    Args:
        draw: Draws from a strategy.
        free: (n, 2) int64, the free cells (iy, ix).
        side: Side of a cell, m.
        reach: Distance to keep, m, added to each other robot's.
        others: Their places x and y, m, and distances to keep, m.
    """
    centres = (free[:, ::-1] + 0.5) * side
    clear = np.ones(len(free), bool)
    for x, y, other in others:
        clear &= np.hypot(centres[:, 0] - x, centres[:, 1] - y) >= reach + other
    cells = free[clear]
    if not len(cells):
        reject()
    return _centre(cells[draw(st.integers(0, len(cells) - 1))], side)


def _centre(cell: Ints, side: float) -> tuple[float, float]:
    """Return the middle of a cell (iy, ix), m."""
    iy, ix = cell.tolist()
    return cell_middle(ix, side), cell_middle(iy, side)
