"""Turn a path over the graph into a witness: few points, exact clearance, valid times."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from worldgen._core import ffi, lib
from worldgen.lattice import UNIT, exact
from worldgen.reach.still.walls import ExactPoint, Number, Walls, segment_box_sq
from worldgen.support.arrays import Bytes, Ints
from worldgen.support.ccall import check, pointer, writable
from worldgen.world import Witness

# Limit on consecutive hidden corners before a straight line ends at the last one seen.
_PATIENCE = 6
# Limit on failed straight lines per path; lower for long paths.
_TESTS = 6_000


def merge_straight(points: list[ExactPoint]) -> list[ExactPoint]:
    """Remove repeated points and points in the middle of a straight line."""
    kept: list[ExactPoint] = []
    ux: Number
    uy: Number
    # The last step.
    ux = uy = 0
    # Keep a point only if it is new, and drop the one before if the direction is the same.
    for point in points:
        if not kept:
            kept.append(point)
            continue
        vx = point[0] - kept[-1][0]
        vy = point[1] - kept[-1][1]
        if not (vx or vy):
            continue
        while len(kept) > 1 and ux * vy == uy * vx and ux * vx + uy * vy > 0:
            kept.pop()
            vx = point[0] - kept[-1][0]
            vy = point[1] - kept[-1][1]
            if len(kept) > 1:
                ux = kept[-1][0] - kept[-2][0]
                uy = kept[-1][1] - kept[-2][1]
        kept.append(point)
        ux = vx
        uy = vy
    return kept


def shorten(walls: Walls, points: list[ExactPoint]) -> list[ExactPoint]:
    """Replace corners by straight lines that the disc may sweep.

    Args:
        walls: The walls with the disc's radius.
        points: The path, lu.
    """
    points = merge_straight(points)
    patience = max(1, min(_PATIENCE, _TESTS // len(points)))
    x, y, whole = _whole_points(points)
    state = np.array([0, 1, 2, 1, lib.WG_UNSURE])
    kept = np.zeros(len(points), np.int64)
    inputs = (
        walls.described,
        walls.disc,
        *_as_read(x, y),
        pointer(ffi, whole, np.uint8),
        len(points),
        patience,
    )
    outputs = (writable(ffi, state, np.int64), writable(ffi, kept, np.int64))
    done = ffi.new("int64_t *")
    while True:
        check(lib.wg_shorten(*inputs, *outputs, done))
        if done[0]:
            break
        # Only fractions can decide whether this piece is clear.
        state[4] = (
            lib.WG_CLEAR if walls.is_clear(points[state[0]], points[state[2]]) else lib.WG_MEETS
        )
    return merge_straight([points[index] for index in kept[: state[3]].tolist()])


def _as_read(x: Ints, y: Ints) -> tuple[Any, Any]:
    return pointer(ffi, x, np.int64), pointer(ffi, y, np.int64)


def _whole_points(points: Sequence[ExactPoint]) -> tuple[Ints, Ints, Bytes]:
    """Return both coordinates in lu, rounded down.

    Also return whether they are integers, so that nothing was lost.
    """
    whole = np.array([isinstance(x, int) and isinstance(y, int) for x, y in points], np.uint8)
    floors = list(points)
    # There are few such points: all others are nodes of a graph.
    for i in np.flatnonzero(whole == 0).tolist():
        floors[i] = (math.floor(points[i][0]), math.floor(points[i][1]))
    both = np.array(floors, np.int64)
    return np.ascontiguousarray(both[:, 0]), np.ascontiguousarray(both[:, 1]), whole


def clearance_sq(walls: Walls, points: Sequence[ExactPoint]) -> Fraction:
    """Return the squared distance from a path to the nearest solid cell, lu squared, exactly."""
    reach = 2 * math.ceil(walls.radius * UNIT)
    while True:
        best, pieces = _least_of_whole(walls, points, reach)
        for p, q in pieces:
            for cell in walls.near(p, q, math.isqrt(math.ceil(best)) + 1):
                distance, over = segment_box_sq(p, q, cell)
                if distance * best.denominator < best.numerator * over:
                    best = Fraction(distance) / over
        if best < reach * reach:
            return best
        reach *= 2


def _least_of_whole(
    walls: Walls, points: Sequence[ExactPoint], reach: int
) -> tuple[Fraction, list[tuple[ExactPoint, ExactPoint]]]:
    """Return the smallest squared distance, up to ``reach`` squared, and the omitted pieces."""
    if len(points) == 1:
        return Fraction(reach * reach), [(points[0], points[0])]
    x, y, whole = _whole_points(points)
    first = int(np.flatnonzero(whole[: len(points) // 2] == 0).max(initial=-1)) + 1
    last = first + int(whole[first:].argmin()) if not whole[first:].all() else len(points)
    odd = [
        (points[i], points[i + 1])
        for i in (*range(first), *range(max(first, last - 1), len(points) - 1))
    ]
    if last - first < 2:
        return Fraction(reach * reach), odd
    x = x[first:last]
    y = y[first:last]
    sides = np.empty(len(x), np.int64)
    lengths_sq = np.empty(len(x), np.int64)
    found = ffi.new("int64_t *")
    least = ffi.new("int64_t *")
    nearest = (writable(ffi, sides, np.int64), writable(ffi, lengths_sq, np.int64), found, least)
    check(lib.wg_sweep_least(walls.described, *_as_read(x, y), len(x), reach, *nearest))
    pairs = set(zip(sides[: found[0]].tolist(), lengths_sq[: found[0]].tolist(), strict=True))
    return min(
        [Fraction(least[0]), *(Fraction(side * side, length_sq) for side, length_sq in pairs)]
    ), odd


@functools.lru_cache(maxsize=1024)
def root_down(square: Fraction) -> float:
    """Return the largest float whose shortest decimal, squared, is at most ``square``."""
    shift = max(0, 128 - square.numerator.bit_length() + square.denominator.bit_length())
    # Compute 64 bits of the root, no matter how large it is.
    shift += shift % 2
    root = float(
        Fraction(math.isqrt((square.numerator << shift) // square.denominator), 1 << (shift // 2))
    )
    while exact(root) ** 2 > square:
        root = math.nextafter(root, 0.0)
    while exact(math.nextafter(root, math.inf)) ** 2 <= square:
        root = math.nextafter(root, math.inf)
    return root


def root_up(square: Fraction) -> float:
    """Return the smallest float whose shortest decimal, squared, is at least ``square``."""
    root = root_down(square)
    return root if exact(root) ** 2 == square else math.nextafter(root, math.inf)


def ticks_per_second(cell_size: float, speed: float) -> int:
    """Return the resolution of a path's times.

    It is a microsecond, or less if the robot crosses a cell in under 1 ms.
    """
    ticks = 10**6
    while cell_size / speed * ticks < 1000 and ticks < 10**12:
        ticks *= 10
    return ticks


def travel_ticks(p: ExactPoint, q: ExactPoint, cell_size: float, speed: float, ticks: int) -> int:
    """Return the smallest number of ticks in which the robot gets from p to q, exactly."""
    return _ticks(
        (q[0] - p[0]) ** 2 + (q[1] - p[1]) ** 2, *ticks_per_unit_sq(cell_size, speed, ticks)
    )


@functools.lru_cache(maxsize=256)
def ticks_per_unit_sq(cell_size: float, speed: float, ticks: int) -> tuple[int, int]:
    """Return the square of the ticks that 1/1024 cell takes, as a fraction."""
    per_unit = exact(cell_size) * ticks / (UNIT * exact(speed))
    return per_unit.numerator**2, per_unit.denominator**2


def _ticks(length_sq: Number, numerator: int, denominator: int) -> int:
    over = length_sq.numerator * numerator
    under = length_sq.denominator * denominator
    least = math.isqrt(over // under)
    return least if least * least * under >= over else least + 1


def make_witness(
    walls: Walls, points: Sequence[ExactPoint], cell_size: float, speed: float
) -> Witness:
    """Return the path at the robot's speed.

    Times are rounded up to ticks so that no piece is too fast.

    Args:
        walls: The walls with the disc's radius.
        points: The path, lu.
        cell_size: Side of a cell, m.
        speed: Top speed, m/s.
    """
    x, y = metres(points, cell_size)
    ticks = ticks_per_second(cell_size, speed)
    times = [0]
    per_unit_sq = ticks_per_unit_sq(cell_size, speed, ticks)
    # A long path has few different lengths, and fractions are slow.
    known: dict[Number, int] = {}
    for p, q in itertools.pairwise(points):
        length_sq = (q[0] - p[0]) ** 2 + (q[1] - p[1]) ** 2
        if length_sq not in known:
            known[length_sq] = _ticks(length_sq, *per_unit_sq)
        times.append(times[-1] + known[length_sq])
    clearance = root_down(clearance_sq(walls, points) * (exact(cell_size) / UNIT) ** 2)
    return Witness(np.array([time / ticks for time in times]), np.array(x), np.array(y), clearance)


def metres(points: Sequence[ExactPoint], cell_size: float) -> tuple[list[float], list[float]]:
    """Return the x and y of points in m, correctly rounded.

    Their shortest decimals are the ones to write.
    """
    over, under = metres_per_unit(cell_size)
    known = {
        value: value.numerator
        * over
        # Python's division of integers is correctly rounded.
        / (value.denominator * under)
        for value in {value for point in points for value in point}
    }
    return [known[p[0]] for p in points], [known[p[1]] for p in points]


@functools.lru_cache(maxsize=256)
def metres_per_unit(cell_size: float) -> tuple[int, int]:
    """Return the metres of 1/1024 cell, as a fraction."""
    scale = exact(cell_size) / UNIT
    return scale.numerator, scale.denominator
