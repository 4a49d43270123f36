"""Confine a car that never reverses: prove that wherever it drives, it stays away from the target.

Poses are put into boxes of places and headings. In a step of fixed length, its heading changes by at
most the length divided by its turning radius; so from all poses of a box, the car gets into known
boxes of each heading, unless it is in a wall there or on the way. If no box that it gets into is near
the target, it never arrives. What boxes lose makes the car a little better than it is, and smaller
ones lose less.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from worldgen._core import ffi, lib
from worldgen.lattice import UNIT, in_cells
from worldgen.reach.decision import CarConfinement
from worldgen.support.arrays import Bools, Bytes, Floats, Ints
from worldgen.support.ccall import check, pointer, writable
from worldgen.world import World

# Boxes per turning radius and per turn, each tried if the one before proves nothing.
_SIZES = ((16, 64), (32, 128))
# Boxes per radius of the disc in the body, at least, so that those in walls are known.
_PER_RADIUS = 3
# Length of a step, turning radii.
_STEP = 0.5
# Limit on the boxes.
_MOST = 12_000_000
# Parts of a step after which the car must be where it has room.
_PARTS = 4
# Share of a step by which places are widened: more than legs of a simulated car differ from arcs.
_WIDER = 0.01
# Cells by which a simulated car may be off an arc, and what rounding adds to that.
_OFF = 1 / 40 + 1e-6
# Angle by which it may turn more than its way allows, rad; more than the checker grants.
_TURN = 5 * math.tau / 65_536
# Points of a step at which its directions are bounded, per part.
_POINTS = 16


def confine_car(world: World) -> CarConfinement | None:
    """Return a proof that the world's car, which never reverses, cannot arrive; None without one.

    Args:
        world: A world that does not change.
    """
    for per_radius, headings in _SIZES:
        question = _boxes_of(world, per_radius, headings)
        if question is None:
            return None
        reached = question.flooded()
        if reached is not None:
            size = world.cell_size
            return CarConfinement(question.side * size, question.step * size, reached)
    return None


@dataclass(frozen=True)
class _Boxes:
    """Boxes of poses in a world; lengths are in cells.

    Args:
        world: The world.
        turning: The turning radius.
        side: Side of a box.
        headings: Parts of a turn.
        step: Length of a step.
        is_free: (rows, columns) uint8, 0 where the car is certainly in a wall.
    """

    world: World
    turning: float
    side: float
    headings: int
    step: float
    is_free: Bytes

    def flooded(self) -> Bools | None:
        """Return the boxes that the car gets into; None if one of them is near the target."""
        rows, columns = self.is_free.shape
        reached = np.zeros((self.headings, rows, columns), np.uint8)
        reached[np.ix_(*self._start())] = 1
        near = self._near_target()
        if reached[:, near].any():
            return None
        places = np.where(near & (self.is_free != 0), lib.WG_CAR_AT_TARGET, self.is_free)
        places = np.ascontiguousarray(places, np.uint8)
        most_turn, steps = self._steps()
        asked = ffi.new(
            "WgCarFlood *",
            {
                "columns": columns,
                "rows": rows,
                "headings": self.headings,
                "most_turn": most_turn,
                "parts": _PARTS,
                "steps": pointer(ffi, steps, np.int32),
                "places": pointer(ffi, places, np.uint8),
            },
        )
        escapes = ffi.new("int64_t *")
        check(lib.wg_car_flood(asked, writable(ffi, reached, np.uint8), escapes))
        return None if escapes[0] else reached.astype(np.bool_)

    def _start(self) -> tuple[list[int], list[int], list[int]]:
        """Return headings, rows and columns of the boxes that the start may be in."""
        start = self.world.start
        size = self.world.cell_size
        part = math.remainder(start.heading, math.tau) / (math.tau / self.headings)
        kinds = []
        turn = _TURN / math.tau * self.headings
        place = 1.5 / UNIT / self.side
        for value, off in (
            (part + 0.5, turn),
            (start.y / size / self.side, place),
            (start.x / size / self.side, place),
        ):
            kinds.append(list(range(math.floor(value - off), math.floor(value + off) + 1)))
        rows, columns = self.is_free.shape
        return (
            sorted({k % self.headings for k in kinds[0]}),
            [k for k in kinds[1] if 0 <= k < rows],
            [k for k in kinds[2] if 0 <= k < columns],
        )

    def _near_target(self) -> Bools:
        target = self.world.target
        size = self.world.cell_size
        rows, columns = self.is_free.shape
        x = np.abs((np.arange(columns) + 0.5) * self.side - target.x / size)
        y = np.abs((np.arange(rows) + 0.5) * self.side - target.y / size)
        reach = target.radius / size + _OFF + (1.0 + _WIDER) * self.step + 0.75 * self.side
        near: Bools = np.hypot(x[None, :], y[:, None]) <= reach
        return near

    def _steps(self) -> tuple[int, Ints]:
        """Return the most headings by which a step turns, and where it gets: the core's table."""
        part = math.tau / self.headings
        most = math.floor((1.001 * self.step / self.turning + _TURN) / part) + 1
        middle = np.arange(self.headings)[:, None, None] * part
        turned = middle + np.arange(-most, most + 1)[None, :, None] * part
        # Directions between two points on the way, which both ends bound.
        points = np.arange(_PARTS * _POINTS) / (_PARTS * _POINTS)
        piece = self.step / (_PARTS * _POINTS)
        gone = (points * self.step + piece) * 1.001 / self.turning + _TURN
        left = (self.step - points * self.step) * 1.001 / self.turning + _TURN
        low = np.maximum(middle - gone, turned - left) - 0.5 * part
        high = np.minimum(middle + gone, turned + left) + 0.5 * part
        low, high = np.minimum(low, high), np.maximum(low, high)
        bounds = []
        for quarter in (0.0, math.pi / 2):
            bounds += [_least(low - quarter, high - quarter), _most(low - quarter, high - quarter)]
        # Places at the end of each part.
        found = []
        wider = _WIDER * self.step
        for k, bound in enumerate(bounds):
            sums = (bound * piece).cumsum(axis=2)[:, :, _POINTS - 1 :: _POINTS]
            if k % 2 == 0:
                found.append(np.floor((sums - wider) / self.side))
            else:
                found.append(np.floor((sums + wider) / self.side) + 1)
        return most, np.ascontiguousarray(np.stack(found, axis=3), np.int32)


def _most(low: Floats, high: Floats) -> Floats:
    """Return the largest cosine of an angle in a range."""
    wraps = np.floor(high / math.tau) * math.tau >= low
    found: Floats = np.where(wraps, 1.0, np.maximum(np.cos(low), np.cos(high)))
    return found


def _least(low: Floats, high: Floats) -> Floats:
    found: Floats = -_most(low - math.pi, high - math.pi)
    return found


def _boxes_of(world: World, per_radius: int, headings: int) -> _Boxes | None:
    """Return boxes of a size; None if there are too many, or the body holds no disc."""
    robot = world.robots[0]
    size = world.cell_size
    inner = float(in_cells(robot.inner_radius, size)) - _OFF
    if inner <= 0.0:
        return None
    turning = float(in_cells(robot.drive.turning_radius, size))
    side = min(turning / per_radius, inner / _PER_RADIUS)
    rows, columns = (math.ceil(cells / side) for cells in world.walls.shape)
    if rows * columns * headings > _MOST:
        return None
    is_free = _free_places(world.walls, side, (rows, columns), inner)
    return _Boxes(world, turning, side, headings, _STEP * turning, is_free)


def _free_places(walls: Bools, side: float, shape: tuple[int, int], radius: float) -> Bytes:
    """Return 0 for boxes at all places of which a disc overlaps the same solid cell."""
    is_free = np.ones(shape, np.uint8)
    ring = math.ceil(radius) + 1
    y = (np.arange(shape[0]) + 0.5) * side
    x = (np.arange(shape[1]) + 0.5) * side
    # From the middle of a box to its corner, and rounding.
    reach = radius - side * math.sqrt(0.5) - 1e-6
    if reach <= 0.0:
        return is_free
    for iy, ix in np.argwhere(np.pad(walls, ring, constant_values=True)) - ring:
        rows = slice(*np.searchsorted(y, (iy - reach, iy + 1 + reach)))
        columns = slice(*np.searchsorted(x, (ix - reach, ix + 1 + reach)))
        dy = np.maximum(np.maximum(iy - y[rows], y[rows] - iy - 1), 0.0)
        dx = np.maximum(np.maximum(ix - x[columns], x[columns] - ix - 1), 0.0)
        is_free[rows, columns][np.hypot(dx[None, :], dy[:, None]) < reach] = 0
    return is_free
