"""Planners that inflate walls by the robot's radius and then search the grid.

The table of docs/notes/census.md compares them with the proved answer.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from benchmarks.foreign_maps import cell_at
from worldgen.lattice import radius_in_cells
from worldgen.reach.still.grid_search import squared_distances
from worldgen.world import World

Labels = npt.NDArray[np.int32]


class InflatedAnswers(NamedTuple):
    """Whether each planner finds a path.

    Args:
        costmap: Eight moves, over cells whose centre is farther than the radius from every solid
            cell's centre.
        square: Four moves, over cells with no solid one within the radius, rounded up to cells,
            along both axes.
    """

    costmap: bool
    square: bool


class InflationPlanners:
    """The two planners on one map.

    Args:
        walls: (height, width) bool, row 0 the lowest y; what is outside is solid.
    """

    def __init__(self, walls: npt.NDArray[np.bool_]) -> None:
        self._walls = walls
        free = np.pad(~walls, 1)
        self._straight: Any = squared_distances(~free)
        self._square: Any = ndimage.distance_transform_cdt(free, metric="chessboard")
        self._inflated: dict[Fraction, tuple[Labels, Labels]] = {}

    def answers(self, world: World) -> InflatedAnswers:
        """Return each planner's answer for a world with these walls."""
        ends = [
            cell_at(self._walls, world.cell_size, place.x, place.y)
            for place in (world.start, world.target)
        ]
        labels = self._inflate(radius_in_cells(world))
        costmap, square = (
            bool(regions[ends[0]] != 0 and regions[ends[0]] == regions[ends[1]])
            for regions in labels
        )
        return InflatedAnswers(costmap, square)

    def _inflate(self, radius: Fraction) -> tuple[Labels, Labels]:
        """Return the regions of both planners for a radius in cells."""
        if radius not in self._inflated:
            # Differences of centres are whole, so their squares are compared with a whole number.
            costmap = self._straight > math.floor(radius**2)
            square = self._square > math.ceil(radius)
            eight, _ = ndimage.label(costmap[1:-1, 1:-1], structure=np.ones((3, 3)))
            four, _ = ndimage.label(square[1:-1, 1:-1])
            self._inflated[radius] = (eight, four)
        return self._inflated[radius]
