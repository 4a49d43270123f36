"""Measure straight parts of a path against unit cells, in cells and float64.

It finds how near they come, how deep they get, and on which stretch. Everything is in arrays, with
one row for each pair of part and cell. The code shares nothing with the simulator that it audits.

shapely's STRtree was measured as an alternative. In a world of 1000 x 1000 cells with 20,000 walls
and a trajectory of 100,000 samples, finding the walls near each move takes 0.12 s, of which 0.10 s
is the query; this audit does all of its checks in 0.07 s, and also finds the depth and time of each
cut.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from worldgen.support.arrays import Bools, Floats, Indices, Ints

_CORNERS = ((-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5))


@dataclass(frozen=True)
class Parts:
    """Straight parts of the centre's path, from (x, y) by (dx, dy); (n,) each, in cells."""

    x: Floats
    y: Floats
    dx: Floats
    dy: Floats

    def between(self, low: Floats, high: Floats) -> Parts:
        """Return the stretch of each part between two fractions of it."""
        span = high - low
        return Parts(self.x + low * self.dx, self.y + low * self.dy, span * self.dx, span * self.dy)

    def take(self, rows: Indices | Bools | slice) -> Parts:
        """Return some of the parts."""
        return Parts(self.x[rows], self.y[rows], self.dx[rows], self.dy[rows])

    def seen_from(self, ix: Ints | Floats, iy: Ints | Floats) -> Parts:
        """Return the parts with the origin moved to the middle of each one's cell."""
        return Parts(self.x - (ix + 0.5), self.y - (iy + 0.5), self.dx, self.dy)

    @property
    def length(self) -> Floats:
        """(n,) Length of each part, cells."""
        length: Floats = np.sqrt(self.dx * self.dx + self.dy * self.dy)
        return length


def nearest(parts: Parts) -> tuple[Floats, Floats]:
    """Return each part's distance from the unit square around the origin, and where it is nearest.

    Places on a part are given as fractions of its length. Parts that cross the square are judged by
    their ends alone; :func:`deepest` finds those.
    """
    square = parts.dx * parts.dx + parts.dy * parts.dy

    def distance(share: Floats) -> Floats:
        across = np.maximum(np.abs(parts.x + share * parts.dx) - 0.5, 0.0)
        along = np.maximum(np.abs(parts.y + share * parts.dy) - 0.5, 0.0)
        gap: Floats = np.sqrt(across * across + along * along)
        return gap

    def shares() -> Iterator[Floats]:
        # The distance is smallest at an end, or where the part passes a corner.
        yield np.zeros_like(parts.x)
        yield np.ones_like(parts.x)
        for x, y in _CORNERS:
            yield _share((x - parts.x) * parts.dx + (y - parts.y) * parts.dy, square)

    return _least(shares(), distance)


def deepest(parts: Parts) -> tuple[Floats, Floats]:
    """Return how deep each part gets into the unit square around the origin, and where.

    Returns:
        Distance to the nearest face of the square, negative and not a true distance outside of
        it; and the fraction of the part at which it is greatest.
    """

    def height(share: Floats) -> Floats:
        x = parts.x + share * parts.dx
        y = parts.y + share * parts.dy
        return np.maximum(np.abs(x), np.abs(y)) - 0.5

    def shares() -> Iterator[Floats]:
        # The depth peaks at an end, or where the part crosses an axis or a diagonal of the square.
        yield np.zeros_like(parts.x)
        yield np.ones_like(parts.x)
        yield _share(-parts.x, parts.dx)
        yield _share(-parts.y, parts.dy)
        yield _share(parts.y - parts.x, parts.dx - parts.dy)
        yield _share(-parts.x - parts.y, parts.dx + parts.dy)

    least, share = _least(shares(), height)
    return -least, share


def _share(numerator: Floats, denominator: Floats) -> Floats:
    """Return the quotient, limited to [0, 1]; 0 where the denominator is 0."""
    zero = denominator == 0.0
    with np.errstate(over="ignore"):  # A part of almost no length overflows, and is then clipped.
        quotient = np.where(zero, 0.0, numerator) / np.where(zero, 1.0, denominator)
    shares: Floats = np.clip(quotient, 0.0, 1.0)
    return shares


def _least(shares: Iterator[Floats], value: Callable[[Floats], Floats]) -> tuple[Floats, Floats]:
    """Return the smallest value over several fractions, and the first fraction that has it."""
    where = next(shares)
    best = value(where)
    for share in shares:
        found = value(share)
        better = found < best
        best = np.where(better, found, best)
        where = np.where(better, share, where)
    return best, where


def slab(parts: Parts, half_x: float, half_y: float) -> tuple[Floats, Floats]:
    """Return the fractions at which each part's line enters and leaves a box around the origin.

    If it misses the box, they are (inf, -inf).

    Source: slabs, Kay and Kajiya, Ray Tracing Complex Scenes (1986).
    """
    enter = np.full(len(parts.x), -np.inf)
    leave = np.full(len(parts.x), np.inf)
    for place, step, half in ((parts.x, parts.dx, half_x), (parts.y, parts.dy, half_y)):
        still = step == 0.0
        with np.errstate(over="ignore"):
            one, two = ((end - place) / np.where(still, 1.0, step) for end in (-half, half))
        # A part that does not move along this axis is within the slab always or never.
        outside = np.where(np.abs(place) <= half, -np.inf, np.inf)
        enter = np.maximum(enter, np.where(still, outside, np.minimum(one, two)))
        leave = np.minimum(leave, np.where(still, -outside, np.maximum(one, two)))
    missed = enter > leave
    return np.where(missed, np.inf, enter), np.where(missed, -np.inf, leave)


def within(parts: Parts, reach: float) -> tuple[Floats, Floats]:
    """Return the fractions between which each part's line is within ``reach`` of the unit square.

    The square grown by a disc is convex, so this is one interval, or (inf, -inf) if it is empty.
    """
    # The grown square is the union of two boxes and a circle at each corner.
    enter, leave = slab(parts, 0.5 + reach, 0.5)
    for found in (
        slab(parts, 0.5, 0.5 + reach),
        *(_in_circle(parts, corner, reach) for corner in _CORNERS),
    ):
        enter = np.minimum(enter, found[0])
        leave = np.maximum(leave, found[1])
    return enter, leave


def _in_circle(parts: Parts, centre: tuple[float, float], radius: float) -> tuple[Floats, Floats]:
    x = parts.x - centre[0]
    y = parts.y - centre[1]
    square = parts.dx * parts.dx + parts.dy * parts.dy
    still = square == 0.0
    inverse = 1.0 / np.where(still, 1.0, square)
    # Find the point of the line nearest to the centre, and go half the chord both ways from there.
    middle = -(x * parts.dx + y * parts.dy) * inverse
    miss_x = x + middle * parts.dx
    miss_y = y + middle * parts.dy
    rest = radius * radius - miss_x * miss_x - miss_y * miss_y
    half = np.where(still, np.inf, np.sqrt(np.maximum(rest, 0.0) * inverse))
    return np.where(rest < 0.0, np.inf, middle - half), np.where(rest < 0.0, -np.inf, middle + half)
