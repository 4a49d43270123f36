"""Points at multiples of half a cell, with clearances.

For each point the distance to the nearest wall is exact, and it is known whether the robot is clear
there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from worldgen.lattice import UNIT, radius_in_cells
from worldgen.reach.still.grid_search import squared_distances
from worldgen.reach.still.lattice_graph import Graph, build_graph
from worldgen.reach.still.walls import ExactPoint, Walls
from worldgen.support.arrays import Bools, Ints
from worldgen.world import World

# Half a cell, in 1/1024 cell.
HALF = UNIT // 2


@dataclass(frozen=True, eq=False)
class Nodes:
    """A static world seen from the points at multiples of half a cell.

    Args:
        graph: Where the robot's disc is clear, and the steps it can make.
        walls: The solid cells, for exact queries.
        clearance_sq: (2 * height + 1, 2 * width + 1) whole numbers, squared distance to the nearest
            wall, half cells.
    """

    graph: Graph
    walls: Walls
    clearance_sq: Ints

    def beside(self, point: ExactPoint) -> list[int]:
        """Return flat indices of nearby clear nodes to which the robot can drive straight.

        The point is in 1/1024 cell.
        """
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
    """Return the nodes of a world with these cells solid."""
    radius = radius_in_cells(world)
    return Nodes(
        build_graph(solid, radius, 2), Walls(solid, radius), squared_distances(_in_walls(solid))
    )


def _in_walls(solid: Bools) -> Bools:
    """Return a mask of the half-cell nodes in a closed solid cell, or on the rim of the grid."""
    quarters = np.pad(solid.repeat(2, axis=0).repeat(2, axis=1), 1, constant_values=True)
    rows = quarters[:-1] | quarters[1:]
    found: Bools = rows[:, :-1] | rows[:, 1:]
    return found
