"""Confine the robot: bound where it can be, tile by tile and slab by slab.

A tile is dead while a single blocked cell is so near that no point of the tile is clear. In one
slab of time a robot gets no farther than one tile's side, so it stays in its tile or moves to one
of the eight around it. The tiles reached this way include all that the disc can reach, and
everything else is out of reach (docs/notes/reachability.md).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from worldgen._core import ffi, lib
from worldgen.lattice import exact, in_cells
from worldgen.reach.decision.confinement import NEVER_ENDS, Confinement
from worldgen.reach.still.walls import Cell
from worldgen.reach.timed.intervals import CellSpans, Intervals, safe_intervals
from worldgen.reach.timed.spans import FOREVER, Spans
from worldgen.support.arrays import Bools, Bytes, Floats, Ints
from worldgen.support.ccall import check, pointer, writable
from worldgen.world import World

# States between two checks for Ctrl-C.
_PORTION = 200_000
# Tiles; distances are reduced by this much, and by less in the checker.
_SLACK = 1e-6


@dataclass(frozen=True)
class Reach:
    """The result of a search.

    Args:
        proof: Proof that the target is not reached, or not by the deadline; None if there is no
            such proof.
        earliest: If there is no proof, a time, s, before which the target is not reached.
    """

    proof: Confinement | None
    earliest: float


def confine(world: World, radius: Fraction, k: int, deadline: float | None) -> Reach | None:
    """Return bounds on where a disc of ``radius`` cells can be, and if they exclude the target.

    Args:
        world: The world.
        radius: Radius of the disc, cells.
        k: Tiles per cell side.
        deadline: Time, s, by which the target must be reached; None for any time.

    Returns:
        None if a robot crosses a tile in less than a tick.
    """
    # A slab is the time in which the robot crosses a tile, in whole ticks.
    spans = Spans(world)
    slab = math.floor(exact(world.cell_size) * spans.ticks / (k * exact(world.robot_speed)))
    if slab < 1:
        return None
    # Find when each tile is alive.
    classes = _covering(radius, k)
    alive = _alive(spans.fixed, classes, k)
    safe = safe_intervals(alive, _inner(spans), classes)
    home, goal = _distances(world, alive.shape, k)
    states = _States.of(safe, slab)
    # Remove states that the robot cannot reach, or from which it cannot arrive in time. Tiles per
    # slab.
    pace = float(exact(world.robot_speed) * slab * k / (spans.ticks * exact(world.cell_size)))
    states.begin_no_earlier(np.ceil((home - _SLACK) / pace) - 1)
    if deadline is not None:
        way = float(exact(deadline) * exact(world.robot_speed) * k / exact(world.cell_size))
        states.end_no_later(np.floor((way - goal + _SLACK) / pace))
        states.high = np.minimum(
            states.high, min(math.floor(exact(deadline) * spans.ticks / slab), NEVER_ENDS)
        )
    # Spread from the start, and keep the states that were reached.
    start = tuple(in_cells(value, world.cell_size) * k for value in (world.start.x, world.start.y))
    came, reached = _spread(
        states, alive.shape, (math.floor(start[0]), math.floor(start[1])), goal <= _SLACK
    )
    length = Fraction(slab, spans.ticks)
    if reached >= 0:
        return Reach(None, float(reached * length))
    there = np.flatnonzero(came >= 0)
    iy, ix = np.divmod(states.tile[there], alive.shape[1])
    stays = np.stack([ix, iy, came[there], states.high[there]], axis=1)
    return Reach(Confinement(k, length, deadline, stays), math.inf)


def _covering(radius: Fraction, k: int) -> list[list[Cell]]:
    """Return, per tile of a cell, the cells (dx, dy) within the radius of every point of it."""
    reach = math.ceil(radius) + 1

    def farthest(tile: int, cell: int) -> Fraction:
        return max(Fraction(cell * k - tile, k), Fraction(tile + 1 - cell * k - k, k), Fraction(0))

    span = range(-reach, reach + 1)
    return [
        [
            (dx, dy)
            for dy in span
            for dx in span
            if farthest(a, dx) ** 2 + farthest(b, dy) ** 2 < radius**2
        ]
        for b in range(k)
        for a in range(k)
    ]


def _alive(fixed: Bools, classes: list[list[Cell]], k: int) -> Bools:
    """Return a (k * height, k * width) bool array: tiles that no permanently solid cell covers."""
    pad = max((max(abs(dx), abs(dy)) for found in classes for dx, dy in found), default=0)
    solid = np.pad(fixed, pad, constant_values=True)
    height, width = fixed.shape
    alive = np.ones((k * height, k * width), np.bool_)
    for kind, found in enumerate(classes):
        part = alive[kind // k :: k, kind % k :: k]
        for dx, dy in found:
            part &= ~solid[pad + dy : pad + dy + height, pad + dx : pad + dx + width]
    return alive


def _inner(spans: Spans) -> CellSpans:
    """Return the spans with each begin rounded up to a tick, and each end rounded down."""

    def ticks(times: Floats, up: bool) -> Ints:
        values, back = np.unique(times, return_inverse=True)
        whole = []
        for value in values.tolist():
            exactly = FOREVER if value == math.inf else exact(value) * spans.ticks
            whole.append(min(math.ceil(exactly) if up else math.floor(exactly), FOREVER))
        return np.array(whole, np.int64)[back.ravel()]

    return CellSpans(
        spans.changing, spans.first, ticks(spans.since, True), ticks(spans.until, False)
    )


def _distances(world: World, shape: tuple[int, ...], k: int) -> tuple[Floats, Floats]:
    """Return each tile's distances, in tile sides, flat, from the start and the target's disc."""
    reach = float(in_cells(world.target.radius, world.cell_size) * k)
    found = []
    for place, less in ((world.start, 0.0), (world.target, reach)):
        x, y = (float(in_cells(value, world.cell_size) * k) for value in (place.x, place.y))
        dx, dy = (
            np.maximum(np.maximum(index - at, at - index - 1.0), 0.0)
            for index, at in ((np.arange(shape[1]), x), (np.arange(shape[0]), y))
        )
        found.append(
            np.maximum(np.sqrt(dx[np.newaxis, :] ** 2 + dy[:, np.newaxis] ** 2).ravel() - less, 0.0)
        )
    return found[0], found[1]


@dataclass
class _States:
    """Tiles with the intervals in which they are alive, in slabs.

    Empty intervals have ``high`` below ``low``.

    Attributes:
        first: Tile t has states first[t] to first[t + 1] - 1.
        tile: Tile of each state.
        low: First slab in which the tile is alive.
        high: Last one.
    """

    first: Ints
    tile: Ints
    low: Ints
    high: Ints

    @classmethod
    def of(cls, safe: Intervals, slab: int) -> _States:
        """Return the intervals in slabs."""
        first, begin, end = (
            np.asarray(values, np.int64) for values in (safe.first, safe.begin, safe.end)
        )
        high = np.where(end >= FOREVER, NEVER_ENDS, (end - 1) // slab)
        return cls(first, np.repeat(np.arange(len(first) - 1), np.diff(first)), begin // slab, high)

    def begin_no_earlier(self, slabs: Floats) -> None:
        """Move the beginning of each tile's states."""
        self.low = np.maximum(self.low, slabs.astype(np.int64)[self.tile])

    def end_no_later(self, slabs: Floats) -> None:
        """Move the end of each tile's states."""
        self.high = np.minimum(self.high, np.clip(slabs, -1.0, 2.0**60).astype(np.int64)[self.tile])


def _spread(states: _States, shape: tuple[int, ...], start: Cell, goal: Bools) -> tuple[Ints, int]:
    """Return the slab in which each state is first reached, -1 for never.

    Also return the slab in which the goal is reached, if it is.
    """
    near = [
        iy * shape[1] + ix
        for iy in range(max(start[1] - 1, 0), min(start[1] + 2, shape[0]))
        for ix in range(max(start[0] - 1, 0), min(start[0] + 2, shape[1]))
    ]
    sources = [
        state
        for tile in near
        for state in range(int(states.first[tile]), int(states.first[tile + 1]))
        if states.low[state] == 0 and states.high[state] >= 0
    ]
    return _spread_out(states, shape, goal.view(np.uint8), sources)


def _spread_out(
    states: _States, shape: tuple[int, ...], goal: Bytes, sources: list[int]
) -> tuple[Ints, int]:
    """Return the same, starting with the states in which the robot may be at first."""
    came: Ints = np.full(len(states.tile), -1, np.int64)
    fields = {
        "rows": shape[0],
        "columns": shape[1],
        "states": len(states.tile),
        **{
            name: pointer(ffi, getattr(states, name), np.int64)
            for name in ("first", "tile", "low", "high")
        },
        "goal": pointer(ffi, goal, np.uint8),
        "came": writable(ffi, came, np.int64),
    }
    tiles = ffi.new("WgTiles *", fields)
    made = ffi.new("WgSpread **")
    progress = ffi.new("WgProgress *")
    slab = ffi.new("int64_t *")
    check(lib.wg_spread_new(tiles, ffi.new("int64_t[]", sources), len(sources), made))
    try:
        while True:
            check(lib.wg_spread_advance(made[0], _PORTION, progress, slab))
            if progress[0] != lib.WG_GOING:
                return came, slab[0]
    finally:
        lib.wg_spread_free(made[0])
