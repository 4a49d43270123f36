"""The target's disc, and what a cut parts from the start."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

from worldgen.lattice import UNIT, in_cells
from worldgen.reach.walls import Cell, ExactPoint, Point
from worldgen.world import World

__all__ = ["Disc", "beyond", "chain_lines", "parts", "target_disc"]


class Disc(NamedTuple):
    """Centre and radius, 1/1024 cell, exact."""

    x: Fraction
    y: Fraction
    radius: Fraction

    def holds(self, p: ExactPoint) -> bool:
        """Whether a point lies in the closed disc."""
        return (p[0] - self.x) ** 2 + (p[1] - self.y) ** 2 <= self.radius**2


def target_disc(world: World) -> Disc:
    """The target as the world's decimals say it."""
    target = world.target
    return _disc(target.x, target.y, target.radius, world.cell_size)


@functools.lru_cache(maxsize=1024)
def _disc(x: float, y: float, radius: float, cell_size: float) -> Disc:
    return Disc(*(in_cells(value, cell_size) * UNIT for value in (x, y, radius)))


def chain_lines(chain: Sequence[Cell]) -> list[tuple[Point, Point]]:
    """The closed line of a chain: each cell's centre, closest point, closest point, next centre."""
    half, corners = UNIT // 2, []
    for (ax, ay), (bx, by) in zip(chain, [*chain[1:], *chain[:1]], strict=True):
        sx, sy = (bx > ax) - (bx < ax), (by > ay) - (by < ay)
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


def parts(chain: Sequence[Cell], start: ExactPoint, pose: ExactPoint) -> bool:
    """Whether a chain winds round one of two poses an odd number of times, and round the other an even number."""
    lines = chain_lines(chain)
    return _inside(lines, start) != _inside(lines, pose)


def beyond(chain: Sequence[Cell], start: ExactPoint, disc: Disc) -> bool:
    """Whether a chain parts a pose from a whole disc, as its line keeps out of the disc."""
    # Whole numbers where they are whole, for fractions are slow.
    disc = Disc(*(value.numerator if value.denominator == 1 else value for value in disc))  # type: ignore[arg-type]
    centre = (disc.x, disc.y)
    return parts(chain, start, centre) and all(_away(line, disc) for line in chain_lines(chain))


def _away(line: tuple[Point, Point], disc: Disc) -> bool:
    """Whether a segment is farther from a disc's centre than its radius."""
    (px, py), (qx, qy) = line
    ex, ey, ux, uy = qx - px, qy - py, disc.x - px, disc.y - py
    along, length_sq = ex * ux + ey * uy, ex * ex + ey * ey
    if 0 < along < length_sq:
        return (ex * uy - ey * ux) ** 2 > disc.radius**2 * length_sq
    return not disc.holds((px, py)) and not disc.holds((qx, qy))
