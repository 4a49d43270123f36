"""One step on the pose lattice.

The move at the speed of the wheels, with each event at its time, then sensing, then the controller,
whose turn takes effect immediately and whose speed drives the next step.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from tests.reference.sim import layout, polygon
from tests.reference.sim.geometry import (
    mark_near,
    segment_crosses_box,
    segment_point_within,
    window_is_free,
)
from tests.reference.sim.lattice_motion import endpoint_move, round_away, swept_move
from tests.reference.sim.lattice_sense import (
    NOISE_SLIP,
    NOISE_TURN,
    NOISE_WAY,
    displacement,
    heading_of,
    noise_channel,
    noise_draw,
    sense,
)
from tests.reference.sim.lattice_state import Arena, Robot, Room, whole_speed
from tests.reference.sim.layout import BURNING, SOLID, SPEED_UNIT, SWEPT, TIME_UNIT, TURN, UNIT
from tests.reference.sim.polygon import contains_axle, turned
from tests.reference.sim.shape import (
    Shape,
    pose_is_clear,
    segment_box_depth,
    segment_first_not_clear,
)

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]


def _drive(speed: int) -> int:
    """Whole lattice units driven at a speed in a step."""
    return speed // SPEED_UNIT if speed >= 0 else -(-speed // SPEED_UNIT)


def shape_of(arena: Arena, settings: Ints, robot: Robot) -> Shape:
    """What moves: a disc's squared clear distance, or the corners of a body at its heading."""
    if arena.carriage is None or not arena.carriage.body:
        return int(settings[layout.SET_CLEAR_SQ])
    heading = int(robot.state[layout.STATE_HEADING])
    return turned(arena.headings, arena.carriage.body, heading)


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
    clear_sq, reach = shape_of(arena, settings, robot), settings[layout.SET_REACH]
    x, y = robot.state[layout.STATE_X], robot.state[layout.STATE_Y]
    for caught in (SOLID, BURNING):
        if not pose_is_clear(arena.cells, caught, clear_sq, reach, x, y):
            _, ix, iy = segment_first_not_clear(arena.cells, caught, clear_sq, reach, (x, y, x, y))
            counts[layout.OUT_ENDING], counts[layout.OUT_HIT_STATE] = layout.BURNED, caught
            counts[layout.OUT_HIT_STEP] = step
            counts[layout.OUT_HIT_IX], counts[layout.OUT_HIT_IY] = ix, iy
            break
    return first


def _judge_segment(
    arena: Arena,
    settings: Ints,
    scales: Floats,
    step: int,
    ends: tuple[int, int, int, int],
    robot: Robot,
) -> None:
    """Notes walls that a segment of an unsafe motion model cuts:

    deepest cut, first overlap, first tunnel.
    """
    px, py, qx, qy = ends
    counts, sums = robot.counts, robot.sums
    reach = settings[layout.SET_REACH]
    shape = shape_of(arena, settings, robot)
    body = () if arena.carriage is None else arena.carriage.body
    for iy in range(
        max((min(py, qy) - reach) // UNIT, -1),
        min((max(py, qy) + reach) // UNIT, arena.cells.shape[0]) + 1,
    ):
        for ix in range(
            max((min(px, qx) - reach) // UNIT, -1),
            min((max(px, qx) + reach) // UNIT, arena.cells.shape[1]) + 1,
        ):
            inside = 0 <= ix < arena.cells.shape[1] and 0 <= iy < arena.cells.shape[0]
            if inside and arena.cells[iy, ix] != SOLID:
                continue
            depth = segment_box_depth(shape, ends, ix, iy)
            sums[layout.SUM_OVERLAP] = max(sums[layout.SUM_OVERLAP], depth)
            if depth > scales[layout.SCALE_TOLERANCE] and counts[layout.OUT_OVERLAP_STEP] < 0:
                counts[layout.OUT_OVERLAP_STEP] = step
                counts[layout.OUT_OVERLAP_IX], counts[layout.OUT_OVERLAP_IY] = ix, iy
            is_through = contains_axle(body) and segment_crosses_box(px, py, qx, qy, ix, iy)
            if counts[layout.OUT_ENDING] == layout.LIMIT and is_through:
                counts[layout.OUT_ENDING], counts[layout.OUT_HIT_STEP] = layout.TUNNEL, step
                counts[layout.OUT_HIT_IX], counts[layout.OUT_HIT_IY] = ix, iy


def load_goal(arena: Arena, settings: Ints, number: int) -> None:
    """Makes one of the goals the one that counts."""
    if arena.goals:
        for index, value in zip(layout.GOAL_SETTINGS, arena.goals[number], strict=True):
            settings[index] = value


def _passed_at(arena: Arena) -> int:
    """Index in a state of the number of waypoints that the robot has passed."""
    return -1 if arena.carriage is None else _bumped_at(arena) - 1


def _bumped_at(arena: Arena) -> int:
    """Index in a state of what cut its last turn short."""
    return -4 if arena.carriage.turn_per_unit > 0.0 else -2


def _meet_goal(arena: Arena, robot: Robot) -> None:
    """Ends the run at the target; a waypoint counts at the end of the move."""
    waypoints = len(arena.goals) - 1
    if waypoints > 0 and robot.state[_passed_at(arena)] < waypoints:
        robot.journey[0] = 1
    else:
        robot.counts[layout.OUT_ENDING] = layout.REACHED
        robot.counts[layout.OUT_GOALS] += 1


def _pass_waypoint(arena: Arena, settings: Ints, step: int, robot: Robot) -> None:
    """Gives a robot that has met a waypoint its next goal."""
    if robot.journey[0] != 0:
        robot.journey[0], robot.journey[1] = 0, step
        robot.counts[layout.OUT_GOALS] += 1
        robot.state[_passed_at(arena)] += 1
        load_goal(arena, settings, int(robot.state[_passed_at(arena)]))


def _heads_for_goal(settings: Ints, heading: int) -> bool:
    """Whether a robot with this heading may arrive."""
    if settings[layout.SET_HAS_GOAL_HEADING] == 0:
        return True
    off = (int(heading) - int(settings[layout.SET_GOAL_HEADING])) % TURN
    return bool(min(off, TURN - off) <= settings[layout.SET_HEADING_TOLERANCE])


def _is_at_goal(settings: Ints, robot: Robot) -> bool:
    """Whether the robot's pose is one of the goal's."""
    x, y = robot.state[layout.STATE_X], robot.state[layout.STATE_Y]
    tx, ty = settings[layout.SET_TARGET_X], settings[layout.SET_TARGET_Y]
    near = (x - tx) ** 2 + (y - ty) ** 2 <= settings[layout.SET_TARGET_SQ]
    return bool(near) and _heads_for_goal(settings, robot.state[layout.STATE_HEADING])


def _cell_distance(x: int, y: int, ix: int, iy: int) -> int:
    """Squared distance from a lattice point to a cell."""
    dx = max(ix * UNIT - x, x - (ix + 1) * UNIT, 0)
    dy = max(iy * UNIT - y, y - (iy + 1) * UNIT, 0)
    return int(dx * dx + dy * dy)


def _judge_contact(
    arena: Arena,
    settings: Ints,
    step: int,
    ends: tuple[int, int, int, int],
    touched: bool,
    robot: Robot,
) -> None:
    """Ends the run if a wall has cut a move from p to q short, and may not.

    The cell is that of the walls cutting its disc on the way which is nearest to the robot, or to the
    place where it may not go.
    """
    counts = robot.counts
    forbidden = settings[layout.SET_CONTACT] == layout.FAIL
    if not forbidden or not touched or counts[layout.OUT_ENDING] != layout.LIMIT:
        return
    px, py, dx, dy = (int(number) for number in ends)
    x, y = int(robot.state[layout.STATE_X]), int(robot.state[layout.STATE_Y])
    way = (px, py, px + dx, py + dy)
    if settings[layout.SET_MOTION] != SWEPT and (x, y) == (px, py):
        x, y = px + dx, py + dy
        way = (x, y, x, y)
    height, width = arena.cells.shape
    shape = shape_of(arena, settings, robot)

    def distance(ix: int, iy: int) -> float:
        if isinstance(shape, tuple):
            return polygon.gap_to(shape, ix, iy, x, y)
        return _cell_distance(x, y, ix, iy)

    solid = [
        (distance(ix, iy), iy, ix)
        for iy in range(-1, height + 1)
        for ix in range(-1, width + 1)
        if not (0 <= ix < width and 0 <= iy < height) or arena.cells[iy, ix] == SOLID
        if segment_box_depth(shape, way, ix, iy) > 1e-6
    ]
    away, iy, ix = min(solid)
    # No wall of these tests stops a robot farther away.
    assert away < (20 if isinstance(shape, tuple) else (settings[layout.SET_REACH] + 20) ** 2)
    counts[layout.OUT_ENDING], counts[layout.OUT_HIT_STEP] = layout.CONTACT, step
    counts[layout.OUT_HIT_IX], counts[layout.OUT_HIT_IY] = ix, iy


def _friction(settings: Ints, scales: Floats) -> float:
    """Share of a slide that is lost to a wall."""
    slides = settings[layout.SET_CONTACT] == layout.SLIDE
    return float(scales[layout.SCALE_WALL_FRICTION]) if slides else 1.0


def _judge_path(
    arena: Arena,
    settings: Ints,
    scales: Floats,
    step: int,
    rows: tuple[int, int],
    free: bool,
    robot: Robot,
) -> None:
    """Judges a piece of a step's path: fire, walls, target, length.

    Then puts the robot at its end.

    Args:
        arena: Surroundings.
        settings: ``SET_``.
        scales: ``SCALE_``.
        step: Number of the step.
        rows: First row of the chain, and the one after the last; none if the robot does not move.
        free: Whether nothing is near the path.
        robot: The robot.
    """
    state, counts, sums = robot.state, robot.counts, robot.sums
    clear_sq, reach = shape_of(arena, settings, robot), settings[layout.SET_REACH]
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
        if (
            not swept
            and not free
            and segment_first_not_clear(arena.cells, SOLID, clear_sq, reach, ends)[0]
        ):
            _judge_segment(arena, settings, scales, step, ends, robot)
        if counts[layout.OUT_ENDING] == layout.LIMIT:
            tx, ty, within = (
                settings[layout.SET_TARGET_X],
                settings[layout.SET_TARGET_Y],
                settings[layout.SET_TARGET_SQ],
            )
            from_x, from_y = (x, y) if swept else (qx, qy)
            if (
                settings[layout.SET_ARRIVAL] == layout.TOUCH
                and _heads_for_goal(settings, state[layout.STATE_HEADING])
                and segment_point_within(from_x, from_y, qx, qy, tx, ty, within)
            ):
                _meet_goal(arena, robot)
        sums[layout.SUM_PATH] += math.sqrt(float((qx - x) * (qx - x) + (qy - y) * (qy - y)))
        x, y = qx, qy
    state[layout.STATE_X], state[layout.STATE_Y] = x, y


def _nothing_near(arena: Arena, reach: int, ends: tuple[int, int, int, int], distance: int) -> bool:
    """Return whether the tables show that all cells within reach of a step are free.

    If not, an exact test is needed.
    """
    if arena.clearance.shape[0] == 0:
        return window_is_free(arena.near, reach, ends)
    x, y = ends[0], ends[1]
    return bool((arena.clearance[y // UNIT, x // UNIT] - 1) * UNIT >= reach + distance)


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
    """Moves the robot by a part of a step in which the world does not change, and judges the path.

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
        The number of filled rows of the chain, and the normal of the contact (0, 0 for none).
    """
    state, chain = robot.state, robot.chain
    dx, dy = part
    ends = (state[layout.STATE_X], state[layout.STATE_Y], dx, dy)
    clear_sq, reach = shape_of(arena, settings, robot), settings[layout.SET_REACH]
    nx, ny, before = 0.0, 0.0, count
    free = _nothing_near(
        arena,
        reach,
        (ends[0], ends[1], ends[0] + dx, ends[1] + dy),
        abs(_drive(state[layout.STATE_SPEED])) + settings[layout.SET_DRIFT_REACH],
    )
    if free:
        if dx != 0 or dy != 0:
            chain[count, 0], chain[count, 1], chain[count, 2] = (
                ends[0] + dx,
                ends[1] + dy,
                during[1],
            )
            count += 1
    elif settings[layout.SET_MOTION] == SWEPT:
        span = (float(during[0]) / TIME_UNIT, float(during[1]) / TIME_UNIT)
        friction = _friction(settings, scales)
        count, nx, ny = swept_move(arena.cells, clear_sq, reach, ends, span, friction, chain, count)
    else:
        count, nx, ny = endpoint_move(arena.cells, clear_sq, reach, ends, chain, count)
    _judge_path(arena, settings, scales, step, (before, count), free, robot)
    _judge_contact(arena, settings, step, ends, nx != 0.0 or ny != 0.0, robot)
    return count, nx, ny


def _share(whole: int, time: int, whole_time: int) -> int:
    """The part of a displacement covered by a time, lattice units."""
    return round_away(float(whole) * (float(time) / float(whole_time)))


def _move_through_events(
    arena: Arena,
    settings: Ints,
    scales: Floats,
    step: int,
    way: tuple[int, int],
    event: int,
    robot: Robot,
    during: tuple[int, int] = (0, TIME_UNIT),
    count: int = 0,
) -> tuple[int, int, float, float]:
    """Moves the robot by a displacement between two times of the step, with each event at its time.

    ``endpoint`` only checks the world at the end of a step, so all events come first.

    Returns:
        Index of the next event, rows of the chain that are filled, and the normal of the last
        contact.
    """
    events, counts, exact = arena.events, robot.counts, settings[layout.SET_MOTION] == SWEPT
    begin, end = during
    now, gone = begin, (0, 0)
    nx, ny = 0.0, 0.0
    stopped = False
    while now < end:
        due = event < events.shape[0] and events[event, layout.EVENT_STEP] == step
        due = due and events[event, layout.EVENT_TIME] < end
        until = events[event, layout.EVENT_TIME] if due and exact else end
        if until > now and not (due and not exact):
            there = (
                way
                if until == end
                else tuple(_share(part, until - begin, end - begin) for part in way)
            )
            if stopped:
                there = gone
            part = (there[0] - gone[0], there[1] - gone[1])
            count, px, py = _move(arena, settings, scales, step, part, (now, until), count, robot)
            if until < TIME_UNIT and (
                count == 0 or robot.chain[count - 1, 2] < until
            ):  # it waits for the next event
                robot.chain[count, 0], robot.chain[count, 1] = (
                    robot.state[layout.STATE_X],
                    robot.state[layout.STATE_Y],
                )
                robot.chain[count, 2] = until
                count += 1
            if px != 0.0 or py != 0.0:
                nx, ny = px, py
                stopped = settings[layout.SET_CONTACT] != layout.SLIDE
            gone, now = there, until
        if due and counts[layout.OUT_ENDING] == layout.LIMIT:
            event = _apply_events(arena, settings, step, event, robot)
        if counts[layout.OUT_ENDING] != layout.LIMIT:
            break
    return event, count, nx, ny


def _measure(
    settings: Ints, scales: Floats, headings: Ints, step: int, way: tuple[int, int], robot: Robot
) -> None:
    """Adds a displacement to the odometry as the robot measures it.

    Its length and its direction have small errors.
    """
    noise = scales[layout.SCALE_ODOMETRY_NOISE]
    turned = math.floor(robot.odometry[2] + 0.5) - robot.state[layout.STATE_HEADING]
    along, across = (
        float(headings[turned % TURN]) / (1 << 30),
        float(headings[(turned - TURN // 4) % TURN]) / (1 << 30),
    )
    wrong = 1.0 + noise * (2.0 * noise_draw(settings, noise_channel(step, NOISE_WAY)) - 1.0)
    robot.odometry[0] += wrong * (along * way[0] - across * way[1])
    robot.odometry[1] += wrong * (across * way[0] + along * way[1])


def _bump(arena: Arena, robot: Robot) -> tuple[float, float]:
    """Direction away from the wall that cut the last turn short; (0, 0) if none did."""
    if robot.state[_bumped_at(arena)] == 0:
        return 0.0, 0.0
    away = int(robot.state[_bumped_at(arena)]) - 1
    return float(arena.headings[away]), float(arena.headings[(away - TURN // 4) % TURN])


def turn_body(arena: Arena, settings: Ints, step: int, turn: int, robot: Robot) -> int:
    """Turns a robot as far as its body is clear; returns how far.

    A word of its state becomes 1 plus the heading away from the wall in its way.
    """
    state, counts = robot.state, robot.counts
    body = arena.carriage.body
    x, y, heading = (int(state[k]) for k in (layout.STATE_X, layout.STATE_Y, layout.STATE_HEADING))
    state[_bumped_at(arena)] = 0
    made, cell = turn, None
    if body and settings[layout.SET_MOTION] == SWEPT:
        made, cell = polygon.clear_turn(arena.cells, arena.headings, body, (x, y, heading), turn)
        pose = (x, y, heading)
        fire = None
        if arena.events.shape[0] > 0:
            _, fire = polygon.clear_turn(arena.cells, arena.headings, body, pose, made, BURNING)
        if fire is not None and counts[layout.OUT_ENDING] == layout.LIMIT:
            counts[layout.OUT_ENDING], counts[layout.OUT_HIT_STATE] = layout.BURNED, BURNING
            counts[layout.OUT_HIT_STEP] = step
            counts[layout.OUT_HIT_IX], counts[layout.OUT_HIT_IY] = fire
        if cell is not None:
            last = turned(arena.headings, body, (heading + made) % TURN)
            nx, ny = polygon.away_from(last, *cell, x, y)
    elif body and turn != 0:
        there = turned(arena.headings, body, (heading + turn) % TURN)
        cut, ix, iy = polygon.first_not_clear(arena.cells, SOLID, there, (x, y, x, y))
        if cut:
            made, cell = 0, (ix, iy)
            nx, ny = float(x - ix * UNIT) - UNIT / 2, float(y - iy * UNIT) - UNIT / 2
    if cell is not None:
        state[_bumped_at(arena)] = 1 + heading_of(int(nx * UNIT), int(ny * UNIT), 0)
        if (
            settings[layout.SET_CONTACT] == layout.FAIL
            and counts[layout.OUT_ENDING] == layout.LIMIT
        ):
            counts[layout.OUT_ENDING], counts[layout.OUT_HIT_STEP] = layout.CONTACT, step
            counts[layout.OUT_HIT_IX], counts[layout.OUT_HIT_IY] = cell
    state[layout.STATE_HEADING] = (heading + made) % TURN
    return made


def _measure_turn(settings: Ints, scales: Floats, step: int, turn: int, robot: Robot) -> None:
    noise = scales[layout.SCALE_ODOMETRY_NOISE]
    wrong = 1.0 + noise * (2.0 * noise_draw(settings, noise_channel(step, NOISE_TURN)) - 1.0)
    robot.odometry[2] += wrong * turn


def _truncated(whole: int, share: int, of: int) -> int:
    """Whole times a fraction, rounded towards zero."""
    return abs(whole) * share // of * (1 if whole >= 0 else -1)


class _Way(NamedTuple):
    """What a car does in a stretch of a step: its drive, its turn, and the floor's drift."""

    ahead: int
    turn: int
    drift: tuple[int, int]

    def part(self, begin: int, end: int) -> _Way:
        """The part between two times of the step."""

        def share(whole: int) -> int:
            return _truncated(whole, end, TIME_UNIT) - _truncated(whole, begin, TIME_UNIT)

        # The turn follows what is driven.
        way = abs(self.ahead)
        done = [way * time // TIME_UNIT for time in (begin, end)]
        turned = [_truncated(self.turn, one, way) if self.turn != 0 else 0 for one in done]
        drift = (share(self.drift[0]), share(self.drift[1]))
        return _Way(share(self.ahead), turned[1] - turned[0], drift)

    @property
    def units(self) -> int:
        return abs(self.ahead) + abs(self.drift[0]) + abs(self.drift[1])


class _Car:
    """One step of a car, by legs with both ends on the arc that begins at its exact place."""

    def __init__(
        self, arena: Arena, settings: Ints, scales: Floats, step: int, event: int, robot: Robot
    ) -> None:
        self.arena, self.settings, self.scales = arena, settings, scales
        self.step, self.event, self.robot = step, event, robot
        self.count, self.tries = 0, 14
        self.swept = settings[layout.SET_MOTION] == SWEPT
        robot.turned[0] = 0

    @property
    def is_over(self) -> bool:
        return bool(self.robot.counts[layout.OUT_ENDING] != layout.LIMIT)

    def pose(self) -> tuple[int, int, int]:
        state = self.robot.state
        return tuple(  # type: ignore[return-value]
            int(state[k]) for k in (layout.STATE_X, layout.STATE_Y, layout.STATE_HEADING)
        )

    def chord(self, way: _Way) -> tuple[tuple[int, int], tuple[int, int]]:
        """The move of a stretch, and what it leaves between the exact place and the lattice."""
        headings = self.arena.headings
        along = self.pose()[2] + int(way.turn / 2)
        own, off = [], []
        for k, quarter in ((-2, 0), (-1, TURN // 4)):
            product = way.ahead * 256 * int(headings[(along - quarter) % TURN])
            half = 1 << 29
            exact = (product + half) >> 30 if product >= 0 else -((half - product) >> 30)
            exact += int(self.robot.state[k])
            own.append((exact + 128) // 256)
            off.append(exact - 256 * own[-1])
        return (own[0] + way.drift[0], own[1] + way.drift[1]), (off[0], off[1])

    def stop(self, way: _Way, before: int) -> str | tuple[int, int, tuple[int, int]] | None:
        """What stops a stretch: a chord, a turn (with its pose, cell), or nothing."""
        body, cells, headings = self.arena.carriage.body, self.arena.cells, self.arena.headings
        x, y, heading = self.pose()
        (dx, dy), _ = self.chord(way)
        after = way.turn - before
        if not self.swept:
            x, y, heading = x + dx, y + dy, heading + way.turn
            return "chord" if self._meets(heading, (x, y, x, y)) else None
        if body:
            made, cell = polygon.clear_turn(cells, headings, body, (x, y, heading), before)
            if made != before:
                return (heading + made) % TURN, 0, cell
        if self._meets(heading + before, (x, y, x + dx, y + dy)):
            return "chord"
        if body:
            there = (x + dx, y + dy, (heading + before) % TURN)
            made, cell = polygon.clear_turn(cells, headings, body, there, after)
            if made != after:
                return (there[2] + made) % TURN, 1, cell
        return None

    def _meets(self, heading: int, ends: tuple[int, int, int, int]) -> bool:
        arena, reach = self.arena, self.settings[layout.SET_REACH]
        shape: Shape = int(self.settings[layout.SET_CLEAR_SQ])
        if arena.carriage.body:
            shape = turned(arena.headings, arena.carriage.body, heading % TURN)
        return bool(segment_first_not_clear(arena.cells, SOLID, shape, reach, ends)[0])

    def turn(self, turn: int) -> None:
        made = turn_body(self.arena, self.settings, self.step, turn, self.robot)
        assert made == turn or not self.swept
        self.robot.state[layout.STATE_HEADING] += turn - made  # `endpoint` refused it at this place
        self.robot.state[layout.STATE_HEADING] %= TURN
        self.robot.state[-4] = 0
        self.robot.turned[0] += turn
        if self.settings[layout.SET_MEASURES] != 0:
            _measure_turn(self.settings, self.scales, self.step, turn, self.robot)

    def drive(self, way: _Way, until: int) -> bool:
        """Drive a stretch if all of it is clear."""
        half = int(way.turn / 2)
        orders = [half]
        if self.arena.carriage.body and self.swept and way.turn != 0:
            orders += [0, way.turn]
        is_still = way.units == 0 and way.turn == 0
        found = [turn for turn in orders if is_still or self.stop(way, turn) is None][:1]
        if not found:
            return False
        chain, state, settings = self.robot.chain, self.robot.state, self.settings
        (dx, dy), off = self.chord(way)
        self.turn(found[0])
        if self.is_over:
            return True
        first = self.count
        if dx != 0 or dy != 0:
            x, y, _ = self.pose()
            chain[first] = x + dx, y + dy, until
            self.count += 1
        rows = (first, self.count)
        _judge_path(self.arena, settings, self.scales, self.step, rows, False, self.robot)
        if settings[layout.SET_MEASURES] != 0:
            own = (dx - way.drift[0], dy - way.drift[1])
            _measure(settings, self.scales, self.arena.headings, self.step, own, self.robot)
        state[-2], state[-1] = off
        if not self.is_over:
            self.turn(way.turn - found[0])
        return True

    def contact(self, way: _Way) -> tuple[float, float]:
        """What stops a stretch that is not clear; it ends the run if none may be touched."""
        arena, settings, state = self.arena, self.settings, self.robot.state
        half = int(way.turn / 2)
        x, y, heading = self.pose()
        (dx, dy), _ = self.chord(way)
        found = self.stop(way, half)
        if isinstance(found, tuple):
            last, is_there, cell = found
            where = (x + dx, y + dy) if is_there else (x, y)
            nx, ny = polygon.away_from(
                turned(arena.headings, arena.carriage.body, last), *cell, *where
            )
            away = heading_of(int(nx * UNIT), int(ny * UNIT), 0)
            counts = self.robot.counts
            if settings[layout.SET_CONTACT] == layout.FAIL:
                counts[layout.OUT_ENDING], counts[layout.OUT_HIT_STEP] = layout.CONTACT, self.step
                counts[layout.OUT_HIT_IX], counts[layout.OUT_HIT_IY] = cell
            return float(arena.headings[away]), float(arena.headings[(away - TURN // 4) % TURN])
        state[layout.STATE_HEADING] = (heading + (half if self.swept else way.turn)) % TURN
        ends = (x, y, dx, dy)
        if self.swept:
            shape = shape_of(arena, settings, self.robot)
            _, nx, ny = swept_move(
                arena.cells, shape, settings[layout.SET_REACH], ends, (0.0, 0.0), 1.0,
                self.robot.chain.copy(), 0,
            )  # fmt: skip
        elif dx != 0 or dy != 0:
            nx, ny = float(-dx), float(-dy)
        else:
            side = 1.0 if state[layout.STATE_SPEED] < 0 else -1.0
            now = int(state[layout.STATE_HEADING])
            nx = side * float(arena.headings[now])
            ny = side * float(arena.headings[(now - TURN // 4) % TURN])
        _judge_contact(arena, settings, self.step, ends, nx != 0.0 or ny != 0.0, self.robot)
        state[layout.STATE_HEADING] = heading
        return nx, ny

    def until(self, way: _Way, begin: int, end: int) -> tuple[float, float]:
        """Drive between two times, in ever shorter legs up to a wall."""
        size, is_blocked = end - begin, False
        while begin < end and not self.is_over:
            until = min(begin + size, end)
            part = way.part(begin, until)
            if self.drive(part, until):
                begin = until
                continue
            if part.units <= 1 or self.tries == 0 or not self.swept:
                return self.contact(part)
            self.tries -= 1
            if not is_blocked:
                is_blocked = True
                unit = min(begin + size // part.units + 1, end)
                part = way.part(begin, unit)
                if not self.drive(part, unit):
                    return self.contact(part)
                begin = unit
            size //= 2
        return 0.0, 0.0

    def events(self, now: int) -> int:
        """Let what is due happen; returns when the next event of the step is."""
        rows, robot = self.arena.events, self.robot
        while self.event < len(rows) and rows[self.event, layout.EVENT_STEP] == self.step:
            time = int(rows[self.event, layout.EVENT_TIME])
            if time > now and self.swept:
                return time
            if now > 0 and (self.count == 0 or robot.chain[self.count - 1, 2] < now):
                robot.chain[self.count] = *self.pose()[:2], now
                self.count += 1
            self.event = _apply_events(self.arena, self.settings, self.step, self.event, robot)
            if self.is_over:
                break
        return TIME_UNIT


def _drive_car(
    arena: Arena, settings: Ints, scales: Floats, step: int, drive: int, event: int, robot: Robot
) -> tuple[int, int, float, float]:
    """Moves a car along its arc, up to the first contact; result as for :func:`_advance`."""
    car = _Car(arena, settings, scales, step, event, robot)
    # The turn of the step, and how many legs keep the path within 1/64 of a cell of its arc.
    ahead = max(min(drive, 2**25 - 1), 1 - 2**25)
    share = float(robot.state[-3]) / float(1 << 30)
    limit = min(32767.0, scales[layout.SCALE_TURN_LIMIT] * scales[layout.SCALE_TURN] + 1e-9)
    turn = int(min(max(share * float(ahead) * arena.carriage.turn_per_unit, -limit), limit))
    legs = 1
    while car.swept and legs < 1024 and legs * legs * 1335088 < abs(ahead) * abs(turn):
        legs += 1
    way = _Way(ahead, turn, (int(settings[layout.SET_DRIFT_X]), int(settings[layout.SET_DRIFT_Y])))
    now, leg, contact = 0, 0, (0.0, 0.0)
    while now < TIME_UNIT:
        due = car.events(now)
        if car.is_over:
            break
        end = TIME_UNIT * (leg + 1) // legs
        until = min(end, due)
        if contact == (0.0, 0.0):
            contact = car.until(way, now, until)
        leg += until == end
        now = until
    return car.event, car.count, *contact


def _steer(arena: Arena, scales: Floats, speed: float, rate: float, robot: Robot) -> None:
    """Sets a car's curvature: the commanded arc's, as near as its steering allows."""
    car, full = arena.carriage, 1 << 30
    limit = scales[layout.SCALE_TURN_LIMIT]
    rate = min(max(rate, -limit), limit)
    wanted = 0.0
    if speed != 0.0:
        wanted = min(max(rate / speed * car.turning_radius, -1.0), 1.0)
    elif rate != 0.0:
        wanted = 1.0 if rate > 0.0 else -1.0
    steering, now = int(wanted * full), int(robot.state[-3])
    if car.steering_rate < math.inf:
        most = int(min(car.steering_rate * scales[layout.SCALE_TIME_STEP] * full, 2.0 * full))
        steering = max(now - most, min(now + most, steering))
    robot.state[-3] = steering


def _push(
    arena: Arena,
    settings: Ints,
    scales: Floats,
    step: int,
    push: Ints,
    moved: tuple[int, float, float],
    robot: Robot,
) -> tuple[int, float, float]:
    """Displaces the robot by a push, as far as the path is clear, and turns it.

    Args:
        arena: Surroundings.
        settings: ``SET_``.
        scales: ``SCALE_``.
        step: Number of the step.
        push: ``PUSH_``.
        moved: Rows of the chain that are filled, and the normal of the contact.
        robot: The robot.

    Returns:
        The same then.
    """
    state, (count, nx, ny) = robot.state, moved
    clear_sq, reach = shape_of(arena, settings, robot), settings[layout.SET_REACH]
    if arena.carriage is not None and arena.carriage.body:
        off = int(push[layout.PUSH_TURN]) % TURN
        earlier = int(state[_bumped_at(arena)])
        turn_body(arena, settings, step, off - TURN if off > TURN // 2 else off, robot)
        if state[_bumped_at(arena)] != 0:
            nx, ny = _bump(arena, robot)
            moved = (count, nx, ny)
        state[_bumped_at(arena)] = earlier
    else:
        state[layout.STATE_HEADING] = (state[layout.STATE_HEADING] + push[layout.PUSH_TURN]) % TURN
    clear_sq = shape_of(arena, settings, robot)
    x, y = state[layout.STATE_X], state[layout.STATE_Y]
    dx, dy = push[layout.PUSH_DX], push[layout.PUSH_DY]
    if (dx == 0 and dy == 0) or not pose_is_clear(arena.cells, SOLID, clear_sq, reach, x, y):
        return moved
    friction, before = _friction(settings, scales), count
    count, px, py = swept_move(
        arena.cells, clear_sq, reach, (x, y, dx, dy), (1.0, 1.0), friction, robot.chain, count
    )
    if px != 0.0 or py != 0.0:
        nx, ny = px, py
    for k in range(before, count):
        if robot.counts[layout.OUT_ENDING] == layout.LIMIT:
            _judge_path(arena, settings, scales, step, (k, k + 1), False, robot)
    _judge_contact(arena, settings, step, (x, y, dx, dy), px != 0.0 or py != 0.0, robot)
    return count, nx, ny


def _disturb(
    arena: Arena,
    settings: Ints,
    scales: Floats,
    step: int,
    moved: tuple[int, float, float],
    robot: Robot,
) -> tuple[int, float, float]:
    """Applies the pushes at the end of a step; arguments and result as for :func:`_push`."""
    places = settings[layout.SET_PLACES]
    for push in arena.pushes[places:]:
        if push[layout.PUSH_STEP] == step and robot.counts[layout.OUT_ENDING] == layout.LIMIT:
            moved = _push(arena, settings, scales, step, push, moved, robot)
    ix, iy = robot.state[layout.STATE_X] // UNIT, robot.state[layout.STATE_Y] // UNIT
    for push in arena.pushes[:places]:
        if push[layout.PUSH_IX] == ix and push[layout.PUSH_IY] == iy:
            if robot.counts[layout.OUT_ENDING] == layout.LIMIT:
                moved = _push(arena, settings, scales, step, push, moved, robot)
            break
    return moved


def _advance(
    arena: Arena, settings: Ints, scales: Floats, step: int, event: int, robot: Robot
) -> tuple[int, int, float, float]:
    """Moves the robot for one step, with its events, and judges the path.

    Returns:
        Index of the next event, rows of the chain that are filled, and the normal of the contact
        (0, 0 for none).
    """
    state, counts = robot.state, robot.counts
    x, y, drive = state[layout.STATE_X], state[layout.STATE_Y], _drive(state[layout.STATE_SPEED])
    slip = scales[layout.SCALE_SLIP]
    if slip > 0.0:
        lost = slip * noise_draw(settings, noise_channel(step, NOISE_SLIP))
        drive = whole_speed(float(drive) * (1.0 - lost))
    way = displacement(arena.headings, state[layout.STATE_HEADING], drive)
    drift = (settings[layout.SET_DRIFT_X], settings[layout.SET_DRIFT_Y])
    way = (way[0] + drift[0], way[1] + drift[1])
    is_car = arena.carriage is not None and arena.carriage.turn_per_unit > 0.0
    if is_car:
        event, count, nx, ny = _drive_car(arena, settings, scales, step, drive, event, robot)
    elif event < arena.events.shape[0] and arena.events[event, layout.EVENT_STEP] == step:
        event, count, nx, ny = _move_through_events(
            arena, settings, scales, step, way, event, robot
        )
    else:
        whole = (0, TIME_UNIT)
        count, nx, ny = _move(arena, settings, scales, step, way, whole, 0, robot)
    if settings[layout.SET_MEASURES] != 0 and not is_car:
        moved = (state[layout.STATE_X] - x, state[layout.STATE_Y] - y)
        if (
            nx == 0.0 and ny == 0.0
        ):  # against a wall the wheels do not turn, whatever the floor does
            moved = (moved[0] - drift[0], moved[1] - drift[1])
        _measure(settings, scales, arena.headings, step, moved, robot)
    if arena.pushes.shape[0] > 0 and counts[layout.OUT_ENDING] == layout.LIMIT:
        count, nx, ny = _disturb(arena, settings, scales, step, (count, nx, ny), robot)
    ends_there = settings[layout.SET_ARRIVAL] == layout.STEP and _is_at_goal(settings, robot)
    if ends_there and counts[layout.OUT_ENDING] == layout.LIMIT:
        _meet_goal(arena, robot)
    _pass_waypoint(arena, settings, step, robot)
    if arena.carriage is not None and nx == 0.0 and ny == 0.0:
        nx, ny = _bump(arena, robot)
    counts[layout.OUT_POINTS] += count
    jx, jy = state[layout.STATE_X] // UNIT, state[layout.STATE_Y] // UNIT
    if (
        0 <= jx < arena.visited.shape[1]
        and 0 <= jy < arena.visited.shape[0]
        and arena.visited[jy, jx] == 0
    ):
        arena.visited[jy, jx] = 1
        counts[layout.OUT_LAST_NEW_CELL] = step
        counts[layout.OUT_VISITED] += 1
        if arena.wanted.shape[0] > 0 and arena.wanted[jy, jx] != 0:
            counts[layout.OUT_UNVISITED] -= 1
            if counts[layout.OUT_UNVISITED] == 0 and counts[layout.OUT_ENDING] == layout.LIMIT:
                counts[layout.OUT_ENDING] = layout.COVERED
    return event, count, nx, ny


def is_inside(arena: Arena, robot: Robot) -> bool:
    """Whether the centre is in the grid."""
    x, y = robot.state[layout.STATE_X] // UNIT, robot.state[layout.STATE_Y] // UNIT
    return bool(0 <= x < arena.cells.shape[1] and 0 <= y < arena.cells.shape[0])


def move_and_sense(
    arena: Arena, settings: Ints, scales: Floats, room: Room, robot: Robot, step: int, event: int
) -> tuple[int, int, float, float]:
    """The part of a step before the controller acts; result as for :func:`_advance`."""
    robot.counts[layout.OUT_STEPS] = step
    event, count, nx, ny = _advance(arena, settings, scales, step, event, robot)
    if robot.counts[layout.OUT_ENDING] == layout.LIMIT and is_inside(arena, robot):
        for k in range(
            room.observation.size
        ):  # anything that a controller wrote there would be memory outside the state
            room.observation[k] = math.nan
        sense(
            arena.cells, arena.headings, settings, scales, robot.state, robot.odometry, (nx, ny), step,
            room.observation, arena.decoys,
        )  # fmt: skip
        for k in range(room.command.size):
            room.command[k] = 0.0
    return event, count, nx, ny


def _next_speed(now: int, wanted: int, scales: Floats) -> int:
    """Speed after a step: as commanded, or as near as the wheels' acceleration and the floor's
    friction allow.
    """
    gain, loss = scales[layout.SCALE_GAIN], scales[layout.SCALE_LOSS]
    if gain == math.inf and loss == math.inf:
        return wanted
    if (wanted > 0 and now < 0) or (wanted < 0 and now > 0):
        wanted = 0  # it must stop first
    if abs(wanted) > abs(now) + gain:
        return now + int(gain) if wanted > 0 else now - int(gain)
    if abs(wanted) < abs(now) - loss:
        return now - int(loss) if now > 0 else now + int(loss)
    return wanted


def obey(
    settings: Ints,
    scales: Floats,
    command: Floats,
    step: int,
    robot: Robot,
    arena: Arena | None = None,
) -> None:
    """Applies a command: the turn now, the speed in the next step.

    Clamps both, and refuses nan and infinities.
    """
    state = robot.state
    speed, rate = command[layout.CMD_SPEED], command[layout.CMD_TURN_RATE]
    if not (math.isfinite(speed) and math.isfinite(rate)):
        robot.counts[layout.OUT_ENDING] = layout.INVALID_COMMAND
        return
    top, limit = scales[layout.SCALE_TOP_SPEED], scales[layout.SCALE_TURN_LIMIT]
    carriage = None if arena is None else arena.carriage
    half = float(TURN // 2) if carriage is None else float(TURN // 2 - 1)
    most = math.floor(min(limit * scales[layout.SCALE_TURN] + 1e-9, half))
    asked = round_away(min(max(rate * scales[layout.SCALE_TURN], -float(TURN)), float(TURN)))
    turn = min(max(asked, -most), most)  # rounded to the lattice, and never above the limit
    is_car = carriage is not None and carriage.turn_per_unit > 0.0
    if is_car:
        turn = 0
        _steer(arena, scales, speed, rate, robot)
    if carriage is None:
        state[layout.STATE_HEADING] = (state[layout.STATE_HEADING] + turn) % TURN
    else:
        turn = turn_body(arena, settings, step, turn, robot)
    if settings[layout.SET_MEASURES] != 0:
        _measure_turn(settings, scales, step, turn, robot)
    wanted = whole_speed(min(max(speed, -top), top) * scales[layout.SCALE_SPEED] * SPEED_UNIT)
    if is_car and not carriage.reverse:
        wanted = max(wanted, 0)
    state[layout.STATE_SPEED] = _next_speed(state[layout.STATE_SPEED], wanted, scales)
    if command[layout.CMD_DRAW] != 0.0:
        state[layout.STATE_DRAWS] += 1
    turn = robot.turned[0] if is_car else turn
    # A turn that a wall cut short, or that swept over fire, may have ended the run before.
    stands = (
        robot.counts[layout.OUT_ENDING] == layout.LIMIT
        and robot.journey[1] != step
        and abs(state[layout.STATE_SPEED]) <= settings[layout.SET_ARRIVAL_SPEED]
        and abs(turn) <= settings[layout.SET_ARRIVAL_TURN]
    )
    if settings[layout.SET_ARRIVAL] == layout.STOP and stands and _is_at_goal(settings, robot):
        _meet_goal(arena, robot)
        _pass_waypoint(arena, settings, step, robot)


def remember(room: Room, robot: Robot) -> None:
    """Copies the controller's memory into the state."""
    for k in range(room.words.size):
        robot.state[layout.STATE_MEMORY + k] = room.words[k]


def one_step(
    arena: Arena,
    settings: Ints,
    scales: Floats,
    act: Any,
    room: Room,
    robot: Robot,
    step: int,
    event: int,
) -> tuple[int, int, bool]:
    """One step: move, sense, act.

    Returns:
        Index of the next event, rows of the chain that are filled, and whether a wall was touched.
    """
    event, count, nx, ny = move_and_sense(arena, settings, scales, room, robot, step, event)
    if robot.counts[layout.OUT_ENDING] == layout.LIMIT and is_inside(arena, robot):
        act(room.observation, room.memory, room.command)
        obey(settings, scales, room.command, step, robot, arena)
    remember(room, robot)
    return event, count, nx != 0.0 or ny != 0.0
