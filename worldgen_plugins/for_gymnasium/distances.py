"""Compute the shortest path to the target from everywhere, as a measure of progress."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from worldgen.errors import InvalidParameter
from worldgen.lattice import radius_in_cells
from worldgen.reach.still.lattice_graph import build_graph
from worldgen.world import World

__all__ = ["distances_to_target"]

# Half cells. Nodes at most this far from the target's centre are joined to it, unless its radius is
# larger; this reaches at least one node.
_NEAR = 1.5


def distances_to_target(world: World) -> npt.NDArray[np.float32]:
    """Return the length of the disc's shortest path over multiples of half a cell, m.

    The length is inf where no path exists.

    Args:
        world: A world that does not change.

    Returns:
        ((2 height + 1) * (2 width + 1),) float32, row by row.

    Raises:
        InvalidParameter: If the world changes.

    Source: Dijkstra, "A note on two problems in connexion with graphs", 1959; SciPy's.
    """
    if world.is_dynamic:
        raise InvalidParameter(
            "world-changes",
            "distance='way' needs worlds that do not change",
            "use distance='straight' for this one",
        )

    # Edges join a node to its eight neighbours; slanted ones also need the middle to be clear.
    graph = build_graph(world.walls, radius_in_cells(world), 2)
    clear = graph.clear
    middle = graph.middle[:-1, :-1]
    numbers = np.arange(clear.size).reshape(clear.shape)
    slanted = math.sqrt(2.0)
    steps = [
        (numbers[:, :-1], numbers[:, 1:], clear[:, :-1] & clear[:, 1:], 1.0),
        (numbers[:-1], numbers[1:], clear[:-1] & clear[1:], 1.0),
        (numbers[:-1, :-1], numbers[1:, 1:], clear[:-1, :-1] & clear[1:, 1:] & middle, slanted),
        (numbers[:-1, 1:], numbers[1:, :-1], clear[:-1, 1:] & clear[1:, :-1] & middle, slanted),
    ]

    # One more node stands for the target, joined to all nodes near it.
    side = 0.5 * world.cell_size
    rows, columns = np.indices(clear.shape)
    away = np.hypot(columns - world.target.x / side, rows - world.target.y / side)
    home = np.flatnonzero(clear & (away <= max(world.target.radius / side, _NEAR)))
    begins = [*(one[there] for one, _, there, _ in steps), np.full(len(home), clear.size)]
    ends = [*(other[there] for _, other, there, _ in steps), home]
    costs = [
        *(np.full(np.count_nonzero(there), cost) for *_, there, cost in steps),
        np.maximum(away.flat[home], 1e-9),
    ]

    # A distance of 0 would mean the lack of an edge, hence the least cost above.
    places = (np.concatenate(begins), np.concatenate(ends))
    matrix = coo_array(
        (np.concatenate(costs), places), shape=(clear.size + 1, clear.size + 1)
    ).tocsr()
    lengths = dijkstra(matrix, directed=False, indices=[clear.size])[0][:-1]
    return np.asarray(lengths * side, np.float32)
