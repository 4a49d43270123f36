"""What planners on the grid say.

With a point for a robot, and with walls inflated by the robot's radius.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from worldgen.interop.census.case import Ends
from worldgen.lattice import in_cells
from worldgen.support.grid_search import squared_distances

__all__ = ["GridAnswers", "GridPlanners"]

Labels = npt.NDArray[np.int32]
_EIGHT = np.ones((3, 3), np.bool_)


class GridAnswers(NamedTuple):
    """Whether each planner finds a way.

    Args:
        four: A point that moves between cells that share a side.
        eight: A point that also moves between cells that share a corner, past whatever is beside
            it.
        costmap: Eight moves, over cells whose centre is farther than the radius from every solid
            cell's centre.
        square: Four moves, over cells with no solid one within the radius, rounded up to cells,
            along both axes.
    """

    four: bool
    eight: bool
    costmap: bool
    square: bool


class GridPlanners:
    """The four planners on one map.

    What lies outside is solid for each of them, as it is for the disc.

    Args:
        walls: (height, width) bool, row 0 the lowest y.
        cell_size: m.
    """

    def __init__(self, walls: npt.NDArray[np.bool_], cell_size: float) -> None:
        self._cell_size = cell_size
        self._free = np.pad(~walls, 1)
        self._four = _regions(self._free)
        self._eight = _regions(self._free, _EIGHT)
        self._straight: Any = None
        self._square: Any = None
        self._inflated: dict[Fraction, tuple[Labels, Labels]] = {}

    def answers(self, ends: Ends, radius: Fraction) -> GridAnswers:
        """What each planner says.

        Args:
            ends: Start and target; the planners go from cell to cell.
            radius: Of the robot, cells.
        """
        start = self._cell(ends.start.x, ends.start.y)
        target = self._cell(ends.target.x, ends.target.y)
        costmap, square = self._inflate(radius)
        return GridAnswers(
            *(
                _joined(labels, start, target)
                for labels in (self._four, self._eight, costmap, square)
            )
        )

    def _cell(self, x: float, y: float) -> tuple[int, int]:
        """Row and column, with the ring round the map, of the cell that holds a point, m."""
        column, row = (math.floor(in_cells(value, self._cell_size)) for value in (x, y))
        height, width = self._free.shape
        return min(row + 1, height - 2), min(column + 1, width - 2)

    def _inflate(self, radius: Fraction) -> tuple[Labels, Labels]:
        if radius not in self._inflated:
            if self._straight is None:
                self._straight = squared_distances(~self._free)
                self._square = ndimage.distance_transform_cdt(self._free, metric="chessboard")
            # Differences of centres are whole, so their squares are compared with a whole number.
            costmap = self._straight > math.floor(radius**2)
            square = self._square > math.ceil(radius)
            self._inflated[radius] = _regions(costmap, _EIGHT), _regions(square)
        return self._inflated[radius]


def _regions(free: npt.NDArray[np.bool_], structure: npt.NDArray[np.bool_] | None = None) -> Labels:
    """Cells numbered by the region that they are in; 0 where not free."""
    labels, _ = ndimage.label(free, structure=structure)
    return np.asarray(labels, np.int32)


def _joined(labels: Labels, start: tuple[int, int], target: tuple[int, int]) -> bool:
    return bool(labels[start] != 0 and labels[start] == labels[target])
