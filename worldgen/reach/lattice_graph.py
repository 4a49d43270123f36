"""The search graph: clear points at multiples of 1/k cell, joined to their eight neighbours, exactly.

An axis step of one unit has its least clearance at an end, a diagonal step at an end or at its middle
(docs/reachability.md proves it). So two rasters decide every edge: ``clear`` at the nodes, ``middle`` at
the middles of the unit squares.
"""

from __future__ import annotations

import functools
import heapq
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from worldgen.jit import lazy_kernel
from worldgen.lattice import UNIT
from worldgen.reach.bucket_search import bucket_search_compiled, room_for_search
from worldgen.reach.disc import Disc
from worldgen.reach.effort import SMALL
from worldgen.reach.flood import flood_compiled
from worldgen.reach.rasters import disc_rasters_compiled, rows_of_discs

__all__ = [
    "AXIS_COST",
    "DIAGONAL_COST",
    "Graph",
    "build_graph",
    "clear_raster",
    "find_path",
    "nodes_within",
    "touching_cells",
]

AXIS_COST, DIAGONAL_COST = 70, 99  # 99/70 is sqrt(2) to 7e-5; whole numbers give the same path everywhere
_FAR = 2**62
_HASTY = 300_000  # nodes expanded before it is looked whether there is a way: about 20 ms, as long as looking takes


@dataclass(frozen=True)
class Graph:
    """Clear nodes at multiples of 1/k cell.

    Args:
        k: Nodes per cell side.
        clear: (k * height + 1, k * width + 1) bool, whether the disc is clear at the node.
        middle: Same shape; whether it is clear half a unit right of and above the node. The last row
            and column have no such point and are False.
    """

    k: int
    clear: npt.NDArray[np.bool_]
    middle: npt.NDArray[np.bool_]

    @property
    def stride(self) -> int:
        """Nodes per row."""
        return int(self.clear.shape[1])


def build_graph(solid: npt.NDArray[np.bool_], radius: Fraction, k: int, *, compiled: bool = False) -> Graph:
    """The graph of a grid for a disc of ``radius`` cells, by plain or by compiled code."""
    height, width = solid.shape
    clear = np.zeros((k * height + 1, k * width + 1), np.bool_)
    middle = np.zeros(clear.shape, np.bool_)
    if 2 * radius > min(height, width):  # nothing is clear
        return Graph(k, clear, middle)
    if compiled and 2 * radius < 65_000:
        begins, rows, pad = rows_of_discs(radius, k)
        gaps = np.zeros((height + 2 * pad, width + 2 * pad), np.uint8 if rows[:, 2].max() <= 255 else np.uint16)
        cells, line = np.ascontiguousarray(solid).view(np.uint8), np.empty(width + 1, np.uint8)
        counts = rows[:, 2].astype(gaps.dtype)
        disc_rasters_compiled(cells, begins, rows, counts, gaps, line, k, clear.view(np.uint8), middle.view(np.uint8))
    else:
        window = _Windows(solid, math.ceil(radius) + 1)
        for b in range(k):
            for a in range(k):
                clear[b::k, a::k] = clear_raster(window, 2 * a, 2 * b, 2 * k, radius, clear[b::k, a::k].shape)
                shape = (height, width)
                middle[b:-1:k, a:-1:k] = clear_raster(window, 2 * a + 1, 2 * b + 1, 2 * k, radius, shape)
    return Graph(k, clear, middle)


class _Windows:
    """Whether any of n cells in a row, counted from a cell rightwards, is solid; by doubling."""

    def __init__(self, solid: npt.NDArray[np.bool_], pad: int) -> None:
        self.pad = pad
        self._powers = [np.pad(solid, pad, constant_values=True)]

    def any_of(self, count: int) -> npt.NDArray[np.bool_]:
        """Array w with w[j, i] = any of the padded cells i .. i + count - 1 of row j."""
        level = count.bit_length() - 1
        while len(self._powers) <= level:
            half, step = self._powers[-1], 1 << (len(self._powers) - 1)
            self._powers.append(half[:, :-step] | half[:, step:])
        base, rest = self._powers[level], count - (1 << level)
        return base if rest == 0 else base[:, : base.shape[1] - rest] | base[:, rest:]


def clear_raster(
    windows: _Windows, a: int, b: int, m: int, radius: Fraction, shape: tuple[int, int]
) -> npt.NDArray[np.bool_]:
    """Whether the disc is clear at the points (i + a/m, j + b/m), for j, i below ``shape``.

    The distance from such a point to a cell is the root of a whole number of 1/m cells squared, so the
    comparison with the radius is exact.
    """
    limit = math.ceil((m * radius) ** 2)  # clear means: squared distance >= limit
    blocked = np.zeros(shape, np.bool_)
    reach = math.isqrt(limit - 1)
    made: dict[int, npt.NDArray[np.bool_]] = {}
    for dj in range(-((reach + m - b) // m), (reach + b) // m + 1):
        dy = max(m * dj - b, 0, b - m * dj - m)
        across = math.isqrt(limit - dy * dy - 1)
        low, high = -((across + m - a) // m), (across + a) // m
        count = high - low + 1
        if count not in made:
            made[count] = windows.any_of(count)
        row, column = windows.pad + dj, windows.pad + low
        blocked |= made[count][row : row + shape[0], column : column + shape[1]]
    return ~blocked


def touching_cells(a: int, b: int, m: int, radius: Fraction) -> list[tuple[int, int]]:
    """Cells (dx, dy) whose distance from the point (a/m, b/m) is below the radius; all in cells."""
    limit = math.ceil((m * radius) ** 2)
    reach = math.isqrt(limit - 1) // m + 2
    return [
        (dx, dy)
        for dy in range(-reach, reach + 1)
        for dx in range(-reach, reach + 1)
        if max(m * dx - a, 0, a - m * dx - m) ** 2 + max(m * dy - b, 0, b - m * dy - m) ** 2 < limit
    ]


def nodes_within(disc: Disc, graph: Graph) -> npt.NDArray[np.int64]:
    """Flat indices of the clear nodes in the target's disc."""
    rows, columns = graph.clear.shape
    scale = math.lcm(disc.x.denominator, disc.y.denominator, disc.radius.denominator)
    x, y, radius = (value.numerator * (scale // value.denominator) for value in disc)
    unit = UNIT // graph.k * scale
    found = []
    for j in range(max(0, -((radius - y) // unit)), min(rows - 1, (y + radius) // unit) + 1):
        half = math.isqrt(radius**2 - (j * unit - y) ** 2)  # of the chord at this height, rounded down
        first, last = max(0, -((half - x) // unit)), min(columns - 1, (x + half) // unit)
        found.append(np.nonzero(graph.clear[j, first : last + 1])[0] + (j * graph.stride + first))
    return np.concatenate(found) if found else np.zeros(0, np.int64)


def find_path(
    graph: Graph,
    sources: Sequence[int],
    ends: Sequence[int],
    spare: npt.NDArray[np.int64],
    toward: tuple[int, int],
    bridges: Sequence[tuple[int, int]] = (),
    *,
    compiled: bool = False,
) -> list[int]:
    """A path over the graph from a source to an end, or else to a spare end; a shortest one without bridges.

    Args:
        graph: The graph.
        sources: Flat indices of clear nodes, near each other.
        ends: Where the search stops.
        spare: Ends to be content with where no end is connected to a source.
        toward: Node (x, y) that the search leans to.
        bridges: Pairs of nodes that are joined too; used once there is no other way on.
        compiled: Whether to run compiled code; the path is the same.

    Returns:
        Flat indices from source to end, without those in the middle of a straight line; empty where none is connected.
    """
    if compiled and not bridges:
        return _find_in_buckets(graph, sources, ends, spare, toward)
    inputs, cost, came, search = _prepared(graph, ends, spare)
    found = search(*inputs, np.array(sources, np.int64), toward, cost, came)
    by_bridge: dict[int, int] = {}
    both_ways = [*bridges, *((b, a) for a, b in bridges)]
    while found < 0:
        onward = {b: a for a, b in both_ways if cost[a] < 0 <= cost[b]}
        if not onward:
            return []
        by_bridge.update(onward)
        found = search(*inputs, np.array(list(onward), np.int64), toward, cost, came)
    return corners(_trace(int(found), came, neighbour_shifts(graph.stride)[0], by_bridge))


def corners(path: Sequence[int]) -> list[int]:
    """A path without the nodes in the middle of a straight line."""
    steps = [b - a for a, b in itertools.pairwise(path)]
    return [*path[:1], *(path[i + 1] for i in range(len(steps) - 1) if steps[i] != steps[i + 1]), *path[1:][-1:]]


def _find_in_buckets(
    graph: Graph, sources: Any, ends: Any, spare: npt.NDArray[np.int64], toward: tuple[int, int]
) -> list[int]:
    """The same path by compiled code."""
    rasters = (graph.clear.view(np.uint8).ravel(), graph.middle.view(np.uint8).ravel())
    sources, ends = np.array(sorted(set(sources)), np.int64), np.asarray(ends, np.int64)
    path = _bucket_search(graph, rasters, sources, ends, spare, toward, _HASTY)
    if path is None:  # before all of a large world is searched, look whether there is anything to find
        seen = np.zeros(graph.clear.size, np.uint8)
        flood_compiled(*rasters, graph.stride, sources, seen)
        ends, spare = ends[seen[ends] > 0], spare[seen[spare] > 0]
        if len(ends) or len(spare):
            path = _bucket_search(graph, rasters, sources, ends, spare, toward, graph.clear.size)
    found: list[int] = [] if path is None else path.tolist()
    return found


def _bucket_search(
    graph: Graph,
    rasters: tuple[Any, Any],
    sources: npt.NDArray[np.int64],
    ends: npt.NDArray[np.int64],
    spare: npt.NDArray[np.int64],
    toward: tuple[int, int],
    most: int,
) -> npt.NDArray[np.int64] | None:
    """The path, empty if there is none; None if more than ``most`` nodes would have to be expanded."""
    size = graph.clear.size
    goal, came, left = np.zeros(size, np.uint8), np.zeros(size, np.uint8), np.array([most])
    both = ends
    if len(spare):
        goal[spare] = 2 if len(ends) else 1  # with nothing better to hope for, the first will do
        both = np.concatenate([spare, ends])
    goal[ends] = 1
    narrow = size * DIAGONAL_COST < 2**31
    path: npt.NDArray[np.int64] = bucket_search_compiled(
        *rasters, goal, graph.stride, _steps(graph.stride), sources,
        np.array([both.min(), both.max()]), np.array(toward),
        np.empty(size, np.int32 if narrow else np.int64), 2**31 - 1 if narrow else _FAR, came, left,
        *room_for_search(size),
    )  # fmt: skip
    return path if left[0] >= 0 else None


@functools.lru_cache(maxsize=16)
def _steps(stride: int) -> npt.NDArray[np.int64]:
    """(8, 4) what each step adds to a flat index, where its middle is, and how far it leads across and up."""
    table = [*neighbour_shifts(stride), [1, -1, 0, 0, 1, -1, -1, 1], [0, 0, 1, -1, 1, -1, 1, -1]]
    return np.ascontiguousarray(np.array(table).T)


def _prepared(graph: Graph, ends: Sequence[int], spare: npt.NDArray[np.int64]) -> tuple[Any, Any, Any, Any]:
    """The first arguments of ``_search``, its two work arrays, and the search itself, plain or compiled."""
    size, moves = graph.clear.size, neighbour_shifts(graph.stride)
    goal, came, cost = np.zeros(size, np.uint8), np.zeros(size, np.uint8), np.full(size, _FAR, np.int64)
    goal[spare] = 2
    goal[np.asarray(ends, np.int64)] = 1
    rasters = (graph.clear.view(np.uint8).ravel(), graph.middle.view(np.uint8).ravel(), goal)
    if size <= SMALL:
        plain = (array.tobytes() for array in rasters)
        return (*plain, graph.stride, *moves), cost.tolist(), bytearray(size), _search
    return (*rasters, graph.stride, *map(np.array, moves)), cost, came, _search_compiled


def neighbour_shifts(stride: int) -> tuple[list[int], list[int]]:
    """What eight steps add to a flat index, four along the axes first; and where their middles are."""
    shifts = [1, -1, stride, -stride, stride + 1, -stride - 1, stride - 1, 1 - stride]
    return shifts, [0, 0, 0, 0, 0, -stride - 1, -1, -stride]


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
    """A* over the eight neighbours; the same text runs plain and compiled.

    ``goal`` is 1 where the search stops, 2 where it would be content; ``came`` gets the direction (1 to 8)
    by which a node is reached, 0 at a source; ``cost`` is negative once a node is done with. Returns the
    end, the cheapest spare end, or -1.

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
    # Entries are (cost + heuristic) * 2**31 + node: one whole number compares faster than a pair.
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
            # Nodes on the rim of the grid are never clear, so a clear node has all eight neighbours.
            if clear[other] == 0 or (direction > 3 and middle[node + corners[direction]] == 0):
                continue
            onward = here + (70 if direction < 4 else 99)
            if onward < cost[other]:
                cost[other] = onward
                came[other] = direction + 1
                dx, dy = abs(other % stride - gx), abs(other // stride - gy)
                guess = 70 * dx + 29 * dy if dx > dy else 70 * dy + 29 * dx
                heapq.heappush(queue, (onward + guess) * 2147483648 + other)
    return spare


_search_compiled = lazy_kernel(_search)
