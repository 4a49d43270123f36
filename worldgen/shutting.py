"""Shut a world: close the fewest cells that keep the robot from its target, and prove that.

Tests that a robot gives up need worlds in which it must. A cut is looked for as a minimum cut of
the graph of cells, so that it completes the world's own walls where they leave the least open.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from worldgen.domain import MASK64
from worldgen.lattice import in_cells
from worldgen.random_streams import RandomStream
from worldgen.reach import BLOCKED, REACHABLE, UNDECIDED, Decision, decide
from worldgen.support.arrays import Bools
from worldgen.world import Cut, World

# The multiples of 2**64 divided by the golden ratio, modulo 2**64, are spread evenly, so that any
# run of consecutive seeds has its share of blocked worlds.
_GOLDEN = 0x9E3779B97F4A7C15
_HALF = 1 << 63
# No cut is nearer to start or target than this share of the shortest path between them, or this
# many radii of the robot if that is more.
_FREE_SHARE = 4
_FREE_RADII = 3
# A cell costs this much, plus up to _SPREAD at random, so that cuts of equal size differ by seed.
_COST = 1024
_SPREAD = 16
_NEVER = 1 << 28


def is_shut(seed: int, share: float) -> bool:
    """Return True if the world of a seed is one of this share of blocked worlds."""
    return ((seed * _GOLDEN + _HALF) & MASK64) < share * 2.0**64


def shut(world: World, decision: Decision, rng: RandomStream) -> tuple[World, Decision]:
    """Return a world with a few more solid cells, and the proof that its target cannot be reached.

    Around start and target there is free room. Opening any one of the new cells opens a path. In a
    world that changes, new cells and cut are where nothing ever changes.

    Args:
        world: A world of one robot.
        decision: Whether it can reach its target.
        rng: Chooses among cuts of equal size.

    Returns:
        The world unchanged and undecided if its target cannot be reached anyway, so that nothing
        would be shut, or is too near to the start.
    """
    closed = _fewest(world, rng) if decision.result == REACHABLE else None
    if closed is None:
        return world, Decision(UNDECIDED, None, "there is no room for a cut")
    # Gaps that are too narrow for the robot may stay open.
    walls = world.walls.copy()
    walls[tuple(np.array(closed).T)] = True
    for cell in closed:
        walls[cell] = False
        opened = decide(_with_walls(world, walls), certificate=False).result
        if opened != BLOCKED:
            walls[cell] = True
        if opened == UNDECIDED and world.is_dynamic:
            return world, Decision(UNDECIDED, None, "nothing proves that each new cell is needed")
    found = _with_walls(world, walls)
    proved = decide(found)
    if not isinstance(proved.certificate, Cut):
        return world, Decision(UNDECIDED, None, "the cut has no proof that a file could hold")
    return found, proved


def _with_walls(world: World, walls: Bools) -> World:
    return replace(world, walls=walls.copy(), certificate=None)


def _fewest(world: World, rng: RandomStream) -> list[tuple[int, int]] | None:
    """Return the fewest free cells without which no path of cells joins start and target.

    Source: Menger, "Zur allgemeinen Kurventheorie", Fundamenta Mathematicae 10, 1927: as many paths
        that share no cell lead past any set of cells that separates the two.
    """
    from scipy.sparse import csr_array  # noqa: PLC0415 - only worlds that are shut need it
    from scipy.sparse.csgraph import dijkstra, maximum_flow  # noqa: PLC0415

    # Number the free cells, and join those that share a side.
    free = ~world.walls | world.changing_cells
    numbers = np.full(free.shape, -1, np.int32)
    count = int(np.count_nonzero(free))
    numbers[free] = np.arange(count, dtype=np.int32)
    pairs = [
        np.stack([a[both], b[both]])
        for a, b in ((numbers[:, :-1], numbers[:, 1:]), (numbers[:-1], numbers[1:]))
        for both in [(a >= 0) & (b >= 0)]
    ]
    sides = np.concatenate([*pairs, *(pair[::-1] for pair in pairs)], axis=1)
    ends = [
        int(numbers[_cell(value.y, world), _cell(value.x, world)])
        for value in (world.start, world.target)
    ]
    if min(ends) < 0:
        return None

    # Leave free room around both ends.
    graph = csr_array((np.ones(sides.shape[1], np.int32), (sides[0], sides[1])), (count, count))
    steps = dijkstra(graph, indices=ends, unweighted=True)
    shortest = steps[0, ends[1]]
    radii = math.ceil(_FREE_RADII * in_cells(world.robots[0].radius, world.cell_size))
    room = max(shortest // _FREE_SHARE, radii)
    if not math.isfinite(shortest) or 2 * room + 1 >= shortest:
        return None
    kept = (steps <= room).any(axis=0) | world.changing_cells[free]

    # Split each cell into an entrance and an exit; what flows from one to the other is its cost.
    costs = (_COST + rng.bits(count) % np.uint64(_SPREAD)).astype(np.int32)
    costs[kept] = _NEVER
    entrances = np.arange(count, dtype=np.int32)
    heads = np.concatenate([entrances, sides[0] + count])
    tails = np.concatenate([entrances + count, sides[1]])
    limits = np.concatenate([costs, np.full(sides.shape[1], _NEVER, np.int32)])
    limited = csr_array((limits, (heads, tails)), (2 * count, 2 * count))
    flow = maximum_flow(limited, ends[0] + count, ends[1])
    if flow.flow_value >= _NEVER:
        return None
    inside = _reached(limited - flow.flow, ends[0] + count)
    cut = np.flatnonzero(inside[:count] & ~inside[count:])
    rows, columns = np.nonzero(free)
    return [(int(rows[node]), int(columns[node])) for node in cut]


def _reached(residual: Any, source: int) -> Bools:
    """Return which nodes can still get flow from a source; this is the same for any maximum flow."""
    from scipy.sparse.csgraph import breadth_first_order  # noqa: PLC0415

    residual = residual.tocsr()
    residual.data[residual.data < 0] = 0
    residual.eliminate_zeros()
    order: npt.NDArray[np.int32] = breadth_first_order(residual, source, return_predecessors=False)
    found = np.zeros(residual.shape[0], np.bool_)
    found[order] = True
    return found


def _cell(value: float, world: World) -> int:
    return int(value / world.cell_size)
