"""The moves of a shortest octile path.

Such a path leads from centre to centre of free cells, straight or diagonally, and does not cut
corners: a diagonal move needs both cells next to it free. SciPy's Dijkstra searches; this module
only draws the graph.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.sparse.csgraph import dijkstra

from worldgen.support.arrays import Bools, Ints

_ROOT_TWO = math.sqrt(2.0)

Cells = npt.NDArray[np.integer[Any]]


def octile_moves(
    walls: Bools, start: tuple[int, int], goal: tuple[int, int]
) -> tuple[int, int] | None:
    """Return the straight and diagonal moves of a shortest octile path; None if there is none.

    As ``straight + diagonal * sqrt(2)`` they give the length without rounding.

    Args:
        walls: (height, width) bool, True is solid; everything outside is solid too.
        start: Column and row of a cell.
        goal: Column and row of a cell.
    """
    # Solid ends have no path.
    begin, end = _numbers(np.array([start, goal]), walls).tolist()
    if walls.flat[begin] or walls.flat[end]:
        return None
    lengths, before = dijkstra(
        _graph(walls), directed=False, indices=begin, return_predecessors=True
    )
    if np.isinf(lengths[end]):
        return None
    # Count the moves from the goal back to the start.
    width = walls.shape[1]
    counts = [0, 0]
    cell = end
    while cell != begin:
        previous = int(before[cell])
        # A diagonal move changes both row and column.
        rows, columns = zip(divmod(cell, width), divmod(previous, width), strict=True)
        counts[rows[0] != rows[1] and columns[0] != columns[1]] += 1
        cell = previous
    return counts[0], counts[1]


def _numbers(cells: Cells, walls: Bools) -> Ints:
    """Return the numbers of cells, given as columns and rows, in the flat map."""
    numbers: Ints = cells[:, 1].astype(np.int64) * walls.shape[1] + cells[:, 0]
    return numbers


def _graph(walls: Bools) -> Any:
    """Return all moves between free cells as a sparse matrix, each in one direction."""
    free = ~walls
    numbers = np.arange(walls.size, dtype=np.int32).reshape(walls.shape)
    across = free[:, :-1] & free[:, 1:]
    down = free[:-1] & free[1:]
    # Both diagonals of a free square of two by two cells are allowed moves.
    square = across[:-1] & across[1:]
    moves = (
        (across, numbers[:, :-1], numbers[:, 1:], 1.0),
        (down, numbers[:-1], numbers[1:], 1.0),
        (square, numbers[:-1, :-1], numbers[1:, 1:], _ROOT_TWO),
        (square, numbers[:-1, 1:], numbers[1:, :-1], _ROOT_TWO),
    )
    begins = np.concatenate([one[able] for able, one, _, _ in moves])
    ends = np.concatenate([other[able] for able, _, other, _ in moves])
    lengths = np.concatenate([np.full(np.count_nonzero(able), step) for able, _, _, step in moves])
    return sparse.csr_matrix((lengths, (begins, ends)), (walls.size, walls.size))
