"""Check proofs about a footprint without any of the code that made them: shapely, numpy, Python.

The body is the polygon whose corners are the footprint's, rounded to 1/1024 cell; headings are those of
the lattice, 1/65536 turn. Lengths here are in cells.

A path is checked move by move and turn by turn. The body may overlap a wall by at most 1e-6 cells: its
corners are computed here by the angle, and elsewhere by a table of cosines with 30 bits.

A cut of poses is checked in two parts. In each of its boxes, one rectangle of wall must overlap the body
at every pose: that is tested at some headings, with a bound on what changes between them. And what the
boxes leave free must not connect the start with a pose of the target: that is a flood over the slabs of
headings between the boxes' bounds.
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
# Cells by which it must overlap one in a box of a cut: more than floats lose.
_OVERLAP = 1e-9
_UNIT = 1024
_TURN = 65536
_RADIANS = 2.0 * math.pi / _TURN
# Limit on the parts into which boxes are split.
_MOST_PARTS = 4_000_000


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
        tuple(_nearest(Fraction(repr(float(value))) / size * _UNIT) for value in corner)
        for corner in robot.footprint
    ]
    hull = shapely.convex_hull(shapely.multipoints(corners))
    ring = np.array(shapely.get_coordinates(shapely.orient_polygons(hull))[:-1]) / _UNIT
    ends = np.roll(ring, -1, axis=0)
    sides = ends - ring
    across = ring[:, 0] * ends[:, 1] - ring[:, 1] * ends[:, 0]
    inner = float((across / np.hypot(sides[:, 0], sides[:, 1])).min())
    return Footprint(ring, float(np.hypot(ring[:, 0], ring[:, 1]).max()), inner)


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


def check_ends(world: World, headings: Floats) -> None:
    """Check the first heading of a path, the last one, and that all are headings of the lattice.

    Raises:
        Mistake: If they aren't the start's and one of the target's, or one is not of the lattice.
    """
    apart = np.abs(headings / _RADIANS - np.round(headings / _RADIANS))
    if (apart > 1e-4).any():
        at = int(np.argmax(apart > 1e-4))
        raise Mistake(f"the heading of point {at} is not a multiple of 1/65536 turn")
    away = abs(float(_angle(headings[:1] - _within_turn(world.start.heading))[0]))
    if away > 0.5 * _RADIANS + 1e-9:
        raise Mistake(f"the witness starts {away:.3g} rad from the start's heading")
    target = world.target
    if target.heading is not None:
        off = abs(float(_angle(headings[-1:] - _within_turn(target.heading))[0]))
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
    body = footprint_of(world.robots[0], world.cell_size)
    walls = _Walls(world.walls | world.changing_cells)
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
    return max(0.0, measured - TOLERANCE)


def _too_near(measured: float, claim: float, what: str, place: npt.ArrayLike, world: World) -> str:
    x, y = np.asarray(place) * world.cell_size
    if not measured > 0.0:
        return f"the body overlaps a wall in {what} near ({x:.6g}, {y:.6g}) m"
    return (
        f"the body comes within {measured * world.cell_size:.9g} m of a wall in {what} near "
        f"({x:.6g}, {y:.6g}) m; the witness claims {claim * world.cell_size:.9g} m"
    )


def _within_turn(heading: float) -> float:
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
    begin, end = (round(heading / _RADIANS) for heading in headings)
    turn = (end - begin + _TURN // 2) % _TURN - _TURN // 2
    if turn == -_TURN // 2:
        raise Mistake("half a turn can be made in two ways; the witness must say in which")
    first = np.array([min(begin, begin + turn)])
    last = np.array([max(begin, begin + turn)])
    measured = math.inf
    while len(first):
        middle = (first + last) // 2
        x, y = (np.full(len(middle), value) for value in place)
        distances = walls.distances(_hulls(body.at(x, y, middle * _RADIANS)))
        near = float(distances.min())
        if not near > 0.0 or near < claim:
            raise Mistake(_too_near(near, claim, "a turn", place, world))
        swing = body.outer * _RADIANS * np.maximum(middle - first, last - middle)
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

    def distances(self, shapes: Shapes) -> Floats:
        """Return the distance of each shape from the nearest solid cell; 0 if they overlap."""
        _, distances = self._tree.query_nearest(shapes, all_matches=False, return_distance=True)
        found: Floats = distances
        return found


# Cuts


def check_boxes(world: World, rows: Ints) -> str:
    """Check a cut of poses; return a sentence about it.

    Args:
        world: The world; only cells that are always solid count.
        rows: (n, 6) as in :class:`worldgen.world.Cut`.

    Raises:
        Mistake: If it doesn't separate the start from the target.
    """
    # The numbers must be boxes.
    if not len(rows):
        raise Mistake("the cut has no cells and no boxes of poses")
    heading, span, side, y, begin, end = rows.T
    limit = rows.min() > -(2**31) and rows.max() < 2**31
    good = (heading >= 0) & (span >= 0) & (side >= 0) & (begin <= end)
    if not limit or not (good & (heading + span <= _TURN)).all():
        raise Mistake("a box of the cut is not one: it ends before it begins, or after a turn")
    body = footprint_of(world.robots[0], world.cell_size)
    boxes = _Boxes(
        heading,
        heading + span,
        np.stack([begin, y], axis=1) / _UNIT,
        np.stack([end, y + side], axis=1) / _UNIT,
    )
    # Every pose in them must overlap a wall.
    rectangles = _largest_rectangles(world.still_walls)
    clear = _first_clear(body, boxes, rectangles)
    if clear is not None:
        raise Mistake(
            f"box {clear} of the cut has poses at which no single rectangle of wall is known to "
            f"overlap the body"
        )
    # And there must be no way around them.
    start = _lattice_start(world)
    if boxes.hold(start):
        return "the body overlaps a wall at the start"
    _check_apart(world, body, boxes, start)
    return f"{len(rows)} boxes of poses separate the start from the target"


@dataclass(frozen=True)
class _Boxes:
    """Closed boxes of poses: headings, 1/65536 turn, and (n, 2) bounds of x and y, cells."""

    first: Ints
    last: Ints
    low: Floats
    high: Floats

    def hold(self, pose: tuple[float, float, int]) -> bool:
        """Return True if a pose is in one of them."""
        x, y, heading = pose
        place = np.array([x, y])
        inside = ((self.low <= place) & (place <= self.high)).all(axis=1)
        turned = (self.first <= heading) & (heading <= self.last)
        # A whole turn later it is the same heading.
        turned |= (self.first <= heading + _TURN) & (heading + _TURN <= self.last)
        return bool((inside & turned).any())


def _lattice_start(world: World) -> tuple[float, float, int]:
    """Return the start's place, cells, and heading, 1/65536 turn, on the lattice."""
    size = Fraction(repr(float(world.cell_size)))
    x, y = (
        math.floor(Fraction(repr(float(value))) / size * _UNIT + Fraction(1, 2)) / _UNIT
        for value in (world.start.x, world.start.y)
    )
    turns = math.fmod(world.start.heading, 2.0 * math.pi) / (2.0 * math.pi)
    return x, y, math.floor(turns * _TURN + 0.5) % _TURN


def _largest_rectangles(solid: Bools) -> Floats:
    """Return (n, 4) rectangles of solid cells: left, low, right, high; the outside reaches far.

    For each run of solid cells in a row, it is the rectangle that extends it up and down, and for
    each run in a column the one that extends it to both sides.
    """
    padded = np.pad(solid, 1, constant_values=True)
    found: set[tuple[int, int, int, int]] = set()
    for is_turned, cells in ((False, padded), (True, padded.T)):
        # How many solid cells follow each cell up, and down.
        up = np.zeros(cells.shape, np.int64)
        down = np.zeros(cells.shape, np.int64)
        run = np.zeros(cells.shape[1], np.int64)
        for row in range(cells.shape[0]):
            run = np.where(cells[row], run + 1, 0)
            down[row] = run
        run = np.zeros(cells.shape[1], np.int64)
        for row in reversed(range(cells.shape[0])):
            run = np.where(cells[row], run + 1, 0)
            up[row] = run
        steps = np.diff(np.pad(cells, ((0, 0), (1, 1))).astype(np.int8), axis=1)
        rows, begins = np.nonzero(steps == 1)
        ends = np.nonzero(steps == -1)[1]
        for row, begin, end in zip(rows.tolist(), begins.tolist(), ends.tolist(), strict=True):
            low = row + 1 - int(down[row, begin:end].min())
            high = row + int(up[row, begin:end].min())
            found.add((low, begin, high, end) if is_turned else (begin, low, end, high))
    rectangles = np.array(sorted(found), np.float64)
    # Back to the grid's cells; what reaches its rim reaches far beyond.
    far = 1.0e4
    height, width = padded.shape
    for column, side in ((0, width), (1, height)):
        rectangles[rectangles[:, column] == 0, column] = -far
        rectangles[rectangles[:, column + 2] == side, column + 2] = side + far
    bounds: Floats = rectangles - 1.0
    return bounds


@dataclass(frozen=True)
class _Parts:
    """Parts of boxes, and for each of them a rectangle that may overlap the body there.

    Args:
        box: (n,) number of the box.
        first: (n,) its first heading, 1/65536 turn.
        last: (n,) its last one.
        low: (n, 2) bounds of x and y, cells.
        high: (n, 2) the same.
        rate: (n,) how much an overlap changes at most for 1/65536 turn, cells.
        owner: (m,) ascending, the part of each pair of part and rectangle.
        rectangles: (m, 4) the rectangle of each pair, as far as the body reaches.
    """

    box: Ints
    first: Ints
    last: Ints
    low: Floats
    high: Floats
    rate: Floats
    owner: Ints
    rectangles: Floats

    def chosen(self, kept: Ints, pairs: Bools, first: Ints, last: Ints) -> _Parts:
        """Return some of the parts with other headings, and those of their pairs that are left.

        Args:
            kept: Numbers of the parts, which may repeat.
            pairs: (m,) True for pairs that still matter.
            first: Headings of the parts returned.
            last: The same.
        """
        begins = np.searchsorted(self.owner, kept)
        ends = np.searchsorted(self.owner, kept, side="right")
        counts = ends - begins
        owner = np.repeat(np.arange(len(kept)), counts)
        at = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        at += np.repeat(begins, counts)
        some = pairs[at]
        return _Parts(
            self.box[kept],
            first,
            last,
            self.low[kept],
            self.high[kept],
            self.rate[kept],
            owner[some],
            self.rectangles[at[some]],
        )


def _first_clear(body: Footprint, boxes: _Boxes, rectangles: Floats) -> int | None:
    """Return a box in which no rectangle surely overlaps the body at some pose; None if none is."""
    parts = _parts_of(body, boxes, rectangles)
    while len(parts.box):
        # The overlaps at the middle of each range of headings.
        middle = (parts.first + parts.last) // 2
        overlap = _overlap(body, parts, middle)
        most = np.full(len(parts.box), -np.inf)
        np.maximum.at(most, parts.owner, overlap)
        if (most <= _OVERLAP).any():
            return int(parts.box[np.argmax(most <= _OVERLAP)])
        # Where it is larger than what can be lost up to the ends, the same rectangle overlaps there.
        lost = parts.rate * np.maximum(middle - parts.first, parts.last - middle)
        left = np.flatnonzero(most <= lost + _OVERLAP)
        possible = overlap > -lost[parts.owner]
        first = np.concatenate([parts.first[left], middle[left] + 1])
        last = np.concatenate([middle[left] - 1, parts.last[left]])
        some = first <= last
        kept = np.concatenate([left, left])[some]
        parts = parts.chosen(kept, possible, first[some], last[some])
        if len(kept) > _MOST_PARTS:
            return int(parts.box[0])
    return None


def _parts_of(body: Footprint, boxes: _Boxes, rectangles: Floats) -> _Parts:
    """Split boxes that are long, for which the bound would be poor, and find what is near."""
    reach = body.outer
    # Bounds of parts, with a loop for the few boxes that are long.
    counts = np.maximum(1, np.ceil((boxes.high - boxes.low) / (2.0 * reach))).astype(np.int64)
    if counts.prod(axis=1, dtype=np.float64).sum() > _MOST_PARTS:
        raise Mistake("the boxes of the cut are too large to be checked")
    places = []
    for k in range(len(counts)):
        edges = [
            np.linspace(boxes.low[k, axis], boxes.high[k, axis], counts[k, axis] + 1)
            for axis in (0, 1)
        ]
        places += [
            (k, left, low, right, high)
            for left, right in zip(edges[0][:-1], edges[0][1:], strict=True)
            for low, high in zip(edges[1][:-1], edges[1][1:], strict=True)
        ]
    table = np.array(places)
    box = table[:, 0].astype(np.int64)
    low = table[:, 1:3]
    high = table[:, 3:5]
    owners = []
    near = []
    # Some thousand parts at a time, so that the table of pairs stays small.
    for begin in range(0, len(table), 4096):
        here = np.s_[begin : begin + 4096]
        clipped = np.concatenate(
            [
                np.maximum(rectangles[None, :, :2], low[here, None] - reach),
                np.minimum(rectangles[None, :, 2:], high[here, None] + reach),
            ],
            axis=2,
        )
        meets = (clipped[..., :2] < clipped[..., 2:]).all(axis=2)
        owners.append(np.nonzero(meets)[0] + begin)
        near.append(clipped[meets])
    # While the body turns, a point of it, or of the wall as seen from it, moves at most at this rate.
    rate = np.hypot(*(reach + high - low).T) * _RADIANS
    return _Parts(
        box,
        boxes.first[box],
        boxes.last[box],
        low,
        high,
        rate,
        np.concatenate(owners),
        np.concatenate(near),
    )


def _overlap(body: Footprint, parts: _Parts, headings: Ints) -> Floats:
    """Return (m,) by how much a pair's rectangle overlaps the body at each place of its part.

    It is the least over the directions in which they could be apart: those of the rectangle's sides,
    and of the body's. The overlap in each of them is linear along a line of places, so the four
    corners of a part stand for all of it.
    """
    zero = np.zeros(len(headings))
    corners = body.at(zero, zero, np.asarray(headings * _RADIANS, np.float64))
    sides = np.roll(corners, -1, axis=1) - corners
    normals = np.stack([sides[..., 1], -sides[..., 0]], axis=2)
    normals /= np.hypot(normals[..., 0], normals[..., 1])[..., None]
    out = (normals * corners).sum(axis=2)
    owner = parts.owner
    walls = parts.rectangles
    low = parts.low[owner]
    high = parts.high[owner]
    least = np.full(len(owner), np.inf)
    for axis in (0, 1):
        ahead = corners[..., axis].max(axis=1)[owner]
        behind = corners[..., axis].min(axis=1)[owner]
        least = np.minimum(least, low[:, axis] + ahead - walls[:, axis])
        least = np.minimum(least, walls[:, axis + 2] - high[:, axis] - behind)
    for side in range(corners.shape[1]):
        # The rectangle's corner that is farthest on the inner side, seen from the part's corner that
        # is farthest on the outer side of it.
        gap = np.zeros(len(owner))
        for axis in (0, 1):
            normal = normals[:, side, axis][owner]
            toward = np.where(
                normal > 0, walls[:, axis] - low[:, axis], walls[:, axis + 2] - high[:, axis]
            )
            gap += normal * toward
        least = np.minimum(least, out[:, side][owner] - gap)
    return least


@dataclass(frozen=True)
class _Slab:
    """What the boxes leave free in a range of headings.

    Args:
        x: Ascending bounds of columns, cells.
        y: Ascending bounds of rows.
        labels: (rows, columns), above 0 where free, the same where connected.
    """

    x: Floats
    y: Floats
    labels: npt.NDArray[np.int32]


def _check_apart(
    world: World, body: Footprint, boxes: _Boxes, start: tuple[float, float, int]
) -> None:
    """Flood what the boxes leave free, and refuse if the start is connected with the target."""
    # Imported here, because it takes longer than a whole check of other proofs.
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    # The axle is in the grid, unless it is outside the body.
    out = body.outer if body.inner < 0 else 0.0
    limits = np.array([[-out, -out], [world.width + out, world.height + out]])
    # Between two bounds of boxes, the same ones count. Heading 0 is a bound, so a slab ends there.
    bounds = np.unique(np.concatenate([boxes.first, boxes.last, [0, _TURN]]))
    slabs: list[_Slab] = []
    offset = 0
    starts: list[int] = []
    ends: list[int] = []
    links: list[Ints] = []
    goal = _goal_headings(world)
    for low, high in zip(bounds[:-1].tolist(), bounds[1:].tolist(), strict=True):
        active = (boxes.first <= low) & (high <= boxes.last)
        slab = _slab_of(boxes.low[active], boxes.high[active], limits)
        slab.labels[slab.labels > 0] += offset
        if low <= start[2] <= high or (start[2] == 0 and high == _TURN):
            starts += _labels_at(slab, start[0], start[1])
        if goal is None or _meets(goal, low, high):
            ends += _labels_near(slab, world)
        if slabs:
            links.append(_links(slabs[-1], slab))
        slabs.append(slab)
        offset = max(offset, int(slab.labels.max(initial=0)))
    links.append(_links(slabs[-1], slabs[0]))
    pairs = np.concatenate(links)
    shape = (offset + 1, offset + 1)
    graph = coo_matrix((np.ones(len(pairs), np.int8), (pairs[:, 0], pairs[:, 1])), shape=shape)
    _, component = connected_components(graph, directed=False)
    if not starts:
        raise Mistake("the start is not in the free space, and no box of the cut holds it")
    if set(component[starts].tolist()) & set(component[ends].tolist()):
        raise Mistake("the boxes of the cut leave a way from the start to the target")


def _slab_of(low: Floats, high: Floats, limits: Floats) -> _Slab:
    from scipy import ndimage

    bounds = []
    for axis in (0, 1):
        values = np.concatenate([low[:, axis], high[:, axis]])
        begin, end = limits[:, axis]
        values = values[(values > begin) & (values < end)]
        bounds.append(np.unique(np.concatenate([values, [begin, end]])))
    x, y = bounds
    # Sums of a raster with a mark at each corner of a box: above 0 where a box is.
    marks = np.zeros((len(y) + 1, len(x) + 1), np.int32)
    x0, x1 = (np.searchsorted(x, np.clip(v[:, 0], x[0], x[-1])) for v in (low, high))
    y0, y1 = (np.searchsorted(y, np.clip(v[:, 1], y[0], y[-1])) for v in (low, high))
    for rows, columns, sign in ((y0, x0, 1), (y0, x1, -1), (y1, x0, -1), (y1, x1, 1)):
        np.add.at(marks, (rows, columns), sign)
    covered = marks.cumsum(axis=0).cumsum(axis=1)[: len(y) - 1, : len(x) - 1] > 0
    labels, _ = ndimage.label(~covered)
    return _Slab(x, y, np.asarray(labels, np.int32))


def _labels_at(slab: _Slab, x: float, y: float) -> list[int]:
    """Return the labels of the free parts that hold a place, or touch it."""
    columns = np.flatnonzero((slab.x[:-1] <= x) & (x <= slab.x[1:]))
    rows = np.flatnonzero((slab.y[:-1] <= y) & (y <= slab.y[1:]))
    found = slab.labels[np.ix_(rows, columns)]
    return list(map(int, np.unique(found[found > 0])))


def _labels_near(slab: _Slab, world: World) -> list[int]:
    """Return the labels of the free parts that have a place of the target."""
    x, y = (value / world.cell_size for value in (world.target.x, world.target.y))
    off_x = np.maximum(np.maximum(slab.x[:-1] - x, x - slab.x[1:]), 0.0)
    off_y = np.maximum(np.maximum(slab.y[:-1] - y, y - slab.y[1:]), 0.0)
    near = np.hypot(off_x[None, :], off_y[:, None]) < world.target.radius / world.cell_size
    found = slab.labels[near & (slab.labels > 0)]
    return list(map(int, np.unique(found)))


def _links(a: _Slab, b: _Slab) -> Ints:
    """Return (n, 2) labels of free parts of two slabs that have a place in common."""
    x = np.unique(np.concatenate([a.x, b.x]))
    y = np.unique(np.concatenate([a.y, b.y]))
    both = []
    for slab in (a, b):
        columns = np.searchsorted(slab.x, x[:-1], side="right") - 1
        rows = np.searchsorted(slab.y, y[:-1], side="right") - 1
        both.append(slab.labels[np.ix_(rows, columns)].astype(np.int64))
    shared = (both[0] > 0) & (both[1] > 0)
    pairs = np.stack([both[0][shared], both[1][shared]], axis=1)
    return np.unique(pairs, axis=0)


def _goal_headings(world: World) -> tuple[float, float] | None:
    """Return the middle and half the range of the target's headings, 1/65536 turn; None for all."""
    target = world.target
    if target.heading is None or target.heading_tolerance >= math.pi:
        return None
    return _within_turn(target.heading) / _RADIANS, target.heading_tolerance / _RADIANS


def _meets(goal: tuple[float, float], low: int, high: int) -> bool:
    """Return True if a range of headings has one of the target's."""
    middle, reach = goal
    center = (low + high) / 2.0
    off = abs((middle - center + _TURN / 2) % _TURN - _TURN / 2)
    return off <= reach + (high - low) / 2.0 + 1e-6
