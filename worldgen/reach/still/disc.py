"""The target's disc, and the poses that a cut separates from the start."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from worldgen._core import ffi, lib
from worldgen.lattice import UNIT, in_cells
from worldgen.reach.still.walls import ExactPoint, Number, Point
from worldgen.support.arrays import Ints
from worldgen.support.ccall import check, pointer
from worldgen.world import World

_HALF = UNIT // 2
_ROUNDED = Fraction(1, 2)
# Fraction of 1/1024 cell; C compares nothing finer.
_FINEST = 2**32


class Disc(NamedTuple):
    """Centre and radius, 1/1024 cell, exact."""

    x: Fraction
    y: Fraction
    radius: Fraction

    def holds(self, p: ExactPoint) -> bool:
        """Return True if a point is in the closed disc."""
        return (p[0] - self.x) ** 2 + (p[1] - self.y) ** 2 <= self.radius**2


def target_disc(world: World) -> Disc:
    """Return the target given by the world's decimals."""
    target = world.target
    return disc_of(target.x, target.y, target.radius, world.cell_size)


@functools.lru_cache(maxsize=1024)
def disc_of(x: float, y: float, radius: float, cell_size: float) -> Disc:
    """Return a target's disc; all in m."""
    return Disc(*(in_cells(value, cell_size) * UNIT for value in (x, y, radius)))


def lattice_centre(disc: Disc) -> Point | None:
    """Return the lattice pose nearest to a disc's centre, if it is in the disc; halves go up."""
    centre = (math.floor(disc.x + _ROUNDED), math.floor(disc.y + _ROUNDED))
    return centre if disc.holds(centre) else None


def beyond(chain: Ints, start: ExactPoint, disc: Disc) -> bool:
    """Return True if a chain separates a pose from a whole disc: its line avoids the disc."""
    winds, away = _around(chain, (disc.x, disc.y), disc.radius)
    return away and winds != winds_around(chain, start)


def winds_around(chain: Ints, pose: ExactPoint) -> bool:
    """Return True if a chain winds around a pose an odd number of times."""
    return _around(chain, pose, 0)[0]


def widest_gap_sq(chain: Ints) -> int:
    """Return the square of the widest gap between two neighbours of a closed chain, cells."""
    gap_sq: int = lib.wg_chain_gap_sq(pointer(ffi, chain, np.int64), len(chain))
    return gap_sq


def is_away(line: tuple[ExactPoint, ExactPoint], pose: ExactPoint, radius: Number) -> bool:
    """Return True if a segment is farther from a pose than a radius."""
    (px, py), (qx, qy) = line
    ex = qx - px
    ey = qy - py
    ux = pose[0] - px
    uy = pose[1] - py
    along = ex * ux + ey * uy
    length_sq = ex * ex + ey * ey
    if 0 < along < length_sq:
        return (ex * uy - ey * ux) ** 2 > radius**2 * length_sq
    return ux**2 + uy**2 > radius**2 < (pose[0] - qx) ** 2 + (pose[1] - qy) ** 2


def _around(chain: Ints, pose: ExactPoint, radius: Number) -> tuple[bool, bool]:
    """Return True if a chain winds an odd number of times around a pose, outside a radius."""
    scale = math.lcm(pose[0].denominator, pose[1].denominator)
    finer = math.lcm(scale, radius.denominator)
    fits = finer <= _FINEST
    scale = finer if fits else scale
    if scale <= _FINEST:
        x, y = (value.numerator * (scale // value.denominator) for value in pose)
        reach = radius.numerator * (scale // radius.denominator) if fits else -1
        winds = ffi.new("int64_t *")
        away = ffi.new("int64_t *")
        cells = pointer(ffi, chain, np.int64)
        rough = float(radius * scale)
        check(
            lib.wg_chain_around(cells, len(chain), _HALF * scale, x, y, reach, rough, winds, away)
        )
        if away[0] >= 0:
            return bool(winds[0]), bool(away[0])
    # These numbers are too large for C.
    lines = _chain_lines(chain)
    return _inside(lines, pose), all(is_away(line, pose, radius) for line in lines)


def _chain_lines(chain: Ints) -> list[tuple[Point, Point]]:
    """Return a chain as a closed line: each cell's centre, two closest points, the next centre."""
    half = _HALF
    corners: list[Point] = []
    cells = chain.tolist()
    for (ax, ay), (bx, by) in zip(cells, [*cells[1:], *cells[:1]], strict=True):
        sx = (bx > ax) - (bx < ax)
        sy = (by > ay) - (by < ay)
        centre = (UNIT * ax + half, UNIT * ay + half)
        corners += [
            centre,
            (centre[0] + half * sx, centre[1] + half * sy),
            (UNIT * bx + half - half * sx, UNIT * by + half - half * sy),
        ]
    return list(zip(corners, [*corners[1:], corners[0]], strict=True))


def _inside(lines: Sequence[tuple[Point, Point]], p: ExactPoint) -> bool:
    odd = False
    for (ax, ay), (bx, by) in lines:
        if (ax <= p[0]) != (bx <= p[0]):
            rise = (ay - p[1]) * (bx - ax) + (by - ay) * (p[0] - ax)
            odd ^= (rise > 0) == (bx > ax) and rise != 0
    return odd
