"""Find the cells whose centres the disc can reach, as a coverage task requires."""

from __future__ import annotations

from collections import deque

import numpy as np

from worldgen.errors import InvalidWorld
from worldgen.lattice import UNIT, in_cells, lattice_to_metres, metres_to_lattice
from worldgen.reach.still.lattice_graph import build_graph, flood, neighbour_shifts
from worldgen.reach.still.walls import Walls
from worldgen.support.arrays import Bools
from worldgen.world import World

# Nodes per cell side: centres and corners of cells, and the middles of their edges.
_NODES = 2

# Number of a node's eight steps that are along the axes.
_AXIS_STEPS = 4

# The number of the start, which is not a node.
_START = -1


def reachable_cells(world: World) -> Bools:
    """Return which cells' centres the disc can reach from the start, along half cells.

    Every cell that counts can really be reached: the disc is clear at each node of the path and on
    the straight lines between them. A path that squeezes between nodes may be missed.

    Args:
        world: A world that does not change.

    Returns:
        (height, width) bool, row 0 the lowest y.

    Raises:
        InvalidWorld: If the world changes.
    """
    if world.is_dynamic:
        raise InvalidWorld(
            "world-changes",
            "the world changes, so the cells that can be reached change too",
            "use a world that does not change",
        )
    return _Ground(world).reached()


def coverage_tour(world: World) -> list[tuple[float, float]]:
    """Return a tour that visits every cell of :func:`reachable_cells`: a proof that it can be done.

    The disc is clear along all of it. It is a depth-first walk of a spanning tree, so it is at most
    twice as long as the tree.

    Args:
        world: A world that does not change.

    Returns:
        Corners of the tour, m, beginning at the start.

    Raises:
        InvalidWorld: If the world changes.
    """
    wanted = reachable_cells(world)
    found = _Ground(world)
    parent = found.tree()
    stride = found.graph.stride

    # Keep the branches that lead to a requested centre.
    rows, columns = np.nonzero(wanted)
    children: dict[int, list[int]] = {}
    kept = {_START}
    for centre in ((_NODES * rows + 1) * stride + _NODES * columns + 1).tolist():
        node = centre
        while node not in kept:
            kept.add(node)
            children.setdefault(parent[node], []).append(node)
            node = parent[node]

    # Walk them depth first; the walk ends at the last centre.
    start = (world.start.x, world.start.y)
    return [
        start if node == _START else found.place(node, world.cell_size) for node in _walk(children)
    ]


def _walk(children: dict[int, list[int]]) -> list[int]:
    """Return the nodes of a walk around a tree from the start, until the last new one."""
    walk = [_START]
    path = [_START]
    last = 0
    while path:
        below = children.get(path[-1], [])
        if below:
            path.append(below.pop())
            last = len(walk)
            walk.append(path[-1])
        else:
            path.pop()
            if path:
                walk.append(path[-1])
    return walk[: last + 1]


class _Ground:
    """The graph over half cells of a world, and the nodes to which its start has a clear line."""

    def __init__(self, world: World) -> None:
        start = (
            metres_to_lattice(world.start.x, world.cell_size),
            metres_to_lattice(world.start.y, world.cell_size),
        )
        radius = in_cells(world.robot_radius, world.cell_size)
        self.graph = build_graph(world.walls, radius, _NODES)
        walls = Walls(world.walls, radius)
        self._side = UNIT // _NODES
        rows, columns = self.graph.clear.shape
        self.sources = []
        for row in range(start[1] // self._side - 1, start[1] // self._side + 3):
            for column in range(start[0] // self._side - 1, start[0] // self._side + 3):
                inside = 0 <= row < rows and 0 <= column < columns
                if not inside or not self.graph.clear[row, column]:
                    continue
                if walls.is_clear(start, (column * self._side, row * self._side)):
                    self.sources.append(row * self.graph.stride + column)

    def reached(self) -> Bools:
        """Return which cells' centres can be reached."""
        if not self.sources:
            rows, columns = self.graph.clear.shape
            return np.zeros((rows // _NODES, columns // _NODES), np.bool_)
        seen = flood(self.graph, np.array(self.sources, np.int64))
        return np.ascontiguousarray(seen.reshape(self.graph.clear.shape)[1::_NODES, 1::_NODES])

    def tree(self) -> dict[int, int]:
        """Return each node's parent, breadth first from the start, where the sources begin."""
        clear = self.graph.clear.ravel()
        middle = self.graph.middle.ravel()
        steps = list(zip(*neighbour_shifts(self.graph.stride), strict=True))
        parent = dict.fromkeys(self.sources, _START)
        queue = deque(self.sources)
        while queue:
            node = queue.popleft()
            for k, (step, between) in enumerate(steps):
                other = node + step
                if other in parent or not 0 <= other < len(clear) or not clear[other]:
                    continue
                # Steps along the axes come first, and need no check of a midpoint.
                if k < _AXIS_STEPS or middle[node + between]:
                    parent[other] = node
                    queue.append(other)
        return parent

    def place(self, node: int, cell_size: float) -> tuple[float, float]:
        """Return where a node is, m."""
        row, column = divmod(node, self.graph.stride)
        return (
            lattice_to_metres(column * self._side, cell_size),
            lattice_to_metres(row * self._side, cell_size),
        )
