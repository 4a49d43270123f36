"""Prove that two robots would have to change places in a passage too narrow for both.

Let both robots be confined to a strip of height h, with radii r and s. If they are at the same x,
their centres are at most h - r - s apart, and at least r + s because the discs do not overlap. So
if h < 2 (r + s), they are never at the same x, and the one that starts on the left stays on the
left: positions change continuously. If each point of its target is right of each point of the
other's target, not both can be in their targets at once. The same holds with x and y exchanged.

A disc cannot pass between two solid cells that touch at a corner. So a robot is confined to the
free cells that a walk over cell sides leads to, and to the box around them.
"""

from __future__ import annotations

import itertools

import numpy as np

from worldgen.lattice import exact, in_cells
from worldgen.reach.decision import Swap
from worldgen.reach.still.grid_search import components
from worldgen.world import World

# Limit on the pairs examined.
_MOST_PAIRS = 2000


def find_swap(world: World, radius: float | None = None) -> Swap | None:
    """Return a pair of robots that would have to pass each other but cannot.

    Args:
        world: A world of several robots.
        radius: Radius of every robot, m; each one's own if None.
    """
    # Number the rooms: free cells that a walk over cell sides connects. Each start is in one.
    free = np.pad(~world.still_walls, 1)
    rooms = components(free)[0].reshape(free.shape)[1:-1, 1:-1]
    sides: dict[int, tuple[int, int]] = {}
    pairs = itertools.combinations(range(len(world.robots)), 2)
    for one, other in itertools.islice(pairs, _MOST_PAIRS):
        room = int(rooms[_cell_of(world, one)])
        if room != rooms[_cell_of(world, other)]:
            continue
        if room not in sides:
            rows, columns = np.nonzero(rooms == room)
            sides[room] = (int(np.ptp(rows)) + 1, int(np.ptp(columns)) + 1)
        for axis in (0, 1):
            # A strip along x is as high as the room, and one along y as wide.
            if _must_swap(world, (one, other), sides[room][axis], axis, radius):
                return Swap(one + 1, other + 1, "xy"[axis])
    return None


def _cell_of(world: World, robot: int) -> tuple[int, int]:
    """Return the cell (row, column) of a robot's start; robots count from 0."""
    start = world.robots[robot].start
    row = min(int(in_cells(start.y, world.cell_size)), world.height - 1)
    return row, min(int(in_cells(start.x, world.cell_size)), world.width - 1)


def _must_swap(
    world: World, pair: tuple[int, int], cells: int, axis: int, radius: float | None
) -> bool:
    """Return True if the strip along an axis is too narrow and the targets are in reversed order.

    Args:
        world: The world.
        pair: The robots, from 0.
        cells: Width of the strip, across the axis.
        axis: 0 for a strip along x, 1 for one along y.
        radius: Radius of every robot, m; each one's own if None.
    """
    size = world.cell_size
    left, right = (world.robots[index] for index in pair)
    if (left.start.x, left.start.y)[axis] > (right.start.x, right.start.y)[axis]:
        left, right = right, left
    height = cells * exact(size)
    radii = [exact(robot.radius if radius is None else radius) for robot in (left, right)]
    if height >= 2 * sum(radii):
        return False
    low = exact((left.target.x, left.target.y)[axis]) - exact(left.target.radius)
    high = exact((right.target.x, right.target.y)[axis]) + exact(right.target.radius)
    return low >= high
