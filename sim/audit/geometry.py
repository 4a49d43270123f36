"""Straight parts of a path against unit cells, in cells and float64.

How near, how deep, from where to where. Arrays throughout, one row a pair of part and cell. Nothing
here is shared with the simulator that may be audited.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

__all__ = ["Parts", "deepest", "nearest", "slab", "within"]

Floats = npt.NDArray[np.float64]

_CORNERS = ((-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5))


@dataclass(frozen=True)
class Parts:
    """Where the centre goes: from (x, y) by (dx, dy), all (n,) in cells."""

    x: Floats
    y: Floats
    dx: Floats
    dy: Floats

    def between(self, low: Floats, high: Floats) -> Parts:
        """The stretch of each part from the share ``low`` of it to the share ``high``."""
        span = high - low
        return Parts(self.x + low * self.dx, self.y + low * self.dy, span * self.dx, span * self.dy)

    def take(self, rows: npt.NDArray[np.intp] | npt.NDArray[np.bool_] | slice) -> Parts:
        """Some of the parts."""
        return Parts(self.x[rows], self.y[rows], self.dx[rows], self.dy[rows])

    def seen_from(
        self, ix: npt.NDArray[np.int64] | Floats, iy: npt.NDArray[np.int64] | Floats
    ) -> Parts:
        """The same parts with the origin in the middle of each one's cell."""
        return Parts(self.x - (ix + 0.5), self.y - (iy + 0.5), self.dx, self.dy)

    @property
    def length(self) -> Floats:
        """(n,) cells."""
        length: Floats = np.sqrt(self.dx * self.dx + self.dy * self.dy)
        return length


def nearest(parts: Parts) -> tuple[Floats, Floats]:
    """Distance of each part from the unit square round the origin, and the share of the part where it is least.

    Parts that cross the square count by their ends alone; :func:`deepest` tells them.
    """
    square = parts.dx * parts.dx + parts.dy * parts.dy

    def distance(share: Floats) -> Floats:
        across = np.maximum(np.abs(parts.x + share * parts.dx) - 0.5, 0.0)
        along = np.maximum(np.abs(parts.y + share * parts.dy) - 0.5, 0.0)
        gap: Floats = np.sqrt(across * across + along * along)
        return gap

    def shares() -> Iterator[Floats]:
        yield np.zeros_like(parts.x)
        yield np.ones_like(parts.x)
        for x, y in _CORNERS:
            yield _share((x - parts.x) * parts.dx + (y - parts.y) * parts.dy, square)

    return _least(shares(), distance)


def deepest(parts: Parts) -> tuple[Floats, Floats]:
    """How deep each part gets into the unit square round the origin, and at which share of it.

    Returns:
        Distance to the nearest face, negative outside; the least that it can be is no measure of
        distance.
    """

    def height(share: Floats) -> Floats:
        x = parts.x + share * parts.dx
        y = parts.y + share * parts.dy
        return np.maximum(np.abs(x), np.abs(y)) - 0.5

    def shares() -> Iterator[Floats]:
        yield np.zeros_like(parts.x)
        yield np.ones_like(parts.x)
        yield _share(-parts.x, parts.dx)
        yield _share(-parts.y, parts.dy)
        yield _share(parts.y - parts.x, parts.dx - parts.dy)
        yield _share(-parts.x - parts.y, parts.dx + parts.dy)

    least, share = _least(shares(), height)
    return -least, share


def _share(numerator: Floats, denominator: Floats) -> Floats:
    """The quotient within [0, 1]; 0 where the denominator is."""
    zero = denominator == 0.0
    with np.errstate(over="ignore"):  # a part of almost no length: clipped
        quotient = np.where(zero, 0.0, numerator) / np.where(zero, 1.0, denominator)
    shares: Floats = np.clip(quotient, 0.0, 1.0)
    return shares


def _least(shares: Iterator[Floats], value: Callable[[Floats], Floats]) -> tuple[Floats, Floats]:
    """The least value over several shares, and the first share that has it."""
    where = next(shares)
    best = value(where)
    for share in shares:
        found = value(share)
        better = found < best
        best = np.where(better, found, best)
        where = np.where(better, share, where)
    return best, where


def slab(parts: Parts, half_x: float, half_y: float) -> tuple[Floats, Floats]:
    """Shares at which the line of each part enters and leaves a box round the origin.

    (inf, -inf) if it does not.

    Source: slabs, Kay and Kajiya, Ray Tracing Complex Scenes (1986).
    """
    enter = np.full(len(parts.x), -np.inf)
    leave = np.full(len(parts.x), np.inf)
    for place, step, half in ((parts.x, parts.dx, half_x), (parts.y, parts.dy, half_y)):
        still = step == 0.0
        with np.errstate(over="ignore"):
            one, two = ((end - place) / np.where(still, 1.0, step) for end in (-half, half))
        beside = np.where(np.abs(place) <= half, -np.inf, np.inf)
        enter = np.maximum(enter, np.where(still, beside, np.minimum(one, two)))
        leave = np.minimum(leave, np.where(still, -beside, np.maximum(one, two)))
    missed = enter > leave
    return np.where(missed, np.inf, enter), np.where(missed, -np.inf, leave)


def within(parts: Parts, reach: float) -> tuple[Floats, Floats]:
    """Shares at which the line of each part comes within ``reach`` of the unit square, and leaves again.

    The square grown by a disc is convex, so there is one interval; (inf, -inf) if there is none.
    """
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
    middle = -(x * parts.dx + y * parts.dy) * inverse
    miss_x = x + middle * parts.dx
    miss_y = y + middle * parts.dy
    rest = radius * radius - miss_x * miss_x - miss_y * miss_y
    half = np.where(still, np.inf, np.sqrt(np.maximum(rest, 0.0) * inverse))
    return np.where(rest < 0.0, np.inf, middle - half), np.where(rest < 0.0, -np.inf, middle + half)
