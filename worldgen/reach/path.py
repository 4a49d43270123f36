"""From a path over the graph to a witness: few points, exact clearance, honest times."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from worldgen.lattice import UNIT, exact, lattice_to_metres
from worldgen.reach.walls import Point, Walls, segment_box_sq
from worldgen.world import Witness

__all__ = ["clearance_sq", "make_witness", "merge_straight", "root_down", "shorten", "tick_of"]

_LOOK_AHEAD = 32  # corners that one straight line may replace
_TESTS = 40_000  # straight lines tried on one path; long paths look ahead less


def merge_straight(points: list[Point]) -> list[Point]:
    """Leaves out repeated points and points in the middle of a straight line."""
    kept: list[Point] = []
    for point in points:
        if kept and point == kept[-1]:
            continue
        while len(kept) > 1 and _goes_on(kept[-2], kept[-1], point):
            kept.pop()
        kept.append(point)
    return kept


def _goes_on(a: Point, b: Point, c: Point) -> bool:
    ux, uy, vx, vy = b[0] - a[0], b[1] - a[1], c[0] - b[0], c[1] - b[1]
    return ux * vy == uy * vx and ux * vx + uy * vy > 0


def shorten(walls: Walls, points: list[Point]) -> list[Point]:
    """Replaces corners by straight lines that the disc may sweep."""
    points = merge_straight(points)
    ahead = min(_LOOK_AHEAD, max(2, _TESTS // max(1, len(points))))
    kept, at = [points[0]], 0
    while at < len(points) - 1:
        far = min(at + ahead, len(points) - 1)
        while far > at + 1 and not walls.is_clear(points[at], points[far]):
            far -= 1
        kept.append(points[far])
        at = far
    return merge_straight(kept)


def clearance_sq(walls: Walls, points: list[Point]) -> Fraction:
    """Squared distance from a path to the nearest solid cell, lu squared, exactly."""
    pieces = list(zip(points, points[1:], strict=False)) or [(points[0], points[0])]
    reach = 2 * math.ceil(walls.radius * UNIT)
    while True:
        best, over = reach * reach, 1
        for p, q in pieces:
            for cell in walls.near(p, q, math.isqrt(best // over) + 1):
                distance, under = segment_box_sq(p, q, cell)
                if distance * over < best * under:
                    best, over = distance, under
        if best * 1 < reach * reach * over:
            return Fraction(best, over)
        reach *= 2


def root_down(square: Fraction) -> float:
    """The largest float whose shortest decimal, squared, is at most ``square``."""
    root = math.sqrt(square)
    while exact(root) ** 2 > square:
        root = math.nextafter(root, 0.0)
    while exact(math.nextafter(root, math.inf)) ** 2 <= square:
        root = math.nextafter(root, math.inf)
    return root


def tick_of(cell_size: float, speed: float) -> int:
    """Ticks per second for the times of a path: microseconds, finer where a cell takes less than a ms."""
    ticks = 10**6
    while cell_size / speed * ticks < 1000 and ticks < 10**12:
        ticks *= 10
    return ticks


def make_witness(
    walls: Walls, points: list[Point], start: tuple[float, float], cell_size: float, speed: float
) -> Witness:
    """The path at the robot's speed, every time rounded up to a tick so that no piece is too fast.

    Args:
        walls: The walls with the disc's radius.
        points: The path, lu; its first point is the start's.
        start: The start as the world has it, m: nearer than half a lattice unit to the first point.
        cell_size: m.
        speed: m/s.
    """
    x = [lattice_to_metres(point[0], cell_size) for point in points]
    y = [lattice_to_metres(point[1], cell_size) for point in points]
    if (x[0], y[0]) != start:
        x.insert(0, start[0])
        y.insert(0, start[1])
    ticks = tick_of(cell_size, speed)
    times = [0]
    for i in range(1, len(x)):
        length = math.hypot(x[i] - x[i - 1], y[i] - y[i - 1]) * (1 + 1e-12)
        times.append(times[-1] + math.ceil(length / speed * ticks))
    clearance = root_down(clearance_sq(walls, points) * (exact(cell_size) / UNIT) ** 2)
    return Witness(np.array([time / ticks for time in times]), np.array(x), np.array(y), clearance)
