"""Find decision points: places along the path from which three or more routes lead.

A *place* is a point, at a multiple of half a cell, with a locally largest free disc: none of its
eight neighbours has a larger one, and it is not in a larger disc of another place. Its *ring*
consists of the points from 1.5 to 2 radii of its disc away that the robot can reach from it without
leaving the ring's outer circle. The separate parts of the ring that reach that circle are the
*routes* that lead from it. Corners of a passage are nearer than 1.5 radii; the corners of a dead
end, which may extend into the ring, are nearer than 2. A *decision point* is a place with three or
more routes whose disc the witness enters, measured to half a cell; places in each other's discs
count as one.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np

from worldgen import _core
from worldgen.difficulty.nodes import Nodes
from worldgen.reach.still.grid_search import squared_distances
from worldgen.support.arrays import Bools, Ints
from worldgen.support.ccall import check, pointer, writable


def decision_points(nodes: Nodes, touched: Ints) -> list[tuple[int, int, int]]:
    """Return the decision points along a path, each once.

    A row has column, row and squared radius of its largest disc, in half cells.

    Args:
        nodes: The static world.
        touched: (n, 2) int64, (column, row) of the nodes next to the path.
    """
    near = np.zeros(nodes.graph.clear.shape, np.bool_)
    near[touched[:, 1], touched[:, 0]] = True
    # Find places whose discs the path may enter, and all places whose discs contain these.
    away = squared_distances(near, 4 * int(nodes.clearance_sq.max(initial=0)))
    places = np.flatnonzero(_largest_discs(nodes, away))
    sizes = nodes.clearance_sq.ravel()[places]
    chosen = np.flatnonzero(away.ravel()[places] <= sizes)
    chosen = chosen[_highest(nodes, places, sizes, chosen)]
    chosen = chosen[_openings(nodes, places[chosen], sizes[chosen]) >= 3]
    spots = _Spots(places[chosen], sizes[chosen], nodes.graph.stride)
    return sorted(max(group, key=lambda spot: spot[2]) for group in spots.groups())


def _largest_discs(nodes: Nodes, away: Ints) -> Bools:
    """Return True if the robot is clear at a near node and no neighbour has a larger free disc.

    Args:
        nodes: The static world.
        away: Squared distances; at most two radii of the disc count as near.
    """
    ffi = _core.ffi
    lib = _core.lib
    found = np.empty(nodes.graph.clear.shape, np.bool_)
    clear = pointer(ffi, np.ascontiguousarray(nodes.graph.clear), np.bool_)
    squared = pointer(ffi, nodes.clearance_sq, np.int32)
    near = pointer(ffi, away, np.int32)
    check(lib.wg_largest_discs(clear, squared, near, *found.shape, writable(ffi, found, np.bool_)))
    return found


def _highest(nodes: Nodes, places: Ints, sizes: Ints, chosen: Ints) -> Bools:
    """Return which places are not in a larger disc than their own.

    Args:
        nodes: The static world.
        places: (n,) flat indices, sorted.
        sizes: (n,) squared radii.
        chosen: (k,) numbers of the places to examine.
    """
    ffi = _core.ffi
    lib = _core.lib
    found = np.empty(len(chosen), np.bool_)
    at = [pointer(ffi, numbers.astype(np.int64), np.int64) for numbers in (places, sizes, chosen)]
    check(
        lib.wg_highest(
            at[0],
            at[1],
            len(places),
            nodes.graph.stride,
            at[2],
            len(chosen),
            writable(ffi, found, np.bool_),
        )
    )
    return found


def _openings(nodes: Nodes, places: Ints, sizes: Ints) -> Ints:
    """Return for each place how many routes lead from it; fewer than three may be 0."""
    ffi = _core.ffi
    lib = _core.lib
    graph = nodes.graph
    found = np.empty(len(places), np.int64)
    rasters = [
        pointer(ffi, np.ascontiguousarray(raster), np.bool_)
        for raster in (graph.clear, graph.middle)
    ]
    asked = [pointer(ffi, column.astype(np.int64), np.int64) for column in (places, sizes)]
    check(
        lib.wg_openings(
            *rasters,
            graph.clear.size,
            graph.stride,
            *asked,
            len(places),
            writable(ffi, found, np.int64),
        )
    )
    return found


class _Spots:
    """Places with their discs, indexed by position.

    Args:
        places: (n,) flat indices.
        sizes: (n,) squared radii, half cells.
        stride: Nodes per row.
    """

    def __init__(self, places: Ints, sizes: Ints, stride: int) -> None:
        self.spots = list(
            zip(
                (places % stride).tolist(), (places // stride).tolist(), sizes.tolist(), strict=True
            )
        )
        self._side = 1 + math.isqrt(int(sizes.max(initial=0)))
        self._boxes: dict[tuple[int, int], list[int]] = {}
        for k, (x, y, _) in enumerate(self.spots):
            self._boxes.setdefault((x // self._side, y // self._side), []).append(k)

    def _near(self, k: int) -> Iterator[tuple[int, int]]:
        """Yield pairs of places that may be in each other's discs, and their squared distances."""
        x, y, _ = self.spots[k]
        column = x // self._side
        row = y // self._side
        for dx, dy in itertools.product((-1, 0, 1), repeat=2):
            for other in self._boxes.get((column + dx, row + dy), ()):
                yield other, (self.spots[other][0] - x) ** 2 + (self.spots[other][1] - y) ** 2

    def groups(self) -> Iterator[list[tuple[int, int, int]]]:
        """Yield the places, grouped if they are in each other's discs."""
        left = set(range(len(self.spots)))
        while left:
            group = [left.pop()]
            for k in group:
                same = {
                    other
                    for other, apart in self._near(k)
                    if other in left and apart <= min(self.spots[k][2], self.spots[other][2])
                }
                left -= same
                group += sorted(same)
            yield sorted(self.spots[k] for k in group)
