"""A trajectory in cells: in float64 for most of it, and in rational numbers for close calls."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sim.audit.exact import Move, decimal, is_beyond
from sim.audit.geometry import Parts, slab
from worldgen.support.arrays import Bools, Floats, Indices
from worldgen.world import World

# Cells. Longer moves are examined in pieces of at most this length.
_PIECE = 2.0


# rad. Arcs that turn by less are straight.
_STRAIGHT = 1e-9

# Pieces of one arc; more would hardly be shorter than rounding errors.
_MOST_PIECES = 4096


@dataclass(frozen=True, eq=False)
class Samples:
    """The samples of a trajectory, (n,) each, with places added along the arcs between them.

    Args:
        times: s, never decreasing.
        x: m.
        y: m.
        headings: rad; ``None`` if unknown.
        place: Place of each on the recorded path; ``None`` if all of them are recorded.
        lengths: Lengths of the moves between recorded samples, m; ``None`` for straight ones.
    """

    times: Floats
    x: Floats
    y: Floats
    headings: Floats | None = None
    place: Floats | None = None
    lengths: Floats | None = None


def shorter_turn(turn: Floats) -> Floats:
    """Return turns in [-pi, pi], rad: a robot turns the shorter way."""
    shorter: Floats = turn - 2.0 * math.pi * np.round(turn / (2.0 * math.pi))
    return shorter


def chord_to(share: Floats, half: Floats) -> tuple[Floats, Floats]:
    """Return how the chord to a place on an arc compares to the chord of the whole arc.

    Args:
        share: Share of the arc up to the place.
        half: Half of the arc's turn, rad.

    Returns:
        Its length divided by that of the whole, and the angle between the two, rad.
    """
    bends = np.abs(half) > _STRAIGHT
    sine = np.sin(np.where(bends, half, 1.0))
    return np.where(bends, np.sin(share * half) / sine, share), (share - 1.0) * half


def longer_by(half: Floats) -> Floats:
    """Return the length of an arc divided by that of its chord, for half of its turn, rad."""
    bends = np.abs(half) > _STRAIGHT
    sine = np.sin(np.where(bends, half, 1.0))
    longer: Floats = np.where(bends, half / sine, 1.0)
    return longer


def along_arcs(samples: Samples, most: float) -> Samples:
    """Add places between samples, so that straight lines are near the arcs that the robot drives.

    On an arc, the speed, the turn rate and the direction of travel in the robot's frame stay the
    same.

    Args:
        samples: The recorded samples, with headings.
        most: Largest distance of an arc from the lines, m.
    """
    assert samples.headings is not None
    half = 0.5 * shorter_turn(np.diff(samples.headings))
    chord = np.column_stack((np.diff(samples.x), np.diff(samples.y)))
    length = np.hypot(*chord.T)
    arc = length * longer_by(half)

    # The line over a piece of an arc is its length times its turn / 8 away from it.
    pieces = np.ceil(np.sqrt(arc * np.abs(half) / (4.0 * most)))
    pieces = np.clip(pieces, 1, _MOST_PIECES).astype(np.int64)
    row = np.repeat(np.arange(len(pieces)), pieces)
    share = (np.arange(len(row)) - (np.cumsum(pieces) - pieces)[row]) / pieces[row]

    scale, angle = chord_to(share, half[row])
    cos = scale * np.cos(angle)
    sin = scale * np.sin(angle)
    dx, dy = chord[row].T
    times = samples.times[row] + share * np.diff(samples.times)[row]
    x = samples.x[row] + dx * cos - dy * sin
    y = samples.y[row] + dx * sin + dy * cos
    headings = samples.headings[row] + 2.0 * share * half[row]
    return Samples(
        np.append(times, samples.times[-1]),
        np.append(x, samples.x[-1]),
        np.append(y, samples.y[-1]),
        np.append(headings, samples.headings[-1]),
        np.append(row + share, len(pieces)),
        arc,
    )


class AuditPath:
    """A trajectory in cells, and the part of each move that is in or near the grid.

    Args:
        world: The world that the robot drove in.
        samples: The samples between which the robot's centre moves straight.
    """

    def __init__(self, world: World, samples: Samples) -> None:
        self.world = world
        self.times = samples.times
        self.headings = samples.headings
        x = samples.x
        y = samples.y
        self.metres = (x, y)
        self._recorded = samples.place
        lengths = np.hypot(np.diff(x), np.diff(y)) if samples.lengths is None else samples.lengths
        self.lengths = lengths
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

    @property
    def samples(self) -> Indices:
        """The rows of the recorded samples."""
        if self._recorded is None:
            return np.arange(len(self.times))
        return np.flatnonzero(self._recorded == np.floor(self._recorded))

    def recorded(self, at: Floats) -> Floats:
        """Return places on the path as places on the recorded path, without what was added."""
        if self._recorded is None:
            return at
        recorded: Floats = np.interp(at, np.arange(len(self.times)), self._recorded)
        return recorded

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
