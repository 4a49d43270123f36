"""Whole episodes on the pose lattice: move, sense, act, until something is decided.

One step: the move at the speed of the wheels, with the events that fall into it each at its time, then sensing,
then the controller, whose turn takes effect at once and whose speed drives the next step.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from sim.kernels import layout
from sim.kernels._jit import allocating_kernel, kernel, rare_kernel
from sim.kernels.geometry import (
    mark_near,
    pose_is_clear,
    segment_box_depth,
    segment_crosses_box,
    segment_first_not_clear,
    segment_point_within,
    window_is_free,
)
from sim.kernels.lattice_motion import MOST_POINTS, endpoint_move, round_away, swept_move
from sim.kernels.lattice_sense import (
    NOISE_SLIP,
    NOISE_TURN,
    NOISE_WAY,
    displacement,
    noise_channel,
    noise_draw,
    sense,
)
from sim.kernels.layout import BURNING, SOLID, SPEED_UNIT, SWEPT, TIME_UNIT, TURN, UNIT

__all__ = ["Arena", "Robot", "Room", "lattice_batch", "lattice_episode", "lattice_steps", "new_robot", "new_room"]

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
        events: (n, EVENT_SIZE) int64, sorted by step and time.
        headings: (65536,) int64, :func:`sim.kernels.lattice_sense.heading_table`.
        visited: (height, width) uint8, cells that the centre has been in.
    """

    cells: npt.NDArray[np.uint8]
    near: npt.NDArray[np.int32]
    clearance: npt.NDArray[np.int32]
    events: Ints
    headings: Ints
    visited: npt.NDArray[np.uint8]


class Robot(NamedTuple):
    """The robot and what is reported of it.

    Args:
        state: (STATE_MEMORY + memory,) int64, ``STATE_``.
        odometry: (3,) x and y, lattice units, and heading, heading units, as the robot measured them.
        chain: (n, 3) int64, path of the last step: x, y, time in the step.
        counts: (OUT_SIZE,) int64, ``OUT_``.
        sums: (SUM_SIZE,) ``SUM_``.
    """

    state: Ints
    odometry: Floats
    chain: Ints
    counts: Ints
    sums: Floats


class Room(NamedTuple):
    """What an episode works with, made beforehand, so that kernels make no arrays.

    Args:
        memory: The controller's memory.
        words: The same bits as int64.
        observation: (OBS_SIZE + beams,) what the controller sees.
        command: (CMD_SIZE,) what it asks for.
        anchor: A state to come back to.
        brent: (3,) int64, steps from the anchor to the next one, steps since it, and whether the last step
            touched a wall.
    """

    memory: Floats
    words: Ints
    observation: Floats
    command: Floats
    anchor: Ints
    brent: Ints


def new_robot(memory: int, events: Ints) -> Robot:
    """A robot with so many numbers of memory, and room for the path of a step with the most events."""
    most = int(np.bincount(events[:, layout.EVENT_STEP] - events[0, layout.EVENT_STEP]).max()) if len(events) else 0
    return Robot(
        np.zeros(layout.STATE_MEMORY + memory, np.int64),
        np.zeros(3),
        np.zeros((MOST_POINTS * (most + 1), 3), np.int64),
        np.zeros(layout.OUT_SIZE, np.int64),
        np.zeros(layout.SUM_SIZE),
    )


def new_room(memory: int, beams: int) -> Room:
    """Room for a controller with so many numbers of memory, and so many range beams."""
    values = np.zeros(memory)
    return Room(
        values,
        values.view(np.int64),
        np.full(layout.OBS_SIZE + beams, np.nan),
        np.zeros(layout.CMD_SIZE),
        np.zeros(layout.STATE_MEMORY + memory, np.int64),
        np.zeros(3, np.int64),
    )


@kernel
def _whole(value: int) -> int:
    """A number as such: numba takes a bare 0 for a type of its own, and would compile all that gets it twice."""
    return value


@kernel
def _speed(asked: float) -> int:
    """Whole units of speed, never more than asked for, so that nobody outruns the top speed."""
    whole = int(math.floor(abs(asked) + 1e-9))
    return whole if asked >= 0.0 else -whole


@kernel
def _drive(speed: int) -> int:
    """Whole lattice units that a speed drives in a step."""
    return speed // SPEED_UNIT if speed >= 0 else -(-speed // SPEED_UNIT)


@rare_kernel
def _begin(settings: Ints, scales: Floats, robot: Robot) -> None:
    """Sets state and reports to the start of an episode."""
    state, counts = robot.state, robot.counts
    for k in range(counts.size):
        counts[k] = 0
    for k in range(robot.sums.size):
        robot.sums[k] = 0.0
    counts[layout.OUT_HIT_STEP], counts[layout.OUT_OVERLAP_STEP] = -1, -1
    counts[layout.OUT_DIGEST] = np.int64(_HASH_START)
    state[layout.STATE_X], state[layout.STATE_Y] = settings[layout.SET_X], settings[layout.SET_Y]
    state[layout.STATE_HEADING] = settings[layout.SET_HEADING]
    speed = scales[layout.SCALE_START_SPEED] * scales[layout.SCALE_SPEED] * SPEED_UNIT
    state[layout.STATE_SPEED], state[layout.STATE_DRAWS] = _speed(speed), 0
    for k in range(3):
        robot.odometry[k] = float(state[layout.STATE_X + k])


@rare_kernel
def _apply_events(arena: Arena, settings: Ints, step: int, first: int, robot: Robot) -> int:
    """Applies all events of one time; one that catches the robot ends the run as BURNED.

    Returns:
        Index of the next event.
    """
    events, counts = arena.events, robot.counts
    time = events[first, layout.EVENT_TIME]
    while (
        first < events.shape[0]
        and events[first, layout.EVENT_STEP] == step
        and events[first, layout.EVENT_TIME] == time
    ):
        ix, iy = events[first, layout.EVENT_IX], events[first, layout.EVENT_IY]
        arena.cells[iy, ix] = np.uint8(events[first, layout.EVENT_STATE])
        mark_near(arena.cells, arena.near, ix, iy)
        first += 1
    clear_sq, reach = settings[layout.SET_CLEAR_SQ], settings[layout.SET_REACH]
    x, y = robot.state[layout.STATE_X], robot.state[layout.STATE_Y]
    for caught in (SOLID, BURNING):
        if not pose_is_clear(arena.cells, caught, clear_sq, reach, x, y):
            _, ix, iy = segment_first_not_clear(arena.cells, caught, clear_sq, reach, (x, y, x, y))
            counts[layout.OUT_ENDING], counts[layout.OUT_HIT_STATE] = layout.BURNED, caught
            counts[layout.OUT_HIT_STEP] = step
            counts[layout.OUT_HIT_IX], counts[layout.OUT_HIT_IY] = ix, iy
            break
    return first


@rare_kernel
def _judge_segment(
    arena: Arena, settings: Ints, scales: Floats, step: int, ends: tuple[int, int, int, int], robot: Robot
) -> None:
    """Notes walls that a segment of an unsafe motion model cuts: deepest cut, first overlap, first tunnel."""
    px, py, qx, qy = ends
    counts, sums = robot.counts, robot.sums
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
    arena: Arena, settings: Ints, scales: Floats, step: int, rows: tuple[int, int], free: bool, robot: Robot
) -> None:
    """What a piece of a step's path meant: fire, walls, target, length; and puts the robot at its end.

    Args:
        arena: Surroundings.
        settings: ``SET_``.
        scales: ``SCALE_``.
        step: Number of the step.
        rows: First row of the chain, and the one after the last; none if the robot stands.
        free: Whether nothing is near the path.
        robot: The robot.
    """
    state, counts, sums = robot.state, robot.counts, robot.sums
    clear_sq, reach = settings[layout.SET_CLEAR_SQ], settings[layout.SET_REACH]
    x, y = state[layout.STATE_X], state[layout.STATE_Y]
    swept = settings[layout.SET_MOTION] == SWEPT
    fire = arena.events.shape[0] > 0
    for k in range(rows[0], max(rows[1], rows[0] + 1)):
        qx, qy = (robot.chain[k, 0], robot.chain[k, 1]) if k < rows[1] else (x, y)
        ends = (x, y, qx, qy)
        if fire and not free and counts[layout.OUT_ENDING] == layout.LIMIT:
            burnt, ix, iy = segment_first_not_clear(arena.cells, BURNING, clear_sq, reach, ends)
            if burnt:
                counts[layout.OUT_ENDING], counts[layout.OUT_HIT_STATE] = layout.BURNED, BURNING
                counts[layout.OUT_HIT_STEP] = step
                counts[layout.OUT_HIT_IX], counts[layout.OUT_HIT_IY] = ix, iy
        if not swept and not free and segment_first_not_clear(arena.cells, SOLID, clear_sq, reach, ends)[0]:
            _judge_segment(arena, settings, scales, step, ends, robot)
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
def _move(
    arena: Arena,
    settings: Ints,
    scales: Floats,
    step: int,
    part: tuple[int, int],
    during: tuple[int, int],
    count: int,
    robot: Robot,
) -> tuple[int, float, float]:
    """Moves the robot by a part of a step, in which the world stands still, and judges the path.

    Args:
        arena: Surroundings.
        settings: ``SET_``.
        scales: ``SCALE_``.
        step: Number of the step.
        part: Displacement, lattice units.
        during: When the part begins and ends, ``TIME_UNIT``ths of the step.
        count: Rows of the chain that are filled.
        robot: The robot.

    Returns:
        Rows of the chain that are filled then, and the normal of the contact (0, 0 for none).
    """
    state, chain = robot.state, robot.chain
    dx, dy = part
    ends = (state[layout.STATE_X], state[layout.STATE_Y], dx, dy)
    clear_sq, reach = settings[layout.SET_CLEAR_SQ], settings[layout.SET_REACH]
    nx, ny, before = 0.0, 0.0, count
    free = _nothing_near(
        arena, reach, (ends[0], ends[1], ends[0] + dx, ends[1] + dy), abs(_drive(state[layout.STATE_SPEED]))
    )
    if free:
        if dx != 0 or dy != 0:
            chain[count, 0], chain[count, 1], chain[count, 2] = ends[0] + dx, ends[1] + dy, during[1]
            count += 1
    elif settings[layout.SET_MOTION] == SWEPT:
        span = (float(during[0]) / TIME_UNIT, float(during[1]) / TIME_UNIT)
        friction = scales[layout.SCALE_WALL_FRICTION]
        count, nx, ny = swept_move(arena.cells, clear_sq, reach, ends, span, friction, chain, count)
    else:
        count, nx, ny = endpoint_move(arena.cells, clear_sq, reach, ends, chain, count)
    _judge_path(arena, settings, scales, step, (before, count), free, robot)
    return count, nx, ny


@kernel
def _share(whole: int, time: int) -> int:
    """What of a displacement is covered by a time in the step, lattice units."""
    return round_away(float(whole) * (float(time) / TIME_UNIT))


@rare_kernel
def _move_through_events(
    arena: Arena, settings: Ints, scales: Floats, step: int, way: tuple[int, int], event: int, robot: Robot
) -> tuple[int, int, float, float]:
    """Moves the robot by a step's displacement, the events of the step each at its time.

    ``endpoint`` looks at the world where a step ends only: there all events come first.

    Returns:
        Index of the next event, rows of the chain that are filled, and the normal of the last contact.
    """
    events, counts, exact = arena.events, robot.counts, settings[layout.SET_MOTION] == SWEPT
    count, now, gone = _whole(0), _whole(0), (_whole(0), _whole(0))
    nx, ny = 0.0, 0.0
    while now < TIME_UNIT:
        due = event < events.shape[0] and events[event, layout.EVENT_STEP] == step
        until = events[event, layout.EVENT_TIME] if due and exact else _whole(TIME_UNIT)
        if until > now and not (due and not exact):
            there = way if until == TIME_UNIT else (_share(way[0], until), _share(way[1], until))
            part = (there[0] - gone[0], there[1] - gone[1])
            count, px, py = _move(arena, settings, scales, step, part, (now, until), count, robot)
            if px != 0.0 or py != 0.0:
                nx, ny = px, py
            gone, now = there, until
        if due and counts[layout.OUT_ENDING] == layout.LIMIT:
            event = _apply_events(arena, settings, step, event, robot)
        if counts[layout.OUT_ENDING] != layout.LIMIT:
            break
    return event, count, nx, ny


@rare_kernel
def _measure(settings: Ints, scales: Floats, headings: Ints, step: int, way: tuple[int, int], robot: Robot) -> None:
    """Adds a displacement to the odometry as the robot measures it: its length a little wrong, its direction too."""
    noise = scales[layout.SCALE_ODOMETRY_NOISE]
    turned = int(math.floor(robot.odometry[2] + 0.5)) - robot.state[layout.STATE_HEADING]
    along, across = float(headings[turned % TURN]) / (1 << 30), float(headings[(turned - TURN // 4) % TURN]) / (1 << 30)
    wrong = 1.0 + noise * (2.0 * noise_draw(settings, noise_channel(step, NOISE_WAY)) - 1.0)
    robot.odometry[0] += wrong * (along * way[0] - across * way[1])
    robot.odometry[1] += wrong * (across * way[0] + along * way[1])


@kernel
def _advance(
    arena: Arena, settings: Ints, scales: Floats, step: int, event: int, robot: Robot
) -> tuple[int, int, float, float]:
    """Moves the robot for one step, with the events that fall into it, and judges the path.

    Returns:
        Index of the next event, rows of the chain that are filled, and the normal of the contact (0, 0 for none).
    """
    state, counts = robot.state, robot.counts
    x, y, drive = state[layout.STATE_X], state[layout.STATE_Y], _drive(state[layout.STATE_SPEED])
    slip = scales[layout.SCALE_SLIP]
    if slip > 0.0:
        lost = slip * noise_draw(settings, noise_channel(step, NOISE_SLIP))
        drive = _speed(float(drive) * (1.0 - lost))
    way = displacement(arena.headings, state[layout.STATE_HEADING], drive)
    if event < arena.events.shape[0] and arena.events[event, layout.EVENT_STEP] == step:
        event, count, nx, ny = _move_through_events(arena, settings, scales, step, way, event, robot)
    else:
        whole = (_whole(0), _whole(TIME_UNIT))
        count, nx, ny = _move(arena, settings, scales, step, way, whole, _whole(0), robot)
    if scales[layout.SCALE_ODOMETRY_NOISE] > 0.0:
        moved = (state[layout.STATE_X] - x, state[layout.STATE_Y] - y)
        _measure(settings, scales, arena.headings, step, moved, robot)
    counts[layout.OUT_POINTS] += count
    jx, jy = state[layout.STATE_X] // UNIT, state[layout.STATE_Y] // UNIT
    if 0 <= jx < arena.visited.shape[1] and 0 <= jy < arena.visited.shape[0] and arena.visited[jy, jx] == 0:
        arena.visited[jy, jx] = 1
        counts[layout.OUT_LAST_NEW_CELL] = step
    return event, count, nx, ny


@kernel
def _obey(settings: Ints, scales: Floats, command: Floats, step: int, robot: Robot) -> None:
    """Applies a command: the turn now, the speed in the next step; clamps both, refuses nan and infinities."""
    state = robot.state
    speed, rate = command[layout.CMD_SPEED], command[layout.CMD_TURN_RATE]
    if not (math.isfinite(speed) and math.isfinite(rate)):
        robot.counts[layout.OUT_ENDING] = layout.INVALID_COMMAND
        return
    top, limit = scales[layout.SCALE_TOP_SPEED], scales[layout.SCALE_TURN_LIMIT]
    rate = min(max(rate, -limit), limit)
    turn = round_away(min(max(rate * scales[layout.SCALE_TURN], -float(TURN // 2)), float(TURN // 2)))
    state[layout.STATE_HEADING] = (state[layout.STATE_HEADING] + turn) % TURN
    noise = scales[layout.SCALE_ODOMETRY_NOISE]
    if noise > 0.0:
        wrong = 1.0 + noise * (2.0 * noise_draw(settings, noise_channel(step, NOISE_TURN)) - 1.0)
        robot.odometry[2] += wrong * turn
    wanted = _speed(min(max(speed, -top), top) * scales[layout.SCALE_SPEED] * SPEED_UNIT)
    state[layout.STATE_SPEED] = _next_speed(state[layout.STATE_SPEED], wanted, scales)
    if command[layout.CMD_DRAW] != 0.0:
        state[layout.STATE_DRAWS] += 1


@kernel
def _next_speed(now: int, wanted: int, scales: Floats) -> int:
    """Speed after a step: as wanted, or as near as the wheels' gain and the floor's friction allow."""
    gain, loss = scales[layout.SCALE_GAIN], scales[layout.SCALE_LOSS]
    if gain == math.inf and loss == math.inf:
        return wanted
    if (wanted > 0 and now < 0) or (wanted < 0 and now > 0):
        wanted = 0  # it must come to a stand first
    if abs(wanted) > abs(now) + gain:
        return now + int(gain) if wanted > 0 else now - int(gain)
    if abs(wanted) < abs(now) - loss:
        return now - int(loss) if now > 0 else now + int(loss)
    return wanted


@kernel
def _hash(digest: Any, word: int) -> Any:
    return (digest ^ np.uint64(word)) * _HASH_PRIME


@rare_kernel
def _hash_step(robot: Robot, count: int, bumped: bool) -> None:
    """Adds a step to the digest: whether a wall was touched, the points of its path, the state after it."""
    digest = _hash(np.uint64(robot.counts[layout.OUT_DIGEST]), 1 if bumped else 0)
    for k in range(count):
        digest = _hash(_hash(_hash(digest, robot.chain[k, 0]), robot.chain[k, 1]), robot.chain[k, 2])
    for k in range(robot.state.size):
        digest = _hash(digest, robot.state[k])
    robot.counts[layout.OUT_DIGEST] = np.int64(digest)


@rare_kernel
def _write_step(robot: Robot, step: int, count: int, bumped: bool, rows: Ints, path: Ints) -> None:
    """Writes a step into a recording: its state, and the points of its path after those of the steps before."""
    rows[step, layout.ROW_BUMP] = 1 if bumped else 0
    for k in range(robot.state.size):
        rows[step, layout.ROW_STATE + k] = robot.state[k]
    first = robot.counts[layout.OUT_POINTS] - count
    for k in range(count):
        path[first + k, layout.POINT_STEP], path[first + k, layout.POINT_TIME] = step, robot.chain[k, 2]
        path[first + k, layout.POINT_X], path[first + k, layout.POINT_Y] = robot.chain[k, 0], robot.chain[k, 1]


@kernel
def _same(one: Ints, other: Ints) -> bool:
    k = 0
    while k < one.size and one[k] == other[k]:
        k += 1
    return k == one.size


@kernel
def _is_again(robot: Robot, room: Room) -> bool:
    """Whether the state is the anchor's; sets R. P. Brent's next anchor, if one is due."""
    room.brent[1] += 1
    if _same(robot.state, room.anchor):
        return True
    if room.brent[1] == room.brent[0]:
        for k in range(room.anchor.size):
            room.anchor[k] = robot.state[k]
        room.brent[0], room.brent[1] = 2 * room.brent[0], 0
    return False


@kernel
def _is_inside(arena: Arena, robot: Robot) -> bool:
    """Whether the centre is in the grid."""
    x, y = robot.state[layout.STATE_X] // UNIT, robot.state[layout.STATE_Y] // UNIT
    return bool(0 <= x < arena.cells.shape[1] and 0 <= y < arena.cells.shape[0])


@kernel
def _move_and_sense(
    arena: Arena, settings: Ints, scales: Floats, room: Room, robot: Robot, step: int, event: int
) -> tuple[int, int, float, float]:
    """The part of a step before the controller acts; result as :func:`_advance`."""
    robot.counts[layout.OUT_STEPS] = step
    event, count, nx, ny = _advance(arena, settings, scales, step, event, robot)
    if robot.counts[layout.OUT_ENDING] == layout.LIMIT and _is_inside(arena, robot):
        sense(
            arena.cells, arena.headings, settings, scales, robot.state, robot.odometry, (nx, ny), step,
            room.observation,
        )  # fmt: skip
        for k in range(room.command.size):
            room.command[k] = 0.0
    return event, count, nx, ny


@kernel
def _remember(room: Room, robot: Robot) -> None:
    """Takes the controller's memory into the state."""
    for k in range(room.words.size):
        robot.state[layout.STATE_MEMORY + k] = room.words[k]


@kernel
def _step(
    arena: Arena, settings: Ints, scales: Floats, act: Any, room: Room, robot: Robot, step: int, event: int
) -> tuple[int, int, bool]:
    """One step: move, sense, act.

    Returns:
        Index of the next event, rows of the chain that are filled, and whether a wall was touched.
    """
    event, count, nx, ny = _move_and_sense(arena, settings, scales, room, robot, step, event)
    if robot.counts[layout.OUT_ENDING] == layout.LIMIT and _is_inside(arena, robot):
        act(room.observation, room.memory, room.command)
        _obey(settings, scales, room.command, step, robot)
    _remember(room, robot)
    return event, count, nx != 0.0 or ny != 0.0


@kernel
def _last_event(arena: Arena) -> int:
    """Step in which the world changes for the last time; 0 if it never does."""
    events = arena.events
    return events[events.shape[0] - 1, layout.EVENT_STEP] if events.shape[0] > 0 else _whole(0)


@kernel
def _is_over(
    settings: Ints,
    room: Room,
    robot: Robot,
    step: int,
    quiet: int,
    moved: tuple[int, bool],
    rows: Ints,
    path: Ints,
) -> bool:
    """Counts, hashes and records a step; whether it was the last one, for a recurrence too.

    Args:
        settings: ``SET_``.
        room: The episode's room.
        robot: The robot after the step.
        step: Its number.
        quiet: Step of the last event.
        moved: Rows of the chain that are filled, and whether a wall was touched.
        rows: Recorded states, or nothing.
        path: Likewise.
    """
    count, bumped = moved
    if bumped and room.brent[2] == 0:
        robot.counts[layout.OUT_COLLISIONS] += 1
    room.brent[2] = 1 if bumped else 0
    if settings[layout.SET_DIGEST] != 0:
        _hash_step(robot, count, bumped)
    if step < rows.shape[0]:
        _write_step(robot, step, count, bumped, rows, path)
    if robot.counts[layout.OUT_ENDING] != layout.LIMIT:
        return True
    if settings[layout.SET_FIND_LOOP] != 0 and step > quiet and _is_again(robot, room):
        robot.counts[layout.OUT_ENDING], robot.counts[layout.OUT_PERIOD] = layout.LOOP, room.brent[1]
        return True
    return False


@rare_kernel
def _set_out(settings: Ints, scales: Floats, memory: Floats, room: Room, robot: Robot) -> None:
    """Puts a robot at its start, with its memory at reset."""
    _begin(settings, scales, robot)
    for k in range(memory.size):
        room.memory[k] = memory[k]
        robot.state[layout.STATE_MEMORY + k] = room.words[k]
    for k in range(room.anchor.size):
        room.anchor[k] = 0
    room.brent[0], room.brent[1], room.brent[2] = 1, 0, 0


@rare_kernel
def lattice_episode(
    arena: Arena,
    settings: Ints,
    scales: Floats,
    act: Any,
    memory: Floats,
    room: Room,
    robot: Robot,
    rows: Ints,
    path: Ints,
) -> None:
    """Runs one episode.

    Args:
        arena: Surroundings; ``cells`` must hold the state before the first event, ``visited`` zeros.
        settings: See :mod:`sim.kernels.layout`, ``SET_``.
        scales: ``SCALE_``.
        act: Compiled controller, ``act(observation, memory, command)``.
        memory: Its memory at reset; not changed.
        room: :func:`new_room`.
        robot: :func:`new_robot`; filled.
        rows: (steps + 1, ROW_STATE + STATE_MEMORY + len(memory)) for a recording, or with 0 rows.
        path: (points, POINT_SIZE) for a recording, with room for all points of the path after the start.

    Recurrence of the complete state is looked for with R. P. Brent, "An improved Monte Carlo factorization
    algorithm", BIT 1980, once the last event is over.
    """
    _set_out(settings, scales, memory, room, robot)
    if rows.shape[0] > 0:
        for k in range(robot.state.size):
            rows[0, layout.ROW_STATE + k] = robot.state[k]
    quiet, event = _last_event(arena), _whole(0)
    for step in range(1, settings[layout.SET_STEPS] + 1):
        event, count, bumped = _step(arena, settings, scales, act, room, robot, step, event)
        if _is_over(settings, room, robot, step, quiet, (count, bumped), rows, path):
            break


@allocating_kernel
def lattice_steps(
    arena: Arena, settings: Ints, scales: Floats, memory: Floats, room: Room, robot: Robot, rows: Ints, path: Ints
) -> Iterator[int]:
    """The same for a controller that is no compiled function: stops wherever it is to act.

    Arguments as for :func:`lattice_episode`. Before it goes on, ``room.memory`` and ``room.command`` must be what the
    controller made of ``room.observation``.

    Yields:
        Number of the step.
    """
    _set_out(settings, scales, memory, room, robot)
    if rows.shape[0] > 0:
        for k in range(robot.state.size):
            rows[0, layout.ROW_STATE + k] = robot.state[k]
    quiet, event = _last_event(arena), _whole(0)
    for step in range(1, settings[layout.SET_STEPS] + 1):
        event, count, nx, ny = _move_and_sense(arena, settings, scales, room, robot, step, event)
        if robot.counts[layout.OUT_ENDING] == layout.LIMIT and _is_inside(arena, robot):
            yield step
            _obey(settings, scales, room.command, step, robot)
        _remember(room, robot)
        if _is_over(settings, room, robot, step, quiet, (count, nx != 0.0 or ny != 0.0), rows, path):
            break


@rare_kernel
def _lone_step(
    arena: Arena, settings: Ints, scales: Floats, act: Any, room: Room, robot: Robot, step: int, event: int
) -> int:
    """:func:`_step` as a call of its own; the index of the next event."""
    return _step(arena, settings, scales, act, room, robot, step, event)[0]


@rare_kernel
def _renew(arena: Arena, fresh: Arena, settings: Ints) -> None:
    """Sets an arena back to what it was before the first event."""
    if arena.events.shape[0] > 0:
        for iy in range(fresh.cells.shape[0]):
            for ix in range(fresh.cells.shape[1]):
                arena.cells[iy, ix] = fresh.cells[iy, ix]
                arena.near[iy, ix] = fresh.near[iy, ix]
    for iy in range(arena.visited.shape[0]):
        for ix in range(arena.visited.shape[1]):
            arena.visited[iy, ix] = 0
    x, y = settings[layout.SET_X] // UNIT, settings[layout.SET_Y] // UNIT
    arena.visited[min(y, arena.visited.shape[0] - 1), min(x, arena.visited.shape[1] - 1)] = 1


@rare_kernel
def _entry_of(
    arenas: tuple[Arena, Arena],
    settings: Ints,
    scales: Floats,
    act: Any,
    rooms: tuple[Room, Room],
    robots: tuple[Robot, Robot],
    period: int,
) -> int:
    """First step after the last event whose state comes back ``period`` steps later, found by two equal robots.

    Both are at their start; the second sets out ``period`` steps before the first.
    """
    (slow, fast), quiet = robots, _last_event(arenas[0])
    step, event_slow, event_fast = _whole(0), _whole(0), _whole(0)
    for ahead in range(1, period + 1):
        event_fast = _lone_step(arenas[1], settings, scales, act, rooms[1], fast, ahead, event_fast)
    while step < quiet or not _same(slow.state, fast.state):
        step += 1
        event_slow = _lone_step(arenas[0], settings, scales, act, rooms[0], slow, step, event_slow)
        event_fast = _lone_step(arenas[1], settings, scales, act, rooms[1], fast, step + period, event_fast)
    return step


@rare_kernel
def lattice_batch(
    fresh: Arena,
    arenas: tuple[Arena, Arena],
    settings: Ints,
    scales: Floats,
    act: Any,
    memory: Floats,
    rooms: tuple[Room, Room],
    robots: tuple[Robot, Robot],
    starts: Ints,
    seeds: Ints,
    nothing: Ints,
    counts: Ints,
    sums: Floats,
) -> None:
    """Runs many episodes of one controller in one world.

    A recurrence is counted as :func:`sim.simulate` counts it: up to the end of its first period.

    Args:
        fresh: Surroundings before the first event; not changed.
        arenas: Two copies of them, to be used.
        settings: ``SET_``; start, seed, steps and the search for loops are changed and set back.
        scales: ``SCALE_``.
        act: Compiled controller.
        memory: Its memory at reset.
        rooms: Two, to be used.
        robots: Likewise.
        starts: (n, 3) x, y, heading, lattice units.
        seeds: (n,) bits of uint64s.
        nothing: (0, 1) int64.
        counts: (n, OUT_SIZE), filled.
        sums: (n, SUM_SIZE), filled.
    """
    steps, find_loop = settings[layout.SET_STEPS], settings[layout.SET_FIND_LOOP]
    robot = robots[0]
    for n in range(seeds.size):
        for k in range(3):
            settings[layout.SET_X + k] = starts[n, k]
        settings[layout.SET_SEED] = seeds[n]
        period = _whole(-1)
        while True:  # a second time for a loop, up to the end of its first period
            _renew(arenas[0], fresh, settings)
            lattice_episode(arenas[0], settings, scales, act, memory, rooms[0], robot, nothing, nothing)
            if period > 0 or robot.counts[layout.OUT_ENDING] != layout.LOOP:
                break
            period = robot.counts[layout.OUT_PERIOD]
            for which in range(2):
                _renew(arenas[which], fresh, settings)
                _set_out(settings, scales, memory, rooms[which], robots[which])
            settings[layout.SET_STEPS] = period + _entry_of(arenas, settings, scales, act, rooms, robots, period)
            settings[layout.SET_FIND_LOOP] = 0
        if period > 0:
            robot.counts[layout.OUT_ENDING], robot.counts[layout.OUT_PERIOD] = layout.LOOP, period
        settings[layout.SET_STEPS], settings[layout.SET_FIND_LOOP] = steps, find_loop
        for k in range(counts.shape[1]):
            counts[n, k] = robot.counts[k]
        for k in range(sums.shape[1]):
            sums[n, k] = robot.sums[k]
