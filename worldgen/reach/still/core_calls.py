"""Convert queries about static worlds to single calls of C, and its answers to witnesses."""

from __future__ import annotations

import functools
from fractions import Fraction
from typing import Any

import numpy as np

from worldgen._core import ffi
from worldgen.lattice import UNIT, exact, in_cells
from worldgen.reach.still.cut import link_limit, refinement
from worldgen.reach.still.disc import disc_of, lattice_centre
from worldgen.reach.still.lattice_graph import clear_from
from worldgen.reach.still.path import (
    metres_per_unit,
    root_down,
    ticks_per_second,
    ticks_per_unit_sq,
)
from worldgen.reach.still.target_poses import described_target
from worldgen.reach.still.walls import ExactPoint, described_disc
from worldgen.world import Witness, World

_HALF = UNIT // 2
_LU = Fraction(1, UNIT)

ROUNDING = Fraction(1, 2**120)
"""Fraction of the radius by which a path to an irrational pose may be too close."""


def ask_still(world: World, radius: float, *, rounded: bool) -> Any:
    """Return a query about a world, without its start; None if a number has too many digits.

    Args:
        world: A static world.
        radius: Radius of the robot, m.
        rounded: True if the start will be a rounded one.
    """
    target = world.target
    place = (target.x, target.y, target.radius)
    known = _known(radius, world.cell_size, world.robot_speed, place, rounded)
    return None if known is None else ffi.new("WgStill *", known[0])


# Look it up by floats, because hashing a fraction takes ten times as long.
@functools.lru_cache(maxsize=1024)
def _known(
    radius: float, cell_size: float, speed: float, place: tuple[float, float, float], rounded: bool
) -> Any:
    cells = in_cells(radius, cell_size)
    disc = disc_of(*place, cell_size)
    known = _numbers_of(radius, cell_size, speed)
    target = described_target(cells, disc)
    if known is None:
        return None
    made = ffi.new("WgStill *", known[0])
    made.target = target[0]
    made.both = described_disc(cells + disc.radius / UNIT)[0]
    made.toward_x = round(disc.x / _HALF)
    made.toward_y = round(disc.y / _HALF)
    goal = lattice_centre(disc)
    if goal is not None:
        made.has_goal = 1
        made.goal_x, made.goal_y = goal
    if rounded:
        # Rounding moves a point by less than 1/1024 cell.
        made.start_disc = described_disc(cells + _LU)[0]
        made.start_core = described_disc(max(cells - _LU, Fraction(0)))[0]
    return made


@functools.lru_cache(maxsize=256)
def _numbers_of(metres: float, cell_size: float, speed: float) -> Any:
    radius = in_cells(metres, cell_size)
    made = ffi.new("WgStill *")
    ticks = ticks_per_second(cell_size, speed)
    try:
        made.clear_from = clear_from(radius, 4)
        made.limit = 0 if refinement(radius) else link_limit(radius)
        made.disc = described_disc(radius)[0]
        made.start_disc = made.start_core = made.disc
        made.goal_disc = described_disc(radius * (1 - ROUNDING))[0]
        made.pace = (
            *metres_per_unit(cell_size),
            *ticks_per_unit_sq(cell_size, speed, ticks),
            ticks,
        )
    except OverflowError:
        return None
    return made if made.pace.metre_under < 2**53 and ticks < 2**53 else None


def points_of(found: Any) -> list[ExactPoint]:
    """Return the corners of the path in an answer, lu."""
    x, y = (ffi.unpack(found.points + part * found.room, found.count) for part in (0, 1))
    return list(zip(x, y, strict=True))


def witness_of(found: Any, cell_size: float) -> Witness:
    """Return the witness in an answer, which may be freed afterwards."""
    count = found.count
    room = found.room
    floats = np.frombuffer(ffi.buffer(found.metres, 24 * room), np.float64)
    x, y, times = (floats[begin : begin + count] for begin in (0, room, 2 * room))
    corners: tuple[tuple[int, int], ...] = ()
    if found.corners:
        sides, lengths_sq = (
            ffi.unpack(found.points + part * room, found.corners) for part in (2, 3)
        )
        corners = tuple(zip(sides, lengths_sq, strict=True))
    return Witness(times, x, y, _clearance(found.least, corners, cell_size))


@functools.lru_cache(maxsize=1024)
def _clearance(least: int, corners: tuple[tuple[int, int], ...], cell_size: float) -> float:
    """Return the clearance, m.

    It is the smallest of a square and the squared distances from corners, lu.
    """
    square = min(
        [Fraction(least), *(Fraction(side * side, length_sq) for side, length_sq in corners)]
    )
    return root_down(square * (exact(cell_size) / UNIT) ** 2)
