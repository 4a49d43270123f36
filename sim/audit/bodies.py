"""Scan a trajectory of poses for places where a body that is not a disc must not be.

Lengths are in cells. Between two poses the robot either drives straight and turns on the spot, at
the one of the two places where it has more room, or it drives an arc: speed, turn rate and the
direction of travel in its own frame stay the same.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from sim.audit.path import AuditPath, chord_to, longer_by, shorter_turn
from sim.audit.polygon import Body, box_corners, deepest_on_segments, distances, separations, turned
from sim.audit.scan import Hits, Scan, merged
from worldgen.lattice import TURN
from worldgen.support.arrays import Bools, Floats, Indices, Ints
from worldgen.timeline import CellState
from worldgen.world import World

# Pairs of a leg and a box that are worked on at once, to limit memory.
_PAIRS_AT_ONCE = 200_000

# Cells beyond the body in which boxes are measured, so that a small clearance is found.
_MARGIN = 0.25

# Cells. Overlaps up to this are rounding errors.
_CLOSE_CALL = 1e-9

# rad; the simulator's headings are this far apart, and turns are not judged finer.
_HEADING_STEP = 2.0 * math.pi / TURN

# Share of the radius of the largest disc in the body, up to which a cut between two clear poses is
# not counted: the height of an arc over a chord as long as its radius, as for discs.
_SHAVED = 0.134


@dataclass(frozen=True)
class Legs:
    """Parts of the robot's motion, (n,) each: straight ahead, turns on the spot, or arcs.

    Args:
        x: Where the origin begins, cells.
        y: The same.
        dx: How far it goes, cells.
        dy: The same.
        heading: At the beginning, rad.
        turn: By how much it turns, rad.
        since: When it begins, s.
        until: When it ends, s.
        move: Number of the move from sample to sample of which it is a part.
        low: Share of the move at which it begins.
        high: Share of the move at which it ends.
    """

    x: Floats
    y: Floats
    dx: Floats
    dy: Floats
    heading: Floats
    turn: Floats
    since: Floats
    until: Floats
    move: Indices
    low: Floats
    high: Floats

    def take(self, rows: Indices | Bools) -> Legs:
        """Return some of the legs."""
        return Legs(*(value[rows] for value in vars(self).values()))

    def between(self, low: Floats, high: Floats) -> Legs:
        """Return the stretch of each leg between two shares of it."""
        begin, heading = self.pose(low)
        end, _ = self.pose(high)
        (dx, dy) = (end - begin).T
        span = high - low
        return replace(
            self, x=begin[:, 0], y=begin[:, 1], dx=dx, dy=dy, heading=heading, turn=span * self.turn
        )

    def followed_by(self, other: Legs) -> Legs:
        """Return these legs and the others, in one record."""
        both = zip(vars(self).values(), vars(other).values(), strict=True)
        return Legs(*map(np.concatenate, both))

    def pose(self, share: Floats) -> tuple[Floats, Floats]:
        """Return places (n, 2) and headings (n,) at these shares of the legs."""
        length, angle = chord_to(share, 0.5 * self.turn)
        chord = turned(np.column_stack((self.dx, self.dy)), angle)
        place = np.column_stack((self.x, self.y)) + length[:, None] * chord
        return place, self.heading + share * self.turn

    @property
    def length(self) -> Floats:
        """(n,) Length of the origin's path, cells."""
        length: Floats = np.hypot(self.dx, self.dy) * longer_by(0.5 * self.turn)
        return length


@dataclass(frozen=True)
class Near:
    """Pairs of a leg and a box of blocked cells near it, (n,) each.

    Args:
        leg: Row of the leg.
        box: (n, 4) Left, low, right and high side.
        burning: Whether it burns.
        low: Share of the leg from which on it is there.
        high: Share of the leg up to which it is there.
    """

    leg: Indices
    box: Floats
    burning: Bools
    low: Floats
    high: Floats

    def take(self, rows: Indices | Bools) -> Near:
        """Return some of the pairs."""
        return Near(*(value[rows] for value in vars(self).values()))


class Blocks:
    """A world's blocked cells as boxes: runs of cells in a row, and the four sides outside."""

    def __init__(self, world: World) -> None:
        self.height, self.width = world.walls.shape
        changing = world.changing_cells
        still = world.walls & ~changing

        # Runs of solid cells, ordered by row and column; keys make them searchable.
        edges = np.diff(np.pad(still, ((0, 0), (1, 1))).astype(np.int8), axis=1)
        self._row, begin = np.nonzero(edges == 1)
        self._begin = begin
        self._end = np.nonzero(edges == -1)[1]
        self._key = self.width + 2
        self._begins = self._row * self._key + self._begin
        self._ends = self._row * self._key + self._end

        # Spans of cells that change, ordered by cell.
        spans = world.timeline.spans(world.walls)
        kept = spans.states != CellState.FREE
        self._since = spans.since[kept]
        self._until = spans.until[kept]
        self._burning = spans.states[kept] == CellState.BURNING
        self._cell = spans.cells[kept]
        self.is_changing = bool(len(self._cell))

        # Each cell's distance to anything that is ever blocked, to skip legs far from it.
        blocked = np.pad(still | changing, 1, constant_values=True)
        self._far = ndimage.distance_transform_cdt(~blocked, metric="chessboard")

    def at_least(self, legs: Legs, reach: float) -> Floats:
        """Return a lower bound on each leg's distance to blocked cells; it may be negative.

        Args:
            legs: The legs.
            reach: Distance of the body's farthest corner from its origin.
        """
        place, _ = legs.pose(np.full(len(legs.x), 0.5))
        ix, iy = (
            np.clip(np.floor(place[:, axis]), -1, side).astype(np.int64) + 1
            for axis, side in ((0, self.width), (1, self.height))
        )
        bound: Floats = self._far[iy, ix] - 1.0 - 0.5 * legs.length - reach
        return bound

    def near(self, legs: Legs, body: Body, margin: float) -> Near:
        """Return the boxes within a distance, in x and in y, of the body along each leg."""
        low, high = _bounds(legs, body, margin)
        leg, row = _ranges(
            np.clip(np.floor(low[:, 1]), 0, self.height).astype(np.int64),
            np.clip(np.floor(high[:, 1]), -1, self.height - 1).astype(np.int64),
        )
        first = np.clip(np.floor(low[leg, 0]), 0, self.width).astype(np.int64)
        last = np.clip(np.floor(high[leg, 0]), -1, self.width - 1).astype(np.int64)
        parts = [self._outside(low, high), self._runs(leg, row, first, last)]
        if self.is_changing:
            parts.append(self._changing(legs, leg, row, first, last))
        return Near(
            *(
                np.concatenate([getattr(part, name) for part in parts])
                for name in ("leg", "box", "burning", "low", "high")
            )
        )

    def _outside(self, low: Floats, high: Floats) -> Near:
        """Return the sides beyond the grid's edge, as far as the legs go."""
        # One cell more, so that a side's far end is never its nearest.
        (left, floor), (right, top) = (low - 1.0).T, (high + 1.0).T
        legs = []
        boxes = []
        for inside, box in (
            (low[:, 0] >= 0.0, (left, floor, 0.0 * left, top)),
            (high[:, 0] <= self.width, (0.0 * left + self.width, floor, right, top)),
            (low[:, 1] >= 0.0, (left, floor, right, 0.0 * left)),
            (high[:, 1] <= self.height, (left, 0.0 * left + self.height, right, top)),
        ):
            rows = np.flatnonzero(~inside)
            legs.append(rows)
            boxes.append(np.column_stack(box)[rows])
        return _always(np.concatenate(legs), np.concatenate(boxes))

    def _runs(self, leg: Indices, row: Ints, first: Ints, last: Ints) -> Near:
        some = np.searchsorted(self._ends, row * self._key + first, side="right")
        after = np.searchsorted(self._begins, row * self._key + last, side="right")
        number, run = _ranges(some, after - 1)
        box = np.column_stack(
            (self._begin[run], self._row[run], self._end[run], self._row[run] + 1)
        ).astype(np.float64)
        return _always(leg[number], box)

    def _changing(self, legs: Legs, leg: Indices, row: Ints, first: Ints, last: Ints) -> Near:
        some = np.searchsorted(self._cell, row * self.width + first, side="left")
        after = np.searchsorted(self._cell, row * self.width + last, side="right")
        number, span = _ranges(some, after - 1)
        own = leg[number]
        begin = legs.since[own]
        lasts = legs.until[own] - begin
        duration = np.where(lasts > 0.0, lasts, 1.0)
        low = np.where(lasts > 0.0, np.clip((self._since[span] - begin) / duration, 0, 1), 0.0)
        high = np.where(lasts > 0.0, np.clip((self._until[span] - begin) / duration, 0, 1), 1.0)
        meets = np.where(
            lasts > 0.0,
            (self._since[span] <= legs.until[own]) & (self._until[span] > begin),
            (self._since[span] <= begin) & (self._until[span] > begin),
        )
        ix = self._cell[span] % self.width
        iy = self._cell[span] // self.width
        box = np.column_stack((ix, iy, ix + 1, iy + 1)).astype(np.float64)
        return Near(own, box, self._burning[span], low, high).take(meets)


def _bounds(legs: Legs, body: Body, margin: float) -> tuple[Floats, Floats]:
    """Return the lower and upper corners (n, 2) of boxes that hold the body all along each leg."""
    lows = []
    highs = []
    for share in (0.0, 1.0):
        place, heading = legs.pose(np.full(len(legs.x), share))
        outline = turned(body.corners, heading[:, None])
        lows.append(place + outline.min(axis=1))
        highs.append(place + outline.max(axis=1))
    # On the way, no point is farther from the straight line than this.
    bend = np.abs(legs.turn)
    sagitta = np.minimum(0.125 * bend * bend, 2.0) * body.reach + 0.125 * bend * legs.length
    around = (sagitta + margin)[:, None]
    return np.minimum(*lows) - around, np.maximum(*highs) + around


def _always(leg: Indices, box: Floats) -> Near:
    count = len(leg)
    return Near(leg, box, np.zeros(count, np.bool_), np.zeros(count), np.ones(count))


def _ranges(first: Ints, last: Ints) -> tuple[Indices, Ints]:
    """Return all numbers of the ranges first..last (inclusive), and which range each is from."""
    count = np.maximum(last - first + 1, 0)
    row = np.repeat(np.arange(len(count)), count)
    offset = np.cumsum(count) - count
    return row, np.arange(len(row)) - offset[row] + first[row]


@dataclass(frozen=True)
class Overlaps:
    """Overlaps of a body with boxes along legs, (n,) each.

    Args:
        move: Number of the move.
        hits: The stretches, with places on the path, and the cell and the heading of the worst.
        burning: Whether the box burns.
    """

    move: Indices
    hits: Hits
    burning: Bools

    def take(self, rows: Indices | Bools) -> Overlaps:
        """Return some of the overlaps."""
        return Overlaps(self.move[rows], self.hits.take(rows), self.burning[rows])

    def deepest(self, moves: int) -> Floats:
        """Return the greatest depth of each of so many moves, cells; 0 without an overlap."""
        depth = np.zeros(moves)
        np.maximum.at(depth, self.move, self.hits.depth)
        return depth


def scan_body(way: AuditPath, body: Body, tolerance: float, *, arcs: bool, literal: bool) -> Scan:
    """Scan every piece of a path for overlaps of the body, and for its clearance.

    Args:
        way: The trajectory, with headings.
        body: The body, in cells.
        tolerance: Depth up to which an overlap is not reported, cells; turns are not judged finer
            than from one heading of the simulator to the next.
        arcs: True if the robot drives arcs between its samples.
        literal: False to leave out small cuts between two poses that are clear.

    Returns:
        Overlaps and touches of fire, and the body's smallest distance to anything blocked: 0 if it
        overlaps.
    """
    assert way.headings is not None
    headings = way.headings
    around = Blocks(way.world)
    result = Scan()
    moves = len(way.moves.x)
    driven, other = _legs(way, headings, arcs=arcs)
    found = _overlaps(driven, around, body, tolerance)
    if other is not None and len(found.move):
        # Where it is not clear, try to turn before driving instead of after it.
        deep = found.deepest(moves)
        tried = other.take(deep[other.move] > 0.0)
        second = _overlaps(tried, around, body, tolerance)
        less = np.zeros(moves, np.bool_)
        less[tried.move] = True
        less &= second.deepest(moves) < deep
        driven = driven.take(~less[driven.move]).followed_by(tried.take(less[tried.move]))
        kept = found.take(~less[found.move]), second.take(less[second.move])
        found = Overlaps(
            np.concatenate([part.move for part in kept]),
            Hits.of([part.hits for part in kept]),
            np.concatenate([part.burning for part in kept]),
        )
    if len(found.move):
        # The clearance is 0 where the body first overlaps.
        result.note_clearance(np.zeros(len(found.move)), found.hits.begin)
    else:
        _note_clearance(driven, around, body, result)
    if not literal and len(found.move):
        found = found.take(~_shaved(found, way, headings, body, tolerance, result))
    for kind, own in (("overlap", ~found.burning), ("burned", found.burning)):
        result.hits[kind] = merged(found.hits.take(own))
    return result


def _legs(way: AuditPath, headings: Floats, *, arcs: bool) -> tuple[Legs, Legs | None]:
    """Return the legs with each turn after its drive, and those with it before, or arcs."""
    turn = shorter_turn(np.diff(headings))
    count = len(turn)
    none = np.zeros(count)
    whole = Legs(
        way.moves.x, way.moves.y, way.moves.dx, way.moves.dy, headings[:-1], turn,
        way.times[:-1], way.times[1:], np.arange(count), none, none + 1.0,
    )  # fmt: skip
    if arcs:
        return whole, None
    turns = turn != 0.0
    ahead = replace(whole, turn=none)
    after = replace(
        whole, x=way.x[1:], y=way.y[1:], dx=none, dy=none, since=whole.until, low=none + 1.0
    )
    before = replace(whole, dx=none, dy=none, until=whole.since, high=none)
    turned_ahead = replace(ahead, heading=headings[:-1] + turn)
    return ahead.followed_by(after.take(turns)), before.take(turns).followed_by(
        turned_ahead.take(turns)
    )


def _portions(legs: Legs, around: Blocks, body: Body) -> Iterator[tuple[Legs, Near]]:
    """Yield the legs that are near blocked cells, in portions, and their pairs."""
    close = legs.take(around.at_least(legs, body.reach) <= 0.0)
    # Each row of cells near a leg has about two runs.
    rows = np.cumsum(np.abs(close.dy) + close.length + 2.0 * body.reach + 2.0)
    part = (rows * 4.0 / _PAIRS_AT_ONCE).astype(np.int64)
    for begin, end in _stretches(part):
        own = close.take(np.arange(begin, end))
        yield own, around.near(own, body, 0.0)


def _stretches(values: Ints) -> Iterator[tuple[int, int]]:
    """Yield the first index and the end of each stretch of equal values."""
    ends = np.flatnonzero(np.diff(values)) + 1
    bounds = [0, *ends.tolist(), len(values)]
    yield from ((a, b) for a, b in itertools.pairwise(bounds) if a < b)


class _Swept:
    """Pairs of a leg and a box, the leg taken as straight, at its middle heading.

    Args:
        body: The body.
        legs: (n,) Legs.
        box: (n, 4) Boxes.
    """

    def __init__(self, body: Body, legs: Legs, box: Floats) -> None:
        self.body = body
        self.legs = legs
        self.heading = legs.heading + 0.5 * legs.turn
        # No point of the body is farther than this from where it is on the straight leg.
        bend = np.abs(legs.turn)
        self.error = bend * (0.5 * body.reach + 0.125 * legs.length)

        # Seen from the robot, the box moves backwards.
        place = np.column_stack((legs.x, legs.y))
        step = np.column_stack((legs.dx, legs.dy))
        seen = box_corners(box) - place[:, None]
        self.begin = turned(seen, -self.heading[:, None])
        self.end = turned(seen - step[:, None], -self.heading[:, None])

        # Gaps along each axis at both ends; negative where the projections overlap.
        outline = turned(body.corners, self.heading[:, None])
        gaps = []
        for corners in (seen, seen - step[:, None]):
            in_frame = self.begin if corners is seen else self.end
            own = [(in_frame @ body.normals.T).min(axis=1) - body.offsets]
            own.append(corners.min(axis=1) - outline.max(axis=1))
            own.append(outline.min(axis=1) - corners.max(axis=1))
            gaps.append(np.concatenate(own, axis=1))
        self._gaps = gaps

    @property
    def apart(self) -> Floats:
        """(n,) A lower bound on the distance, negative if no axis keeps them apart all along."""
        apart: Floats = np.minimum(*self._gaps).max(axis=1)
        return apart

    def overlap(self) -> tuple[Floats, Floats]:
        """Return the shares of the leg between which body and box overlap; (inf, -inf) if never."""
        begin, end = self._gaps
        slope = end - begin
        still = slope == 0.0
        with np.errstate(over="ignore"):
            crossing = (-_CLOSE_CALL - begin) / np.where(still, 1.0, slope)
        never = np.where(begin < -_CLOSE_CALL, -np.inf, np.inf)
        enter = np.where(still, never, np.where(slope < 0.0, crossing, -np.inf)).max(axis=1)
        leave = np.where(still, -never, np.where(slope > 0.0, crossing, np.inf)).min(axis=1)
        enter = np.maximum(enter, 0.0)
        leave = np.minimum(leave, 1.0)
        missed = enter > leave
        return np.where(missed, np.inf, enter), np.where(missed, -np.inf, leave)

    def segments(self, rows: Indices) -> tuple[Floats, Floats]:
        """Return the sides of the boxes at both ends and the paths of their corners: (n, 12, 2)."""
        first = self.begin[rows]
        last = self.end[rows]
        begin = np.concatenate((first, last, first), axis=1)
        end = np.concatenate((np.roll(first, -1, 1), np.roll(last, -1, 1), last), axis=1)
        return begin, end

    def depth(self, rows: Indices) -> tuple[Floats, Floats, Floats]:
        """Return the greatest depth of boxes in the body, the leg's share there, and the point."""
        begin, end = self.segments(rows)
        depth, share = deepest_on_segments(self.body, begin, end)
        best = depth.argmax(axis=1)
        own = np.arange(len(rows)), best
        along = share[own]
        point = begin[own] + along[:, None] * (end[own] - begin[own])
        # The first four are sides at the beginning, the next four at the end.
        at = np.where(best < 4, 0.0, np.where(best < 8, 1.0, along))
        deepest = depth[own]

        # A box may cover the body's middle, which is deeper than all that is around it.
        corners = self.begin[rows]
        back = self.end[rows] - corners
        enter, leave = _covered(corners, back[:, 0], self.heading[rows], self.body.middle)
        covers = enter <= leave
        return (
            np.where(covers, self.body.inner, deepest),
            np.where(covers, enter, at),
            np.where(covers[:, None], self.body.middle, point),
        )

    def distance(self, rows: Indices) -> Floats:
        """Return the distances of body and box along the legs, which must not overlap."""
        begin, end = self.segments(rows)
        found = np.empty(len(rows))
        moves = ((self.legs.dx != 0.0) | (self.legs.dy != 0.0))[rows]
        found[moves] = distances(self.body, begin[moves], end[moves])
        # On the spot, the box has the same sides at both ends, and its corners no paths.
        found[~moves] = distances(self.body, begin[~moves, :4], end[~moves, :4])
        return found


def _covered(
    corners: Floats, back: Floats, heading: Floats, middle: Floats
) -> tuple[Floats, Floats]:
    """Return the shares between which moving boxes cover a point; (inf, -inf) if they never do."""
    # In the world's axes the boxes are upright.
    upright = turned(corners, heading[:, None])
    low = upright.min(axis=1)
    high = upright.max(axis=1)
    step = turned(back, heading)
    point = turned(middle, heading)
    enter = np.zeros(len(low))
    leave = np.ones(len(low))
    for axis in (0, 1):
        still = np.abs(step[:, axis]) < _CLOSE_CALL
        speed = np.where(still, 1.0, step[:, axis])
        one = (point[:, axis] - high[:, axis]) / speed
        two = (point[:, axis] - low[:, axis]) / speed
        inside = (low[:, axis] <= point[:, axis]) & (point[:, axis] <= high[:, axis])
        outside = np.where(inside, -np.inf, np.inf)
        enter = np.maximum(enter, np.where(still, outside, np.minimum(one, two)))
        leave = np.minimum(leave, np.where(still, -outside, np.maximum(one, two)))
    missed = enter > leave
    return np.where(missed, np.inf, enter), np.where(missed, -np.inf, leave)


def _first_of_equal(legs: Legs, around: Blocks) -> tuple[Indices, Indices]:
    """Return the first of each set of equal legs, and each leg's set; a robot may be stuck."""
    if around.is_changing:
        every = np.arange(len(legs.x))
        return every, every
    motion = np.column_stack((legs.x, legs.y, legs.dx, legs.dy, legs.heading, legs.turn))
    _, first, kind = np.unique(motion, axis=0, return_index=True, return_inverse=True)
    return first, kind.reshape(-1)


def _overlaps(legs: Legs, around: Blocks, body: Body, tolerance: float) -> Overlaps:
    """Return the overlaps that are deeper than the tolerance."""
    first, kind = _first_of_equal(legs, around)
    numbered = replace(legs, move=np.arange(len(legs.x)))
    found = _overlaps_of(numbered.take(first), around, body, tolerance)
    again = np.isin(kind, kind[found.move])
    return _overlaps_of(legs.take(again), around, body, tolerance)


def _overlaps_of(legs: Legs, around: Blocks, body: Body, tolerance: float) -> Overlaps:
    """Return the overlaps that are deeper than the tolerance, of each leg.

    A leg that turns is halved until a straight one is near enough to it, or it is surely clear, or
    it surely overlaps and others of its move are deeper.
    """
    grain = 0.5 * body.reach * _HEADING_STEP
    parts: list[Overlaps] = []
    for own, near in _portions(legs, around, body):
        best = np.zeros(len(own.x))
        pair = np.arange(len(near.leg))
        low = near.low
        high = near.high
        while len(pair):
            leg = near.leg[pair]
            swept = _Swept(body, own.take(leg).between(low, high), near.box[pair])
            enter, leave = swept.overlap()
            rows = np.flatnonzero(enter <= leave)
            depth = np.zeros(len(pair))
            at = np.zeros(len(pair))
            point = np.zeros((len(pair), 2))
            depth[rows], at[rows], point[rows] = swept.depth(rows)
            np.maximum.at(best, leg, depth - swept.error)

            # Halve what is not decided, and keep the rest.
            doubtful = (swept.apart <= swept.error) & (swept.error > grain)
            doubtful &= (depth <= 2.0 * swept.error) | (depth + swept.error > best[leg] + grain)
            allowed = np.where(own.turn[leg] != 0.0, max(tolerance, 2.0 * grain), tolerance)
            kept = np.flatnonzero(~doubtful & (depth > allowed))
            shares = [low + (high - low) * share for share in (enter, leave, at)]
            parts.append(
                _as_overlaps(
                    own.take(leg[kept]),
                    near.take(pair[kept]),
                    [share[kept] for share in shares],
                    depth[kept],
                    point[kept],
                )
            )
            middle = 0.5 * (low + high)[doubtful]
            low = np.concatenate((low[doubtful], middle))
            high = np.concatenate((middle, high[doubtful]))
            pair = np.tile(pair[doubtful], 2)
    return Overlaps(
        np.concatenate([np.zeros(0, np.intp), *(part.move for part in parts)]),
        Hits.of([part.hits for part in parts]),
        np.concatenate([np.zeros(0, np.bool_), *(part.burning for part in parts)]),
    )


def _as_overlaps(
    legs: Legs, near: Near, shares: list[Floats], depth: Floats, point: Floats
) -> Overlaps:
    place, heading = legs.pose(shares[2])
    x, y = (place + turned(point, heading)).T
    # The deepest point may be on a side of its cell.
    ix = np.clip(np.floor(x), near.box[:, 0], near.box[:, 2] - 1.0).astype(np.int64)
    iy = np.clip(np.floor(y), near.box[:, 1], near.box[:, 3] - 1.0).astype(np.int64)
    places = [legs.move + legs.low + share * (legs.high - legs.low) for share in shares]
    hits = Hits(places[0], places[1], depth, places[2], ix, iy, heading)
    return Overlaps(legs.move, hits, near.burning)


def _shaved(
    found: Overlaps, way: AuditPath, headings: Floats, body: Body, tolerance: float, result: Scan
) -> Bools:
    """Return which overlaps are small cuts between two clear poses that are near each other.

    A robot that slides around a corner, or turns while it drives, leaves such poses.
    """
    move = found.move
    motion = way.moves.length + body.reach * np.abs(shorter_turn(np.diff(headings)))
    small = (motion[move] <= body.inner) & (found.hits.depth <= _SHAVED * body.inner)
    cell = np.column_stack((found.hits.ix, found.hits.iy)).astype(np.float64)
    corners = box_corners(np.concatenate((cell, cell + 1.0), axis=1))
    for end in (0, 1):
        place = np.column_stack((way.x, way.y))[move + end]
        small &= separations(body, corners, place, headings[move + end]) >= -tolerance
    if small.any():
        result.shaved += len(np.unique(move[small]))
        result.shaved_depth = max(result.shaved_depth, float(found.hits.depth[small].max()))
    return small


def _note_clearance(legs: Legs, around: Blocks, body: Body, result: Scan) -> None:
    """Find the smallest distance of the body to anything blocked, of legs that never overlap."""
    # Measure the most promising legs first, with a growing reach that ends at the grid's edge.
    legs = legs.take(_first_of_equal(legs, around)[0])
    grain = body.reach * _HEADING_STEP
    bound = around.at_least(legs, body.reach)
    order = np.argsort(bound, kind="stable")
    margin = max(float(bound.min(initial=0.0)), 0.0) + _MARGIN
    begin = 0
    count = 16
    while begin < len(order) and max(bound[order[begin]], grain) < result.clearance:
        some = legs.take(order[begin : begin + count])
        while True:
            near = around.near(some, body, min(margin, result.clearance))
            _measure_clearance(some, near, body, result)
            if result.clearance <= margin or begin > 0:
                break
            margin *= 2.0
        begin += count
        count = min(4 * count, 4096)


def _measure_clearance(legs: Legs, near: Near, body: Body, result: Scan) -> None:
    grain = 0.5 * body.reach * _HEADING_STEP
    pair = np.arange(len(near.leg))
    low = near.low
    high = near.high
    while len(pair):
        own = legs.take(near.leg[pair])
        swept = _Swept(body, own.between(low, high), near.box[pair])
        distance = np.full(len(pair), np.inf)
        # The nearest first: they rule out most of the others.
        apart = swept.apart
        nearest = apart - swept.error
        order = np.argsort(nearest, kind="stable")
        least = result.clearance
        for part in np.array_split(order, max(1, math.ceil(len(order) / 512))):
            rows = part[nearest[part] < least]
            if not len(rows):
                break
            distance[rows] = np.where(
                apart[rows] > 0.0, swept.distance(rows), np.maximum(apart[rows], 0.0)
            )
            least = min(least, float((distance[rows] + swept.error[rows]).min()))
        # A robot that pushes against walls touches them everywhere, which is near enough.
        touches = least <= 4.0 * grain
        final = ((swept.error <= grain) | touches) & (distance < np.inf)
        place = own.move + own.low + 0.5 * (low + high) * (own.high - own.low)
        result.note_clearance(distance[final], place[final])
        doubtful = (distance - swept.error < least) & ~final
        middle = 0.5 * (low + high)[doubtful]
        low = np.concatenate((low[doubtful], middle))
        high = np.concatenate((middle, high[doubtful]))
        pair = np.tile(pair[doubtful], 2)
