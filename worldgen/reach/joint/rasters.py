"""Find where each size of disc is clear, tick by tick, in a world that may change."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from worldgen.reach.still.lattice_graph import Graph, build_graph
from worldgen.reach.timed.spans import Spans
from worldgen.support.arrays import Bools, Ints
from worldgen.world import World

MOST_TICKS = 50_000  # limit on the ticks in which a world may change
_MOST_BYTES = 400_000_000  # limit on the bytes of all rasters


@dataclass(frozen=True)
class Rasters:
    """Rasters of clear nodes, each for some ticks and one class of robots.

    Args:
        k: Nodes per cell side.
        clear: (rasters, classes, rows, columns) bool; as in a ``Graph``.
        middle: The same for the middles of squares.
        raster_of: (ticks,) int64, raster of each tick; the last one stays valid from then on.
        blocked: (rasters, height, width) bool, the cells that are blocked at some time of the tick.
    """

    k: int
    clear: Bools
    middle: Bools
    raster_of: Ints
    blocked: Bools

    def ever(self, which: int) -> Graph:
        """Return the graph of the nodes at which a class is clear in some tick."""
        clear = np.logical_or.reduce(self.clear[:, which], axis=0)
        middle = np.logical_or.reduce(self.middle[:, which], axis=0)
        return Graph(self.k, clear, middle)

    @property
    def ever_blocked(self) -> Bools:
        """(height, width) bool, the cells that are blocked in some tick."""
        ever: Bools = np.logical_or.reduce(self.blocked, axis=0)
        return ever


def make_rasters(
    world: World, radii: list[Fraction], k: int, spans: Spans | None, tick: int
) -> Rasters | None:
    """Return the rasters of a world for discs of some radii, in cells.

    In a world that changes, a cell counts as blocked in a tick if it is blocked at any time of it.
    A position clear of those cells is clear throughout the tick.

    Args:
        world: The world.
        radii: Radius of each class, cells.
        k: Nodes per cell side.
        spans: When cells are blocked; None in a static world.
        tick: Length of a tick, in ticks of ``spans``.

    Returns:
        The rasters, or None if there would be too many.
    """
    if spans is None:
        blocked = world.walls[None]
        raster_of = np.zeros(1, np.int64)
    else:
        # A span counts from the tick in which it begins to the tick in which it ends.
        first = np.maximum(-(-spans.begin // tick) - 1, 0)
        last = np.minimum(spans.end // tick, MOST_TICKS + 1)
        ticks = np.union1d(first, last + 1)
        ticks = np.union1d(ticks[ticks <= MOST_TICKS + 1], [0])
        until = int(ticks[-1])
        size = (k * world.height + 1) * (k * world.width + 1)
        if until > MOST_TICKS or 2 * len(ticks) * len(radii) * size > _MOST_BYTES:
            return None
        raster_of = np.searchsorted(ticks, np.arange(until + 1), side="right") - 1
        cell = np.repeat(np.arange(world.walls.size), np.diff(spans.first))
        blocked = np.repeat(spans.fixed[None], len(ticks), axis=0)
        flat = blocked.reshape(len(ticks), -1)
        for place, begin, end in zip(cell.tolist(), first.tolist(), last.tolist(), strict=True):
            low, high = np.searchsorted(ticks, [begin, end + 1])
            flat[low:high, place] = True
    # Build a graph for every raster and radius.
    graphs = [[build_graph(cells, radius, k) for radius in radii] for cells in blocked]
    clear = np.array([[graph.clear for graph in row] for row in graphs])
    middle = np.array([[graph.middle for graph in row] for row in graphs])
    return Rasters(k, clear, middle, raster_of.astype(np.int64), blocked)
