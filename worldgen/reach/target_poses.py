"""The clear poses of the target's disc that decide for all of them: finitely many, each exact.

Every connected part of the clear poses in the disc has one that is nearest to the disc's centre. That one is the
centre itself, or the foot of a perpendicular from it on the edge of one cell's neighbourhood, or it lies on the edges
of two neighbourhoods at once (docs/reachability.md). Such edges are straight lines and arcs, so each coordinate is
a + b * sqrt(m) with fractions a, b and m, and every comparison is one of fractions.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from fractions import Fraction
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from worldgen.lattice import UNIT
from worldgen.reach.cut import rim_cells
from worldgen.reach.disc import Disc
from worldgen.reach.walls import Cell, ExactPoint, Walls

__all__ = ["deciding_poses"]

_SLACK = 1e-6  # cells; floats are wrong by far less where they choose what is looked at exactly
_BITS = 160  # after the point, of a root: far finer than the distance of any clear pose from any cut
_MOST = 3_000  # corners of cells near the disc; with more it is too large to look at each pose
_WORK = 100_000_000  # likewise, pairs of a pose and a cell

Floats: TypeAlias = npt.NDArray[np.float64]


class _Pose(NamedTuple):
    """The point (ax + bx * root, ay + by * root), root being the square root of ``square``; cells."""

    ax: Fraction
    ay: Fraction
    bx: Fraction = Fraction(0)
    by: Fraction = Fraction(0)
    square: Fraction = Fraction(0)


class _Edges(NamedTuple):
    """What the edges of neighbourhoods are made of: lines x = ..., lines y = ..., circles round corners; cells."""

    columns: list[Fraction]
    rows: list[Fraction]
    corners: list[Cell]


def deciding_poses(walls: Walls, disc: Disc) -> list[ExactPoint] | None:
    """Clear poses in a disc, at least one in each connected part of its clear poses.

    Args:
        walls: The walls with the robot's radius.
        disc: The target's disc.

    Returns:
        Points, lu; what is irrational is wrong by less than 2**-140. None if there is too much to look at.
    """
    x, y, radius = disc.x / UNIT, disc.y / UNIT, disc.radius / UNIT
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
    return list(
        dict.fromkeys(_point(pose) for pose in exact if _in_disc(pose, x, y, radius) and _is_clear(walls, pose))
    )


def _edges(walls: Walls, x: float, y: float, radius: float) -> _Edges:
    """The edges near a disc; cells all of whose neighbours are solid add none."""
    iy, ix = np.nonzero(rim_cells(walls.solid))
    ix, iy = ix - 1, iy - 1
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


def _candidates(edges: _Edges, centre: tuple[Fraction, Fraction], radius: Fraction) -> Iterator[_Pose]:
    """The centre, its feet on the edges, and where two edges meet; also points that lie beyond an edge's end."""
    x, y = centre
    yield _Pose(x, y)
    yield from (_Pose(x, row) for row in edges.rows)
    yield from (_Pose(column, y) for column in edges.columns)
    yield from (_Pose(column, row) for column in edges.columns for row in edges.rows)
    for qx, qy in edges.corners:
        away_sq = (x - qx) ** 2 + (y - qy) ** 2
        if away_sq:
            share = radius / away_sq
            yield _Pose(Fraction(qx), Fraction(qy), share * (x - qx), share * (y - qy), away_sq)
        for row in edges.rows:
            if (row - qy) ** 2 <= radius**2:
                yield from (_Pose(Fraction(qx), row, side, Fraction(0), radius**2 - (row - qy) ** 2) for side in _SIDES)
        for column in edges.columns:
            if (column - qx) ** 2 <= radius**2:
                yield from (
                    _Pose(column, Fraction(qy), Fraction(0), side, radius**2 - (column - qx) ** 2) for side in _SIDES
                )
    yield from _between_corners(edges.corners, radius)


_SIDES = (Fraction(1), Fraction(-1))


def _between_corners(corners: list[Cell], radius: Fraction) -> Iterator[_Pose]:
    """Where the circles round two corners meet."""
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
                square = radius**2 / (dx * dx + dy * dy) - Fraction(1, 4)
                middle = (px + Fraction(dx, 2), py + Fraction(dy, 2))
                yield from (_Pose(*middle, -dy * side, dx * side, square) for side in _SIDES)


def _approximate(pose: _Pose) -> tuple[float, float]:
    root = math.sqrt(pose.square)
    return float(pose.ax) + float(pose.bx) * root, float(pose.ay) + float(pose.by) * root


def _almost_clear(walls: Walls, at: Floats) -> npt.NDArray[np.bool_]:
    """(n,) whether points (n, 2) are clear, or nearly; in floats."""
    reach, limit = math.ceil(walls.radius) + 1, max(0.0, float(walls.radius) - _SLACK)
    pad = reach + 1
    solid = np.pad(walls.solid, pad, constant_values=True)
    inside = ((at >= 0.0) & (at <= (walls.width, walls.height))).all(axis=1)
    column, row = np.clip(np.floor(at), 0, (walls.width, walls.height)).astype(np.int64).T
    clear = np.asarray(inside)
    for dy, dx in itertools.product(range(-reach, reach + 1), repeat=2):
        there = solid[np.minimum(row + dy + pad, len(solid) - 1), np.minimum(column + dx + pad, solid.shape[1] - 1)]
        across = np.maximum(np.maximum(column + dx - at[:, 0], at[:, 0] - column - dx - 1), 0.0)
        along = np.maximum(np.maximum(row + dy - at[:, 1], at[:, 1] - row - dy - 1), 0.0)
        clear = clear & ~(there & (across**2 + along**2 < limit**2))
    return clear


def _sign(whole: Fraction, factor: Fraction, square: Fraction) -> int:
    """Sign of whole + factor * sqrt(square), exactly."""
    a, b = (whole > 0) - (whole < 0), ((factor > 0) - (factor < 0)) * (square > 0)
    if a * b >= 0:
        return a or b
    larger = whole**2 - factor**2 * square
    return a * ((larger > 0) - (larger < 0))


def _in_disc(pose: _Pose, x: Fraction, y: Fraction, radius: Fraction) -> bool:
    return _compared(pose, (pose.ax - x, pose.bx), (pose.ay - y, pose.by), radius) <= 0


def _compared(pose: _Pose, dx: tuple[Fraction, Fraction], dy: tuple[Fraction, Fraction], radius: Fraction) -> int:
    """Sign of dx**2 + dy**2 - radius**2, each d being d[0] + d[1] * root."""
    whole = dx[0] ** 2 + dy[0] ** 2 + (dx[1] ** 2 + dy[1] ** 2) * pose.square - radius**2
    return _sign(whole, 2 * (dx[0] * dx[1] + dy[0] * dy[1]), pose.square)


def _is_clear(walls: Walls, pose: _Pose) -> bool:
    """Whether a pose is at least the radius from every solid cell."""
    point = _point(pose)
    for ix, iy in walls.near(point, point, math.ceil(walls.radius * UNIT) + 1):
        dx, dy = _beyond(pose.ax, pose.bx, pose.square, ix), _beyond(pose.ay, pose.by, pose.square, iy)
        if _compared(pose, dx, dy, walls.radius) < 0:
            return False
    return True


def _beyond(whole: Fraction, factor: Fraction, square: Fraction, low: int) -> tuple[Fraction, Fraction]:
    """How far a coordinate is from the interval [low, low + 1]; as itself, it has a root."""
    if _sign(whole - low, factor, square) < 0:
        return low - whole, -factor
    if _sign(whole - low - 1, factor, square) > 0:
        return whole - low - 1, factor
    return Fraction(0), Fraction(0)


def _point(pose: _Pose) -> ExactPoint:
    """The pose, lu."""
    over = pose.square.denominator
    root = Fraction(math.isqrt(pose.square.numerator * over << (2 * _BITS)), over << _BITS)
    return (pose.ax + pose.bx * root) * UNIT, (pose.ay + pose.by * root) * UNIT
