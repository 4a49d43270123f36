"""The pose lattice: positions in 1/1024 of a cell, headings in 1/65536 of a turn.

A number in a file means its shortest decimal: 0.07 is 7/100, not the nearest binary fraction. So
0.35 m in 0.1 m cells is exactly cell 3.5, and "is this disc clear" can be an exact integer test.
"""

from __future__ import annotations

import functools
import math
from fractions import Fraction

import numpy as np

from worldgen.errors import InvalidWorld
from worldgen.robot import Corner
from worldgen.support.arrays import Ints
from worldgen.world import World

# Lattice units per cell.
UNIT = 1024
# Heading units per turn.
TURN = 65536
# To 50 digits, so that no angle with a short decimal is rounded to another heading unit.
_PI = Fraction("3.14159265358979323846264338327950288419716939937510")


# A search requests the same few numbers 24 times per run, which took 0.14 of its 0.21 ms.
@functools.lru_cache(maxsize=4096)
def exact(value: float) -> Fraction:
    """Return the number given by its shortest decimal."""
    return Fraction(repr(float(value)))


@functools.lru_cache(maxsize=4096)
def in_cells(metres: float, cell_size: float) -> Fraction:
    """Return a length in cells, exactly."""
    return exact(metres) / exact(cell_size)


def radius_in_cells(world: World) -> Fraction:
    """Return the robot's radius in cells, exactly."""
    return in_cells(world.robot_radius, world.cell_size)


@functools.lru_cache(maxsize=4096)
def lattice_units(metres: float, cell_size: float) -> int | Fraction:
    """Return a length in lattice units, exactly.

    The result is an int if it is whole, because fractions are slow.
    """
    units = in_cells(metres, cell_size) * UNIT
    return units.numerator if units.denominator == 1 else units


@functools.lru_cache(maxsize=4096)
def metres_to_lattice(metres: float, cell_size: float) -> int:
    """Return the nearest lattice coordinate; halves go up."""
    return math.floor(in_cells(metres, cell_size) * UNIT + Fraction(1, 2))


def lattice_to_metres(units: int, cell_size: float) -> float:
    """Return the coordinate in m, correctly rounded: its shortest decimal is the one to write."""
    return float(Fraction(units, UNIT) * exact(cell_size))


def cell_middle(index: int, cell_size: float) -> float:
    """Return the middle of a column or row of cells, m, correctly rounded."""
    return lattice_to_metres(int(index) * UNIT + UNIT // 2, cell_size)


@functools.lru_cache(maxsize=256)
def footprint_on_lattice(footprint: tuple[Corner, ...], cell_size: float) -> Ints:
    """Return the body of a robot with a footprint: a convex polygon with corners on the lattice.

    Every corner is rounded to the nearest unit, halves away from zero; the hull of these is the
    body.

    Args:
        footprint: Corners, m, in the robot's frame.
        cell_size: Side of a cell, m.

    Returns:
        (k, 2) int64, lattice units, counter-clockwise and strictly convex. It is read-only.

    Raises:
        InvalidWorld: If it is so small that no area is left.
    """
    corners = sorted(
        {(_nearest_unit(x, cell_size), _nearest_unit(y, cell_size)) for x, y in footprint}
    )
    hull = _half_hull(corners)[:-1] + _half_hull(corners[::-1])[:-1]
    if len(hull) < 3:
        raise InvalidWorld(
            "wrong-footprint",
            "footprint is thinner than 1/1024 of a cell of {cell_size:g} m",
            "use smaller cells, or a larger footprint",
            cell_size=cell_size,
        )
    body = np.array(hull, np.int64)
    body.flags.writeable = False
    return body


def _nearest_unit(metres: float, cell_size: float) -> int:
    units = math.floor(in_cells(abs(metres), cell_size) * UNIT + Fraction(1, 2))
    return units if metres > 0 else -units


def _half_hull(points: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Return the lower half of the hull of sorted points, or the upper half of reversed ones.

    Source: Andrew, Another efficient algorithm for convex hulls in two dimensions (1979).
    """
    hull: list[tuple[int, int]] = []
    for x, y in points:
        while len(hull) > 1:
            (ax, ay), (bx, by) = hull[-2:]
            if (bx - ax) * (y - by) - (by - ay) * (x - bx) > 0:
                break
            hull.pop()
        hull.append((x, y))
    return hull


@functools.lru_cache(maxsize=256)
def clear_distance_sq(radius: Fraction) -> int:
    """Return the smallest squared distance, lu, at which a disc of ``radius`` cells is clear.

    A pose is clear if its squared distance to every solid cell, an integer, is at least this. For a
    lattice pose the test is exact; the result is at least 1, because even a point robot may not
    enter a wall.
    """
    return max(1, math.ceil((radius * UNIT) ** 2))


def heading_to_lattice(heading: float) -> int:
    """Convert radians to heading units in [0, 65536), nearest."""
    return math.floor(math.fmod(heading, 2.0 * math.pi) * (TURN / (2.0 * math.pi)) + 0.5) % TURN


def turn_to_lattice(turn: float | Fraction) -> int:
    """Return the most whole heading units that a turn of this many radians, 0 or more, has."""
    return math.floor((turn if isinstance(turn, Fraction) else exact(turn)) * TURN / (2 * _PI))


def heading_from_lattice(units: int) -> float:
    """Convert heading units to radians in (-pi, pi]."""
    units = units % TURN
    return (units - TURN if units > TURN // 2 else units) * (2.0 * math.pi / TURN)
