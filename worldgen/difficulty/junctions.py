"""Decision points: places along the way from which three or more ways lead.

A *place* is a point, at a multiple of half a cell, with a locally largest free disc: none of its eight neighbours has a
larger one, and it lies in no larger disc of another place. Its *ring* are the points from 1.5 to 2 radii of its disc
away that the robot can reach from it without leaving the ring's outer circle; the separate parts of the ring that reach
to that circle are the *ways* that lead from it. Corners of a passage are nearer than 1.5 radii; those of a blind end,
which may stick into the ring, are nearer than 2. A *decision point* is a place with three or more ways whose disc the
witness enters, to half a cell; places that lie in each other's discs are one.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from worldgen.difficulty.nodes import Bools, Nodes, squared_distances
from worldgen.difficulty.way import Ints
from worldgen.jit import lazy_kernel
from worldgen.reach.lattice_graph import neighbour_shifts

__all__ = ["decision_points"]


def decision_points(nodes: Nodes, touched: Ints) -> list[tuple[int, int, int]]:
    """The decision points along a way, each once: column, row and squared radius of its largest disc, in half cells.

    Args:
        nodes: The world at rest.
        touched: (n, 2) int64, (column, row) of the nodes next to the way.
    """
    near = np.zeros(nodes.graph.clear.shape, np.bool_)
    near[touched[:, 1], touched[:, 0]] = True
    away = squared_distances(near)
    places = np.flatnonzero(_largest_discs(nodes) & (away <= 4 * nodes.clearance_sq))  # and all whose discs hold these
    sizes = nodes.clearance_sq.ravel()[places]
    spots = _Spots(places, sizes, nodes.graph.stride)
    chosen = np.flatnonzero(away.ravel()[places] <= sizes)
    if nodes.is_small:  # the dearer test on what the cheaper one leaves
        chosen = chosen[spots.highest(chosen)]
        chosen = chosen[_openings(nodes, places[chosen], sizes[chosen]) >= 3]
    else:
        chosen = chosen[_openings(nodes, places[chosen], sizes[chosen]) >= 3]
        chosen = chosen[spots.highest(chosen)]
    return sorted(max(group, key=lambda spot: spot[2]) for group in spots.groups(chosen.tolist()))


def _largest_discs(nodes: Nodes) -> Any:
    """Whether the robot is clear at a node, and none of its eight neighbours has a larger free disc."""
    padded = np.pad(nodes.clearance_sq, 1)
    rows = np.maximum(np.maximum(padded[:-2], padded[1:-1]), padded[2:])
    highest = np.maximum(np.maximum(rows[:, :-2], rows[:, 1:-1]), rows[:, 2:])
    return nodes.graph.clear & (nodes.clearance_sq == highest)


def _openings(nodes: Nodes, places: Ints, sizes: Ints) -> Ints:
    """For each place, how many ways lead from it; fewer than three may be 0."""
    graph = nodes.graph
    shifts, corners = neighbour_shifts(graph.stride)
    rasters = (graph.clear.ravel().view(np.uint8), graph.middle.ravel().view(np.uint8))
    kinds, kind = np.unique(sizes, return_inverse=True)
    rings = [_ring(int(size)) for size in kinds]
    begins = np.cumsum([0, *(len(ring) for ring in rings)])
    ring = np.concatenate([*rings, np.zeros((0, 2), np.int64)])
    columns = (places, sizes, kind, begins, ring[:, 0], ring[:, 1])
    found, size = np.zeros(len(places), np.int64), graph.clear.size
    if nodes.is_small:
        plain: Any = [raster.tobytes() for raster in rasters]
        counts: Any = found.tolist()
        lists: Any = [column.tolist() for column in columns]
        inputs: Any = (*plain, graph.stride, shifts, corners, *lists, [0] * size, [0] * (2 * size), counts)
        _count_openings(*inputs)
        return np.array(counts, np.int64)
    work = (np.zeros(size, np.int32), np.zeros(2 * size, np.int32))
    _count_openings_compiled(*rasters, graph.stride, np.array(shifts), np.array(corners), *columns, *work, found)
    return found


def _ring(size: int) -> Ints:
    """(n, 2) offsets of the nodes from 1.5 to a little over 2 radii of a disc of squared radius ``size``."""
    outer = math.isqrt(4 * size) + 2
    dx, dy = np.mgrid[-outer : outer + 1, -outer : outer + 1].reshape(2, -1)
    squared = dx * dx + dy * dy
    kept = (4 * squared >= 9 * size) & (squared <= outer * outer)
    return np.stack((dx[kept], dy[kept]), axis=1)


def _count_openings(  # noqa: PLR0912 - one kernel: a call from kernel to kernel would compile both for small worlds too
    clear: Any, middle: Any, stride: Any, shifts: Any, corners: Any, places: Any, sizes: Any, kind: Any, begins: Any,
    ring_x: Any, ring_y: Any, mark: Any, queue: Any, found: Any,
) -> None:  # fmt: skip
    """Counts the parts of each place's ring; the same text runs plain and compiled.

    First all parts of the ring, which takes little and decides most places; where there are three or more, those
    that a flood from the place comes to. ``mark`` numbers floods: a multiple of 4 and 1 for the disc, 2 for the ring,
    3 for its parts.
    """
    for k in range(len(places)):
        x, y = places[k] % stride, places[k] // stride
        first, last, stamp = begins[kind[k]], begins[kind[k] + 1], 4 * (k + 1)
        outer = ring_x[last - 1] * ring_x[last - 1] + ring_y[last - 1] * ring_y[last - 1]
        for only_reached in range(2):
            tail = 0
            if only_reached:
                mark[places[k]] = stamp + 1
                queue[0] = places[k]
                head, tail = 0, 1
                while head < tail:
                    node = queue[head]
                    head += 1
                    for direction in range(8):
                        other = node + shifts[direction]
                        if clear[other] == 0 or mark[other] == stamp + 1:
                            continue
                        if direction > 3 and middle[node + corners[direction]] == 0:
                            continue
                        dx, dy = other % stride - x, other // stride - y
                        if dx * dx + dy * dy <= outer:
                            mark[other] = stamp + 1
                            queue[tail] = other
                            tail += 1
            for r in range(first, last):
                i, j = x + ring_x[r], y + ring_y[r]
                node = j * stride + i
                if (
                    0 <= i < stride
                    and j >= 0
                    and node < len(mark)
                    and clear[node]
                    and (only_reached == 0 or mark[node] == stamp + 1)
                ):
                    mark[node] = stamp + 2
            parts = 0
            for r in range(first, last):
                i, j = x + ring_x[r], y + ring_y[r]
                node = j * stride + i
                if i < 0 or i >= stride or j < 0 or node >= len(mark) or mark[node] != stamp + 2:
                    continue
                mark[node] = stamp + 3
                queue[0] = node
                head, tail, leads_on = 0, 1, 0
                while head < tail:
                    node = queue[head]
                    head += 1
                    dx, dy = node % stride - x, node // stride - y
                    if dx * dx + dy * dy >= 4 * sizes[k]:
                        leads_on = 1
                    for direction in range(8):
                        other = node + shifts[direction]
                        if mark[other] != stamp + 2 or (direction > 3 and middle[node + corners[direction]] == 0):
                            continue
                        mark[other] = stamp + 3
                        queue[tail] = other
                        tail += 1
                parts += leads_on
            found[k] = parts
            if parts < 3:
                break


_count_openings_compiled = lazy_kernel(_count_openings)


class _Spots:
    """Places with their discs, found by where they are.

    Args:
        places: (n,) flat indices.
        sizes: (n,) squared radii, half cells.
        stride: Nodes a row.
    """

    def __init__(self, places: Ints, sizes: Ints, stride: int) -> None:
        self.spots = list(zip((places % stride).tolist(), (places // stride).tolist(), sizes.tolist(), strict=True))
        self._side = 1 + math.isqrt(int(sizes.max(initial=0)))
        self._boxes: dict[tuple[int, int], list[int]] = {}
        for k, (x, y, _) in enumerate(self.spots):
            self._boxes.setdefault((x // self._side, y // self._side), []).append(k)

    def _near(self, k: int) -> Iterator[tuple[int, int]]:
        """Numbers of the places that may be in each other's discs, and their squared distances."""
        x, y, _ = self.spots[k]
        column, row = x // self._side, y // self._side
        for dx, dy in itertools.product((-1, 0, 1), repeat=2):
            for other in self._boxes.get((column + dx, row + dy), ()):
                yield other, (self.spots[other][0] - x) ** 2 + (self.spots[other][1] - y) ** 2

    def highest(self, chosen: Ints) -> Bools:
        """Whether places lie in no larger disc than their own."""
        size = [spot[2] for spot in self.spots]
        found = [not any(size[k] < size[other] >= apart for other, apart in self._near(k)) for k in chosen.tolist()]
        return np.array(found, np.bool_)

    def groups(self, chosen: list[int]) -> Iterator[list[tuple[int, int, int]]]:
        """Some of the places, those that lie in each other's discs together."""
        left = set(chosen)
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
