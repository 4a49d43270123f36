"""Lengths of shortest octile paths.

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
from scipy.sparse.csgraph import connected_components, dijkstra

from worldgen.support.arrays import Bools, Floats, Ints

_ROOT_TWO = math.sqrt(2.0)
# Distances that one batch of searches may return: 32 MB of float64.
_BATCH_CELLS = 4_000_000
# A limit this much beyond the expected length never cuts off a path of that length.
_SLACK = 1.001

Cells = npt.NDArray[np.integer[Any]]


def octile_lengths(walls: Bools, starts: Cells, goals: Cells, expected: Floats) -> Floats:
    """Return the lengths of shortest octile paths, in cells.

    Good guesses make it fast: each search first goes no farther than the expected length, and
    searches the whole map only if that was too short.

    Args:
        walls: (height, width) bool, True is solid; everything outside is solid too.
        starts: (n, 2) column and row of cells; rows count as in ``walls``.
        goals: (n, 2) column and row of cells.
        expected: (n,) guessed lengths, in cells.

    Returns:
        (n,) lengths; infinity if there is no path, or an end is solid.
    """
    graph = _graph(walls)
    begin = _numbers(starts, walls)
    end = _numbers(goals, walls)
    found = np.full(len(starts), np.inf)

    # Solid cells are regions of their own, so a solid end needs a test only if it is both ends.
    _, region = connected_components(graph, directed=False)
    joined = (region[begin] == region[end]) & ~walls.ravel()[begin]

    # Neighbours in the order of expected lengths share a limit that fits all of them.
    waiting = np.flatnonzero(joined)
    waiting = waiting[np.argsort(expected[waiting], kind="stable")]
    limits = expected * _SLACK + 1.0
    found[waiting] = _searched(graph, begin[waiting], end[waiting], limits[waiting])

    # These paths are longer than expected.
    longer = np.flatnonzero(joined & np.isinf(found))
    found[longer] = _searched(graph, begin[longer], end[longer], np.full(len(longer), np.inf))
    return found


def _searched(graph: Any, begin: Cells, end: Cells, limits: Floats) -> Any:
    """Return the lengths of shortest paths; infinity if one is longer than the batch's limit."""
    batch = max(_BATCH_CELLS // graph.shape[0], 1)
    found = np.empty(len(begin))
    for at in range(0, len(begin), batch):
        part = slice(at, at + batch)
        lengths = dijkstra(
            graph, directed=False, indices=begin[part], limit=float(limits[part].max())
        )
        found[part] = lengths[np.arange(len(lengths)), end[part]]
    return found


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
