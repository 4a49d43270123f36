"""A trajectory in cells: in float64 for most of it, and in rational numbers for close calls."""

from __future__ import annotations

import numpy as np

from sim.audit.exact import Move, decimal, is_beyond
from sim.audit.geometry import Parts, slab
from worldgen.support.arrays import Bools, Floats
from worldgen.world import World

# Cells. Longer moves are examined in pieces of at most this length.
_PIECE = 2.0


class AuditPath:
    """A trajectory in cells, and the part of each move that is in or near the grid.

    Args:
        world: The world that the robot drove in.
        times: (n,) s, never decreasing.
        x: (n,) m.
        y: (n,) m.
    """

    def __init__(self, world: World, times: Floats, x: Floats, y: Floats) -> None:
        self.world = world
        self.times = times
        self.metres = (x, y)
        self.height, self.width = world.walls.shape
        self.x, beyond_x = _coordinate(x, self.width, world.cell_size)
        self.y, beyond_y = _coordinate(y, self.height, world.cell_size)
        self.beyond = beyond_x | beyond_y
        self.moves = Parts(self.x[:-1], self.y[:-1], np.diff(self.x), np.diff(self.y))
        self.leaving = np.flatnonzero(self.beyond[:-1] | self.beyond[1:])
        # A burning cell may touch a disc whose centre is outside the grid.
        margin = 0.0
        if world.is_dynamic:
            margin = min(world.robot_radius / world.cell_size, self.height + self.width)
        self.low = np.zeros(len(self.moves.x))
        self.high = np.ones(len(self.moves.x))
        self.low[self.leaving], self.high[self.leaving] = self.in_grid(margin)

        # Divide long moves into pieces; moves that miss the grid have none.
        near = np.maximum(self.high - self.low, 0.0) * self.moves.length
        pieces = np.maximum(np.ceil(near / _PIECE), 1.0)
        self.pieces = np.where(self.low <= self.high, pieces, 0.0).astype(np.int64)

    def in_grid(self, margin: float) -> tuple[Floats, Floats]:
        """Return where each move in ``leaving`` enters and leaves the grid grown by a margin.

        Args:
            margin: How far the grid is grown on each side, cells.

        Returns:
            Fractions of each move at its entry and exit; 1 and 0 for moves that miss the grid.
        """
        own = self.moves.take(self.leaving)
        half_x = 0.5 * self.width
        half_y = 0.5 * self.height
        low, high = slab(
            Parts(own.x - half_x, own.y - half_y, own.dx, own.dy), half_x + margin, half_y + margin
        )
        missed = (low > 1.0) | (high < 0.0)
        return np.where(missed, 1.0, np.maximum(low, 0.0)), np.where(
            missed, 0.0, np.minimum(high, 1.0)
        )

    def place(self, at: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the times, x and y (s, m, m), at places on the path.

        The place 3.25 is a quarter of the way from sample 3 to sample 4.
        """
        row = np.minimum(at.astype(np.int64), len(self.times) - 2)
        share = at - row
        found = []
        for values in (self.times, *self.metres):
            a = values[row]
            b = values[row + 1]
            found.append(np.where(share >= 1.0, b, a + share * (b - a)))
        return found[0], found[1], found[2]

    def is_face(self, metres: float) -> bool:
        """Return True if a coordinate in m is exactly on the line between two columns or rows."""
        return (decimal(metres) / decimal(self.world.cell_size)).denominator == 1

    def move(self, row: int) -> Move:
        """Return one move in rational numbers."""
        size = decimal(self.world.cell_size)
        x, y = self.metres
        begin = decimal(self.times[row])
        end = decimal(self.times[row + 1])
        places = [decimal(values[k]) / size for k in (row, row + 1) for values in (x, y)]
        return Move(begin, end, *places)


def _coordinate(metres: Floats, count: int, cell_size: float) -> tuple[Floats, Bools]:
    """Return coordinates in cells, and exactly which of them are outside a grid of ``count``."""
    size = decimal(cell_size)
    if max(size.numerator, size.denominator) < 2**53:
        # Both factors are exact, so 0.3 m in cells of 0.1 m gives exactly 3.
        cells = metres * float(size.denominator) / float(size.numerator)
    else:
        cells = metres / cell_size

    # For coordinates this near an edge, rounding could change the result; compare those exactly.
    outside = (cells < 0.0) | (cells > count)
    for row in np.flatnonzero(np.minimum(np.abs(cells), np.abs(cells - count)) < 1e-9 * count):
        outside[row] = is_beyond(float(metres[row]), count, cell_size)
    return np.where(outside, cells, np.clip(cells, 0.0, count)), outside
