"""Check that a cut separates the start from every clear pose of the target's disc.

It shares nothing with the prover. Each connected part of those poses has a pose nearest to the
disc's centre. At that pose, one or two cells block the direct line to the centre. So it is the
centre, the nearest point on the edge of one cell's neighbourhood, or an intersection of two such
edges (docs/notes/reachability.md). Edges lie on lines and circles. All such points are
computed to 180 digits. A point within 10**-80 cell of being clear counts as clear, and one that
close to the disc counts as inside, so doubtful cases count against the certificate. Floats only
decide which points are near enough to be examined.
"""

from __future__ import annotations

import decimal
import itertools
import math
from collections.abc import Iterator
from decimal import Decimal
from fractions import Fraction
from typing import TypeAlias

import numpy as np

from worldgen.support.arrays import Bools

# Digits of places, of their excess over the smallest radius, and of its roots.
_DIGITS = 180
# Digits that remain of a root near zero.
_CERTAIN = 80
# Limit on the points to examine.
_MOST = 4_000_000

ExactPoint: TypeAlias = tuple[Decimal, Decimal]
Cell: TypeAlias = tuple[int, int]


class TooMuch(Exception):
    """Raised if the target's disc has too many poses to examine each."""


def poses_to_part(
    blocked: Bools, radius: Fraction, centre: tuple[Fraction, Fraction], reach: Fraction
) -> list[tuple[Fraction, Fraction]]:
    """Return poses of a disc (centre, ``reach``, cells): at least one in each connected clear part.

    Args:
        blocked: (height, width) bool, blocked cells.
        radius: Radius of the robot, cells.
        centre: Centre of the target, cells.
        reach: Radius of the target, cells.

    Raises:
        TooMuch: If there are too many points to examine.
    """
    with decimal.localcontext() as context:
        context.prec = _DIGITS
        # Margin in cells.
        doubt = Decimal(10) ** -_CERTAIN
        size = _decimal(radius)
        middle = (_decimal(centre[0]), _decimal(centre[1]))
        width = _decimal(reach)
        cells = _cells_near(blocked, float(radius) + float(reach) + 0.01, centre)
        there = set(cells)
        kept: dict[ExactPoint, None] = {}
        for looked, place in enumerate(_places(cells, middle, size, doubt)):
            if looked > _MOST:
                raise TooMuch
            near = (place[0] - middle[0]) ** 2 + (place[1] - middle[1]) ** 2 <= (width + doubt) ** 2
            inside = 0 <= place[0] <= blocked.shape[1] and 0 <= place[1] <= blocked.shape[0]
            if near and inside and _is_clear(there, place, size, doubt):
                kept[place] = None
        return [(Fraction(x), Fraction(y)) for x, y in kept]


def _decimal(value: Fraction) -> Decimal:
    return Decimal(value.numerator) / Decimal(value.denominator)


def _cells_near(blocked: Bools, far: float, centre: tuple[Fraction, Fraction]) -> list[Cell]:
    """Return blocked cells near a point, including those just outside the grid."""
    ring = np.pad(blocked, 1, constant_values=True)
    x = float(centre[0])
    y = float(centre[1])
    low_x, low_y = (max(math.floor(value - far), 0) for value in (x, y))
    rows, columns = np.nonzero(ring[low_y : math.ceil(y + far) + 2, low_x : math.ceil(x + far) + 2])
    return [
        (int(column) + low_x - 1, int(row) + low_y - 1)
        for row, column in zip(rows, columns, strict=True)
    ]


def _places(
    cells: list[Cell], middle: ExactPoint, radius: Decimal, doubt: Decimal
) -> Iterator[ExactPoint]:
    """Yield the points that may be decisive."""
    x, y = middle
    rows = sorted(
        {Decimal(iy) - radius for _, iy in cells} | {Decimal(iy + 1) + radius for _, iy in cells}
    )
    columns = sorted(
        {Decimal(ix) - radius for ix, _ in cells} | {Decimal(ix + 1) + radius for ix, _ in cells}
    )
    corners = sorted(
        {(ix + i, iy + j) for ix, iy in cells for i, j in itertools.product((0, 1), repeat=2)}
    )
    yield middle
    yield from ((x, row) for row in rows)
    yield from ((column, y) for column in columns)
    yield from itertools.product(columns, rows)
    for cx, cy in corners:
        away = ((x - cx) ** 2 + (y - cy) ** 2).sqrt()
        if away > 0:
            yield cx + radius * (x - cx) / away, cy + radius * (y - cy) / away
        for row in rows:
            half = _half_chord(radius, row - cy, doubt)
            yield from () if half is None else ((cx + half, row), (cx - half, row))
        for column in columns:
            half = _half_chord(radius, column - cx, doubt)
            yield from () if half is None else ((column, cy + half), (column, cy - half))
    yield from _where_circles_meet(corners, radius, doubt)


def _half_chord(radius: Decimal, height: Decimal, doubt: Decimal) -> Decimal | None:
    """Return half the chord of a circle at a height above its centre; None if there is none."""
    square = radius**2 - height**2
    return None if square < -doubt else max(square, Decimal(0)).sqrt()


def _where_circles_meet(
    corners: list[Cell], radius: Decimal, doubt: Decimal
) -> Iterator[ExactPoint]:
    by_column: dict[int, list[int]] = {}
    for cx, cy in corners:
        by_column.setdefault(cx, []).append(cy)
    reach = math.floor(2 * radius)
    for cx, cy in corners:
        for column in range(cx, cx + reach + 1):
            for other in by_column.get(column, ()):
                dx = column - cx
                dy = other - cy
                half = _half_chord(radius, Decimal(dx * dx + dy * dy).sqrt() / 2, doubt)
                if (dx, dy) <= (0, 0) or half is None:
                    continue
                apart = Decimal(dx * dx + dy * dy).sqrt()
                for side in (1, -1):
                    yield (
                        cx + Decimal(dx) / 2 - side * half * dy / apart,
                        cy + Decimal(dy) / 2 + side * half * dx / apart,
                    )


def _is_clear(cells: set[Cell], place: ExactPoint, radius: Decimal, doubt: Decimal) -> bool:
    """Return True unless a place is certainly closer to some cell than the radius."""
    x, y = place
    reach = math.ceil(radius) + 1
    least = (radius - doubt) ** 2
    base_x = math.floor(x)
    base_y = math.floor(y)
    for iy in range(base_y - reach, base_y + reach + 1):
        dy = max(iy - y, y - iy - 1, Decimal(0))
        for ix in range(base_x - reach, base_x + reach + 1):
            if (ix, iy) in cells:
                dx = max(ix - x, x - ix - 1, Decimal(0))
                if dx * dx + dy * dy < least:
                    return False
    return True
