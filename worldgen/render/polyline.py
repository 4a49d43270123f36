"""Geometry of drawn lines: thinning, arc length, dashes, places for arrow heads."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from worldgen.support.arrays import Bools, Floats

# Points thinned together, which bounds the work on a long scribble.
CHUNK = 2000


def simplified(points: Floats, tolerance: float) -> Floats:
    """Thin out a line so that it stays within ``tolerance`` of the given one.

    Args:
        points: (n, 2).
        tolerance: Tolerance in the points' unit.

    Source: David Douglas, Thomas Peucker, "Algorithms for the Reduction of the Number of Points
        Required to Represent a Digitized Line or its Caricature", 1973; in chunks.
    """
    if len(points) < 3:
        return points
    moved = np.concatenate(([True], (np.diff(points, axis=0) != 0.0).any(axis=1)))
    points = points[moved]
    keep = np.zeros(len(points), np.bool_)
    keep[0] = keep[-1] = True
    for first in range(0, len(points) - 1, CHUNK):
        _keep_far(points, first, min(first + CHUNK, len(points) - 1), tolerance, keep)
    return points[keep]


def _keep_far(points: Floats, first: int, last: int, tolerance: float, keep: Bools) -> None:
    keep[first] = keep[last] = True
    # Ramer-Douglas-Peucker with a stack: the path may be longer than Python's recursion limit.
    spans = [(first, last)]
    while spans:
        a, b = spans.pop()
        if b - a < 2:
            continue
        offset = points[a + 1 : b] - points[a]
        chord = points[b] - points[a]
        square = float(chord @ chord)
        share = (
            np.clip(offset @ chord / square, 0.0, 1.0) if square > 0.0 else np.zeros(len(offset))
        )
        distance = np.hypot(*(offset - share[:, None] * chord).T)
        # Split where the path is farthest from the chord.
        worst = int(np.argmax(distance))
        if distance[worst] > tolerance:
            middle = a + 1 + worst
            keep[middle] = True
            spans += [(a, middle), (middle, b)]


def arc_length(points: Floats) -> Floats:
    """Return a (n,) float64 array: arc length at each of its (n, 2) points."""
    return np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))))


def along(points: Floats, distance: Sequence[float] | Floats) -> Floats:
    """Return a (k, 2) float64 array: the points at arc lengths ``distance`` (k,)."""
    length = arc_length(points)
    return np.column_stack([np.interp(distance, length, points[:, axis]) for axis in (0, 1)])


def arrow_places(points: Floats, spacing: float, reach: float) -> list[tuple[float, float, float]]:
    """Return places for arrow heads: about ``spacing`` apart, on straight pieces.

    Args:
        points: (n, 2).
        spacing: Distance along the line between two heads; a shorter line gets one.
        reach: Half the length of line that a head covers.

    Returns:
        (x, y, angle) of each head, with the angle in radians in the points' axes.
    """
    total = float(arc_length(points)[-1])
    count = max(1, round(total / spacing))
    step = total / count
    places: list[tuple[float, float, float]] = []
    for index in range(count):
        # Try places around the even one, straightest first, since a head on a corner points
        # nowhere.
        spots = (index + 0.5 + np.array((0.0, 0.1, -0.1, 0.2, -0.2, 0.3, -0.3, 0.4, -0.4))) * step
        chords = along(points, spots + reach) - along(points, spots - reach)
        order = np.argsort(-np.round(np.hypot(*chords.T) / reach, 2), kind="stable")
        for spot, (dx, dy) in zip(along(points, spots[order]), chords[order], strict=True):
            x = float(spot[0])
            y = float(spot[1])
            if all(max(abs(x - other[0]), abs(y - other[1])) > 2.5 * reach for other in places):
                places.append((x, y, float(np.arctan2(dy, dx))))
                break
    return places


def corners(points: Floats, sharpest: float = 0.5) -> Floats:
    """Return the (k, 2) points at which the line turns by more than ``sharpest`` radians."""
    if len(points) < 3:
        return points[:0]
    ways = np.diff(points, axis=0)
    heading = np.arctan2(ways[:, 1], ways[:, 0])
    turn = np.abs((np.diff(heading) + np.pi) % (2.0 * np.pi) - np.pi)
    return points[1:-1][turn > sharpest]


def dashes(points: Floats, pattern: tuple[float, ...]) -> list[Floats]:
    """Return the drawn pieces of a dashed line, each (k, 2).

    Args:
        points: (n, 2).
        pattern: Lengths drawn and skipped, in turn.
    """
    length = arc_length(points)
    period = sum(pattern)
    total = float(length[-1])
    pieces = []
    # Walk along the line in periods of the pattern; each pair is a dash and a gap.
    starts = np.concatenate(([0.0], np.cumsum(pattern)))
    for lap in range(int(total // period) + 1):
        for first in range(0, len(pattern), 2):
            a = lap * period + starts[first]
            b = min(total, lap * period + starts[first + 1])
            if a < b:
                inner = points[(length > a) & (length < b)]
                ends = along(points, [a, b])
                pieces.append(np.concatenate((ends[:1], inner, ends[1:])))
    return pieces
