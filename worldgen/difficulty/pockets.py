"""Measure pockets that draw a robot in, and how far every path must lead away from the target.

A robot at ``p`` is ``D(p)`` from the target in a straight line. The pass of ``p`` is the least,
over all paths from ``p`` to the target, of the greatest ``D`` on the path: a robot at ``p`` must go
at least that far from the target, whatever it does. Its depth is pass minus ``D``.

The points are processed in the order of ``D``, and each is merged with its earlier neighbours. Two
pockets become one at the lowest point between them, and a pocket's depth is known when it joins the
target's component.

Source: Edelsbrunner, Letscher, Zomorodian, "Topological Persistence and Simplification", 2002.
    Barnes, Lehman, Mulla, "Priority-Flood", 2014, fill depressions in terrain in that order.
"""

from __future__ import annotations

import math

import numpy as np

from worldgen import _core
from worldgen.difficulty.nodes import HALF, Nodes
from worldgen.difficulty.path import WitnessPath
from worldgen.reach.still.disc import Disc
from worldgen.reach.still.grid_search import by_distance
from worldgen.reach.still.lattice_graph import nodes_within
from worldgen.support.arrays import Ints
from worldgen.support.ccall import check, pointer, writable


def pockets(nodes: Nodes, way: WitnessPath, disc: Disc) -> tuple[float, float] | None:
    """Return the depth of the deepest pocket, and how far every path must go back.

    Only those pockets count that a robot can enter without going farther from the target than it
    must.

    Args:
        nodes: The static world.
        way: A path from the start to the target.
        disc: The target.

    Returns:
        Concavity and retreat, 1/1024 cell; None if no path leads over the half cells.
    """
    start = (int(way.x[0]), int(way.y[0]))
    x = round(disc.x)
    y = round(disc.y)
    # If no node is inside the target disc, start from those next to the end of the path.
    sources = nodes_within(disc, nodes.graph).tolist() or nodes.beside(
        (int(way.x[-1]), int(way.y[-1]))
    )
    begins = nodes.beside(start)
    if not sources or not begins:
        return None
    places, squared = by_distance(nodes.graph.clear, HALF, x, y)
    at_start = (start[0] - x) ** 2 + (start[1] - y) ** 2
    found = _flooded(nodes, places, squared, sources, begins, at_start)
    if found[0] < 0:
        return None
    # A pocket is as deep as the difference in distance between its exit and its bottom.
    deepest = max((math.sqrt(top) - math.sqrt(bottom) for top, bottom in found[1]), default=0.0)
    return deepest, math.sqrt(found[0]) - math.sqrt(at_start)


def _flooded(
    nodes: Nodes, places: Ints, squared: Ints, sources: list[int], begins: list[int], at_start: int
) -> tuple[int, list[tuple[int, int]]]:
    """Return the squared pass of the start, or -1, and the pockets that joined the target's part.

    Each pocket is its pass and its bottom, squared.
    """
    ffi = _core.ffi
    lib = _core.lib
    graph = nodes.graph
    role = np.zeros(graph.clear.size, np.uint8)
    role[begins] = 2
    role[sources] |= 1
    top = ffi.new("int64_t *")
    pairs = ffi.new("int64_t *")
    joined = np.empty((len(places), 2), np.int64)
    order = (pointer(ffi, places, np.int64), pointer(ffi, squared, np.int64), len(places))
    rasters = (
        pointer(ffi, np.ascontiguousarray(graph.middle), np.bool_),
        pointer(ffi, role, np.uint8),
    )
    found = (top, writable(ffi, joined, np.int64), pairs)
    check(lib.wg_pockets(*order, *rasters, role.size, graph.stride, at_start, *found))
    flat = joined[: pairs[0]].tolist()
    return int(top[0]), [(pass_sq, bottom_sq) for pass_sq, bottom_sq in flat]
