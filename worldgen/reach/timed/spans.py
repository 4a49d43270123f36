"""The spans in which cells are solid or burning, as the prover sees them.

They are in whole ticks, and each is slightly too long.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from worldgen.lattice import UNIT, exact
from worldgen.reach.still.path import ticks_per_second
from worldgen.reach.still.walls import Cell, ExactPoint, Number, Walls, segment_box_sq
from worldgen.support.arrays import Bools, Ints
from worldgen.timeline import CellState
from worldgen.world import World

# A tick after everything else.
FOREVER = 2**60
# Ticks by which a span begins earlier and ends later, to allow for rounded decimals.
MARGIN = 2
# Ticks up to which a float stores an event's time to a fraction of a tick.
_LAST = 2.0**50


class Spans:
    """The cells that change, and when they are blocked: solid or burning.

    If a robot is clear of spans that begin ``early`` seconds early, it stays clear if it arrives up
    to that much later: for some delay up to ``early``, t + delay is b or later exactly if t is b -
    early or later.

    Args:
        world: The world.
        early: Time, s, by which every span begins before its cell is blocked; it only moves
            ``begin``.

    Attributes:
        ticks: Ticks per second.
        fixed: (height, width) bool, solid and never changed.
        changing: (height, width) bool, cells with an event.
        at_start: (height, width) bool, blocked at time 0.
        always: (height, width) bool, blocked at every time.
        ever: (height, width) bool, blocked at some time.
        first: (height * width + 1,) int64; cell c = iy * width + ix has spans first[c] to first[c +
            1] - 1.
        begin: (n,) int64, tick from which on the cell counts as blocked.
        end: (n,) int64, tick until which it does; ``FOREVER`` if it stays so.
        since: (n,) float64, time, s, from which it is blocked.
        until: (n,) float64, time, s, until which it is; infinite if it stays so.
    """

    def __init__(self, world: World, early: float = 0.0) -> None:
        line = world.timeline
        size = world.walls.size
        self.width = world.width
        self.ticks = ticks_per_second(world.cell_size, world.robot_speed)
        last = max(line.last_time, early)
        while self.ticks > 1 and last * self.ticks > _LAST:
            self.ticks //= 10
        # A cell's first state begins at time 0, and is dropped if an event ends it right then.
        spans = line.spans(world.walls)
        since = np.maximum(spans.since, 0.0)
        lasting = since < spans.until
        place = spans.cells[lasting]
        since = since[lasting]
        until = spans.until[lasting]
        blocked = spans.states[lasting] != CellState.FREE
        # Adjacent spans of one cell (solid, then burning) become one, because there is no gap
        # between them.
        goes_on = np.zeros(len(place), np.bool_)
        goes_on[1:] = blocked[1:] & blocked[:-1] & (place[1:] == place[:-1])
        heads = np.nonzero(blocked & ~goes_on)[0]
        ends_here = blocked.copy()
        ends_here[:-1] &= ~goes_on[1:]
        tails = np.nonzero(ends_here)[0]
        cell = place[heads]
        since = since[heads]
        until = until[tails]
        self.since = since
        self.until = until
        self.first: Ints = np.searchsorted(cell, np.arange(size + 1)).astype(np.int64)
        self.begin: Ints = np.floor(since * self.ticks).astype(np.int64) - MARGIN
        self.begin -= math.ceil(exact(early) * self.ticks)
        stays = until == math.inf
        self.end: Ints = np.where(
            stays, FOREVER, np.ceil(np.where(stays, 0.0, until) * self.ticks) + MARGIN
        )
        self.end = self.end.astype(np.int64)
        self.changing = world.changing_cells
        self.fixed: Bools = world.walls & ~self.changing
        self.at_start = self.fixed | self._raster(world, cell[since == 0])
        self.always = self.fixed | self._raster(world, cell[(since == 0) & (until == math.inf)])
        self.ever = self.fixed | self._raster(world, cell)

    @staticmethod
    def _raster(world: World, places: Ints) -> Bools:
        raster = np.zeros(world.walls.size, np.bool_)
        raster[places] = True
        return raster.reshape(world.walls.shape)

    def of(self, cell: Cell) -> list[tuple[int, int]]:
        """Return the spans of one cell."""
        place = cell[1] * self.width + cell[0]
        low = int(self.first[place])
        high = int(self.first[place + 1])
        return list(zip(self.begin[low:high].tolist(), self.end[low:high].tolist(), strict=True))


class ChangingWalls:
    """Walls for exact queries about pieces of a timed path."""

    def __init__(self, world: World, spans: Spans, radius: Fraction) -> None:
        self.spans = spans
        self.radius = radius
        self._ever = Walls(spans.fixed | spans.changing, radius)

    def _blocked(self, cell: Cell, since: int, until: int) -> list[tuple[int, int]]:
        """Return the parts of a time span in which a cell is blocked."""
        ix, iy = cell
        inside = 0 <= ix < self._ever.width and 0 <= iy < self._ever.height
        if not inside or not self.spans.changing[iy, ix]:
            return [(since, until)]
        return [
            (max(since, begin), min(until, end))
            for begin, end in self.spans.of(cell)
            if begin <= until and end >= since
        ]

    def spans_near(self, p: ExactPoint, q: ExactPoint) -> list[tuple[int, int]]:
        """Return the sorted spans in which a blocked cell is within the radius of segment pq."""
        found = set()
        for cell in self._ever.near(p, q, math.ceil(self.radius * UNIT)):
            distance, over = segment_box_sq(p, q, cell)
            if distance < self._ever.radius_sq * over:
                found.update(self._blocked(cell, 0, FOREVER))
        return sorted(found)

    def is_clear(self, p: ExactPoint, q: ExactPoint, since: int, until: int) -> bool:
        """Return True if the disc may sweep pq past every cell blocked at any of these ticks."""
        limit = self._ever.radius_sq
        for cell in self._ever.near(p, q, math.ceil(self.radius * UNIT)):
            if self._blocked(cell, since, until):
                distance, over = segment_box_sq(p, q, cell)
                if distance < limit * over:
                    return False
        return True

    def clearance_sq(self, points: list[ExactPoint], times: list[int]) -> Fraction:
        """Return the squared distance, lu squared, from a timed path to the cells blocked then."""
        pieces = list(zip(points[:-1], points[1:], times[:-1], times[1:], strict=True))
        pieces = pieces or [(points[0], points[0], 0, 0)]
        reach = 2 * math.ceil(self.radius * UNIT)
        while True:
            best = Fraction(reach * reach)
            for p, q, since, until in pieces:
                for cell in self._ever.near(p, q, math.isqrt(math.ceil(best)) + 1):
                    for begin, end in self._blocked(cell, since, until):
                        a = _at(p, q, since, until, begin)
                        b = _at(p, q, since, until, end)
                        distance, over = segment_box_sq(a, b, cell)
                        best = min(best, Fraction(distance) / over)
            if best < reach * reach:
                return best
            reach *= 2


def _at(p: ExactPoint, q: ExactPoint, since: int, until: int, tick: int) -> ExactPoint:
    if tick <= since:
        return p
    if tick >= until:
        return q
    share: Number = Fraction(tick - since, until - since)
    return p[0] + (q[0] - p[0]) * share, p[1] + (q[1] - p[1]) * share
