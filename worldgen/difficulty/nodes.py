"""Points at multiples of half a cell: how far each is from the nearest wall, exactly, and where the robot is clear."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from worldgen.difficulty.way import Ints
from worldgen.jit import lazy_kernel
from worldgen.lattice import UNIT, radius_in_cells
from worldgen.reach.lattice_graph import Graph, build_graph
from worldgen.reach.walls import ExactPoint, Walls
from worldgen.world import World

__all__ = ["HALF", "SMALL", "Nodes", "nodes_of", "squared_distances"]

HALF = UNIT // 2  # half a cell in 1/1024 cell
SMALL = 60_000  # nodes that plain Python looks at in less time than loading numba takes
_BRUTE = 200_000  # nodes for which NumPy tries row after row

Bools = npt.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Nodes:
    """A still world seen from the points at multiples of half a cell.

    Args:
        graph: Where the robot's disc is clear, and the steps that it can make.
        walls: The solid cells, for exact questions.
        clearance_sq: (2 * height + 1, 2 * width + 1) whole numbers, squared distance to the nearest wall, half cells.
    """

    graph: Graph
    walls: Walls
    clearance_sq: Ints

    @property
    def is_small(self) -> bool:
        """Whether plain Python is quick enough."""
        return self.graph.clear.size <= SMALL

    def beside(self, point: ExactPoint) -> list[int]:
        """Flat indices of the clear nodes near a point (1/1024 cell) to which the robot may go straight from it."""
        found = []
        rows, columns = self.graph.clear.shape
        for j in _near(point[1], rows):
            for i in _near(point[0], columns):
                if self.graph.clear[j, i] and self.walls.is_clear(point, (i * HALF, j * HALF)):
                    found.append(j * columns + i)
        return found


def _near(value: Any, count: int) -> range:
    first = int(value // HALF)
    reach = range(first, first + 1) if value % HALF == 0 else range(first - 1, first + 3)
    return range(max(reach.start, 0), min(reach.stop, count))


def nodes_of(world: World, solid: Bools) -> Nodes:
    """The nodes of a world with these cells solid."""
    radius = radius_in_cells(world)
    return Nodes(build_graph(solid, radius, 2), Walls(solid, radius), squared_distances(_in_walls(solid)))


def _in_walls(solid: Bools) -> Bools:
    """Whether a node lies in a closed solid cell, or on the rim of the grid."""
    quarters = np.pad(solid.repeat(2, axis=0).repeat(2, axis=1), 1, constant_values=True)
    rows = quarters[:-1] | quarters[1:]
    found: Bools = rows[:, :-1] | rows[:, 1:]
    return found


def squared_distances(marked: Bools) -> Ints:
    """Squared distance from each node to the nearest marked one; exact.

    The nearest point of a cell to a node is a node, so marking the nodes in cells gives distances to cells.

    Source: Meijster, Roerdink, Hesselink, "A General Algorithm for Computing Distance Transforms in Linear Time",
    2000, for all but small grids.
    """
    height, width = marked.shape
    far = height + width
    columns = np.arange(width, dtype=np.int32)
    left = np.maximum.accumulate(np.where(marked, columns, np.int32(-far)), axis=1)
    right = np.minimum.accumulate(np.where(marked, columns, np.int32(width + far))[:, ::-1], axis=1)[:, ::-1]
    beside = np.minimum(np.minimum(columns - left, right - columns), np.int32(far))
    if marked.size > _BRUTE:
        found = np.zeros((width, height), np.int32)
        _columns_compiled(np.ascontiguousarray(beside.T), found)
        return np.ascontiguousarray(found.T)
    level = beside * beside
    best, step = level.copy(), 1
    while step < height and step * step < best.max():
        np.minimum(best[step:], level[:-step] + step * step, out=best[step:])
        np.minimum(best[:-step], level[step:] + step * step, out=best[:-step])
        step += 1
    return best


def _columns(beside: Any, found: Any) -> None:
    """Squared distances from the distances along rows; each row here is a column of the grid."""
    count = beside.shape[1]
    place, begin = np.zeros(count, np.int64), np.zeros(count, np.int64)
    for line in range(beside.shape[0]):
        g = beside[line]
        top = 0
        place[0] = 0
        begin[0] = 0
        for u in range(1, count):
            gu = g[u] * g[u]
            while top >= 0:
                s, t = place[top], begin[top]
                if (t - s) * (t - s) + g[s] * g[s] <= (t - u) * (t - u) + gu:
                    break
                top -= 1
            if top < 0:
                top = 0
                place[0] = u
                continue
            s = place[top]
            w = 1 + (u * u - s * s + gu - g[s] * g[s]) // (2 * (u - s))
            if w < count:
                top += 1
                place[top] = u
                begin[top] = w
        for back in range(count):
            u = count - 1 - back
            s = place[top]
            found[line, u] = (u - s) * (u - s) + g[s] * g[s]
            if u == begin[top]:
                top -= 1


_columns_compiled = lazy_kernel(_columns)
