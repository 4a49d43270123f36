"""Packs a world for the lattice kernels, runs them, and reads the result back. No maths of its own."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numba
import numpy as np
import numpy.typing as npt

from sim.controllers.base import CompiledController, Controller, compiled_act, numba_config, robot_for, senses_of
from sim.controllers.program import Misbehaviour
from sim.crash_frames import crash_facts
from sim.kernel_types import episode_types, typed_kernel
from sim.kernels import layout
from sim.kernels.geometry import NEAR, chessboard_clearance, near_masks, pose_is_clear
from sim.kernels.lattice_batch import lattice_batch
from sim.kernels.lattice_episode import lattice_episode
from sim.kernels.lattice_sense import heading_table, sense
from sim.kernels.lattice_state import Arena, Robot, Room, new_robot, new_room
from sim.kernels.recurrence import entry_of_loop
from sim.long_runs import MOST_HELD, portions
from sim.motion import MOTIONS
from sim.outcome import Outcome
from sim.packing import disc_numbers, event_time, start_overlaps, target_sq
from sim.python_loop import PythonLoop
from sim.robot_options import SIGNALS
from sim.run_options import MAX_RECORDED, RunOptions, check_recordable, check_step_length
from sim.trace import Trace, Words
from worldgen.lattice import (
    TURN,
    UNIT,
    exact,
    heading_to_lattice,
    lattice_to_metres,
    metres_to_lattice,
)
from worldgen.timeline import CellState
from worldgen.world import Pose, World

__all__ = ["LatticeRun"]

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]

_ENDINGS = {
    layout.LIMIT: "limit",
    layout.REACHED: "reached",
    layout.LOOP: "loop",
    layout.TUNNEL: "tunnel",
    layout.BURNED: "burned",
    layout.INVALID_COMMAND: "invalid-command",
}


@functools.cache
def _headings() -> Ints:
    return heading_table()


@functools.cache
def _typed(function: Any) -> Any:
    """An episode kernel, typed for any compiled controller, so that it compiles once for all of them."""
    if numba_config.DISABLE_JIT:
        return function
    arena, robot, room, act = episode_types()
    ints = numba.int64[::1]
    floats = numba.float64[::1]
    rows = numba.int64[:, ::1]
    numbers = (ints, floats, act, floats, room, robot)
    signatures = {
        lattice_episode: numba.void(arena, *numbers, rows, rows),
        lattice_batch: numba.void(arena, arena, *numbers, rows, ints, rows, rows, numba.float64[:, ::1]),
    }
    return typed_kernel(function, signatures[function])


class LatticeRun:
    """One world, controller and set of options, ready to run any number of times.

    Args:
        world: Where.
        controller: Who.
        options: How.
        lean: Whether the recording of a compiled controller leaves its memory out if that would take much.

    Raises:
        InvalidWorld: If the start is not clear of walls.
        InvalidParameter: If the controller does not compile.
    """

    def __init__(self, world: World, controller: Controller, options: RunOptions, *, lean: bool = False) -> None:
        robot = robot_for(controller, options.robot)
        self.world, self.controller, self.options = world, controller, replace(options, robot=robot)
        self._lean = lean
        check_step_length(world, options.time_step, Fraction(1, UNIT))
        motion = MOTIONS.get(options.motion)
        self._cells = world.walls.astype(np.uint8)
        self.events = _event_rows(world, options.time_step)
        self.settings, self.scales = np.zeros(layout.SET_SIZE, np.int64), np.zeros(layout.SCALE_SIZE)
        self._fill_settings(motion.code)
        self._fill_scales(motion.overlap_tolerance)
        self._near = np.zeros(world.walls.shape, np.int32)
        near_masks(self._cells, self._near)
        self._clearance = self._clearance_table()

    def _fill_settings(self, motion_code: int) -> None:
        world, settings = self.world, self.settings
        clear_sq, reach = disc_numbers(world)
        settings[layout.SET_CLEAR_SQ], settings[layout.SET_REACH] = clear_sq, reach
        settings[layout.SET_X : layout.SET_HEADING + 1] = self.start_of(world.start)
        settings[layout.SET_TARGET_X] = metres_to_lattice(world.target.x, world.cell_size)
        settings[layout.SET_TARGET_Y] = metres_to_lattice(world.target.y, world.cell_size)
        settings[layout.SET_TARGET_SQ] = target_sq(world)
        settings[layout.SET_MOTION] = motion_code
        robot = self.options.robot
        settings[layout.SET_SENSES] = senses_of(self.controller) & ~(0 if robot.beams else layout.SENSE_BEAMS)
        settings[layout.SET_BEAMS], settings[layout.SET_SENSOR_CELLS] = robot.beams, robot.sensor_cells
        settings[layout.SET_SIGNAL] = SIGNALS.index(robot.signal)
        settings[layout.SET_SMOKE_REACH] = robot.smoke_reach
        settings[layout.SET_PLAIN_SENSOR] = int(robot.plain_sensor)
        settings[layout.SET_LATTICE] = UNIT // robot.lattice if robot.lattice else 1
        settings[layout.SET_COIN] = robot.coin
        settings[layout.SET_SEED] = np.uint64(self.options.seed).astype(np.int64)

    def _fill_scales(self, tolerance: float) -> None:
        world, scales, step = self.world, self.scales, self.options.time_step
        scales[layout.SCALE_METRES] = float(exact(world.cell_size) / UNIT)
        scales[layout.SCALE_SPEED] = float(exact(step) / exact(world.cell_size) * UNIT)
        scales[layout.SCALE_TURN] = step * (TURN / (2.0 * math.pi))
        scales[layout.SCALE_RADIANS] = 2.0 * math.pi / TURN
        scales[layout.SCALE_TIME_STEP] = step
        scales[layout.SCALE_TOP_SPEED], scales[layout.SCALE_RADIUS] = world.robot_speed, world.robot_radius
        scales[layout.SCALE_TOLERANCE] = tolerance * UNIT
        self._fill_robot_scales()
        if isinstance(self.controller, CompiledController):
            scales[layout.SCALE_START_SPEED] = min(self.controller.start_speed, world.robot_speed)

    def _fill_robot_scales(self) -> None:
        """Dynamics and sensors; an option that is off becomes a limit that nothing reaches."""
        scales, robot, step = self.scales, self.options.robot, self.options.time_step
        gain = step * scales[layout.SCALE_SPEED] * layout.SPEED_UNIT
        scales[layout.SCALE_TURN_LIMIT] = robot.turn_limit or math.inf
        scales[layout.SCALE_GAIN] = max(1.0, robot.acceleration * gain) if robot.acceleration else math.inf
        scales[layout.SCALE_LOSS] = max(1.0, robot.friction * gain) if robot.friction else math.inf
        scales[layout.SCALE_WALL_FRICTION], scales[layout.SCALE_SLIP] = robot.wall_friction, robot.slip
        scales[layout.SCALE_ODOMETRY_NOISE] = robot.odometry_noise
        unit = scales[layout.SCALE_METRES]
        scales[layout.SCALE_SENSOR_RANGE] = robot.sensor_range / unit if robot.sensor_range else math.inf
        scales[layout.SCALE_SENSOR_FIELD] = _units(robot.sensor_field or 2 * math.pi) / 2
        scales[layout.SCALE_SENSOR_NOISE], scales[layout.SCALE_SMOKE] = robot.sensor_noise, robot.smoke
        scales[layout.SCALE_BEAM_RANGE] = robot.beam_range / unit
        scales[layout.SCALE_BEAM_FIELD] = _units(robot.beam_field or 2 * math.pi)
        scales[layout.SCALE_BEAM_NOISE], scales[layout.SCALE_BEAM_DROPOUT] = robot.beam_noise, robot.beam_dropout

    def _clearance_table(self) -> npt.NDArray[np.int32]:
        """Distances to cells that are ever not free; of no rows where the masks reach as far as the fastest step."""
        fastest = int(self.scales[layout.SCALE_TOP_SPEED] * self.scales[layout.SCALE_SPEED]) + 1
        if self.settings[layout.SET_REACH] + fastest <= NEAR * UNIT:
            return np.zeros((0, 0), np.int32)
        ever, line = self._cells.copy(), self.world.timeline
        np.maximum.at(ever, (line.iy, line.ix), line.states)  # a cell may change more than once
        table = np.zeros(ever.shape, np.int32)
        chessboard_clearance(ever, table)
        return table

    def start_of(self, pose: Pose) -> tuple[int, int, int]:
        """A start on the lattice: heading, and the clear point nearest to the place, among the nine next to it.

        Raises:
            InvalidWorld: If none of them is clear of walls.
        """
        side, settings = self.world.cell_size, self.settings
        x, y = metres_to_lattice(pose.x, side), metres_to_lattice(pose.y, side)
        clear_sq, reach = int(settings[layout.SET_CLEAR_SQ]), int(settings[layout.SET_REACH])
        near = sorted(((i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)), key=lambda d: (d[0] ** 2 + d[1] ** 2, d))
        for dx, dy in near:
            if pose_is_clear(self._cells, layout.SOLID, clear_sq, reach, x + dx, y + dy):
                return x + dx, y + dy, heading_to_lattice(pose.heading)
        raise start_overlaps(replace(self.world, start=pose))

    @property
    def last_event_step(self) -> int:
        """Step in which the world changes for the last time; 0 if it never does."""
        return int(self.events[-1, layout.EVENT_STEP]) if len(self.events) else 0

    def run(self, steps: int, *, find_loop: bool, record: bool, digest: bool = True) -> Outcome:
        """Runs up to ``steps`` steps from the start; with ``find_loop`` a recurrence ends the run."""
        self.settings[layout.SET_STEPS], self.settings[layout.SET_DIGEST] = steps, int(digest)
        self.settings[layout.SET_FIND_LOOP] = layout.SEEK_LOOP if find_loop and self.can_loop else layout.NO_LOOP
        if isinstance(self.controller, CompiledController):
            return self._run_compiled(self.controller, record)[0]
        loop = PythonLoop(self.controller, self.arena(), self.settings, self.scales, self.world)
        loop.run(steps, record=record)
        entry = self._entry(loop.room, loop.robot)
        return self._outcome(loop.robot, loop.recording(), entry, loop.complete, loop.fault)

    def prove(self, entry: int, period: int, *, record: bool) -> tuple[Outcome, Words] | None:
        """Runs to the end of a loop's first period; see :meth:`sim.outcome.Runnable.prove`.

        A controller that is not compiled may be in a state that we do not see: it must repeat a second period too.
        """
        if not isinstance(self.controller, CompiledController):
            return self._prove_by_recording(entry, period, record)
        settings = self.settings
        settings[layout.SET_STEPS], settings[layout.SET_DIGEST] = entry + period, 1
        settings[layout.SET_FIND_LOOP], settings[layout.SET_ENTRY] = layout.PROVE_LOOP, entry
        outcome, room = self._run_compiled(self.controller, record)
        return (outcome, room.search.known.view(np.uint64)) if outcome.ending == "loop" else None

    def _prove_by_recording(self, entry: int, period: int, record: bool) -> tuple[Outcome, Words] | None:
        if record:
            check_recordable(entry + 2 * period)
        elif entry + 2 * period > MAX_RECORDED:
            return None  # too long to be proved; nobody asked for a recording, so the budget decides
        whole = self.run(entry + 2 * period, find_loop=False, record=True)
        if whole.trace is None or not whole.complete or whole.trace.steps < entry + 2 * period:
            return None
        states = whole.trace.states
        if not np.array_equal(states[entry : entry + period + 1], states[entry + period :]):
            return None
        outcome = self.run(entry + period, find_loop=False, record=record)
        return replace(outcome, ending="loop", period=period, entry=entry), states[entry]

    @property
    def shapes(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """What runs in lockstep must have in common: the shapes of the grid and of the table of distances."""
        return self._cells.shape, self._clearance.shape

    @property
    def bytes_per_robot(self) -> int:
        """What a robot takes of a fleet's memory: where it has been, and a world that changes as it goes."""
        own = self._cells.nbytes + self._near.nbytes if len(self.events) else 0
        return int(own + self._cells.size)

    @property
    def can_loop(self) -> bool:
        """Whether a state can come back: not if the controller reads the clock, or noise that is new in each step.

        What a controller does not declare among its ``senses`` it does not get, so noise there decides nothing.
        """
        robot = self.options.robot
        noisy = layout.SENSE_TIME
        if robot.odometry_noise > 0.0:
            noisy |= layout.SENSE_ODOMETRY
        if robot.sensor_noise > 0.0:
            noisy |= layout.SENSE_SIGNAL | layout.SENSE_SIGNAL_HEADING
        if robot.beam_noise > 0.0 or robot.beam_dropout > 0.0:
            noisy |= layout.SENSE_BEAMS
        return robot.slip == 0.0 and not self.settings[layout.SET_SENSES] & noisy

    def run_many(
        self, controller: CompiledController, starts: Ints, seeds: npt.NDArray[np.uint64], *, digest: bool
    ) -> tuple[Ints, Floats]:
        """Runs many episodes in one call of the kernel; several threads may do so at once.

        Args:
            controller: The controller of this run.
            starts: (n, 3) :meth:`start_of`.
            seeds: (n,).
            digest: Whether to work out the traces' digests.

        Returns:
            (n, OUT_SIZE) int64 ``OUT_``, and (n, SUM_SIZE) ``SUM_``.
        """
        settings = self.settings.copy()
        settings[layout.SET_STEPS], settings[layout.SET_DIGEST] = self.options.steps, int(digest)
        settings[layout.SET_FIND_LOOP] = layout.SEEK_LOOP if self.can_loop else layout.NO_LOOP
        counts, sums = np.zeros((len(seeds), layout.OUT_SIZE), np.int64), np.zeros((len(seeds), layout.SUM_SIZE))
        memory, act = np.array(controller.memory, np.float64), compiled_act(controller.act)
        room = self._room(memory.size, settings)
        robot = new_robot(memory.size, self.events)
        _typed(lattice_batch)(
            self.arena(), self.arena(), settings, self.scales, act, memory, room, robot, starts, seeds.view(np.int64),
            np.zeros((0, 1), np.int64), counts, sums,
        )  # fmt: skip
        return counts, sums

    def sensed_of_walls(self, states: Ints) -> Floats:
        """What the controller senses, of all that walls decide beside contact, before the first event.

        Args:
            states: (n, 3) ``STATE_X``, ``STATE_Y``, ``STATE_HEADING``.

        Returns:
            (n, OBS_SIZE + beams) observations in which the signal and the beams count, if it looks at them.
        """
        settings = self.settings.copy()
        settings[layout.SET_SENSES] &= layout.SENSE_SIGNAL | layout.SENSE_SIGNAL_HEADING | layout.SENSE_BEAMS
        seen = np.zeros((len(states), layout.OBS_SIZE + self.options.robot.beams))
        nowhere = np.zeros(3)
        for state, observation in zip(states, seen, strict=True):
            sense(self._cells, _headings(), settings, self.scales, state, nowhere, (0.0, 0.0), 0, observation)
        return seen

    def arena(self) -> Arena:
        """The world before the first event."""
        visited = np.zeros(self._cells.shape, np.uint8)
        visited[self._cell_of(layout.SET_Y, 0), self._cell_of(layout.SET_X, 1)] = 1
        near = self._near.copy() if len(self.events) else self._near
        return Arena(self._cells.copy(), near, self._clearance, self.events, _headings(), visited)

    def _cell_of(self, setting: int, axis: int) -> int:
        """Row or column of the start."""
        return int(min(self.settings[setting] // UNIT, self._cells.shape[axis] - 1))

    def _room(self, memory: int, settings: Ints) -> Room:
        """Room for one run, with a log if it looks for a recurrence."""
        seeks = settings[layout.SET_FIND_LOOP] == layout.SEEK_LOOP
        return new_room(memory, self.options.robot.beams, int(settings[layout.SET_STEPS]) if seeks else 0)

    def _entry(self, room: Room | None, robot: Robot) -> int:
        """Where the loop begins with which a run has ended; -1 if it ended otherwise."""
        counts = robot.counts
        if room is None or counts[layout.OUT_ENDING] != layout.LOOP:
            return -1
        end = int(counts[layout.OUT_STEPS])
        period = int(counts[layout.OUT_PERIOD])
        if self.settings[layout.SET_FIND_LOOP] == layout.PROVE_LOOP:
            return end - period
        return int(entry_of_loop(room.search.log, self.last_event_step, end, period))

    def _run_compiled(self, controller: CompiledController, record: bool) -> tuple[Outcome, Room]:
        nothing = np.zeros((0, 1), np.int64)
        robot, room, fault = self._episode(controller, nothing, nothing)
        entry = self._entry(room, robot)
        if not record:
            return self._outcome(robot, None, entry, fault=fault), room
        done, points = int(robot.counts[layout.OUT_STEPS]), int(robot.counts[layout.OUT_POINTS])
        if self._lean and 8 * (done + 1) * (layout.ROW_STATE + robot.state.size) > MOST_HELD:
            outcome = self._outcome(robot, None, entry, fault=fault)
            return replace(outcome, trace=self._lean_trace(controller, done, points)), room
        rows = np.zeros((done + 1, layout.ROW_STATE + robot.state.size), np.int64)
        path = np.zeros((points, layout.POINT_SIZE), np.int64)
        robot, room, fault = self._episode(controller, rows, path)
        return self._outcome(robot, (rows, path), entry, fault=fault), room

    def _episode(
        self, controller: CompiledController, rows: Ints, path: Ints
    ) -> tuple[Robot, Room, Misbehaviour | None]:
        """One run of the kernel, and what the controller raised."""
        memory = np.array(controller.memory, np.float64)
        robot = new_robot(memory.size, self.events)
        room = self._room(memory.size, self.settings)
        act = compiled_act(controller.act)
        fault = None
        try:
            _typed(lattice_episode)(self.arena(), self.settings, self.scales, act, memory, room, robot, rows, path)
        except Exception as error:  # noqa: BLE001 - raised in the compiled controller, which may raise anything
            facts = crash_facts(error, controller) or {"message": str(error)}
            fault = Misbehaviour("crash", f"{type(error).__name__}: {error}", facts)
        return robot, room, fault

    def _lean_trace(self, controller: CompiledController, steps: int, points: int) -> Trace:
        """The recording without the memory, which it can recall."""
        settings, size = self.settings.copy(), len(controller.memory)
        settings[layout.SET_FIND_LOOP] = layout.NO_LOOP
        rows = np.zeros((steps + 1, layout.ROW_STATE + layout.STATE_MEMORY), np.int64)
        path, filled = np.zeros((points, layout.POINT_SIZE), np.int64), 0
        for portion in portions(controller, self.arena(), settings, self.scales, steps):
            steps, new = portion.first + len(portion.rows) - 1, len(portion.path)
            rows[portion.first : steps + 1] = portion.rows[:, : rows.shape[1]]
            path[filled : filled + new] = portion.path
            filled += new

        def recall(at: Ints, take: Callable[[int, Floats], None]) -> None:
            for first, states, _ in portions(controller, self.arena(), settings, self.scales, int(at[-1])):
                memories = states[:, layout.ROW_STATE + layout.STATE_MEMORY :].view(np.float64)
                begin, end = np.searchsorted(at, (first, first + len(states)))
                for step in at[begin:end].tolist():
                    take(step, memories[step - first])

        return replace(self._trace(rows[: steps + 1], path[:filled], True, lean=True), recall=recall, recalled=size)

    def _outcome(
        self,
        robot: Robot,
        recording: tuple[Ints, Ints] | None,
        entry: int,
        complete: bool = True,
        fault: Misbehaviour | None = None,
    ) -> Outcome:
        counts = robot.counts

        def cell(first: int) -> tuple[int, int]:
            return int(counts[first]), int(counts[first + 1])

        return Outcome(
            ending=fault.verdict if fault else _ENDINGS[int(counts[layout.OUT_ENDING])],
            steps=int(counts[layout.OUT_STEPS]),
            period=int(counts[layout.OUT_PERIOD]),
            entry=entry,
            path_length=float(robot.sums[layout.SUM_PATH]) * float(self.scales[layout.SCALE_METRES]),
            collisions=int(counts[layout.OUT_COLLISIONS]),
            digest=f"{int(counts[layout.OUT_DIGEST]) & (2**64 - 1):016x}",
            last_new_cell=int(counts[layout.OUT_LAST_NEW_CELL]),
            hit_step=int(counts[layout.OUT_HIT_STEP]),
            hit_cell=cell(layout.OUT_HIT_IX),
            hit_state=CellState(int(counts[layout.OUT_HIT_STATE])).word,
            overlap_step=int(counts[layout.OUT_OVERLAP_STEP]),
            overlap_cell=cell(layout.OUT_OVERLAP_IX),
            random_draws=int(robot.state[layout.STATE_DRAWS]),
            complete=complete,
            fault={"error": fault.error, **fault.evidence} if fault else {},
            trace=None if recording is None else self._trace(*recording, complete),
        )

    def _trace(self, rows: Ints, path: Ints, complete: bool, *, lean: bool = False) -> Trace:
        """The recorded rows in metres and radians."""
        states, side = rows[:, layout.ROW_STATE :], self.world.cell_size
        turned = states[:, layout.STATE_HEADING]
        way = _with_stands(rows, path)
        return Trace(
            time_step=self.options.time_step,
            x=_metres(states[:, layout.STATE_X], side),
            y=_metres(states[:, layout.STATE_Y], side),
            heading=np.where(turned > TURN // 2, turned - TURN, turned) * float(self.scales[layout.SCALE_RADIANS]),
            bump=rows[:, layout.ROW_BUMP] != 0,
            path_x=_metres(way[:, layout.POINT_X], side),
            path_y=_metres(way[:, layout.POINT_Y], side),
            path_step=way[:, layout.POINT_STEP].copy(),
            path_share=way[:, layout.POINT_TIME] / layout.TIME_UNIT,
            words=np.zeros(0, np.uint64) if lean else _words(rows, path),
            states=np.ascontiguousarray(states).view(np.uint64),
            complete=complete and not lean,
            memory_at=-1 if lean else layout.STATE_MEMORY,
        )


def _with_stands(rows: Ints, path: Ints) -> Ints:
    """The path from the start on, with a point at the end of each step in which the robot came to stand."""
    last = np.zeros(len(rows), np.int64)
    np.maximum.at(last, path[:, layout.POINT_STEP], path[:, layout.POINT_TIME])
    last[0] = -1  # the start
    stands = np.flatnonzero(last < layout.TIME_UNIT)
    ends = np.empty((len(stands), layout.POINT_SIZE), np.int64)
    ends[:, layout.POINT_STEP], ends[:, layout.POINT_TIME] = stands, np.where(stands > 0, layout.TIME_UNIT, 0)
    ends[:, layout.POINT_X] = rows[stands, layout.ROW_STATE + layout.STATE_X]
    ends[:, layout.POINT_Y] = rows[stands, layout.ROW_STATE + layout.STATE_Y]
    whole = np.concatenate([path, ends])
    return whole[np.lexsort((whole[:, layout.POINT_TIME], whole[:, layout.POINT_STEP]))]


def _words(rows: Ints, path: Ints) -> npt.NDArray[np.uint64]:
    """What the digest runs over: of each step the contact, the points of its path, and the state after it."""
    steps = np.concatenate([np.arange(1, len(rows)), path[:, layout.POINT_STEP], np.arange(1, len(rows))])
    kinds = np.repeat([0, 1, 2], [len(rows) - 1, len(path), len(rows) - 1])
    order = np.lexsort((np.arange(len(steps)), kinds, steps))
    width = np.array([1, 3, rows.shape[1] - 1])[kinds]
    starts = np.zeros(len(steps) + 1, np.int64)
    starts[1:] = np.cumsum(width[order])
    places = np.empty(len(steps), np.int64)
    places[order] = starts[:-1]
    words = np.empty(starts[-1], np.int64)
    words[places[kinds == 0]] = rows[1:, layout.ROW_BUMP]
    for k, column in enumerate((layout.POINT_X, layout.POINT_Y, layout.POINT_TIME)):
        words[places[kinds == 1] + k] = path[:, column]
    for k in range(rows.shape[1] - 1):
        words[places[kinds == 2] + k] = rows[1:, layout.ROW_STATE + k]
    return words.view(np.uint64)


def _units(radians: float) -> float:
    """An angle in heading units; a whole turn exactly."""
    return TURN * (radians / (2 * math.pi))


def _metres(units: Ints, cell_size: float) -> Floats:
    """Lattice units as metres, correctly rounded, so that short decimals stay short."""
    ratio = exact(cell_size) / UNIT
    if int(np.abs(units).max(initial=0)) * ratio.numerator < 2**53 and ratio.denominator < 2**53:
        return (units * ratio.numerator) / float(ratio.denominator)  # one rounding: both are exact
    return np.array([lattice_to_metres(unit, cell_size) for unit in units.tolist()])


def _event_rows(world: World, time_step: float) -> Ints:
    """Events as the kernel takes them, sorted by time."""
    rows = [
        (*event_time(event, time_step, layout.TIME_UNIT), event.ix, event.iy, int(event.state))
        for event in world.timeline
    ]
    return np.array(rows, np.int64).reshape(-1, layout.EVENT_SIZE)
