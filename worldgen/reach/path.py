"""From a path over the graph to a witness: few points, exact clearance, honest times."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from worldgen.lattice import UNIT, exact
from worldgen.reach.walls import ExactPoint, Walls, segment_box_sq
from worldgen.world import Witness

__all__ = [
    "clearance_sq",
    "make_witness",
    "merge_straight",
    "metres",
    "root_down",
    "root_up",
    "shorten",
    "ticks_per_second",
]

_PATIENCE = 6  # corners in a row that may be out of sight before a straight line ends at the last one seen
_TESTS = 6_000  # straight lines that may fail on one path; on long paths there is less patience


def merge_straight(points: list[ExactPoint]) -> list[ExactPoint]:
    """Leaves out repeated points and points in the middle of a straight line."""
    kept: list[ExactPoint] = []
    for point in points:
        if kept and point == kept[-1]:
            continue
        while len(kept) > 1 and _goes_on(kept[-2], kept[-1], point):
            kept.pop()
        kept.append(point)
    return kept


def _goes_on(a: ExactPoint, b: ExactPoint, c: ExactPoint) -> bool:
    ux, uy, vx, vy = b[0] - a[0], b[1] - a[1], c[0] - b[0], c[1] - b[1]
    return ux * vy == uy * vx and ux * vx + uy * vy > 0


def shorten(walls: Walls, points: list[ExactPoint]) -> list[ExactPoint]:
    """Replaces corners by straight lines that the disc may sweep."""
    points = merge_straight(points)
    patience = max(1, min(_PATIENCE, _TESTS // len(points)))
    kept, at = [points[0]], 0
    while at < len(points) - 1:
        seen, far = at + 1, at + 2
        while far < len(points) and far <= seen + patience:
            if walls.is_clear(points[at], points[far]):
                seen = far
            far += 1
        kept.append(points[seen])
        at = seen
    return merge_straight(kept)


def clearance_sq(walls: Walls, points: Sequence[ExactPoint]) -> Fraction:
    """Squared distance from a path to the nearest solid cell, lu squared, exactly."""
    pieces = list(itertools.pairwise(points)) or [(points[0], points[0])]
    reach = 2 * math.ceil(walls.radius * UNIT)
    while True:
        best = Fraction(reach * reach)
        for p, q in pieces:
            for cell in walls.near(p, q, math.isqrt(math.ceil(best)) + 1):
                distance, over = segment_box_sq(p, q, cell)
                if distance * best.denominator < best.numerator * over:
                    best = Fraction(distance) / over
        if best < reach * reach:
            return best
        reach *= 2


def root_down(square: Fraction) -> float:
    """The largest float whose shortest decimal, squared, is at most ``square``."""
    shift = max(0, 128 - square.numerator.bit_length() + square.denominator.bit_length())
    shift += shift % 2  # 64 bits of the root, however small or large it is
    root = float(Fraction(math.isqrt((square.numerator << shift) // square.denominator), 1 << (shift // 2)))
    while exact(root) ** 2 > square:
        root = math.nextafter(root, 0.0)
    while exact(math.nextafter(root, math.inf)) ** 2 <= square:
        root = math.nextafter(root, math.inf)
    return root


def root_up(square: Fraction) -> float:
    """The smallest float whose shortest decimal, squared, is at least ``square``."""
    root = root_down(square)
    return root if exact(root) ** 2 == square else math.nextafter(root, math.inf)


def ticks_per_second(cell_size: float, speed: float) -> int:
    """Resolution of a path's times: microseconds, finer where the robot crosses a cell in less than 1 ms."""
    ticks = 10**6
    while cell_size / speed * ticks < 1000 and ticks < 10**12:
        ticks *= 10
    return ticks


def travel_ticks(p: ExactPoint, q: ExactPoint, cell_size: float, speed: float, ticks: int) -> int:
    """The least whole number of ticks in which the robot gets from p to q; exact."""
    per_unit = exact(cell_size) * ticks / (UNIT * exact(speed))
    square = ((q[0] - p[0]) ** 2 + (q[1] - p[1]) ** 2) * per_unit**2
    least = math.isqrt(math.floor(square))
    return least if least * least >= square else least + 1


def make_witness(walls: Walls, points: Sequence[ExactPoint], cell_size: float, speed: float) -> Witness:
    """The path at the robot's speed, each time rounded up to a tick so that no piece is too fast.

    Args:
        walls: The walls with the disc's radius.
        points: The path, lu.
        cell_size: m.
        speed: m/s.
    """
    x, y = metres(points, cell_size)
    ticks, times = ticks_per_second(cell_size, speed), [0]
    for p, q in itertools.pairwise(points):
        times.append(times[-1] + travel_ticks(p, q, cell_size, speed, ticks))
    clearance = root_down(clearance_sq(walls, points) * (exact(cell_size) / UNIT) ** 2)
    return Witness(np.array([time / ticks for time in times]), np.array(x), np.array(y), clearance)


def metres(points: Sequence[ExactPoint], cell_size: float) -> tuple[list[float], list[float]]:
    """The x and y of points in m, correctly rounded: their shortest decimals are the ones to write."""
    scale = exact(cell_size) / UNIT
    return [float(p[0] * scale) for p in points], [float(p[1] * scale) for p in points]
