"""Ask the C core about a body: a convex polygon that turns about its axle."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from worldgen._core import ffi, lib
from worldgen.lattice import TURN, UNIT, exact, footprint_on_lattice
from worldgen.reach.still.disc import Disc
from worldgen.reach.still.walls import described_walls
from worldgen.robot import Corner
from worldgen.support.arrays import Bools, Ints
from worldgen.support.ccall import check, kept, pointer, writable

# lu by which a measured clearance may be below the real one.
_SLACK = 0.5
# lu by which a disc is widened or narrowed when its radius becomes a float.
_GRAIN = Fraction(1, 1000)


class BodyPose(NamedTuple):
    """A pose on the lattice: x and y in lu, heading in [0, 65536)."""

    x: int
    y: int
    heading: int


class Headings(NamedTuple):
    """Headings of the lattice: the first one, and how many follow counter-clockwise."""

    first: int
    following: int


ALL_HEADINGS = Headings(0, TURN - 1)


class BodyAnswer(NamedTuple):
    """The answer of the core.

    Args:
        outcome: A WgBodyOutcome.
        rows: (n, 3) int64, the poses of a path; or (n, 6), those of a cut; else empty.
        clearance: Lower bound of a path's clearance, lu.
        boxes: How many boxes of poses were made.
        finest: Shortest side, lu, and fewest headings of a box that was left undecided.
    """

    outcome: int
    rows: Ints
    clearance: float
    boxes: int
    finest: tuple[int, int]


class Body:
    """A body among solid cells, for exact questions.

    Args:
        solid: (height, width) bool, True is solid.
        footprint: Corners of the body, m.
        cell_size: Side of a cell, m.
    """

    def __init__(self, solid: Bools, footprint: tuple[Corner, ...], cell_size: float) -> None:
        self.solid = solid
        self.cell_size = cell_size
        self.corners = footprint_on_lattice(footprint, cell_size)
        self._walls = described_walls(solid)
        self._body = _described(footprint, cell_size)
        self._clear = ffi.new("int64_t *")

    @property
    def described(self) -> Any:
        """The body in the form that C reads, valid as long as this object."""
        return self._body

    @property
    def outer_sq(self) -> int:
        """Squared distance from the axle to the farthest corner, lu."""
        return int((self.corners**2).sum(axis=1).max())

    @property
    def inner(self) -> Fraction:
        """Radius of a disc about the axle that the body holds, lu; at most 0 if it holds none."""
        ends = np.roll(self.corners, -1, axis=0).tolist()
        nearest = Fraction(TURN * UNIT)
        for (ax, ay), (bx, by) in zip(self.corners.tolist(), ends, strict=True):
            across = ax * by - ay * bx
            length_sq = (bx - ax) ** 2 + (by - ay) ** 2
            # Rounded down, to a billionth.
            nearest = min(nearest, _root_down(across, length_sq))
        return nearest

    def disc(self, *, outer: bool) -> float:
        """Return the radius, m, of the disc that holds the body, or of one in it: 0 if it has none."""
        if outer:
            units = Fraction(math.isqrt(self.outer_sq * 10**12) + 1, 10**6) + _GRAIN
        else:
            units = max(self.inner - _GRAIN, Fraction(0))
        return float(units * exact(self.cell_size) / UNIT)

    def is_clear(self, pose: BodyPose) -> bool:
        """Return True if the body is clear at a pose."""
        check(lib.wg_body_is_clear(self._walls, self._body, [pose], self._clear))
        return bool(self._clear[0])

    def may_move(self, pose: BodyPose, x: int, y: int) -> bool:
        """Return True if it is clear on the straight line to (x, y), with its heading kept."""
        check(lib.wg_body_may_move(self._walls, self._body, [pose], x, y, self._clear))
        return bool(self._clear[0])

    def may_turn(self, pose: BodyPose, turn: int) -> bool:
        """Return True if it is clear at every heading of a turn on the spot, counter-clockwise."""
        check(lib.wg_body_may_turn(self._walls, self._body, [pose], turn, self._clear))
        return bool(self._clear[0])

    def clearance(self, poses: Sequence[BodyPose]) -> float:
        """Return a lower bound of a path's clearance, lu, less than 1 below it."""
        rows = np.array(poses, np.int64)
        least = ffi.new("double *")
        check(
            lib.wg_body_clearance(
                self._walls, self._body, pointer(ffi, rows, np.int64), len(rows), _SLACK, least
            )
        )
        return float(least[0])

    def search(
        self, start: BodyPose, target: Disc, headings: Headings, *, most_boxes: int, proof: bool
    ) -> BodyAnswer:
        """Decide whether the body gets from a pose to a target.

        Args:
            start: The pose.
            target: Places of the axle, lu.
            headings: Headings there.
            most_boxes: Limit on the boxes of poses.
            proof: True to return the path or the cut, too.
        """
        query = ffi.new(
            "WgBodyQuery *",
            {
                "start": start,
                "target_x": float(target.x),
                "target_y": float(target.y),
                "target_radius": float(target.radius),
                "from_heading": headings.first,
                "headings": headings.following,
                "most_boxes": most_boxes,
                "wants_proof": proof,
            },
        )
        check(lib.wg_body_decide(self._walls, self._body, query))
        try:
            columns = 3 if query.outcome == lib.WG_BODY_REACHED else 6
            numbers = ffi.unpack(query.rows, columns * query.count) if query.count else []
            rows = np.array(numbers, np.int64)
        finally:
            lib.wg_body_free(query)
        return BodyAnswer(
            query.outcome,
            rows.reshape(-1, columns),
            query.clearance,
            query.boxes,
            (query.finest_side, query.finest_turn),
        )


def cosines() -> Ints:
    """Return (65536,) int64, the cosines of all headings in units of 2^-30; read-only."""
    return _cosines()


@functools.cache
def _cosines() -> Ints:
    table = np.zeros(TURN, np.int64)
    lib.wg_body_cosines(writable(ffi, table, np.int64))
    table.flags.writeable = False
    return table


@functools.lru_cache(maxsize=256)
def _described(footprint: tuple[Corner, ...], cell_size: float) -> Any:
    corners = footprint_on_lattice(footprint, cell_size)
    table = _cosines()
    numbers = (pointer(ffi, corners, np.int64), len(corners), pointer(ffi, table, np.int64))
    return kept(ffi, ffi.new("WgBody *", numbers), corners, table)


def _root_down(value: int, length_sq: int) -> Fraction:
    """Return value / sqrt(length_sq), rounded down to a millionth."""
    scaled = value * abs(value) * 10**12 // length_sq
    if scaled < 0:
        return Fraction(-1)
    return Fraction(math.isqrt(scaled), 10**6)
