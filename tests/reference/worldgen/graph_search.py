"""A* over the eight neighbours with a heap, and a flood.

The specification of ``search.c`` and ``flood.c``.
"""

import heapq
import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from worldgen.reach.still.lattice_graph import Graph, neighbour_shifts

_FAR = 2**62


def find_path(
    graph: Graph,
    sources: Sequence[int],
    ends: Sequence[int],
    spare: npt.NDArray[np.int64],
    toward: tuple[int, int],
    bridges: Sequence[tuple[int, int]] = (),
) -> list[int]:
    """Return a path over the graph from a source to an end, or otherwise to a spare end.

    Like the package's.
    """
    size = graph.clear.size
    shifts, middles = neighbour_shifts(graph.stride)
    goal = np.zeros(size, np.uint8)
    goal[spare] = 2
    goal[np.asarray(ends, np.int64)] = 1
    cost = [_FAR] * size
    came = bytearray(size)
    rasters = (graph.clear.tobytes(), graph.middle.tobytes(), goal.tobytes())
    inputs = (*rasters, graph.stride, shifts, middles)
    found = _search(*inputs, sources, toward, cost, came)
    by_bridge: dict[int, int] = {}
    both_ways = [*bridges, *((b, a) for a, b in bridges)]
    while found < 0:
        onward = {b: a for a, b in both_ways if cost[a] < 0 <= cost[b]}
        if not onward:
            return []
        by_bridge.update(onward)
        found = _search(*inputs, list(onward), toward, cost, came)
    return corners(_trace(found, came, shifts, by_bridge))


def corners(path: Sequence[int]) -> list[int]:
    """Return a path without the nodes in the middle of a straight line."""
    steps = [b - a for a, b in itertools.pairwise(path)]
    return [
        *path[:1],
        *(path[i + 1] for i in range(len(steps) - 1) if steps[i] != steps[i + 1]),
        *path[1:][-1:],
    ]


def _trace(node: int, came: Any, shifts: list[int], by_bridge: dict[int, int]) -> list[int]:
    path = [node]
    while came[node] or node in by_bridge:
        node = node - shifts[came[node] - 1] if came[node] else by_bridge[node]
        path.append(node)
    return path[::-1]


def _search(
    clear: Any, middle: Any, goal: Any, stride: Any, shifts: Any, corners: Any, sources: Any, toward: Any,
    cost: Any, came: Any,
) -> int:  # fmt: skip
    """A* over the eight neighbours.

    ``goal`` is 1 where the search stops, 2 at spare ends; ``came`` gets the direction (1 to 8) from
    which a node is reached, 0 at a source; ``cost`` is negative once a node is finished. Returns
    the end, the cheapest spare end, or -1.

    Source: Hart, Nilsson, Raphael, "A Formal Basis for the Heuristic Determination of Minimum Cost
    Paths", 1968.
    """
    gx, gy = toward
    spare = -1
    queue = [0]
    heapq.heappop(queue)
    for source in sources:
        node = int(source)
        cost[node] = 0
        heapq.heappush(queue, node)
    # Entries are (cost + heuristic) * 2**31 + node: one integer compares faster than a pair.
    while len(queue) > 0:
        node = heapq.heappop(queue) & 2147483647
        here = cost[node]
        if here < 0:  # already expanded
            continue
        if goal[node] == 1:
            return node
        if goal[node] == 2 and spare < 0:
            spare = node
        cost[node] = -1 - here
        for direction in range(8):
            other = node + shifts[direction]
            # Nodes on the rim of the grid are never clear, so a clear node has all eight
            # neighbours.
            if clear[other] == 0 or (direction > 3 and middle[node + corners[direction]] == 0):
                continue
            onward = here + (70 if direction < 4 else 99)
            if onward < cost[other]:
                cost[other] = onward
                came[other] = direction + 1
                dx = abs(other % stride - gx)
                dy = abs(other // stride - gy)
                guess = 70 * dx + 29 * dy if dx > dy else 70 * dy + 29 * dx
                heapq.heappush(queue, (onward + guess) * 2147483648 + other)
    return spare


def flood(clear: Any, middle: Any, stride: Any, sources: Any, seen: Any) -> None:
    """Marks every node that can be reached by the eight steps.

    Args:
        clear: (n,) uint8, 1 where the disc is clear; none on the rim of the grid.
        middle: (n,) uint8, the same half a step right of and above each node.
        stride: Nodes per row.
        sources: (m,) numbers of clear nodes.
        seen: (n,) uint8 zeros; gets 1.
    """
    stack = np.empty(1024 + len(sources), np.int64)
    count = len(sources)
    for i in range(count):
        stack[i] = sources[i]
    while count > 0:
        count -= 1
        node = stack[count]
        if seen[node] != 0:
            continue
        left = right = node
        while clear[left - 1] != 0:
            left -= 1
        while clear[right + 1] != 0:
            right += 1
        for i in range(left, right + 1):
            seen[i] = 1
        while count + right - left + 8 > len(
            stack
        ):  # at most every second node begins a run, on either side
            longer = np.empty(2 * len(stack), np.int64)
            for i in range(count):
                longer[i] = stack[i]
            stack = longer
        for side in range(2):
            shift = stride if side == 0 else -stride
            # The whole run is joined to the nodes next to it; one step beyond its ends, only by a
            # clear diagonal.
            low = left if middle[left - 1 + min(shift, 0)] == 0 else left - 1
            high = right if middle[right + min(shift, 0)] == 0 else right + 1
            for i in range(low + shift, high + shift + 1):
                if clear[i] != 0 and seen[i] == 0 and (i == low + shift or clear[i - 1] == 0):
                    stack[count] = i
                    count += 1
