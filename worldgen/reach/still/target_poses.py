"""Find finitely many clear poses of the target's disc that decide exactly for all of them.

Every connected part of the clear poses in the disc has a pose nearest to the disc's centre. That
pose is the centre itself, the foot of a perpendicular from it on the edge of one cell's
neighbourhood, or an intersection of the edges of two neighbourhoods
(docs/notes/reachability.md). Such edges are straight lines and arcs, so each coordinate is a
+ b * sqrt(m) with fractions a, b and m, and every comparison is exact. C computes them.
"""

from __future__ import annotations

import functools
import math
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from worldgen._core import ffi, lib
from worldgen.lattice import UNIT
from worldgen.reach.still.disc import Disc, winds_around
from worldgen.reach.still.walls import Cell, ExactPoint, Walls
from worldgen.support.arrays import Ints
from worldgen.support.ccall import check, kept, pointer

# Binary digits of a root: far finer than the distance of any clear pose from any cut.
_BITS = 160

# Parts of a cell, and lengths in these; larger values overflow in C.
_LONGEST = 2**61


class _ExactPose(NamedTuple):
    """The point (ax + bx * root, ay + by * root), root being the square root of ``square``.

    Lengths are in cells.
    """

    ax: Fraction
    ay: Fraction
    bx: Fraction = Fraction(0)
    by: Fraction = Fraction(0)
    square: Fraction = Fraction(0)


def deciding_poses(walls: Walls, disc: Disc) -> DecidingPoses | None:
    """Return the poses of a disc that decide for all of it.

    Return None if there are too many to examine, or lengths have too many digits.

    Args:
        walls: The walls with the robot's radius.
        disc: The target's disc.
    """
    target = described_target(walls.radius, disc)
    if not target.scale:
        return None
    made = ffi.new("WgPoses **")
    listed = ffi.new("WgListed *")
    check(lib.wg_poses_new(walls.described, target, made, listed))
    if listed[0] in (lib.WG_TOO_LONG, lib.WG_TOO_MANY):
        return None
    return DecidingPoses(made[0], target.scale, walls.radius, disc)


@functools.lru_cache(maxsize=1024)
def described_target(radius: Fraction, disc: Disc) -> Any:
    """Return a robot's radius, cells, and a target's disc in the form that C reads.

    The scale is 0 if they are too long.
    """
    x, y, reach = (value / UNIT for value in disc)
    floats = (float(x), float(y), float(radius), float(reach))
    made = ffi.new("WgTarget *", (0, 0, 0, 0, -1, *floats))
    for values in ((x, y, radius, reach), (x, y, radius)):
        scale = math.lcm(*(value.denominator for value in values))
        whole = [value.numerator * (scale // value.denominator) for value in values]
        if max(scale, *whole) < _LONGEST:
            # Without the last one, C takes the disc's radius as a float.
            made.x, made.y, made.reach, made.radius = (
                whole if len(whole) == len(floats) else (*whole, -1)
            )
            made.scale = scale
            break
    return made


class DecidingPoses:
    """Clear poses in a disc, held by C: at least one in each connected part of them."""

    def __init__(self, poses: Any, scale: int, radius: Fraction, disc: Disc) -> None:
        self._poses = kept(ffi, poses, free=lib.wg_poses_free)
        self._scale = scale
        self._radius = radius
        self._disc = disc

    def __len__(self) -> int:
        return int(lib.wg_poses_count(self._poses))

    def __getitem__(self, index: int) -> ExactPoint:
        """Return a pose, lu; the error of irrational coordinates is below 2**-140."""
        if not 0 <= index < len(self):
            raise IndexError(f"there are {len(self)} poses, and {index} is not one of them")
        found = ffi.new("WgPoseOf *")
        lib.wg_poses_describe(self._poses, index, found)
        return _point(self._pose(found))

    def first_unparted(self, chain: Ints, start: ExactPoint, begin: int = 0) -> int:
        """Return the first pose, counting from an index, that a chain fails to separate.

        Return the number of poses if there is none.
        """
        cells = pointer(ffi, chain, np.int64)
        return int(
            lib.wg_poses_next(self._poses, cells, len(chain), winds_around(chain, start), begin)
        )

    def _pose(self, found: Any) -> _ExactPose:
        """Return the pose in fractions of a cell."""
        corner = (found.x, found.y)
        if found.kind == lib.WG_PLAIN:
            return _ExactPose(Fraction(found.x, self._scale), Fraction(found.y, self._scale))
        if found.kind == lib.WG_ON_RAY:
            return _on_ray((self._disc.x / UNIT, self._disc.y / UNIT), corner, self._radius)
        if found.kind == lib.WG_BETWEEN:
            return _between(corner, found.dx, found.dy, found.side, self._radius)
        meet = _on_row if found.kind == lib.WG_ON_ROW else _on_column
        return meet(corner, Fraction(found.level, self._scale), found.side, self._radius)


def _on_ray(centre: tuple[Fraction, Fraction], corner: Cell, radius: Fraction) -> _ExactPose:
    """Return the point of the circle around a corner that is nearest to a centre."""
    qx, qy = corner
    dx = centre[0] - qx
    dy = centre[1] - qy
    away_sq = dx**2 + dy**2
    share = radius / away_sq
    return _ExactPose(Fraction(qx), Fraction(qy), share * dx, share * dy, away_sq)


def _on_row(corner: Cell, row: Fraction, side: int, radius: Fraction) -> _ExactPose:
    """Return where a line y = row meets the circle around a corner, on one side."""
    return _ExactPose(
        Fraction(corner[0]), row, Fraction(side), Fraction(0), radius**2 - (row - corner[1]) ** 2
    )


def _on_column(corner: Cell, column: Fraction, side: int, radius: Fraction) -> _ExactPose:
    """Return where a line x = column meets the circle around a corner, on one side."""
    return _ExactPose(
        column,
        Fraction(corner[1]),
        Fraction(0),
        Fraction(side),
        radius**2 - (column - corner[0]) ** 2,
    )


def _between(corner: Cell, dx: int, dy: int, side: int, radius: Fraction) -> _ExactPose:
    """Return where the circles around two corners meet, on one side."""
    square = radius**2 / (dx * dx + dy * dy) - Fraction(1, 4)
    middle = (corner[0] + Fraction(dx, 2), corner[1] + Fraction(dy, 2))
    return _ExactPose(*middle, Fraction(-dy * side), Fraction(dx * side), square)


def _point(pose: _ExactPose) -> ExactPoint:
    """Return the pose, lu."""
    over = pose.square.denominator
    root = Fraction(math.isqrt(pose.square.numerator * over << (2 * _BITS)), over << _BITS)
    return (pose.ax + pose.bx * root) * UNIT, (pose.ay + pose.by * root) * UNIT
