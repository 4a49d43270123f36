"""Whole episodes on the pose lattice: move, sense, act, until something is decided.

One step: the events that are due, then the move at the commanded drive, then sensing, then the controller,
whose turn takes effect at once and whose speed drives the next step. A Python controller runs through the
same pieces one call at a time (:mod:`sim.episode`).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from sim.kernels import layout
from sim.kernels._jit import allocating_kernel, kernel
from sim.kernels.geometry import (
    mark_near,
    pose_is_clear,
    segment_box_depth,
    segment_crosses_box,
    segment_first_not_clear,
    segment_point_within,
    window_is_free,
)
from sim.kernels.lattice_motion import endpoint_move, round_away, swept_move
from sim.kernels.lattice_sense import displacement, sense
from sim.kernels.layout import BURNING, SOLID, TURN, UNIT

__all__ = ["Arena", "advance", "apply_events", "begin", "hash_row", "lattice_episode", "obey"]

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]

_HASH_START = np.uint64(1469598103934665603)  # as in the thesis's vectors: FNV-1a over 64-bit words
_HASH_PRIME = np.uint64(1099511628211)


class Arena(NamedTuple):
    """What surrounds the robot; ``cells``, ``near`` and ``visited`` change during an episode.

    Args:
        cells: (height, width) uint8, cell states now.
        near: (height, width) int32, :func:`sim.kernels.geometry.near_masks` of ``cells``.
        clearance: (height, width) int32, chessboard distance to cells that are ever not free; of no rows where
            the masks reach as far as any step.
        events: (n, 4) int64, rows (step, ix, iy, state), sorted by step.
        headings: (65536,) int64, :func:`sim.kernels.lattice_sense.heading_table`.
        visited: (height, width) uint8, cells that the centre has been in.
    """

    cells: npt.NDArray[np.uint8]
    near: npt.NDArray[np.int32]
    clearance: npt.NDArray[np.int32]
    events: Ints
    headings: Ints
    visited: npt.NDArray[np.uint8]


@kernel
def _drive(units: float) -> int:
    """Whole lattice units of a step, never more than asked for, so that nobody outruns the top speed."""
    whole = int(math.floor(abs(units) + 1e-9))
    return whole if units >= 0.0 else -whole


@allocating_kernel
def begin(settings: Ints, scales: Floats, state: Ints, counts: Ints, sums: Floats) -> None:
    """Sets state and reports to the start of an episode."""
    counts[:] = 0
    sums[:] = 0.0
    counts[layout.OUT_HIT_STEP], counts[layout.OUT_OVERLAP_STEP] = -1, -1
    counts[layout.OUT_DIGEST] = np.int64(_HASH_START)
    state[layout.STATE_X], state[layout.STATE_Y] = settings[layout.SET_X], settings[layout.SET_Y]
    state[layout.STATE_HEADING] = settings[layout.SET_HEADING]
    speed = scales[layout.SCALE_START_SPEED] * scales[layout.SCALE_SPEED]
    state[layout.STATE_DRIVE], state[layout.STATE_DRAWS] = _drive(speed), 0


@kernel
def apply_events(arena: Arena, settings: Ints, step: int, first: int, state: Ints, counts: Ints) -> int:
    """Applies the events due at ``step``; an event that catches the robot ends the run as BURNED.

    Returns:
        Index of the next event.
    """
    while first < arena.events.shape[0] and arena.events[first, 0] <= step:
        ix, iy, new = arena.events[first, 1], arena.events[first, 2], arena.events[first, 3]
        arena.cells[iy, ix] = np.uint8(new)
        mark_near(arena.cells, arena.near, ix, iy)
        first += 1
    clear_sq, reach = settings[layout.SET_CLEAR_SQ], settings[layout.SET_REACH]
    x, y = state[layout.STATE_X], state[layout.STATE_Y]
    for caught in (SOLID, BURNING):
        if not pose_is_clear(arena.cells, caught, clear_sq, reach, x, y):
            _, ix, iy = segment_first_not_clear(arena.cells, caught, clear_sq, reach, (x, y, x, y))
            counts[layout.OUT_ENDING], counts[layout.OUT_HIT_STATE] = layout.BURNED, caught
            counts[layout.OUT_HIT_STEP], counts[layout.OUT_HIT_SEGMENT] = step, 0
            counts[layout.OUT_HIT_IX], counts[layout.OUT_HIT_IY] = ix, iy
            break
    return first


@kernel
def _judge_segment(
    arena: Arena,
    settings: Ints,
    scales: Floats,
    step: int,
    ends: tuple[int, int, int, int],
    counts: Ints,
    sums: Floats,
) -> None:
    """Notes walls that a segment of an unsafe motion model cuts: deepest cut, first overlap, first tunnel."""
    px, py, qx, qy = ends
    reach = settings[layout.SET_REACH]
    radius = math.sqrt(float(settings[layout.SET_CLEAR_SQ]))
    for iy in range(
        max((min(py, qy) - reach) // UNIT, -1), min((max(py, qy) + reach) // UNIT, arena.cells.shape[0]) + 1
    ):
        for ix in range(
            max((min(px, qx) - reach) // UNIT, -1),
            min((max(px, qx) + reach) // UNIT, arena.cells.shape[1]) + 1,
        ):
            inside = 0 <= ix < arena.cells.shape[1] and 0 <= iy < arena.cells.shape[0]
            if inside and arena.cells[iy, ix] != SOLID:
                continue
            depth = segment_box_depth(radius, px, py, qx, qy, ix, iy)
            sums[layout.SUM_OVERLAP] = max(sums[layout.SUM_OVERLAP], depth)
            if depth > scales[layout.SCALE_TOLERANCE] and counts[layout.OUT_OVERLAP_STEP] < 0:
                counts[layout.OUT_OVERLAP_STEP] = step
                counts[layout.OUT_OVERLAP_IX], counts[layout.OUT_OVERLAP_IY] = ix, iy
            if counts[layout.OUT_ENDING] == layout.LIMIT and segment_crosses_box(px, py, qx, qy, ix, iy):
                counts[layout.OUT_ENDING], counts[layout.OUT_HIT_STEP] = layout.TUNNEL, step
                counts[layout.OUT_HIT_IX], counts[layout.OUT_HIT_IY] = ix, iy


@kernel
def _judge_path(
    arena: Arena,
    settings: Ints,
    scales: Floats,
    step: int,
    state: Ints,
    chain: Ints,
    points: int,
    free: bool,
    counts: Ints,
    sums: Floats,
) -> None:
    """What the path of one step meant: fire, walls, target, length; ``free`` if nothing is near it."""
    clear_sq, reach = settings[layout.SET_CLEAR_SQ], settings[layout.SET_REACH]
    x, y = state[layout.STATE_X], state[layout.STATE_Y]
    swept = settings[layout.SET_MOTION] == layout.SWEPT
    fire = arena.events.shape[0] > 0
    for k in range(max(points, 1)):
        qx, qy = (chain[k, 0], chain[k, 1]) if points > 0 else (x, y)
        ends = (x, y, qx, qy)
        if fire and not free and counts[layout.OUT_ENDING] == layout.LIMIT:
            burnt, ix, iy = segment_first_not_clear(arena.cells, BURNING, clear_sq, reach, ends)
            if burnt:
                counts[layout.OUT_ENDING], counts[layout.OUT_HIT_STATE] = layout.BURNED, BURNING
                counts[layout.OUT_HIT_STEP], counts[layout.OUT_HIT_SEGMENT] = step, k
                counts[layout.OUT_HIT_IX], counts[layout.OUT_HIT_IY] = ix, iy
        if not swept and not free and segment_first_not_clear(arena.cells, SOLID, clear_sq, reach, ends)[0]:
            _judge_segment(arena, settings, scales, step, ends, counts, sums)
        if counts[layout.OUT_ENDING] == layout.LIMIT:
            tx, ty, within = (
                settings[layout.SET_TARGET_X],
                settings[layout.SET_TARGET_Y],
                settings[layout.SET_TARGET_SQ],
            )
            from_x, from_y = (x, y) if swept else (qx, qy)
            if segment_point_within(from_x, from_y, qx, qy, tx, ty, within):
                counts[layout.OUT_ENDING] = layout.REACHED
        sums[layout.SUM_PATH] += math.sqrt(float((qx - x) * (qx - x) + (qy - y) * (qy - y)))
        x, y = qx, qy
    state[layout.STATE_X], state[layout.STATE_Y] = x, y


@kernel
def _nothing_near(arena: Arena, reach: int, ends: tuple[int, int, int, int], distance: int) -> bool:
    """Whether the tables show that no cell that is not free is within reach of a step; if not, a closer look is due."""
    if arena.clearance.shape[0] == 0:
        return window_is_free(arena.near, reach, ends)
    x, y = ends[0], ends[1]
    return bool((arena.clearance[y // UNIT, x // UNIT] - 1) * UNIT >= reach + distance)


@kernel
def advance(
    arena: Arena,
    settings: Ints,
    scales: Floats,
    step: int,
    state: Ints,
    chain: Ints,
    counts: Ints,
    sums: Floats,
) -> tuple[int, float, float]:
    """Moves the robot by its commanded drive and judges the path.

    Returns:
        Points of ``chain`` that were used, and the normal of the contact (0, 0 for none).
    """
    x, y, drive = state[layout.STATE_X], state[layout.STATE_Y], state[layout.STATE_DRIVE]
    clear_sq, reach = settings[layout.SET_CLEAR_SQ], settings[layout.SET_REACH]
    dx, dy = displacement(arena.headings, state[layout.STATE_HEADING], drive)
    points, nx, ny = 0, 0.0, 0.0
    if _nothing_near(arena, reach, (x, y, x + dx, y + dy), abs(drive)):
        free = True
        if drive != 0:
            chain[0, 0], chain[0, 1] = x + dx, y + dy
            points = 1
    else:
        free = False
        if settings[layout.SET_MOTION] == layout.SWEPT:
            points, nx, ny = swept_move(arena.cells, clear_sq, reach, x, y, dx, dy, chain)
        else:
            points, nx, ny = endpoint_move(arena.cells, clear_sq, reach, x, y, dx, dy, chain)
    _judge_path(arena, settings, scales, step, state, chain, points, free, counts, sums)
    jx, jy = state[layout.STATE_X] // UNIT, state[layout.STATE_Y] // UNIT
    if 0 <= jx < arena.visited.shape[1] and 0 <= jy < arena.visited.shape[0] and arena.visited[jy, jx] == 0:
        arena.visited[jy, jx] = 1
        counts[layout.OUT_LAST_NEW_CELL] = step
    return points, nx, ny


@kernel
def obey(scales: Floats, command: Floats, state: Ints, counts: Ints) -> None:
    """Applies a command: the turn now, the speed in the next step; clamps both, refuses nan and infinities."""
    speed, rate = command[layout.CMD_SPEED], command[layout.CMD_TURN_RATE]
    if not (math.isfinite(speed) and math.isfinite(rate)):
        counts[layout.OUT_ENDING] = layout.INVALID_COMMAND
        return
    top = scales[layout.SCALE_TOP_SPEED]
    speed = min(max(speed, -top), top)
    turn = min(max(rate * scales[layout.SCALE_TURN], -float(TURN // 2)), float(TURN // 2))
    state[layout.STATE_HEADING] = (state[layout.STATE_HEADING] + round_away(turn)) % TURN
    state[layout.STATE_DRIVE] = _drive(speed * scales[layout.SCALE_SPEED])
    if command[layout.CMD_DRAW] != 0.0:
        state[layout.STATE_DRAWS] += 1


@kernel
def hash_row(row: Ints, counts: Ints) -> None:
    """Adds one row of the trace to the digest."""
    digest = np.uint64(counts[layout.OUT_DIGEST])
    for word in row:
        digest = (digest ^ np.uint64(word)) * _HASH_PRIME
    counts[layout.OUT_DIGEST] = np.int64(digest)


@kernel
def _write_row(state: Ints, chain: Ints, points: int, bumped: bool, row: Ints) -> None:
    row[layout.ROW_BUMP] = 1 if bumped else 0
    corners = max(points - 1, 0)
    row[layout.ROW_CORNERS] = corners
    for k in range(2):
        used = k < corners
        row[layout.ROW_CORNER_1 + 2 * k] = chain[k, 0] if used else 0
        row[layout.ROW_CORNER_1 + 2 * k + 1] = chain[k, 1] if used else 0
    for k in range(state.size):
        row[layout.ROW_STATE + k] = state[k]


@kernel
def _same(one: Ints, other: Ints) -> bool:
    k = 0
    while k < one.size and one[k] == other[k]:
        k += 1
    return k == one.size


@allocating_kernel
def lattice_episode(
    arena: Arena,
    settings: Ints,
    scales: Floats,
    act: Any,
    memory: Floats,
    counts: Ints,
    sums: Floats,
    trace: Ints,
) -> None:
    """Runs one episode.

    Args:
        arena: Surroundings; ``cells`` must hold the state before the first event, ``visited`` zeros.
        settings: See :mod:`sim.kernels.layout`, ``SET_``.
        scales: ``SCALE_``.
        act: Compiled controller, ``act(observation, memory, command)``.
        memory: Its memory, at the state of its reset.
        counts: Filled, ``OUT_``.
        sums: Filled, ``SUM_``.
        trace: (steps + 1, ROW_STATE + STATE_MEMORY + len(memory)) for a recording, or with 0 rows.

    Recurrence of the complete state is looked for with R. P. Brent, "An improved Monte Carlo factorization
    algorithm", BIT 1980, once the last event is over.
    """
    words = memory.view(np.int64)
    state = np.zeros(layout.STATE_MEMORY + memory.size, np.int64)
    anchor = np.zeros_like(state)
    row = np.zeros(layout.ROW_STATE + state.size, np.int64)
    chain = np.zeros((4, 2), np.int64)
    observation, command = np.full(layout.OBS_SIZE, np.nan), np.zeros(layout.CMD_SIZE)
    begin(settings, scales, state, counts, sums)
    state[layout.STATE_MEMORY :] = words
    if trace.shape[0] > 0:
        trace[0, layout.ROW_STATE :] = state
    quiet = arena.events[arena.events.shape[0] - 1, 0] if arena.events.shape[0] > 0 else 0
    event, power, period, touching = 0, 1, 0, False
    hashed = settings[layout.SET_DIGEST] != 0
    for step in range(1, settings[layout.SET_STEPS] + 1):
        counts[layout.OUT_STEPS] = step
        if event < arena.events.shape[0] and arena.events[event, 0] <= step:
            event = apply_events(arena, settings, step, event, state, counts)
        points, nx, ny = 0, 0.0, 0.0
        if counts[layout.OUT_ENDING] == layout.LIMIT:
            points, nx, ny = advance(arena, settings, scales, step, state, chain, counts, sums)
        bumped = nx != 0.0 or ny != 0.0
        if bumped and not touching:
            counts[layout.OUT_COLLISIONS] += 1
        touching = bumped
        pose = (state[layout.STATE_X], state[layout.STATE_Y], state[layout.STATE_HEADING])
        inside = 0 <= pose[0] // UNIT < arena.cells.shape[1] and 0 <= pose[1] // UNIT < arena.cells.shape[0]
        if counts[layout.OUT_ENDING] == layout.LIMIT and inside:
            sense(arena.cells, settings, scales, pose, (nx, ny), state[layout.STATE_DRAWS], observation)
            for k in range(command.size):
                command[k] = 0.0
            act(observation, memory, command)
            obey(scales, command, state, counts)
        for k in range(words.size):
            state[layout.STATE_MEMORY + k] = words[k]
        if hashed or step < trace.shape[0]:
            _write_row(state, chain, points, bumped, row)
            if hashed:
                hash_row(row, counts)
            if step < trace.shape[0]:
                trace[step, :] = row
        if counts[layout.OUT_ENDING] != layout.LIMIT:
            break
        if settings[layout.SET_FIND_LOOP] != 0 and step > quiet:
            period += 1
            if _same(state, anchor):
                counts[layout.OUT_ENDING], counts[layout.OUT_PERIOD] = layout.LOOP, period
                break
            if period == power:
                anchor[:] = state
                power, period = 2 * power, 0
    counts[layout.OUT_DRAWS] = state[layout.STATE_DRAWS]
    counts[layout.OUT_X], counts[layout.OUT_Y] = state[layout.STATE_X], state[layout.STATE_Y]
    counts[layout.OUT_HEADING] = state[layout.STATE_HEADING]
