"""Scan a trajectory piece by piece for places where the disc, or its centre, must not be.

Lengths are in cells. A place on the path is a number: 3.25 is a quarter of the way from sample 3 to
sample 4.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from sim.audit.cells import Pairs, Surroundings
from sim.audit.exact import meet_inside, run_along, run_between
from sim.audit.geometry import deepest, nearest, slab, within
from sim.audit.path import AuditPath
from worldgen.support.arrays import Bools, Floats, Indices, Ints
from worldgen.timeline import CellState

# Sizes of the arrays that are worked on at once, in pieces and in pairs, to limit memory.
_PIECES_AT_ONCE = 60_000
_ROWS_AT_ONCE = 400_000

# Cells beyond the radius that are examined, so that a clearance just above it is found as well.
_MARGIN = 0.25

# Moves that are measured first, to estimate how far away everything is.
_FIRST = 16

# Cells. Nearer to a face than this, rational numbers decide.
_CLOSE_CALL = 1e-9

# Cells; far more than rounding errors.
_NEARLY = 1e-6

# Relative rounding error of a few operations in float64.
_ROUNDING = 4e-16

# Fraction of a move. Stretches closer to each other than this count as one.
_TOUCHING = 1e-8


@dataclass(frozen=True)
class Hits:
    """Stretches of the path on which something is wrong, (n,) each.

    Args:
        begin: Place on the path where it begins.
        end: Place where it ends.
        depth: Largest depth, cells.
        worst: Place where it is worst.
        ix: Column of the cell there.
        iy: Row of the cell there.
        heading: Heading of a body there, rad; NaN for a disc.
    """

    begin: Floats = field(default_factory=lambda: np.zeros(0))
    end: Floats = field(default_factory=lambda: np.zeros(0))
    depth: Floats = field(default_factory=lambda: np.zeros(0))
    worst: Floats = field(default_factory=lambda: np.zeros(0))
    ix: Ints = field(default_factory=lambda: np.zeros(0, np.int64))
    iy: Ints = field(default_factory=lambda: np.zeros(0, np.int64))
    heading: Floats = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        if len(self.heading) != len(self.begin):
            object.__setattr__(self, "heading", np.full(len(self.begin), np.nan))

    def of_moves(self, rows: Indices) -> Hits:
        """Return the stretches on the path, if the places are fractions of these moves."""
        begin, end, worst = (rows + place for place in (self.begin, self.end, self.worst))
        return replace(self, begin=begin, end=end, worst=worst)

    @classmethod
    def of(cls, many: Sequence[Hits]) -> Hits:
        """Return all of the stretches in one record."""
        if not many:
            return cls()
        columns = zip(*(hits.columns for hits in many), strict=True)
        return cls(*map(np.concatenate, columns))

    @property
    def columns(self) -> tuple[Any, ...]:
        """The fields in their order."""
        return self.begin, self.end, self.depth, self.worst, self.ix, self.iy, self.heading

    def take(self, rows: Indices | Bools) -> Hits:
        """Return some of the stretches."""
        return Hits(*(column[rows] for column in self.columns))


def merged(hits: Hits, grain: float = 1e-9) -> Hits:
    """Merge stretches that overlap or touch, keeping the greatest depth and its first place.

    Args:
        hits: Stretches in any order.
        grain: Depths that differ by less than this count as equal, cells.
    """
    if not len(hits.begin):
        return hits

    # A group ends where the next stretch begins after everything before it has ended.
    order = np.argsort(hits.begin, kind="stable")
    reached = np.maximum.accumulate(hits.end[order])
    fresh = np.concatenate([[True], hits.begin[order][1:] > reached[:-1] + _TOUCHING])
    group = np.cumsum(fresh) - 1
    first = np.flatnonzero(fresh)

    # Rank the stretches within their group; groups keep their place and size in the order.
    depth = np.round(hits.depth[order] / grain)
    ranked = order[np.lexsort((hits.worst[order], -depth, group))][first]
    ends = np.append(first[1:], len(group)) - 1
    return replace(hits.take(ranked), begin=hits.begin[order][first], end=reached[ends])


@dataclass
class Scan:
    """The result of a scan.

    Args:
        hits: Stretches by kind of finding, merged.
        clearance: Smallest distance of the centre to the outside or to anything solid or burning,
            cells.
        nearest: Place on the path of that smallest distance.
        shaved: Number of moves whose straight line cuts a corner between clear samples, which does
            not count as a finding.
        shaved_depth: Depth of the deepest such cut, cells.
    """

    hits: dict[str, Hits] = field(default_factory=dict)
    clearance: float = np.inf
    nearest: float = 0.0
    shaved: int = 0
    shaved_depth: float = 0.0

    def note_clearance(self, distance: Floats, at: Floats) -> None:
        """Keep the smallest distance, and the first place that has it."""
        if len(distance):
            least = distance.min()
            place = at[distance == least].min()
            if (least, place) < (self.clearance, self.nearest):
                self.clearance = float(least)
                self.nearest = float(place)


@dataclass(frozen=True)
class _Measured:
    """Pairs of a piece and a cell, with their distance; (n,) each."""

    pairs: Pairs
    row: Indices
    burning: Bools
    # Fractions of the move at which the piece begins and ends while the cell is blocked.
    low: Floats
    high: Floats
    # The same for the whole move.
    window: tuple[Floats, Floats]
    distance: Floats
    # Fraction of the move at which the distance is smallest.
    nearest: Floats
    # Depth of the centre in the cell, negative outside it; -inf if it is far away.
    inside: Floats


def scan(way: AuditPath, radius: float, tolerance: float, *, straight: bool) -> Scan:
    """Scan every piece of a path.

    Args:
        way: The trajectory.
        radius: Radius of the disc, cells.
        tolerance: Depth up to which a cut of the disc is not reported, cells.
        straight: True if every straight line counts as driven; see :func:`_shaved`.
    """
    around = Surroundings(way.world)
    result = Scan()
    found: dict[str, list[Hits]] = {kind: [] for kind in ("tunnel", "overlap", "burned", "outside")}

    # Outside the grid the whole disc is in forbidden space, and its clearance is 0.
    outside = _outside(way)
    found["outside"].append(outside)
    found["overlap"].append(replace(outside, depth=np.full(len(outside.depth), radius)))
    result.note_clearance(np.zeros(len(outside.begin)), outside.begin)

    # Measure the pieces near the grid's cells, a portion at a time.
    least = np.full(len(way.low), np.inf)
    reach = radius + _MARGIN
    for rows in _portions(way.pieces, np.arange(len(way.pieces)), 2.0 * reach + 4.0):
        measured = _measure(way, around, rows, reach, least)
        result.note_clearance(measured.distance, measured.row + measured.nearest)
        kinds = _overlaps(measured, way, radius, tolerance, straight, result) | {
            "tunnel": _tunnels(measured, way, around)
        }
        for kind, hits in kinds.items():
            found[kind].append(merged(hits))

    # If the whole path stays farther away than the searched distance, search farther for its
    # clearance.
    if result.clearance > reach:
        _widest(way, around, least, result)
    result.hits = {kind: merged(Hits.of(many)) for kind, many in found.items()}
    return result


def _portions(pieces: Ints, rows: Indices, rows_each: float) -> Iterator[Indices]:
    """Yield the moves in portions that fit into memory."""
    most = max(1, min(_PIECES_AT_ONCE, int(_ROWS_AT_ONCE / rows_each)))
    total = np.cumsum(pieces[rows])
    begin = 0
    while begin < len(rows):
        done = total[begin - 1] if begin else 0
        end = max(begin + 1, int(np.searchsorted(total, done + most, side="right")))
        yield rows[begin:end]
        begin = end


def _measure(
    way: AuditPath, around: Surroundings, rows: Indices, reach: float, least: Floats
) -> _Measured:
    """Measure the distances of some moves to the cells around them.

    Lower bounds on the distance that each move keeps are noted in ``least``.
    """
    # Cut the moves into their pieces.
    row = np.repeat(rows, way.pieces[rows])
    count = way.pieces[row]
    number = np.arange(len(row)) - np.repeat(
        np.cumsum(way.pieces[rows]) - way.pieces[rows], way.pieces[rows]
    )
    span = way.high[row] - way.low[row]
    begin = way.low[row] + span * (number / count)
    end = way.low[row] + span * ((number + 1) / count)
    pieces = way.moves.take(row).between(begin, end)

    # Drop pieces that are surely out of reach.
    away = around.at_least(pieces)
    np.minimum.at(least, row, away)
    close = np.flatnonzero(away < reach)
    row = row[close]
    begin = begin[close]
    end = end[close]

    # Find the cells near the others, and cut each piece to the time when its cell is blocked.
    pairs = around.near(pieces.take(close), (way.times[row], way.times[row + 1]), reach)
    since, until, burning = _windows(way, around, pairs, row[pairs.piece])
    low = np.maximum(begin[pairs.piece], since)
    high = np.minimum(end[pairs.piece], until)
    kept = np.flatnonzero(low <= high)
    pairs = pairs.take(kept)
    since = since[kept]
    until = until[kept]
    burning = burning[kept]
    return _measured(way, pairs, row[pairs.piece], (low[kept], high[kept]), (since, until), burning)


def _windows(
    way: AuditPath, around: Surroundings, pairs: Pairs, row: Indices
) -> tuple[Floats, Floats, Bools]:
    """Return the fractions of the move between which each cell is blocked, and if it burns."""
    since = np.zeros(len(row))
    until = np.ones(len(row))
    burning = np.zeros(len(row), np.bool_)
    timed = np.flatnonzero(pairs.span >= 0)
    if len(timed):
        span = pairs.span[timed]
        begin = way.times[row[timed]]
        end = way.times[row[timed] + 1]
        lasts = end > begin
        duration = np.where(lasts, end - begin, 1.0)
        enter = np.clip((around.since[span] - begin) / duration, 0.0, 1.0)
        leave = np.clip((around.until[span] - begin) / duration, 0.0, 1.0)
        since[timed] = np.where(lasts, enter, 0.0)
        until[timed] = np.where(lasts, leave, 1.0)
        burning[timed] = around.state[span] == int(CellState.BURNING)
    return since, until, burning


def _measured(
    way: AuditPath,
    pairs: Pairs,
    row: Indices,
    shares: tuple[Floats, Floats],
    window: tuple[Floats, Floats],
    burning: Bools,
) -> _Measured:
    low, high = shares
    parts = way.moves.take(row).between(low, high).seen_from(pairs.ix, pairs.iy)
    distance, at = nearest(parts)
    inside = np.full(len(row), -np.inf)
    # Only parts whose bounding box overlaps the cell's can enter it.
    gap_x = np.minimum(np.abs(parts.x), np.abs(parts.x + parts.dx)) - 0.5
    gap_y = np.minimum(np.abs(parts.y), np.abs(parts.y + parts.dy)) - 0.5
    passes_x = parts.x * (parts.x + parts.dx) < 0.0
    passes_y = parts.y * (parts.y + parts.dy) < 0.0
    meets = np.flatnonzero(((gap_x < _NEARLY) | passes_x) & ((gap_y < _NEARLY) | passes_y))
    inside[meets], share = deepest(parts.take(meets))
    entered = inside[meets] >= 0.0
    distance[meets[entered]] = 0.0
    at[meets[entered]] = share[entered]
    return _Measured(
        pairs, row, burning, low, high, window, distance, low + (high - low) * at, inside
    )


def _outside(way: AuditPath) -> Hits:
    """Return the stretches beyond the grid's edge."""
    height, width = way.world.walls.shape
    off_x = np.maximum(-way.x, way.x - width)
    off_y = np.maximum(-way.y, way.y - height)
    depth = np.where(way.beyond, np.hypot(np.maximum(off_x, 0.0), np.maximum(off_y, 0.0)), 0.0)

    # A move that leaves the grid is outside before it enters, after it exits, or all the time.
    rows = way.leaving
    enter, leave = way.in_grid(0.0)
    missed = enter > leave
    found = []
    for share, begin, end in (
        (0, np.zeros(len(rows)), np.where(missed, 1.0, enter)),
        (1, np.where(missed, 0.0, leave), np.ones(len(rows))),
    ):
        own = way.beyond[rows + share]
        sample = rows[own] + share
        ix = np.clip(np.floor(way.x[sample]), -1, width).astype(np.int64)
        iy = np.clip(np.floor(way.y[sample]), -1, height).astype(np.int64)
        worst = np.full(len(ix), float(share))
        hits = Hits(begin[own], end[own], depth[sample], worst, ix, iy)
        found.append(hits.of_moves(rows[own]))
    return merged(Hits.of(found))


def _overlaps(
    measured: _Measured,
    way: AuditPath,
    radius: float,
    tolerance: float,
    straight: bool,
    result: Scan,
) -> dict[str, Hits]:
    """Return the stretches on which the disc cuts solid cells, and burning ones."""
    hit = np.flatnonzero(radius - measured.distance > tolerance)
    if not straight and len(hit):
        hit = hit[~_shaved(measured, way, hit, radius, tolerance, result)]
    row = measured.row[hit]
    pairs = measured.pairs.take(hit)

    # A stretch lasts while the centre is too near, as long as the cell is blocked.
    parts = way.moves.take(row).seen_from(pairs.ix, pairs.iy)
    enter, leave = within(parts, radius - tolerance)
    at = measured.nearest[hit]
    begin = np.minimum(np.maximum(enter, measured.low[hit]), at)
    end = np.maximum(np.minimum(leave, measured.high[hit]), at)
    depth = radius - measured.distance[hit]
    hits = Hits(begin, end, depth, at, pairs.ix, pairs.iy).of_moves(row)
    burning = measured.burning[hit]
    return {"overlap": hits.take(~burning), "burned": hits.take(burning)}


def _shaved(
    measured: _Measured, way: AuditPath, hit: Indices, radius: float, tolerance: float, result: Scan
) -> Bools:
    """Return which hits are cuts by a line no longer than the radius, with both ends clear.

    A robot that slides around a corner between two samples leaves such a line. The line cuts by at
    most the height of an arc of radius ``radius`` over it, 0.134 of the radius.
    """
    row = measured.row[hit]
    # Both ends must be clear of the cell while the cell is blocked.
    pairs = measured.pairs.take(hit)
    length = way.moves.length[row]
    parts = way.moves.take(row).seen_from(pairs.ix, pairs.iy)
    clear = length <= radius
    for share in (window[hit] for window in measured.window):
        gap = np.hypot(
            np.maximum(np.abs(parts.x + share * parts.dx) - 0.5, 0.0),
            np.maximum(np.abs(parts.y + share * parts.dy) - 0.5, 0.0),
        )
        clear &= radius - gap <= tolerance
    if clear.any():
        result.shaved += len(np.unique(row[clear]))
        result.shaved_depth = max(
            result.shaved_depth, float((radius - measured.distance[hit][clear]).max())
        )
    return clear


def _tunnels(measured: _Measured, way: AuditPath, around: Surroundings) -> Hits:
    """Return the stretches on which the centre is inside a wall."""
    pairs = measured.pairs
    height, width = way.world.walls.shape
    in_grid = (pairs.ix >= 0) & (pairs.iy >= 0) & (pairs.ix < width) & (pairs.iy < height)

    # Depths within the doubt are close calls, which rational numbers decide.
    doubt = _doubt(measured, way, around)
    near = np.flatnonzero((measured.inside > -doubt) & in_grid & ~measured.burning)
    sure = measured.inside[near] > doubt[near]

    # A centre between two solid cells is measured from the face between them.
    shift = np.zeros((len(near), 2))
    doubtful = np.flatnonzero(~sure)
    for index in doubtful[~_along_a_free_cell(measured, near[doubtful], way, around)]:
        found = _way_in(pairs, int(near[index]), int(measured.row[near[index]]), way, around)
        if found is not None:
            sure[index] = True
            shift[index] = found

    # A stretch lasts while the centre is in the cell, as long as the cell is solid.
    hit = near[sure]
    shift = shift[sure]
    row = measured.row[hit]
    own = pairs.take(hit)
    low = measured.low[hit]
    high = measured.high[hit]
    moves = way.moves.take(row).seen_from(own.ix + shift[:, 0], own.iy + shift[:, 1])
    enter, leave = slab(moves, 0.5, 0.5)
    depth, share = deepest(moves.between(low, high))
    at = low + (high - low) * share
    begin = np.minimum(np.maximum(enter, low), at)
    end = np.maximum(np.minimum(leave, high), at)
    return Hits(begin, end, np.maximum(depth, 0.0), at, own.ix, own.iy).of_moves(row)


def _doubt(measured: _Measured, way: AuditPath, around: Surroundings) -> Floats:
    """Return the possible error of ``inside`` from rounding, in cells.

    Both positions and fractions computed from times are rounded.
    """
    row = measured.row
    span = measured.pairs.span
    length = way.moves.length[row]
    scale = np.abs(way.x[row]) + np.abs(way.y[row]) + length
    timed = np.flatnonzero(span >= 0)
    begin = way.times[row[timed]]
    end = way.times[row[timed] + 1]
    lasts = np.where(end > begin, end - begin, np.inf)
    scale[timed] += length[timed] * (np.abs(begin) + np.abs(end)) / lasts
    doubt: Floats = _CLOSE_CALL + _ROUNDING * scale
    return doubt


def _along_a_free_cell(
    measured: _Measured, index: Indices, way: AuditPath, around: Surroundings
) -> Bools:
    """Return where the centre moves along a face with a cell behind it that is never blocked.

    Those are not close calls. A robot that drives along a wall does this with every sample, so each
    coordinate is decided only once.
    """
    row = measured.row[index]
    ix = measured.pairs.ix[index]
    iy = measured.pairs.iy[index]
    free = np.zeros(len(index), np.bool_)
    for metres, cells, own, (step_x, step_y) in (
        (way.metres[0], way.x, ix, (1, 0)),
        (way.metres[1], way.y, iy, (0, 1)),
    ):
        # The move must stay on the line between two columns or rows.
        face = np.rint(cells[row]).astype(np.int64)
        on_face = (metres[row] == metres[row + 1]) & ((face == own) | (face == own + 1))
        on_face &= np.abs(cells[row] - face) < _NEARLY

        # Decide exactly whether it is that line, once for each distinct coordinate.
        values, number = np.unique(metres[row[on_face]], return_inverse=True)
        on_face[on_face] = np.array([way.is_face(value) for value in values.tolist()], np.bool_)[
            number
        ]

        # Then the cell on the other side of the line must be free.
        side = np.where(face == own, -1, 1)
        free |= on_face & ~around.ever_blocked(ix + side * step_x, iy + side * step_y)
    return free


def _way_in(
    pairs: Pairs, index: int, row: int, way: AuditPath, around: Surroundings
) -> tuple[float, float] | None:
    """Decide exactly whether the centre enters a cell, or the face between it and a solid cell.

    Returns:
        (0, 0) if it enters the cell, half the step to the other cell if it enters the face, or
        ``None``.
    """
    ix = int(pairs.ix[index])
    iy = int(pairs.iy[index])
    span = int(pairs.span[index])
    since, until = around.span(span)
    move = way.move(row)
    if meet_inside(move, ix, iy, since, until):
        return 0.0, 0.0
    for other in run_between(move, ix, iy):
        for begin, end in around.solid_spans(*other):
            low = max(since, begin)
            high = min(until, end)
            if low < high and run_along(move, ix, iy, other, low, high):
                return 0.5 * (other[0] - ix), 0.5 * (other[1] - iy)
    return None


def _widest(way: AuditPath, around: Surroundings, least: Floats, result: Scan) -> None:
    """Find the clearance of a path that stays far from everything, most promising moves first."""
    # Measure the first few moves with a growing reach, which ends at the latest at the grid's edge.
    rows = _distinct(way, np.flatnonzero((way.pieces > 0) & (least < result.clearance)))
    rows = rows[np.argsort(least[rows], kind="stable")]
    first = rows[:_FIRST]
    reach = 2.0 * (max(float(least[rows].min(initial=0.0)), 0.0) + 2.0)
    while len(first):
        measured = _measure(way, around, first, reach, least)
        result.note_clearance(measured.distance, measured.row + measured.nearest)
        if result.clearance <= reach:
            break
        reach *= 2.0

    # Measure the others only as far as the best clearance so far.
    for some in _portions(way.pieces, rows[_FIRST:], 2.0 * result.clearance + 4.0):
        if least[some[0]] >= result.clearance:
            break
        measured = _measure(way, around, some, result.clearance, least)
        result.note_clearance(measured.distance, measured.row + measured.nearest)


def _distinct(way: AuditPath, rows: Indices) -> Indices:
    """Return the moves, keeping only one of several equal ones if the world does not change."""
    if way.world.is_dynamic or not len(rows):
        return rows
    moves = way.moves.take(rows)
    _, first = np.unique(
        np.stack([moves.x, moves.y, moves.dx, moves.dy], axis=1), axis=0, return_index=True
    )
    return rows[first]
