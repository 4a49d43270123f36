"""The search graph: clear points at multiples of 1/k cell, joined to eight neighbours, exactly.

An axis step of one unit has its smallest clearance at an end, a diagonal step at an end or at its
middle (docs/notes/reachability.md proves it). So two rasters decide every edge: ``clear`` at
the nodes, ``middle`` at the middles of the unit squares.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from worldgen._core import ffi, lib
from worldgen.lattice import UNIT
from worldgen.reach.still.disc import Disc
from worldgen.support.arrays import Bools, Ints
from worldgen.support.ccall import check, pointer, writable

# Nodes expanded between two checks for Ctrl-C: 0.2 s.
_PORTION = 2_000_000
# Limit on the targets of a flood, which checks all of them in each run.
_MOST_STOPS = 16
# Nodes that a flood fills in the time that a search needs to expand one.
_LOOK = 32


@dataclass(frozen=True)
class Graph:
    """Clear nodes at multiples of 1/k cell.

    Args:
        k: Nodes per cell side.
        clear: (k * height + 1, k * width + 1) bool, True if the disc is clear at the node.
        middle: Same shape; True if it is clear half a unit right of and above the node. The last
            row and column have no such point and are False.
    """

    k: int
    clear: Bools
    middle: Bools

    @property
    def stride(self) -> int:
        """Nodes per row."""
        return int(self.clear.shape[1])

    @functools.cached_property
    def _rasters(self) -> tuple[Any, Any]:
        """Both rasters in the form that C reads."""
        return pointer(ffi, self.clear, np.bool_), pointer(ffi, self.middle, np.bool_)


def build_graph(solid: Bools, radius: Fraction, k: int) -> Graph:
    """Return the graph of a grid for a disc of ``radius`` cells."""
    height, width = solid.shape
    shape = (k * height + 1, k * width + 1)
    # Nothing is clear.
    if 2 * radius > min(height, width):
        return Graph(k, np.zeros(shape, np.bool_), np.zeros(shape, np.bool_))
    clear = np.empty(shape, np.bool_)
    middle = np.empty(shape, np.bool_)
    cells = pointer(ffi, np.ascontiguousarray(solid), np.bool_)
    made = writable(ffi, clear, np.bool_), writable(ffi, middle, np.bool_)
    check(lib.wg_disc_rasters(cells, height, width, k, clear_from(radius, 2 * k), *made))
    return Graph(k, clear, middle)


@functools.lru_cache(maxsize=256)
def clear_from(radius: Fraction, m: int) -> int:
    """Return the smallest squared distance, in 1/m cell, at which a disc is clear.

    The distance from a multiple of 1/m cell to a cell is the root of such an integer, so the
    comparison is exact.
    """
    return math.ceil((m * radius) ** 2)


def touching_cells(a: int, b: int, m: int, radius: Fraction) -> list[tuple[int, int]]:
    """Return the cells (dx, dy) that are closer to the point (a/m, b/m) than the radius.

    All lengths are in cells.
    """
    limit = math.ceil((m * radius) ** 2)
    reach = math.isqrt(limit - 1) // m + 2
    return [
        (dx, dy)
        for dy in range(-reach, reach + 1)
        for dx in range(-reach, reach + 1)
        if max(m * dx - a, 0, a - m * dx - m) ** 2 + max(m * dy - b, 0, b - m * dy - m) ** 2 < limit
    ]


def nodes_within(disc: Disc, graph: Graph) -> Ints:
    """Return the flat indices of the clear nodes in the target's disc."""
    rows, columns = graph.clear.shape
    scale = math.lcm(disc.x.denominator, disc.y.denominator, disc.radius.denominator)
    x, y, radius = (value.numerator * (scale // value.denominator) for value in disc)
    unit = UNIT // graph.k * scale
    found = []
    for j in range(max(0, -((radius - y) // unit)), min(rows - 1, (y + radius) // unit) + 1):
        # Half the chord at this height, rounded down.
        half = math.isqrt(radius**2 - (j * unit - y) ** 2)
        first = max(0, -((half - x) // unit))
        last = min(columns - 1, (x + half) // unit)
        found.append(np.nonzero(graph.clear[j, first : last + 1])[0] + (j * graph.stride + first))
    return np.concatenate(found) if found else np.zeros(0, np.int64)


def find_path(
    graph: Graph,
    sources: Sequence[int],
    ends: Sequence[int],
    spare: Ints,
    toward: tuple[int, int],
    bridges: Sequence[tuple[int, int]] = (),
) -> list[int]:
    """Return a path over the graph from a source to an end, or failing that to a spare end.

    Without bridges it is a shortest one.

    Args:
        graph: The graph.
        sources: Flat indices of clear nodes.
        ends: Nodes at which the search stops.
        spare: Nodes to accept if no end is connected to a source.
        toward: Node (x, y) that guides the search.
        bridges: Pairs of nodes that are also connected; used only if there is no other path.

    Returns:
        Flat indices from source to end, without those in the middle of a straight line; empty if
        none is connected.
    """
    begun = np.array(sources, np.int64)
    aims = np.array(ends, np.int64)
    with _search(
        graph, begun, aims, spare, toward, np.array(bridges, np.int64).reshape(-1, 2)
    ) as search:
        # Before searching all of a large world, check whether there is anything to find.
        found = _advance(search, max(1, graph.clear.size // _LOOK))
        if found == lib.WG_GOING and not bridges:
            seen = flood(graph, begun, aims)
            if not seen[aims].any():
                if not seen[spare].any():
                    return []
                lib.wg_search_be_content(search)
        while found == lib.WG_GOING:
            found = _advance(search, _PORTION)
        if found != lib.WG_FOUND:
            return []
        path = np.empty(lib.wg_search_path_length(search), np.int64)
        lib.wg_search_path(search, writable(ffi, path, np.int64))
    nodes: list[int] = path.tolist()
    return nodes


@contextmanager
def _search(
    graph: Graph, sources: Ints, ends: Ints, spare: Ints, toward: tuple[int, int], bridges: Ints
) -> Iterator[Any]:
    """Begin a search, and free it at the end."""
    clear, middle = graph._rasters
    described = ffi.new("WgGraph *", (clear, middle, graph.clear.size, graph.stride))
    lists = [
        item
        for nodes in (sources, ends, np.ascontiguousarray(spare))
        for item in (pointer(ffi, nodes, np.int64), len(nodes))
    ]
    made = ffi.new("WgSearch **")
    check(
        lib.wg_search_new(
            described, *lists, *toward, pointer(ffi, bridges, np.int64), len(bridges), made
        )
    )
    try:
        yield made[0]
    finally:
        lib.wg_search_free(made[0])


def _advance(search: Any, most: int) -> int:
    progress = ffi.new("WgProgress *")
    check(lib.wg_search_advance(search, most, progress))
    return int(progress[0])


def flood(graph: Graph, sources: Ints, stops: Ints | None = None) -> Bools:
    """Return which nodes, flat, can be reached by the eight steps from any of some clear ones.

    Args:
        graph: The graph.
        sources: Nodes to begin at.
        stops: A few nodes; reaching one of them is enough.
    """
    few = np.zeros(0, np.int64) if stops is None or len(stops) > _MOST_STOPS else stops
    seen = np.zeros(graph.clear.size, np.bool_)
    begun = (pointer(ffi, sources, np.int64), len(sources))
    enough = (pointer(ffi, few, np.int64), len(few))
    made = writable(ffi, seen, np.bool_)
    check(lib.wg_flood(*graph._rasters, graph.clear.size, graph.stride, *begun, *enough, made))
    return seen


def neighbour_shifts(stride: int) -> tuple[list[int], list[int]]:
    """Return the offsets of the eight steps in flat indices, the four along the axes first.

    Also return the offsets of their middles.
    """
    shifts = [1, -1, stride, -stride, stride + 1, -stride - 1, stride - 1, 1 - stride]
    return shifts, [0, 0, 0, 0, 0, -stride - 1, -1, -stride]
