"""Questions about still worlds as one call of C takes them, and the witnesses that come back."""

from __future__ import annotations

import functools
from fractions import Fraction
from typing import Any

import numpy as np

from worldgen._core import ffi
from worldgen.lattice import UNIT, exact
from worldgen.reach.lattice_graph import clear_from
from worldgen.reach.path import metres_per_unit, root_down, ticks_per_second, ticks_per_unit_sq
from worldgen.reach.walls import described_disc
from worldgen.world import Witness

__all__ = ["ROUNDING", "ask_still", "witness_of"]

ROUNDING = Fraction(1, 2**120)
"""Share of the radius by which a way to a pose that is no fraction may be too near."""


def ask_still(radius: Fraction, cell_size: float, speed: float) -> Any:
    """Return a question, without start and goal, for a disc of ``radius`` cells; None if a number is too large."""
    known = _numbers_of(radius, cell_size, speed)
    return None if known is None else ffi.new("WgStill *", known[0])


@functools.lru_cache(maxsize=256)
def _numbers_of(radius: Fraction, cell_size: float, speed: float) -> Any:
    made = ffi.new("WgStill *")
    ticks = ticks_per_second(cell_size, speed)
    try:
        made.clear_from = clear_from(radius, 4)
        made.disc = described_disc(radius)[0]
        made.goal_disc = described_disc(radius * (1 - ROUNDING))[0]
        made.pace = (*metres_per_unit(cell_size), *ticks_per_unit_sq(cell_size, speed, ticks), ticks)
    except OverflowError:
        return None
    return made if made.pace.metre_under < 2**53 and ticks < 2**53 else None


def witness_of(found: Any, cell_size: float) -> Witness:
    """Return the witness that an answer holds; it may be freed after that."""
    count, room = found.count, found.room
    floats = np.frombuffer(ffi.buffer(found.metres, 24 * room), np.float64)
    x, y, times = (floats[begin : begin + count] for begin in (0, room, 2 * room))
    corners: tuple[tuple[int, int], ...] = ()
    if found.corners:
        sides, lengths_sq = (ffi.unpack(found.points + part * room, found.corners) for part in (2, 3))
        corners = tuple(zip(sides, lengths_sq, strict=True))
    return Witness(times, x, y, _clearance(found.least, corners, cell_size))


@functools.lru_cache(maxsize=1024)
def _clearance(least: int, corners: tuple[tuple[int, int], ...], cell_size: float) -> float:
    """Return the clearance, m: the least of a square, and of those of distances from corners, lu."""
    square = min([Fraction(least), *(Fraction(side * side, length_sq) for side, length_sq in corners)])
    return root_down(square * (exact(cell_size) / UNIT) ** 2)
