"""Distances from a few cells far apart.

From cell to goal it is no shorter than the difference of theirs.

Source: Goldberg and Harrelson, "Computing the shortest path: A* search meets graph theory", SODA
    2005.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse.csgraph import dijkstra

__all__ = ["landmark_distances", "rounding"]


def landmark_distances(
    free: npt.NDArray[np.uint8],
    steps: npt.NDArray[np.int64],
    region: npt.NDArray[np.bool_],
    count: int,
) -> npt.NDArray[np.float64]:
    """Lengths of shortest octile paths from some cells, each the farthest from those before it.

    Args:
        free: (n,) cells as of :class:`~worldgen.interop.benchmark.octile.OctileMap`.
        steps: (8,) what a move adds to a cell's number.
        region: (n,) the cells among which they are chosen.
        count: How many.

    Returns:
        (n, count) cells; 0 where no path leads.
    """
    moves = _moves(free, steps)
    nearest = np.where(region, _lengths(moves, region), -1.0)
    found = np.zeros((len(free), count))
    for number in range(count):
        lengths = _lengths(moves, nearest)
        nearest = np.where(region, np.minimum(nearest, lengths) if number else lengths, -1.0)
        found[:, number] = np.where(np.isfinite(lengths), lengths, 0.0)
    return found


def _lengths(moves: Any, rank: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
    """Lengths from the cell of highest rank, the first of several; infinity where no path leads."""
    found: npt.NDArray[np.float64] = dijkstra(moves, indices=np.array([np.argmax(rank)]))[0]
    return found


def _moves(free: npt.NDArray[np.uint8], steps: npt.NDArray[np.int64]) -> Any:
    """All moves between free cells, as a sparse matrix of their lengths."""
    cells = np.flatnonzero(free)
    begins = []
    ends = []
    lengths = []
    for direction, step in enumerate(steps.tolist()):
        sides = [steps[(direction + turn) % 8] for turn in ((-1, 0, 1) if direction % 2 else (0,))]
        able = cells[np.logical_and.reduce([free[cells + side] != 0 for side in sides])]
        begins.append(able)
        ends.append(able + step)
        lengths.append(np.full(len(able), math.sqrt(2.0) if direction % 2 else 1.0))
    places = np.concatenate(begins), np.concatenate(ends)
    return sparse.csr_matrix((np.concatenate(lengths), places), (len(free), len(free)))


def rounding(distances: npt.NDArray[np.float64]) -> float:
    """By how much the difference of two such distances may be wrong.

    Each is a sum of no more moves than it is long.
    """
    return 4.0 * float(np.max(distances, initial=0.0)) ** 2 * 2.0**-53
