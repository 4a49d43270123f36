"""Place more robots in worlds that were drawn for one."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import reject
from hypothesis import strategies as st

from worldgen.errors import InvalidWorld
from worldgen.lattice import UNIT, lattice_to_metres
from worldgen.world import Pose, Robot, Target, World

__all__ = ["fleet_worlds"]

_HEADINGS = 8  # headings to draw from, evenly spaced


def fleet_worlds(where: st.SearchStrategy[World], robots: int) -> st.SearchStrategy[World]:
    """Draw worlds with more robots; the worlds themselves for a single robot.

    Half of the robots have to change places with an earlier one, because robots that meet in a
    narrow place are what fleets fail at. The others start and end in arbitrary free cells.

    Args:
        where: Worlds for one robot.
        robots: Number of robots in each world.
    """
    return where if robots == 1 else _with_more_robots(where, robots)


@st.composite
def _with_more_robots(draw: st.DrawFn, where: st.SearchStrategy[World], robots: int) -> World:
    world = draw(where)
    side = world.cell_size
    free = np.argwhere(~world.walls)
    index = st.integers(0, len(free) - 1)
    placed = list(world.robots)
    while len(placed) < robots:
        earlier = draw(st.sampled_from(placed))
        heading = draw(st.integers(0, _HEADINGS - 1)) * (2 * math.pi / _HEADINGS)
        if draw(st.booleans()):
            place = (earlier.target.x, earlier.target.y)
            goal = (earlier.start.x, earlier.start.y)
        else:
            place = _centre(free[draw(index)], side)
            goal = _centre(free[draw(index)], side)
        placed.append(
            Robot(
                Pose(*place, heading),
                Target(*goal, earlier.target.radius),
                earlier.radius,
                earlier.speed,
            )
        )
    try:
        return world.with_robots(placed, certificate=None, provenance=None)
    except InvalidWorld:  # two of them start or end in the same place
        reject()


def _centre(cell: np.ndarray, side: float) -> tuple[float, float]:
    """Return the middle of a cell (iy, ix), m."""
    iy, ix = cell.tolist()
    return (
        lattice_to_metres(ix * UNIT + UNIT // 2, side),
        lattice_to_metres(iy * UNIT + UNIT // 2, side),
    )
