"""Pockets into which the target draws a robot, and how far every way leads away from the target.

A robot at ``p`` is ``D(p)`` from the target as the crow flies. The pass of ``p`` is the least, over
all ways from ``p`` to the target, of the greatest ``D`` on the way: so far from the target must a
robot at ``p`` go, whatever it does. Its depth is pass less ``D``.

The points are taken in the order of ``D``, each united with its neighbours before it: two pockets
become one at the lowest point between them, and a pocket's depth shows when it joins what is
connected with the target.

Source: Edelsbrunner, Letscher, Zomorodian, "Topological Persistence and Simplification", 2002; of
    depressions in
terrain, filled in that order, Barnes, Lehman, Mulla, "Priority-Flood", 2014.
"""

from __future__ import annotations

import math

import numpy as np

from worldgen import _core
from worldgen.difficulty.nodes import HALF, Nodes
from worldgen.difficulty.path import Ints, WitnessPath
from worldgen.reach.still.disc import Disc
from worldgen.reach.still.lattice_graph import nodes_within
from worldgen.support.ccall import check, pointer, writable
from worldgen.support.grid_search import by_distance

__all__ = ["pockets"]


def pockets(nodes: Nodes, way: WitnessPath, disc: Disc) -> tuple[float, float] | None:
    """Return the depth of the deepest pocket, and how far every way must go back.

    Of the pockets, those count that a robot can come to without going farther from the target than
    it has to.

    Args:
        nodes: The world at rest.
        way: A way from the start to the target.
        disc: The target.

    Returns:
        Concavity and retreat, 1/1024 cell; None if no way leads over the half cells.
    """
    start = (int(way.x[0]), int(way.y[0]))
    x = round(disc.x)
    y = round(disc.y)
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
    deepest = max((math.sqrt(top) - math.sqrt(bottom) for top, bottom in found[1]), default=0.0)
    return deepest, math.sqrt(found[0]) - math.sqrt(at_start)


def _flooded(
    nodes: Nodes, places: Ints, squared: Ints, sources: list[int], begins: list[int], at_start: int
) -> tuple[int, list[tuple[int, int]]]:
    """Return the squared pass of the start, or -1.

    And (pass, bottom), squared, of pockets that joined the target's.
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
