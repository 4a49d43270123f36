"""Check a path of a footprint without any of the code that made it: shapely, numpy, plain Python.

The body is the polygon whose corners are the footprint's, rounded to 1/1024 cell; headings are those of
the lattice, 1/65536 turn. Lengths here are in cells.

A path is checked move by move and turn by turn. The body may overlap a wall by at most 1e-6 cells: its
corners are computed here by the angle, and elsewhere by a table of cosines with 30 bits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
import shapely

from worldgen.support.arrays import Bools, Floats, Ints
from worldgen.world import Robot, World

Shapes: TypeAlias = npt.NDArray[np.object_]

# Cells by which a body may overlap a wall on its path.
TOLERANCE = 1e-6
# Cells by which a path may begin next to the start: half a unit of the lattice, both ways.
LATTICE = 0.5 * math.sqrt(2.0) / 1024 + 1e-8
UNIT = 1024
TURN = 65536
RADIANS = 2.0 * math.pi / TURN


class Mistake(Exception):
    """Raised if a proof is invalid; the message gives the reason."""


@dataclass(frozen=True)
class Footprint:
    """A body in its own frame.

    Args:
        corners: (k, 2) float64, cells, counter-clockwise.
        outer: Distance of the farthest corner from the axle.
        inner: Radius of the largest disc about the axle that it holds; negative if the axle is
            outside.
    """

    corners: Floats
    outer: float
    inner: float

    def at(self, x: Floats, y: Floats, heading: Floats) -> Floats:
        """Return (n, k, 2) corners at poses."""
        c = np.cos(heading)[:, None]
        s = np.sin(heading)[:, None]
        cx, cy = self.corners.T
        return np.stack([x[:, None] + c * cx - s * cy, y[:, None] + s * cx + c * cy], axis=2)


def footprint_of(robot: Robot, cell_size: float) -> Footprint:
    """Return the body of a robot with a footprint, on the lattice."""
    size = Fraction(repr(float(cell_size)))
    corners = [
        tuple(_nearest(Fraction(repr(float(value))) / size * UNIT) for value in corner)
        for corner in robot.footprint
    ]
    hull = shapely.convex_hull(shapely.multipoints(corners))
    ring = np.array(shapely.get_coordinates(shapely.orient_polygons(hull))[:-1]) / UNIT
    ends = np.roll(ring, -1, axis=0)
    sides = ends - ring
    across = ring[:, 0] * ends[:, 1] - ring[:, 1] * ends[:, 0]
    inner = float((across / np.hypot(sides[:, 0], sides[:, 1])).min())
    return Footprint(ring, float(np.hypot(ring[:, 0], ring[:, 1]).max()), inner)


def shrunk(body: Footprint, inward: float) -> Footprint:
    """Return a body without what is nearer to its outline than a length, cells.

    Raises:
        Mistake: If one of its sides, or all of it, would be gone.
    """
    ends = np.roll(body.corners, -1, axis=0)
    sides = ends - body.corners
    sides /= np.hypot(sides[:, 0], sides[:, 1])[:, None]
    # Lines along the sides, moved inward; each corner is where two of them meet.
    normals = np.column_stack([sides[:, 1], -sides[:, 0]])
    offsets = (normals * body.corners).sum(axis=1) - inward
    before = np.roll(normals, 1, axis=0)
    across = before[:, 0] * normals[:, 1] - before[:, 1] * normals[:, 0]
    first = np.roll(offsets, 1)
    corners = np.column_stack(
        [
            (first * normals[:, 1] - offsets * before[:, 1]) / across,
            (offsets * before[:, 0] - first * normals[:, 0]) / across,
        ]
    )
    along = ((np.roll(corners, -1, axis=0) - corners) * sides).sum(axis=1)
    if not (along > 0.0).all():
        raise Mistake(
            f"a footprint that is {inward:.6g} cells smaller all around has no such sides"
        )
    outer = float(np.hypot(corners[:, 0], corners[:, 1]).max())
    return Footprint(corners, outer, body.inner - inward)


def _nearest(value: Fraction) -> int:
    units = math.floor(abs(value) + Fraction(1, 2))
    return units if value > 0 else -units


# Paths


@dataclass(frozen=True)
class BodyPath:
    """Poses of a path, cells and rad, (n,) each."""

    x: Floats
    y: Floats
    headings: Floats


@dataclass(frozen=True)
class BlockedSpans:
    """The times at which changing cells are blocked (solid or burning).

    Each lasts from ``begin`` until just before ``end``, s.
    """

    ix: Ints
    iy: Ints
    begin: Floats
    end: Floats


def check_ends(world: World, headings: Floats) -> None:
    """Check the first heading of a path, the last one, and that all are headings of the lattice.

    Raises:
        Mistake: If they aren't the start's and one of the target's, or one is not of the lattice.
    """
    apart = np.abs(headings / RADIANS - np.round(headings / RADIANS))
    if (apart > 1e-4).any():
        at = int(np.argmax(apart > 1e-4))
        raise Mistake(f"the heading of point {at} is not a multiple of 1/65536 turn")
    away = abs(float(_angle(headings[:1] - within_turn(world.start.heading))[0]))
    if away > 0.5 * RADIANS + 1e-9:
        raise Mistake(f"the witness starts {away:.3g} rad from the start's heading")
    target = world.target
    if target.heading is not None:
        off = abs(float(_angle(headings[-1:] - within_turn(target.heading))[0]))
        if off > target.heading_tolerance + 1e-9:
            raise Mistake(
                f"the witness ends {off:.3g} rad from the target's heading; the tolerance is "
                f"{target.heading_tolerance:g} rad"
            )


def body_clearance(world: World, path: BodyPath, claim: float) -> float:
    """Return a distance by which the body could be padded along its path, cells.

    It is at least the claim, less the tolerance.

    Args:
        world: The world; cells that are solid at any time count.
        path: Its poses.
        claim: The padding that the witness claims, cells.

    Raises:
        Mistake: If it cannot.
    """
    walls = _Walls(world.walls | world.changing_cells)
    return max(0.0, _clearance_of(world, path, claim, walls) - TOLERANCE)


def timed_body_clearance(
    world: World, path: BodyPath, times: Floats, spans: BlockedSpans, claim: float
) -> float:
    """Return the same for a path whose poses have times, among cells that are blocked at times.

    A cell counts for all of a move that takes place while it is blocked at some time.

    Args:
        world: The world.
        path: Its poses.
        times: (n,) s, when the body is there.
        spans: When cells are blocked.
        claim: As above.

    Raises:
        Mistake: If it cannot.
    """
    measured = _clearance_of(world, path, claim, _Walls(world.still_walls))
    boxes = shapely.box(spans.ix, spans.iy, spans.ix + 1, spans.iy + 1)
    for number in range(len(times) - 1):
        piece = slice(number, number + 2)
        part = BodyPath(path.x[piece], path.y[piece], path.headings[piece])
        during = (spans.begin <= times[number + 1]) & (spans.end > times[number])
        if during.any():
            measured = min(measured, _clearance_of(world, part, claim, _Walls.of(boxes[during])))
    return max(0.0, measured - TOLERANCE)


def _clearance_of(world: World, path: BodyPath, claim: float, walls: _Walls) -> float:
    body = footprint_of(world.robots[0], world.cell_size)
    turned = np.abs(_angle(np.diff(path.headings))) > 1e-9
    moved = np.hypot(np.diff(path.x), np.diff(path.y)) > 1e-9
    for number in np.flatnonzero(turned & moved).tolist():
        raise Mistake(f"the witness turns while it moves, after point {number}")
    # Moves: the hull of both ends, and of the only pose of a path without moves.
    ends = body.at(path.x, path.y, path.headings)
    pairs = np.concatenate([ends[:-1], ends[1:]], axis=1)[~turned] if len(ends) > 1 else ends
    measured = math.inf
    if len(pairs):
        distances = walls.distances(_hulls(pairs))
        at = int(np.argmin(distances))
        measured = float(distances[at])
        if not measured > 0.0 or measured < claim:
            raise Mistake(_too_near(measured, claim, "a move", pairs[at].mean(axis=0), world))
    for number in np.flatnonzero(turned).tolist():
        clear = _turn_clearance(
            walls,
            body,
            (path.x[number], path.y[number]),
            (path.headings[number], path.headings[number + 1]),
            claim,
            world,
        )
        measured = min(measured, clear)
    return measured


def _too_near(measured: float, claim: float, what: str, place: npt.ArrayLike, world: World) -> str:
    x, y = np.asarray(place) * world.cell_size
    if not measured > 0.0:
        return f"the body overlaps a wall in {what} near ({x:.6g}, {y:.6g}) m"
    return (
        f"the body comes within {measured * world.cell_size:.9g} m of a wall in {what} near "
        f"({x:.6g}, {y:.6g}) m; the witness claims {claim * world.cell_size:.9g} m"
    )


def within_turn(heading: float) -> float:
    """Return a heading within half a turn of 0, exactly; a difference from a huge one is not."""
    return math.remainder(heading, 2.0 * math.pi)


def _angle(difference: Floats) -> Floats:
    return (difference + math.pi) % (2.0 * math.pi) - math.pi


def _turn_clearance(
    walls: _Walls,
    body: Footprint,
    place: tuple[float, float],
    headings: tuple[float, float],
    claim: float,
    world: World,
) -> float:
    """Return a lower bound of the distance from the walls during a turn the shorter way.

    Every heading of the lattice is either tested, or so near to one that is tested that no corner
    moves farther than the distance found there.
    """
    begin, end = (round(heading / RADIANS) for heading in headings)
    turn = (end - begin + TURN // 2) % TURN - TURN // 2
    if turn == -TURN // 2:
        raise Mistake("half a turn can be made in two ways; the witness must say in which")
    first = np.array([min(begin, begin + turn)])
    last = np.array([max(begin, begin + turn)])
    measured = math.inf
    while len(first):
        middle = (first + last) // 2
        x, y = (np.full(len(middle), value) for value in place)
        distances = walls.distances(_hulls(body.at(x, y, middle * RADIANS)))
        near = float(distances.min())
        if not near > 0.0 or near < claim:
            raise Mistake(_too_near(near, claim, "a turn", place, world))
        swing = body.outer * RADIANS * np.maximum(middle - first, last - middle)
        bounds = distances - swing
        is_done = bounds >= max(claim, 0.0)
        measured = min([measured, *bounds[is_done].tolist(), near])
        left = ~is_done
        first, last = (
            np.concatenate([first[left], middle[left] + 1]),
            np.concatenate([middle[left] - 1, last[left]]),
        )
        some = first <= last
        first = first[some]
        last = last[some]
    return measured


def _hulls(points: Floats) -> Shapes:
    """Return the hulls of (n, k, 2) points, made smaller by the tolerance.

    What is thinner than that keeps its size, because nothing would be left of it to measure.
    """
    hulls = np.asarray(shapely.convex_hull(shapely.multipoints(points)))
    smaller = np.asarray(shapely.buffer(hulls, -TOLERANCE, join_style="mitre"))
    return np.where(shapely.is_empty(smaller), hulls, smaller)


class _Walls:
    """Solid cells as rectangles, and the outside.

    Args:
        solid: (height, width) bool.
    """

    def __init__(self, solid: Bools) -> None:
        height, width = solid.shape
        runs = np.diff(np.pad(solid, ((0, 0), (1, 1))).astype(np.int8), axis=1)
        iy, begin = np.nonzero(runs == 1)
        end = np.nonzero(runs == -1)[1]
        far = 1.0e4
        outside = [
            shapely.box(-far, -far, 0.0, height + far),
            shapely.box(width, -far, width + far, height + far),
            shapely.box(-far, -far, width + far, 0.0),
            shapely.box(-far, height, width + far, height + far),
        ]
        self._tree = shapely.STRtree([*shapely.box(begin, iy, end, iy + 1), *outside])

    @classmethod
    def of(cls, boxes: Shapes) -> _Walls:
        """Return some cells as walls, without the outside."""
        walls = cls.__new__(cls)
        walls._tree = shapely.STRtree(boxes)
        return walls

    def distances(self, shapes: Shapes) -> Floats:
        """Return the distance of each shape from the nearest solid cell; 0 if they overlap."""
        _, distances = self._tree.query_nearest(shapes, all_matches=False, return_distance=True)
        found: Floats = distances
        return found


# Cuts
