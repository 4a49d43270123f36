"""Whole runs of the thesis's robot, tick by tick, in its own frame: pixels, y down, float64.

One tick: the events that are due, then the motion at the present speed and heading, then the arbiter and the
behaviour in charge. See :mod:`sim.kernels.thesis_layout` for what stands where.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from sim.kernels import thesis_layout as at
from sim.kernels._jit import allocating_kernel, kernel
from sim.kernels.fdlibm import cos, float_bits, sin
from sim.kernels.layout import BURNING, SOLID
from sim.kernels.stepped_motion import advance
from sim.kernels.thesis_arbiter import (
    COLLIDE,
    DRIVE,
    GO,
    IDLE,
    RESUME,
    SEEK,
    TURN,
    run_behaviour,
    select_behaviour,
)
from sim.kernels.thesis_layout import CELL, FLAME, WALL, Arena, Progress, Setup
from sim.kernels.thesis_signal import signal_direction, turn_towards

__all__ = ["thesis_episode"]

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Cells = npt.NDArray[np.int32]

_HASH_PRIME = np.uint64(1099511628211)
_TWO_PI = 2.0 * math.pi


@kernel
def _gap(cells: Cells, kind: int, x: float, y: float) -> tuple[float, int, int]:
    """Distance, px, from a point to the nearest cell of a kind within two cells, and that cell; inf if none."""
    own_x, own_y = int(math.floor(x / CELL)), int(math.floor(y / CELL))
    best, best_x, best_y = math.inf, -1, -1
    for cell_y in range(max(own_y - 2, 0), min(own_y + 3, cells.shape[1])):
        for cell_x in range(max(own_x - 2, 0), min(own_x + 3, cells.shape[0])):
            if cells[cell_x, cell_y] == kind:
                dx = max(cell_x * CELL - x, 0.0, x - (cell_x + 1) * CELL)
                dy = max(cell_y * CELL - y, 0.0, y - (cell_y + 1) * CELL)
                gap = math.sqrt(dx * dx + dy * dy)
                if gap < best:
                    best, best_x, best_y = gap, cell_x, cell_y
    return best, best_x, best_y


@kernel
def _apply_events(arena: Arena, radius: float, step: int, state: Floats, counts: Ints) -> None:
    """Applies the events due at ``step``; one that catches the robot ends the run as BURNED."""
    changed = False
    while counts[at.NEXT_EVENT] < arena.events.shape[0] and arena.events[counts[at.NEXT_EVENT], 0] <= step:
        event = counts[at.NEXT_EVENT]
        x, y, new = arena.events[event, 1], arena.events[event, 2], arena.events[event, 3]
        arena.cells[x, y] = WALL if new == SOLID else (FLAME if new == BURNING else arena.light[x, y])
        counts[at.NEXT_EVENT] += 1
        changed = changed or new == SOLID
    if changed:
        gap, ix, iy = _gap(arena.cells, WALL, state[at.X], state[at.Y])
        if gap < radius - 1.0:  # what it overlaps by less it may have been touching before
            _burn(step, SOLID, ix, iy, counts)


@kernel
def _burn(step: int, kind: int, ix: int, iy: int, counts: Ints) -> None:
    counts[at.OUT_ENDING], counts[at.OUT_HIT_STATE] = at.BURNED, kind
    counts[at.OUT_HIT_STEP], counts[at.OUT_HIT_IX], counts[at.OUT_HIT_IY] = step, ix, iy


@kernel
def _crosses(x: float, y: float, end_x: float, end_y: float, cell_x: int, cell_y: int) -> bool:
    """Whether a segment meets the open inside of a cell (Liang and Barsky, 1984)."""
    first, last = 0.0, 1.0
    for axis in range(2):
        start, way = (x, end_x - x) if axis == 0 else (y, end_y - y)
        low = (cell_x if axis == 0 else cell_y) * CELL
        if way == 0.0:
            if start <= low or start >= low + CELL:
                return False
            continue
        one, two = (low - start) / way, (low + CELL - start) / way
        first, last = max(first, min(one, two)), min(last, max(one, two))
    return first < last or (first == last and first > 0.0 and last < 1.0 and end_x == x and end_y == y)


@kernel
def _judge(arena: Arena, setup: Setup, step: int, old_x: float, old_y: float, progress: Progress) -> None:
    """What a tick's motion meant: walls cut and crossed, flames, target, new cells, length."""
    cells, counts, sums = arena.cells, progress.counts, progress.sums
    x, y = progress.state[at.X], progress.state[at.Y]
    ix, iy = int(x / CELL), int(y / CELL)
    gap, wall_x, wall_y = _gap(cells, WALL, x, y)
    depth = max(setup.radius - gap, 0.0)
    sums[at.SUM_OVERLAP] = max(sums[at.SUM_OVERLAP], depth)
    if depth > setup.tolerance and counts[at.OUT_OVERLAP_STEP] < 0:
        counts[at.OUT_OVERLAP_STEP], counts[at.OUT_OVERLAP_IX], counts[at.OUT_OVERLAP_IY] = step, wall_x, wall_y
    if cells[ix, iy] == WALL and counts[at.OUT_IN_WALL_STEP] < 0:
        counts[at.OUT_IN_WALL_STEP], counts[at.OUT_IN_WALL_IX], counts[at.OUT_IN_WALL_IY] = step, ix, iy
    if counts[at.OUT_TUNNEL_STEP] < 0 and (depth > 0.0 or setup.speed * setup.time_step > CELL):
        for cell_x in range(int(min(x, old_x) / CELL), int(max(x, old_x) / CELL) + 1):
            for cell_y in range(int(min(y, old_y) / CELL), int(max(y, old_y) / CELL) + 1):
                if cells[cell_x, cell_y] == WALL and _crosses(old_x, old_y, x, y, cell_x, cell_y):
                    counts[at.OUT_TUNNEL_STEP], counts[at.OUT_TUNNEL_IX], counts[at.OUT_TUNNEL_IY] = (
                        step,
                        cell_x,
                        cell_y,
                    )
    if arena.visited[ix, iy] == 0:
        arena.visited[ix, iy] = 1
        counts[at.OUT_LAST_NEW_CELL] = step
    sums[at.SUM_PATH] += math.sqrt((x - old_x) * (x - old_x) + (y - old_y) * (y - old_y))
    flame, flame_x, flame_y = _gap(cells, FLAME, x, y) if arena.events.shape[0] > 0 else (math.inf, -1, -1)
    if flame < setup.radius:
        _burn(step, BURNING, flame_x, flame_y, counts)
    elif setup.stop_at_tunnel != 0 and counts[at.OUT_TUNNEL_STEP] >= 0:
        counts[at.OUT_ENDING] = at.TUNNEL
    elif cells[ix, iy] == 0:
        counts[at.OUT_ENDING] = at.REACHED


@kernel
def _take_control(setup: Setup, draws: Floats, progress: Progress) -> None:
    """What collide does when it takes control: remembers the speed, stops, sets the new target heading."""
    state, mode = progress.state, progress.mode
    state[at.OLD_SPEED], state[at.SPEED] = state[at.SPEED], 0.0
    progress.counts[at.OUT_ACTIVATIONS] += 1
    if setup.rule == 3:
        state[at.TARGET_HEADING] = draws[mode[at.DRAWS_USED]] * _TWO_PI
        mode[at.DRAWS_USED] += 1
    else:
        turn = math.pi / 2.0 if setup.rule == 1 else -math.pi / 2.0
        state[at.TARGET_HEADING] = np.fmod(state[at.HEADING] + turn, _TWO_PI)


@kernel
def _arbitrate(arena: Arena, setup: Setup, draws: Floats, progress: Progress) -> bool:
    """One tick of arbiter and behaviour; False if a random number was needed and none was left."""
    state, mode = progress.state, progress.mode
    collision = mode[at.COLLISION] != 0
    signal = signal_direction(arena.cells, state[at.X], state[at.Y], setup.sense)
    if mode[at.BEHAVIOUR] == IDLE and collision and setup.rule == 3 and mode[at.DRAWS_USED] >= draws.size:
        return False
    behaviour, ticks, taken = select_behaviour(
        mode[at.BEHAVIOUR],
        mode[at.TICKS_LEFT],
        collision,
        state[at.TARGET_HEADING] == signal,
        setup.collide_ticks,
        setup.drive_ticks,
    )
    if taken and behaviour == COLLIDE:
        _take_control(setup, draws, progress)
    if behaviour == SEEK:
        state[at.SPEED], state[at.TARGET_HEADING] = 0.0, signal
    mode[at.ACTIVE] = behaviour
    turned = state[at.HEADING] == state[at.TARGET_HEADING]
    wheels, behaviour, ticks = run_behaviour(behaviour, ticks, collision, turned)
    if wheels == TURN:
        state[at.HEADING] = turn_towards(state[at.HEADING], state[at.TARGET_HEADING])
    elif wheels == GO:
        state[at.SPEED] = setup.speed
    elif wheels == RESUME:
        state[at.SPEED] = state[at.OLD_SPEED]
    mode[at.BEHAVIOUR] = behaviour
    mode[at.TICKS_LEFT] = ticks if behaviour in (COLLIDE, DRIVE) else 0
    return True


@kernel
def _hash(progress: Progress) -> None:
    """Adds the seven state words of a tick to the digest, as the recorded vectors do."""
    state, mode = progress.state, progress.mode
    digest = np.uint64(progress.counts[at.OUT_DIGEST])
    for k in range(5):
        digest = (digest ^ np.uint64(float_bits(state[k]))) * _HASH_PRIME
    busy = 0 if mode[at.BEHAVIOUR] == IDLE else 2 + 4 * (mode[at.BEHAVIOUR] + 1)
    digest = (digest ^ np.uint64(mode[at.COLLISION] + busy)) * _HASH_PRIME
    digest = (digest ^ np.uint64(float_bits(float(mode[at.TICKS_LEFT])))) * _HASH_PRIME
    progress.counts[at.OUT_DIGEST] = np.int64(digest)


@kernel
def _recurs(progress: Progress) -> bool:
    """Compares the complete state with Brent's anchor, and moves the anchor when its time has come."""
    counts = progress.counts
    counts[at.ANCHOR_AGE] += 1
    same = counts[at.ANCHOR_POWER] > 0
    for k in range(at.STATE_SIZE):
        same = same and float_bits(progress.state[k]) == float_bits(progress.anchor_state[k])
    for k in range(at.MODE_STATE_SIZE):
        same = same and progress.mode[k] == progress.anchor_mode[k]
    if same:
        return True
    if counts[at.ANCHOR_AGE] >= counts[at.ANCHOR_POWER]:
        for k in range(at.STATE_SIZE):
            progress.anchor_state[k] = progress.state[k]
        for k in range(at.MODE_STATE_SIZE):
            progress.anchor_mode[k] = progress.mode[k]
        counts[at.ANCHOR_POWER], counts[at.ANCHOR_AGE] = max(2 * counts[at.ANCHOR_POWER], 1), 0
    return False


@allocating_kernel
def thesis_episode(arena: Arena, setup: Setup, progress: Progress, draws: Floats, trace: Floats) -> None:
    """Runs until the target is reached, the run ends otherwise, or ticks or draws are used up.

    Args:
        arena: Surroundings.
        setup: The robot and what is asked.
        progress: Start, and everything that is reported; see :mod:`sim.kernels.thesis_layout`.
        draws: Random numbers in [0, 1) for rule 3; without enough of them the run ends as ``NEEDS_DRAWS``.
        trace: (steps + 1, ROW_SIZE) for a recording, or with 0 rows.

    Recurrence: R. P. Brent, "An improved Monte Carlo factorization algorithm", BIT 1980.
    """
    state, mode, counts = progress.state, progress.mode, progress.counts
    counts[at.OUT_ENDING] = at.LIMIT
    quiet = arena.events[arena.events.shape[0] - 1, 0] if arena.events.shape[0] > 0 else 0
    if trace.shape[0] > 0:
        trace[0, : at.ROW_MODE], trace[0, at.ROW_MODE :] = state, mode
    for step in range(counts[at.OUT_STEPS] + 1, setup.steps + 1):
        old_x, old_y, was_touching = state[at.X], state[at.Y], mode[at.COLLISION]
        counts[at.OUT_STEPS] = step
        _apply_events(arena, setup.radius, step, state, counts)
        if counts[at.OUT_ENDING] == at.LIMIT:
            goal_x = old_x - cos(state[at.HEADING]) * state[at.SPEED] * setup.time_step
            goal_y = old_y - sin(state[at.HEADING]) * state[at.SPEED] * setup.time_step
            x, y, collision = advance(arena.cells, old_x, old_y, goal_x, goal_y, setup.radius)
            state[at.X], state[at.Y], mode[at.COLLISION] = x, y, 1 if collision else 0
            counts[at.OUT_COLLISIONS] += 1 if collision and was_touching == 0 else 0
            _judge(arena, setup, step, old_x, old_y, progress)
        if not _arbitrate(arena, setup, draws, progress):
            counts[at.OUT_ENDING] = at.NEEDS_DRAWS
        _hash(progress)
        if step < trace.shape[0]:
            trace[step, : at.ROW_MODE], trace[step, at.ROW_MODE :] = state, mode
        if counts[at.OUT_ENDING] != at.LIMIT:
            break
        if setup.find_loop != 0 and step > quiet and _recurs(progress):
            counts[at.OUT_ENDING], counts[at.OUT_PERIOD] = at.LOOP, counts[at.ANCHOR_AGE]
            break
