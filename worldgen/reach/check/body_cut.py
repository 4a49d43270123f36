"""Check a cut of poses without any of the code that made it: numpy, scipy, plain Python.

In each of its boxes, one rectangle of wall must overlap the body at every pose: that is tested at some
headings, with a bound on what changes between them. And what the boxes leave free must not connect the
start with a pose of the target: that is a flood over the slabs of headings between the boxes' bounds.
Lengths are in cells, as in `worldgen.reach.check.body`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from worldgen.reach.check.body import (
    RADIANS,
    TURN,
    UNIT,
    Footprint,
    Mistake,
    footprint_of,
    shrunk,
    within_turn,
)
from worldgen.support.arrays import Bools, Floats, Ints
from worldgen.world import World

# Cells by which the body must overlap a wall in a box: more than floats lose.
_OVERLAP = 1e-9
# Limit on the parts into which boxes are split.
_MOST_PARTS = 4_000_000


def check_boxes(world: World, rows: Ints, clearance: float = 0.0) -> str:
    """Check a cut of poses; return a sentence about it.

    Args:
        world: The world; only cells that are always solid count.
        rows: (n, 6) as in :class:`worldgen.world.Cut`.
        clearance: As there, m.

    Raises:
        Mistake: If it doesn't separate the start from the target.
    """
    # The numbers must be boxes.
    if not len(rows):
        raise Mistake("the cut has no cells and no boxes of poses")
    heading, span, side, y, begin, end = rows.T
    limit = rows.min() > -(2**31) and rows.max() < 2**31
    good = (heading >= 0) & (span >= 0) & (side >= 0) & (begin <= end)
    if not limit or not (good & (heading + span <= TURN)).all():
        raise Mistake("a box of the cut is not one: it ends before it begins, or after a turn")
    body = footprint_of(world.robots[0], world.cell_size)
    boxes = _Boxes(
        heading,
        heading + span,
        np.stack([begin, y], axis=1) / UNIT,
        np.stack([end, y + side], axis=1) / UNIT,
    )
    # Every pose in them must overlap a wall, and so must what is inside of the body by the clearance.
    rectangles = _largest_rectangles(world.still_walls)
    if not 0.0 <= clearance < math.inf:
        raise Mistake(f"the cut claims to stop footprints that are {clearance} m smaller")
    smaller = shrunk(body, clearance / world.cell_size) if clearance else body
    clear = _first_clear(smaller, boxes, rectangles)
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
    also = f"; they also stop a footprint {clearance:.4g} m smaller all around" if clearance else ""
    return f"{len(rows)} boxes of poses separate the start from the target{also}"


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
        turned |= (self.first <= heading + TURN) & (heading + TURN <= self.last)
        return bool((inside & turned).any())


def _lattice_start(world: World) -> tuple[float, float, int]:
    """Return the start's place, cells, and heading, 1/65536 turn, on the lattice."""
    size = Fraction(repr(float(world.cell_size)))
    x, y = (
        math.floor(Fraction(repr(float(value))) / size * UNIT + Fraction(1, 2)) / UNIT
        for value in (world.start.x, world.start.y)
    )
    turns = math.fmod(world.start.heading, 2.0 * math.pi) / (2.0 * math.pi)
    return x, y, math.floor(turns * TURN + 0.5) % TURN


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
    rate = np.hypot(*(reach + high - low).T) * RADIANS
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
    corners = body.at(zero, zero, np.asarray(headings * RADIANS, np.float64))
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
    bounds = np.unique(np.concatenate([boxes.first, boxes.last, [0, TURN]]))
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
        if low <= start[2] <= high or (start[2] == 0 and high == TURN):
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
    return within_turn(target.heading) / RADIANS, target.heading_tolerance / RADIANS


def _meets(goal: tuple[float, float], low: int, high: int) -> bool:
    """Return True if a range of headings has one of the target's."""
    middle, reach = goal
    center = (low + high) / 2.0
    off = abs((middle - center + TURN / 2) % TURN - TURN / 2)
    return off <= reach + (high - low) / 2.0 + 1e-6
