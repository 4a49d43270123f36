"""Decide close calls in rational numbers.

The close calls are whether the centre really entered a wall, and whether it really left the grid.
A float means its shortest decimal, as in the world's file: with cells of 0.1 m, 0.3 m is
exactly on the face of cell 3.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

# Fractions of a move before its beginning and after its end.
_BEFORE = Fraction(-1)
_AFTER = Fraction(2)


@dataclass(frozen=True)
class Move:
    """The centre's move from one sample to the next, exact: times in s, positions in cells."""

    begin: Fraction
    end: Fraction
    ax: Fraction
    ay: Fraction
    bx: Fraction
    by: Fraction


def decimal(value: float) -> Fraction:
    """Return a float's shortest decimal as an exact number."""
    return Fraction(repr(float(value)))


def is_beyond(place: float, cells: int, cell_size: float) -> bool:
    """Return True if a coordinate in m is outside a grid with this many cells."""
    return not 0 <= decimal(place) <= cells * decimal(cell_size)


def meet_inside(move: Move, ix: int, iy: int, since: float, until: float) -> bool:
    """Return True if the centre is inside an open cell at some time in [since, until) s.

    The time span must overlap the move.
    """
    return _any_share(
        move, since, until, [(move.ax, move.bx, ix, ix + 1), (move.ay, move.by, iy, iy + 1)]
    )


def run_between(move: Move, ix: int, iy: int) -> tuple[tuple[int, int], ...]:
    """Return the cells across faces of cell (ix, iy) along which the centre moves or stays."""
    neighbours = []
    if move.ax == move.bx and move.ax in (ix, ix + 1) and _meets(move.ay, move.by, iy):
        neighbours.append((ix - 1 if move.ax == ix else ix + 1, iy))
    if move.ay == move.by and move.ay in (iy, iy + 1) and _meets(move.ax, move.bx, ix):
        neighbours.append((ix, iy - 1 if move.ay == iy else iy + 1))
    return tuple(neighbours)


def run_along(
    move: Move, ix: int, iy: int, other: tuple[int, int], since: float, until: float
) -> bool:
    """Return True if the centre is on the open face between two cells during [since, until) s."""
    if other[0] != ix:
        return _any_share(move, since, until, [(move.ay, move.by, iy, iy + 1)])
    return _any_share(move, since, until, [(move.ax, move.bx, ix, ix + 1)])


def _meets(a: Fraction, b: Fraction, low: int) -> bool:
    return max(a, b) > low and min(a, b) < low + 1


def _any_share(
    move: Move, since: float, until: float, ranges: list[tuple[Fraction, Fraction, int, int]]
) -> bool:
    """Return True if at some time in [since, until) each coordinate is in its open range."""
    # Intersect the open intervals, as fractions of the move, in which each coordinate is in range.
    open_low = _BEFORE
    open_high = _AFTER
    for a, b, low, high in ranges:
        if a == b:
            if not low < a < high:
                return False
            continue
        shares = sorted(((low - a) / (b - a), (high - a) / (b - a)))
        open_low = max(open_low, shares[0])
        open_high = min(open_high, shares[1])

    # Intersect with the time span, which includes its beginning and excludes its end.
    closed_low = Fraction(0)
    closed_high = Fraction(1)
    lasts = move.end - move.begin
    if lasts > 0:
        if math.isfinite(since):
            closed_low = max(closed_low, (decimal(since) - move.begin) / lasts)
        if math.isfinite(until):
            open_high = min(open_high, (decimal(until) - move.begin) / lasts)
    elif not (_reached(since, move.begin) and not _reached(until, move.begin)):
        return False

    # An open and a half-open interval meet if each begins before the other ends.
    return (
        max(open_low, closed_low) < open_high
        and open_low < closed_high
        and closed_low <= closed_high
    )


def _reached(time: float, now: Fraction) -> bool:
    return time < 0 if math.isinf(time) else decimal(time) <= now
