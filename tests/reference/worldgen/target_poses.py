"""The poses of a target's disc that decide for all of it, in fractions of any length.

It does the work of worldgen/core/still/target_poses.c without rounding anything.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from worldgen.lattice import UNIT
from worldgen.reach.still.cut import rim_cells
from worldgen.reach.still.disc import Disc, winds_around
from worldgen.reach.still.walls import Cell, ExactPoint, Walls
from worldgen.support.arrays import Bools, Floats, Ints

# Margin, cells; floats, whose error is far smaller, only select candidates for the exact test.
_SLACK = 1e-6

# Binary digits of a root: far finer than the distance of any clear pose from any cut.
_BITS = 160

# Corners of cells near the disc; with more, the disc is too large to examine each pose.
_MOST = 3_000

# The same limit for pairs of a pose and a cell.
_WORK = 100_000_000


class _ExactPose(NamedTuple):
    """The point (ax + bx * root, ay + by * root), root being the square root of ``square``.

    Lengths are in cells.
    """

    ax: Fraction
    ay: Fraction
    bx: Fraction = Fraction(0)
    by: Fraction = Fraction(0)
    square: Fraction = Fraction(0)


class _Edges(NamedTuple):
    """The parts of the edges of neighbourhoods.

    These are lines x = ..., lines y = ..., and circles around corners, in cells.
    """

    columns: list[Fraction]
    rows: list[Fraction]
    corners: list[Cell]


class PlainPoses(list[ExactPoint]):
    """Poses in fractions."""

    def first_unparted(self, chain: Ints, start: ExactPoint, begin: int = 0) -> int:
        odd = winds_around(chain, start)
        return next(
            (i for i in range(begin, len(self)) if winds_around(chain, self[i]) == odd), len(self)
        )


def plain_poses(walls: Walls, disc: Disc) -> PlainPoses | None:
    """Return the poses; None if there are too many to examine."""
    x = disc.x / UNIT
    y = disc.y / UNIT
    radius = disc.radius / UNIT
    edges = _edges(walls, float(x), float(y), float(radius))
    if len(edges.corners) > _MOST:
        return None
    poses = list(_candidates(edges, (x, y), walls.radius))
    at = np.array([_approximate(pose) for pose in poses])
    inside = np.sqrt(((at - (float(x), float(y))) ** 2).sum(axis=1)) <= float(radius) + _SLACK
    kept = np.flatnonzero(inside)
    if len(kept) * (2 * math.ceil(walls.radius) + 5) ** 2 > _WORK:
        return None
    kept = kept[_almost_clear(walls, at[kept])]
    exact = (poses[index] for index in kept.tolist())
    return PlainPoses(
        _point(pose) for pose in exact if _in_disc(pose, x, y, radius) and _is_clear(walls, pose)
    )


def _edges(walls: Walls, x: float, y: float, radius: float) -> _Edges:
    """Return the edges near a disc; cells whose neighbours are all solid add none."""
    iy, ix = np.nonzero(rim_cells(walls.solid))
    ix = ix - 1
    iy = iy - 1
    dx = np.maximum(np.maximum(ix - x, x - ix - 1), 0.0)
    dy = np.maximum(np.maximum(iy - y, y - iy - 1), 0.0)
    near = np.sqrt(dx * dx + dy * dy) <= radius + float(walls.radius) + _SLACK
    cells = list(zip(ix[near].tolist(), iy[near].tolist(), strict=True))
    reach = walls.radius
    return _Edges(
        sorted({line for ix, _ in cells for line in (ix - reach, ix + 1 + reach)}),
        sorted({line for _, iy in cells for line in (iy - reach, iy + 1 + reach)}),
        sorted({(ix + i, iy + j) for ix, iy in cells for i in (0, 1) for j in (0, 1)}),
    )


def _candidates(
    edges: _Edges, centre: tuple[Fraction, Fraction], radius: Fraction
) -> Iterator[_ExactPose]:
    """Yield the centre, its feet on the edges, and the intersections of edges.

    This includes points beyond the ends of edges.
    """
    x, y = centre
    yield _ExactPose(x, y)
    yield from (_ExactPose(x, row) for row in edges.rows)
    yield from (_ExactPose(column, y) for column in edges.columns)
    yield from (_ExactPose(column, row) for column in edges.columns for row in edges.rows)
    for qx, qy in edges.corners:
        if x != qx or y != qy:
            yield _on_ray(centre, (qx, qy), radius)
        for row in edges.rows:
            if (row - qy) ** 2 <= radius**2:
                yield from (_on_row((qx, qy), row, side, radius) for side in _SIDES)
        for column in edges.columns:
            if (column - qx) ** 2 <= radius**2:
                yield from (_on_column((qx, qy), column, side, radius) for side in _SIDES)
    yield from _between_corners(edges.corners, radius)


_SIDES = (1, -1)


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


def _between_corners(corners: list[Cell], radius: Fraction) -> Iterator[_ExactPose]:
    """Yield the points where the circles around two corners meet."""
    known = set(corners)
    widest_sq = math.floor(4 * radius**2)
    reach = math.isqrt(widest_sq)
    offsets = [
        (dx, dy)
        for dx, dy in itertools.product(range(reach + 1), range(-reach, reach + 1))
        if 0 < dx * dx + dy * dy <= widest_sq and (dx > 0 or dy > 0)
    ]
    for px, py in corners:
        for dx, dy in offsets:
            if (px + dx, py + dy) in known:
                yield from (_between((px, py), dx, dy, side, radius) for side in _SIDES)


def _approximate(pose: _ExactPose) -> tuple[float, float]:
    root = math.sqrt(pose.square)
    return float(pose.ax) + float(pose.bx) * root, float(pose.ay) + float(pose.by) * root


def _almost_clear(walls: Walls, at: Floats) -> Bools:
    """Return a (n,) bool array: True for points (n, 2) that are clear, or nearly, in floats."""
    reach = math.ceil(walls.radius) + 1
    limit = max(0.0, float(walls.radius) - _SLACK)
    pad = reach + 1
    solid = np.pad(walls.solid, pad, constant_values=True)
    inside = ((at >= 0.0) & (at <= (walls.width, walls.height))).all(axis=1)
    column, row = np.clip(np.floor(at), 0, (walls.width, walls.height)).astype(np.int64).T
    clear = np.asarray(inside)
    for dy, dx in itertools.product(range(-reach, reach + 1), repeat=2):
        there = solid[
            np.minimum(row + dy + pad, len(solid) - 1),
            np.minimum(column + dx + pad, solid.shape[1] - 1),
        ]
        across = np.maximum(np.maximum(column + dx - at[:, 0], at[:, 0] - column - dx - 1), 0.0)
        along = np.maximum(np.maximum(row + dy - at[:, 1], at[:, 1] - row - dy - 1), 0.0)
        clear = clear & ~(there & (across**2 + along**2 < limit**2))
    return clear


def _sign(whole: Fraction, factor: Fraction, square: Fraction) -> int:
    """Return the sign of whole + factor * sqrt(square), exactly."""
    a = (whole > 0) - (whole < 0)
    b = ((factor > 0) - (factor < 0)) * (square > 0)
    if a * b >= 0:
        return a or b
    larger = whole**2 - factor**2 * square
    return a * ((larger > 0) - (larger < 0))


def _in_disc(pose: _ExactPose, x: Fraction, y: Fraction, radius: Fraction) -> bool:
    return _compared(pose, (pose.ax - x, pose.bx), (pose.ay - y, pose.by), radius) <= 0


def _compared(
    pose: _ExactPose, dx: tuple[Fraction, Fraction], dy: tuple[Fraction, Fraction], radius: Fraction
) -> int:
    """Return the sign of dx**2 + dy**2 - radius**2, where each d is d[0] + d[1] * root."""
    whole = dx[0] ** 2 + dy[0] ** 2 + (dx[1] ** 2 + dy[1] ** 2) * pose.square - radius**2
    return _sign(whole, 2 * (dx[0] * dx[1] + dy[0] * dy[1]), pose.square)


def _is_clear(walls: Walls, pose: _ExactPose) -> bool:
    """Return True if a pose is at least the radius from every solid cell."""
    point = _point(pose)
    for ix, iy in walls.near(point, point, math.ceil(walls.radius * UNIT) + 1):
        dx = _beyond(pose.ax, pose.bx, pose.square, ix)
        dy = _beyond(pose.ay, pose.by, pose.square, iy)
        if _compared(pose, dx, dy, walls.radius) < 0:
            return False
    return True


def _beyond(
    whole: Fraction, factor: Fraction, square: Fraction, low: int
) -> tuple[Fraction, Fraction]:
    """Return how far a coordinate is from [low, low + 1], in the coordinate's own form."""
    if _sign(whole - low, factor, square) < 0:
        return low - whole, -factor
    if _sign(whole - low - 1, factor, square) > 0:
        return whole - low - 1, factor
    return Fraction(0), Fraction(0)


def _point(pose: _ExactPose) -> ExactPoint:
    """Return the pose, lu."""
    over = pose.square.denominator
    root = Fraction(math.isqrt(pose.square.numerator * over << (2 * _BITS)), over << _BITS)
    return (pose.ax + pose.bx * root) * UNIT, (pose.ay + pose.by * root) * UNIT
