"""Whole runs of the thesis's robot: a tick, and an episode.

A tick: events that are due, then the move at the current speed, then the arbiter, whose turn takes
effect immediately and whose speed drives the next tick.

Source: the thesis's listing, ``simGuiExp.actionPerformed``, ``robot.update`` and the three
    behaviours.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from tests.reference.sim import thesis_layout as at
from tests.reference.sim.fdlibm import cos, float_bits, sin
from tests.reference.sim.random_draw import random_draw
from tests.reference.sim.stepped_motion import CORNER, SLIDE, STRAIGHT, advance, clamp_inside
from tests.reference.sim.thesis_arbiter import (
    A1,
    A2,
    A3,
    COLLIDE,
    GO,
    HALT,
    IDLE,
    INTERRUPTIBLE,
    RESUME,
    SEEK,
    TURN,
    run_behaviour,
    select_behaviour,
)
from tests.reference.sim.thesis_layout import (
    BURNING,
    CELL,
    FLAME,
    NO_LOOP,
    PROVE_LOOP,
    SOLID,
    WALL,
    Arena,
    Progress,
    Setup,
)  # fmt: skip
from tests.reference.sim.thesis_signal import sensed_direction, turn_towards

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Cells = npt.NDArray[np.int32]

_TWO_PI = 2.0 * math.pi
_MASK = 2**64 - 1
_HASH_PRIME = 1099511628211
_FIRST_STEPS = 16  # before the first lookup
_SLIP = 2**16 - 1  # the one random number of a tick that the sensor does not use
_LEAST_CROSSING = (
    1e-6  # px; a shorter path through a wall is due to rounding, and no checker could confirm it
)


def thesis_tick(
    cells: Cells, setup: Setup, draws: Floats, state: Floats, mode: Ints, step: int
) -> tuple[bool, float, float]:
    """Moves the robot and lets the behaviours act.

    Args:
        cells: The signal, see :mod:`tests.reference.sim.thesis_layout`.
        setup: The robot.
        draws: Random numbers in [0, 1) for rule 3, in order.
        state: Changed in place.
        mode: Same as above.
        step: Number of the tick, from 1.

    Returns:
        False if the tick needs a draw and none is left, in which case nothing has changed; and the
        centre before a wall changed the move.
    """
    x, y, collision, move, before_x, before_y, rolling = _move(cells, setup, state, step)
    old = mode[at.BEHAVIOUR]
    behaviour, ticks, reading = old, mode[at.TICKS_LEFT], setup.reading
    heading, target = state[at.HEADING], state[at.TARGET_HEADING]
    speed, old_speed = state[at.SPEED], state[at.OLD_SPEED]
    signal, acted, draws_used = 0.0, IDLE, mode[at.DRAWS_USED]
    if old == SEEK or (not collision and (old == IDLE or reading >= A2)):
        signal = sensed_direction(cells, x, y, heading, setup, step)
    if old != IDLE and reading in (A2, A3):  # act, then select the next behaviour
        acted = old
        heading, target, speed, behaviour, ticks = _act(
            old, ticks, collision, heading, target, speed, old_speed, signal, setup.speed
        )
        if behaviour == IDLE and not collision:
            signal = sensed_direction(cells, x, y, heading, setup, step)
    at_signal = target == signal and (reading != INTERRUPTIBLE or heading == signal)
    chosen, ticks, taken = select_behaviour(
        reading, behaviour, ticks, collision, at_signal, setup.collide_ticks, setup.drive_ticks
    )
    escapes = taken and chosen == COLLIDE
    if escapes:
        if setup.rule == 3 and draws_used >= draws.shape[0]:
            return False, x, y
        if speed > 0.0 or (setup.friction == 0.0 and reading != INTERRUPTIBLE):
            # A robot that rolls out, or is interrupted while it turns, still needs its speed from
            # before that.
            old_speed = speed
        speed = 0.0
        if setup.rule == 1:
            target = np.fmod(heading + setup.turn_angle, _TWO_PI)
        elif setup.rule == 2:
            target = np.fmod(heading - setup.turn_angle, _TWO_PI)
        else:
            target = draws[draws_used] * _TWO_PI
            draws_used += 1
    waits = reading == A2 or (reading == A1 and taken) or (reading == A3 and behaviour != IDLE)
    if not waits:
        acted = chosen
        heading, target, speed, chosen, ticks = _act(
            chosen, ticks, collision, heading, target, speed, old_speed, signal, setup.speed
        )
    state[at.X], state[at.Y], state[at.HEADING], state[at.ROLLING] = x, y, heading, rolling
    state[at.TARGET_HEADING], state[at.SPEED], state[at.OLD_SPEED] = target, speed, old_speed
    mode[at.COLLISION], mode[at.BEHAVIOUR], mode[at.DRAWS_USED] = int(collision), chosen, draws_used
    mode[at.TICKS_LEFT], mode[at.ACTIVE], mode[at.MOVE] = ticks, acted, move
    mode[at.ESCAPES] = int(escapes)
    return True, before_x, before_y


def _move(
    cells: Cells, setup: Setup, state: Floats, step: int
) -> tuple[float, float, bool, int, float, float, float]:
    """The tick's move: the result of :func:`tests.reference.sim.stepped_motion.advance`, and the
    new rolling speed.
    """
    x, y, wanted, rolling = state[at.X], state[at.Y], state[at.SPEED], state[at.ROLLING]
    if rolling < wanted:
        gain = setup.acceleration * setup.time_step
        rolling = wanted if gain == 0.0 else min(rolling + gain, wanted)
    elif rolling > wanted:
        loss = setup.friction * setup.time_step
        rolling = wanted if loss == 0.0 else max(rolling - loss, wanted)
    if rolling == 0.0:  # most ticks only turn: this raises the rate from 12.9 to 15.5 M ticks/s
        x, y = clamp_inside(cells, x, y, setup.radius)
        return x, y, False, STRAIGHT, x, y, rolling
    way = rolling
    if setup.slip > 0.0:
        way *= 1.0 - setup.slip * random_draw(setup.seed, step * 2**16 + _SLIP)
    heading = state[at.HEADING]
    goal_x = x - cos(heading) * way * setup.time_step
    goal_y = y - sin(heading) * way * setup.time_step
    x, y, collision, move, before_x, before_y = advance(
        cells, x, y, goal_x, goal_y, setup.radius, setup.repairs, setup.wall_friction
    )
    if collision and (setup.acceleration > 0.0 or setup.friction > 0.0):
        rolling = rolling * (1.0 - setup.wall_friction) if move == SLIDE else 0.0
    return x, y, collision, move, before_x, before_y, rolling


def _act(
    behaviour: int,
    ticks: int,
    collision: bool,
    heading: float,
    target: float,
    speed: float,
    old_speed: float,
    signal: float,
    top_speed: float,
) -> tuple[float, float, float, int, int]:
    """Lets the behaviour in charge act.

    Heading, target heading, speed, the behaviour then in charge, its counter.
    """
    if behaviour == SEEK:
        target = signal
    wheels, behaviour, ticks = run_behaviour(behaviour, ticks, collision, heading == target)
    if wheels == TURN:
        heading = turn_towards(heading, target)
    if wheels in (TURN, HALT):
        speed = 0.0
    elif wheels == GO:
        speed = top_speed
    elif wheels == RESUME:
        speed = old_speed
    return heading, target, speed, behaviour, ticks


def _gap(x: float, y: float, cell_x: int, cell_y: int) -> float:
    """Distance from a point to a cell, px; 0 inside."""
    dx = max(cell_x * CELL - x, 0.0, x - (cell_x + 1) * CELL)
    dy = max(cell_y * CELL - y, 0.0, y - (cell_y + 1) * CELL)
    return math.sqrt(dx * dx + dy * dy)


def _overlaps(cells: Cells, x: float, y: float, radius: float) -> bool:
    """Whether the disc cuts a wall by more than rounding."""
    reach = math.ceil(radius / CELL)
    for cell_y in range(
        max(int(y / CELL) - reach, 0), min(int(y / CELL) + reach, cells.shape[1] - 1) + 1
    ):
        for cell_x in range(
            max(int(x / CELL) - reach, 0), min(int(x / CELL) + reach, cells.shape[0] - 1) + 1
        ):
            if (
                cells[cell_x, cell_y] == WALL
                and radius - _gap(x, y, cell_x, cell_y) > _LEAST_CROSSING
            ):
                return True
    return False


def _apply_events(arena: Arena, setup: Setup, step: int, state: Floats, counts: Ints) -> None:
    """Applies the events due at ``step``.

    An event that falls on the robot ends the run as ``BURNED``.
    """
    while (
        counts[at.NEXT_EVENT] < arena.events.shape[0]
        and arena.events[counts[at.NEXT_EVENT], 0] <= step
    ):
        event = counts[at.NEXT_EVENT]
        x, y, new = arena.events[event, 1], arena.events[event, 2], arena.events[event, 3]
        counts[at.NEXT_EVENT] += 1
        value = WALL if new == SOLID else (FLAME if new == BURNING else arena.light[x, y])
        harms = new != SOLID or setup.stop_at_tunnel != 0
        falls = value < 0 and value != arena.cells[x, y] and counts[at.OUT_ENDING] == at.LIMIT
        falls = falls and harms
        arena.cells[x, y] = value
        if falls and _gap(state[at.X], state[at.Y], x, y) < setup.radius:
            counts[at.OUT_ENDING], counts[at.OUT_HIT_STATE] = at.BURNED, new
            counts[at.OUT_HIT_STEP], counts[at.OUT_HIT_IX], counts[at.OUT_HIT_IY] = step, x, y


def _judge_place(
    arena: Arena, setup: Setup, step: int, before: tuple[float, float], run: Progress
) -> None:
    """Notes what the robot touches at the end of the tick:

    walls, flames, cells that it had not been in. ``before`` is the centre before a wall changed the
    tick's move: if it already overlaps there, a corner let it in.
    """
    state, counts, sums = run.state, run.counts, run.sums
    x, y = state[at.X], state[at.Y]
    own_x, own_y = int(x / CELL), int(y / CELL)
    reach = math.ceil(setup.radius / CELL)
    deepest, deepest_x, deepest_y = 0.0, -1, -1
    for cell_y in range(max(own_y - reach, 0), min(own_y + reach, arena.cells.shape[1] - 1) + 1):
        for cell_x in range(
            max(own_x - reach, 0), min(own_x + reach, arena.cells.shape[0] - 1) + 1
        ):
            if arena.cells[cell_x, cell_y] >= 0:
                continue
            depth = setup.radius - _gap(x, y, cell_x, cell_y)
            if arena.cells[cell_x, cell_y] == WALL:
                if depth > deepest:
                    deepest, deepest_x, deepest_y = depth, cell_x, cell_y
            elif depth > 0.0 and counts[at.OUT_ENDING] == at.LIMIT:
                counts[at.OUT_ENDING], counts[at.OUT_HIT_STATE] = at.BURNED, BURNING
                counts[at.OUT_HIT_STEP], counts[at.OUT_HIT_IX], counts[at.OUT_HIT_IY] = (
                    step,
                    cell_x,
                    cell_y,
                )
    sums[at.SUM_OVERLAP] = max(sums[at.SUM_OVERLAP], deepest)
    if deepest <= _LEAST_CROSSING:
        counts[at.OVERLAP_BEGAN] = -1
    elif counts[at.OVERLAP_BEGAN] < 0:
        counts[at.OVERLAP_BEGAN], counts[at.OVERLAP_CAUSE] = step, run.mode[at.MOVE]
        if _overlaps(arena.cells, before[0], before[1], setup.radius):
            counts[at.OVERLAP_CAUSE] = CORNER
    if deepest > setup.tolerance and counts[at.OUT_OVERLAP_STEP] < 0:
        counts[at.OUT_OVERLAP_STEP] = step
        counts[at.OUT_OVERLAP_IX], counts[at.OUT_OVERLAP_IY] = deepest_x, deepest_y
        counts[at.OUT_OVERLAP_BEGAN] = counts[at.OVERLAP_BEGAN]
        counts[at.OUT_OVERLAP_CAUSE] = counts[at.OVERLAP_CAUSE]
    if arena.cells[own_x, own_y] == WALL and counts[at.OUT_IN_WALL_STEP] < 0:
        counts[at.OUT_IN_WALL_STEP] = step
        counts[at.OUT_IN_WALL_IX], counts[at.OUT_IN_WALL_IY] = own_x, own_y
    if arena.visited[own_x, own_y] == 0:
        arena.visited[own_x, own_y] = 1
        counts[at.OUT_LAST_NEW_CELL] = step
        counts[at.OUT_VISITED] += 1


def _way_inside(x: float, y: float, dx: float, dy: float, cell_x: int, cell_y: int) -> float:
    """Share, 0 to 1, of the straight path (x, y) + t (dx, dy) that is inside the cell.

    Source: slab test, Ericson, Real-Time Collision Detection (2005), 5.3.3.
    """
    enter, leave = 0.0, 1.0
    for axis in range(2):
        low = cell_x * CELL - x if axis == 0 else cell_y * CELL - y
        way = dx if axis == 0 else dy
        if way == 0.0:
            if not low < 0.0 < low + CELL:
                return 0.0
            continue
        first, last = low / way, (low + CELL) / way
        enter, leave = max(enter, min(first, last)), min(leave, max(first, last))
    return max(leave - enter, 0.0)


def _judge_way(
    arena: Arena,
    setup: Setup,
    step: int,
    x: float,
    y: float,
    state: Floats,
    counts: Ints,
    sums: Floats,
) -> None:
    """Adds the segment from (x, y) to the path, and notes the first wall that it enters."""
    dx, dy = state[at.X] - x, state[at.Y] - y
    length = math.sqrt(dx * dx + dy * dy)
    sums[at.SUM_PATH] += length
    if counts[at.OUT_TUNNEL_STEP] >= 0:
        return
    end_x, end_y = int(state[at.X] / CELL), int(state[at.Y] / CELL)
    own_x, own_y = int(x / CELL), int(y / CELL)
    for cell_y in range(min(own_y, end_y), max(own_y, end_y) + 1):
        for cell_x in range(min(own_x, end_x), max(own_x, end_x) + 1):
            if arena.cells[cell_x, cell_y] != WALL or counts[at.OUT_TUNNEL_STEP] >= 0:
                continue
            if _way_inside(x, y, dx, dy, cell_x, cell_y) * length > _LEAST_CROSSING:
                counts[at.OUT_TUNNEL_STEP] = step
                counts[at.OUT_TUNNEL_IX], counts[at.OUT_TUNNEL_IY] = cell_x, cell_y
                counts[at.OUT_TUNNEL_BEGAN] = counts[at.OVERLAP_BEGAN]
                counts[at.OUT_TUNNEL_CAUSE] = counts[at.OVERLAP_CAUSE]
    if (
        setup.stop_at_tunnel == 1
        and counts[at.OUT_TUNNEL_STEP] >= 0
        and counts[at.OUT_ENDING] == at.LIMIT
    ):
        counts[at.OUT_ENDING] = at.TUNNEL


def _hash_word(digest: int, word: int) -> int:
    """FNV-1a of one 64-bit word."""
    return ((digest ^ (word & _MASK)) * _HASH_PRIME) & _MASK


def _hash_state(digest: int, state: Floats, mode: Ints) -> int:
    """Adds the seven words of a tick's state to the digest, as the recorded vectors do."""
    for word in range(at.SPEED + 1):
        digest = _hash_word(digest, int(float_bits(state[word])))
    busy = 0 if mode[at.BEHAVIOUR] == IDLE else 2 + 4 * (int(mode[at.BEHAVIOUR]) + 1)
    digest = _hash_word(digest, int(mode[at.COLLISION]) + busy)
    return _hash_word(digest, int(float_bits(float(mode[at.TICKS_LEFT]))))


def _record(state: Floats, mode: Ints, row: int, trace: Floats) -> None:
    """Writes the state to a row of the trace, if it has that row."""
    if 0 <= row < trace.shape[0]:
        for k in range(at.STATE_SIZE):
            trace[row, k] = state[k]
        for k in range(at.MODE_SIZE):
            trace[row, at.ROW_MODE + k] = float(mode[k])


def _complete_state(run: Progress) -> bytes:
    """Everything that decides the future, as bytes: -0.0 is not 0.0."""
    return run.state.tobytes() + run.mode[: at.MODE_STATE_SIZE].tobytes()


def _period(setup: Setup, run: Progress, step: int, quiet: int) -> int:
    """Returns the steps since the state last occurred, if a recurrence ends the run here.

    Else 0. The last state of the budget is looked up, and some earlier ones, each twice as far
    along as the previous one.
    """
    if step < quiet:
        return 0
    search, state = run.search, _complete_state(run)
    if setup.find_loop == PROVE_LOOP:
        if step == setup.loop_entry:
            search.known = state
        proved = step == setup.steps and state == search.known
        return setup.steps - setup.loop_entry if proved else 0
    search.states[step] = state
    if step < search.next and step < setup.steps:
        return 0
    search.next = 2 * step - quiet + _FIRST_STEPS
    earlier = [k for k in range(quiet, step) if search.states.get(k) == state]
    return step - earlier[-1] if earlier else 0


def thesis_episode(arena: Arena, setup: Setup, run: Progress, draws: Floats, trace: Floats) -> None:
    """Runs until there is a verdict, or ``setup.steps`` ticks are done.

    A run that ended as ``LIMIT`` or ``NEEDS_DRAWS`` continues where it stopped, if called again
    with the same arena and more steps or draws (the earlier draws stay in front).

    Args:
        arena: Surroundings, changed in place.
        setup: The robot and the options.
        run: A fresh or a stopped run; see :mod:`tests.reference.sim.thesis_layout`, ``OUT_`` and
            ``SUM_``.
        draws: Random numbers in [0, 1) for rule 3, in order.
        trace: (n, ROW_SIZE), n may be 0; row k gets the state after step ``TRACE_START`` + k.

    If several endings happen in one tick, the first of these counts: ``BURNED``, ``TUNNEL``,
    ``REACHED``, ``LOOP``. A recurrence of the complete state after the last event is found when it
    is looked up.
    """
    cells, state, mode, counts = arena.cells, run.state, run.mode, run.counts
    quiet = arena.events[arena.events.shape[0] - 1, 0] if arena.events.shape[0] > 0 else 0
    if setup.find_loop != NO_LOOP and counts[at.OUT_STEPS] == 0:
        run.search.states[0] = run.search.known = _complete_state(run)
        run.search.next = quiet + _FIRST_STEPS
    counts[at.OUT_ENDING] = at.LIMIT
    _record(state, mode, counts[at.OUT_STEPS] - counts[at.TRACE_START], trace)
    for step in range(counts[at.OUT_STEPS] + 1, setup.steps + 1):
        changed = step == 1
        if (
            counts[at.NEXT_EVENT] < arena.events.shape[0]
            and arena.events[counts[at.NEXT_EVENT], 0] <= step
        ):
            _apply_events(arena, setup, step, state, counts)
            changed = True
        x, y, touched = state[at.X], state[at.Y], mode[at.COLLISION]
        if counts[at.OUT_ENDING] == at.LIMIT:
            done, before_x, before_y = thesis_tick(cells, setup, draws, state, mode, step)
            if not done:
                counts[at.OUT_ENDING] = at.NEEDS_DRAWS
                return
            counts[at.OUT_COLLISIONS] += 1 if mode[at.COLLISION] == 1 and touched == 0 else 0
            counts[at.OUT_ACTIVATIONS] += mode[at.ESCAPES]
            if changed or state[at.X] != x or state[at.Y] != y:
                _judge_place(arena, setup, step, (before_x, before_y), run)
                _judge_way(arena, setup, step, x, y, state, counts, run.sums)
            if (
                counts[at.OUT_ENDING] == at.LIMIT
                and cells[int(state[at.X] / CELL), int(state[at.Y] / CELL)] == 0
            ):
                counts[at.OUT_ENDING] = at.REACHED
        counts[at.OUT_STEPS] = step
        if setup.digest == 1:
            digests = counts.view(np.uint64)
            digests[at.OUT_DIGEST] = _hash_state(int(digests[at.OUT_DIGEST]), state, mode)
        if step - counts[at.TRACE_START] < trace.shape[0]:
            _record(state, mode, step - counts[at.TRACE_START], trace)
        if counts[at.OUT_ENDING] == at.LIMIT and setup.find_loop != NO_LOOP:
            period = _period(setup, run, step, quiet)
            if period > 0:
                counts[at.OUT_ENDING], counts[at.OUT_PERIOD] = at.LOOP, period
        if counts[at.OUT_ENDING] != at.LIMIT:
            break
