"""Pockets into which the target draws a robot, and how far every way leads away from the target.

A robot at ``p`` is ``D(p)`` from the target as the crow flies. The pass of ``p`` is the least, over all ways from ``p``
to the target, of the greatest ``D`` on the way: so far from the target must a robot at ``p`` go, whatever it does. Its
depth is pass less ``D``.

The points are taken in the order of ``D``, each united with its neighbours before it: two pockets become one at the
lowest point between them, and a pocket's depth shows when it joins what is connected with the target.

Source: Edelsbrunner, Letscher, Zomorodian, "Topological Persistence and Simplification", 2002; of depressions in
terrain, filled in that order, Barnes, Lehman, Mulla, "Priority-Flood", 2014.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from worldgen.difficulty.nodes import HALF, Nodes
from worldgen.difficulty.way import Way
from worldgen.jit import lazy_kernel
from worldgen.reach.disc import Disc
from worldgen.reach.lattice_graph import neighbour_shifts, nodes_within

__all__ = ["pockets"]


def pockets(nodes: Nodes, way: Way, disc: Disc) -> tuple[float, float] | None:
    """Depth of the deepest pocket, and how far every way must go back.

    Of the pockets, those count that a robot can come to without going farther from the target than it has to.

    Args:
        nodes: The world at rest.
        way: A way from the start to the target.
        disc: The target.

    Returns:
        Concavity and retreat, 1/1024 cell; None if no way leads over the half cells.
    """
    columns = nodes.graph.stride
    start = (int(way.x[0]), int(way.y[0]))
    x, y = round(disc.x), round(disc.y)
    sources = nodes_within(disc, nodes.graph).tolist() or nodes.beside((int(way.x[-1]), int(way.y[-1])))
    begins = nodes.beside(start)
    if not sources or not begins:
        return None
    places = np.flatnonzero(nodes.graph.clear)
    squared = (places % columns * HALF - x) ** 2 + (places // columns * HALF - y) ** 2
    order = np.argsort(squared, kind="stable")
    places, squared = places[order], squared[order]
    at_start = (start[0] - x) ** 2 + (start[1] - y) ** 2
    found = _flooded(nodes, places, squared, sources, begins, at_start)
    if found[0] < 0:
        return None
    deepest = max((math.sqrt(top) - math.sqrt(bottom) for top, bottom in found[1]), default=0.0)
    return deepest, math.sqrt(found[0]) - math.sqrt(at_start)


def _flooded(
    nodes: Nodes, places: Any, squared: Any, sources: list[int], begins: list[int], at_start: int
) -> tuple[int, list[tuple[int, int]]]:
    """Squared pass of the start, or -1; and (pass, bottom), squared, of the pockets that joined the target's."""
    size = nodes.graph.clear.size
    role = np.zeros(size, np.uint8)
    role[begins] = 2
    role[sources] |= 1
    shifts, corners = neighbour_shifts(nodes.graph.stride)
    rank = np.full(size, -1, np.int64)
    rank[places] = np.arange(len(places))
    parent, bottom = np.full(len(places), -1, np.int64), np.arange(len(places))
    joined = np.zeros((len(places), 2), np.int64)
    rasters = (nodes.graph.middle.ravel().view(np.uint8), rank)
    if nodes.is_small:
        plain: Any = [raster.tolist() for raster in rasters]
        pairs: list[int] = [0] * joined.size
        top, count = _flood(
            places.tolist(), squared.tolist(), plain[0], plain[1], shifts, corners, at_start, parent.tolist(),
            bottom.tolist(), role[places].tolist(), pairs,
        )  # fmt: skip
        flat = pairs[: 2 * count]
    else:
        top, count = _flood_compiled(
            places, squared, *rasters, np.array(shifts), np.array(corners), at_start, parent, bottom, role[places],
            joined.ravel(),
        )  # fmt: skip
        flat = joined.ravel()[: 2 * count].tolist()
    return int(top), list(zip(flat[::2], flat[1::2], strict=True))


def _flood(
    places: Any, squared: Any, middle: Any, rank: Any, shifts: Any, corners: Any, at_start: Any,
    parent: Any, bottom: Any, mark: Any, joined: Any,
) -> Any:  # fmt: skip
    """Unites the points in the order of their distance; the same text runs plain and compiled.

    ``mark`` of a root has bit 1 if its set holds the target, bit 2 if the robot can step into it from the start. Stops
    beyond the pass of the start. Returns it, squared, or -1; and how many pairs stand in ``joined``.
    """
    top, count = -1, 0
    for r in range(len(places)):
        level = squared[r]
        if top >= 0 and level > top:
            break
        parent[r] = r
        root = r
        place = places[r]
        for direction in range(8):
            other = rank[place + shifts[direction]]
            if other < 0 or other >= r or (direction > 3 and middle[place + corners[direction]] == 0):
                continue
            while parent[other] != other:
                parent[other] = parent[parent[other]]
                other = parent[other]
            if other == root:
                continue
            if (mark[other] ^ mark[root]) & 1:  # what is not the target's is a pocket, with its bottom
                low = bottom[other] if mark[root] & 1 else bottom[root]
                if squared[low] < level:
                    joined[2 * count] = level
                    joined[2 * count + 1] = squared[low]
                    count += 1
            if other > root:
                other, root = root, other
            parent[root] = other
            mark[other] |= mark[root]
            bottom[other] = min(bottom[other], bottom[root])
            root = other
        if top < 0 and mark[root] == 3:
            top = max(level, at_start)
    return top, count


_flood_compiled = lazy_kernel(_flood)
