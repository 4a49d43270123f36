"""Pack a world for the core's episodes, run them, and read the results."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from sim._core import ffi, lib
from sim.controllers.base import CompiledController, Controller, robot_for, senses_of
from sim.controllers.core_act import CoreAct, controller_error_of
from sim.controllers.crash_frames import crash_facts
from sim.controllers.flat_act import compiled_act
from sim.controllers.programs.program import ControllerError
from sim.controllers.shared.guarded import ControllerDied, call
from sim.kernels import layout
from sim.motion import MOTIONS
from sim.options.noise import is_noisy
from sim.options.robot import SIGNALS
from sim.options.run import COVER, MAX_RECORDED, RunOptions, check_recordable, check_step_length
from sim.outcome import ENDINGS, Outcome
from sim.runners.core_calls import (
    EVENT_FIELDS,
    REPORT,
    SENSES,
    STATE_WORDS,
    CoreArena,
    CoreEpisode,
    Driver,
    EpisodeHandle,
    Workspace,
    beam_tables,
    copy_of,
    grid_of,
    memory_for,
    near_masks,
)
from sim.runners.disturbing import PackedDisturbances
from sim.runners.long_runs import MOST_HELD, portions
from sim.runners.packing import disc_numbers, event_time, start_overlaps, target_sq
from sim.runners.python_loop import PythonLoop
from sim.trace import Trace, Words
from sim.verdict import Verdict
from worldgen.errors import InvalidParameter, InvalidWorld
from worldgen.lattice import (
    TURN,
    UNIT,
    exact,
    heading_to_lattice,
    lattice_to_metres,
    metres_to_lattice,
)
from worldgen.reach.still.cells import reachable_cells
from worldgen.support.ccall import check, pointer, writable
from worldgen.timeline import CellState
from worldgen.world import Pose, World

__all__ = ["LatticeRun"]

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]
Reports = npt.NDArray[Any]

# Parts of a step in which times are counted.
_STEP_TIME = 1 << 32

# Runs in one call of the core.
_MANY = 64

# Lattice units that robots of a fleet look further than they move, and what rounding adds to that.
_FLEET_SLACK = 40

# Columns of a recorded row: whether a wall was touched, then the state. Next, the same for a point
# of the path.
_BUMP = 0
_STATE = 1
_HEADING = 2  # index in a state, after x and y
_POINT_STEP, _POINT_TIME, _POINT_X, _POINT_Y = range(4)
_POINT_FIELDS = 4


def _memory_of(episode: CoreEpisode) -> Floats:
    """Return (m,) the memory of an episode that has ended."""
    return episode.state_words()[STATE_WORDS:].view(np.float64)


class LatticeRun:
    """One world, controller and set of options, ready to run any number of times.

    Args:
        world: The world to drive in.
        controller: The controller.
        options: Options of the run.
        lean: Whether the recording of a compiled controller omits its memory if that is large.

    Raises:
        InvalidWorld: If the start is not clear of walls.
        InvalidParameter: If the world has several robots, or the controller does not compile.
    """

    def __init__(
        self, world: World, controller: Controller, options: RunOptions, *, lean: bool = False
    ) -> None:
        # Without this, callers that do not handle fleets would ignore all robots but one.
        if world.others:
            raise InvalidParameter(
                "world-of-several-robots",
                "this runs one robot, and the world has {robots}",
                "take a world of one robot, or worldgen run",
                at_terminal=True,
                robots=len(world.robots),
            )
        robot = robot_for(controller, options.robot)
        self.world = world
        self.controller = controller
        self.options = replace(options, robot=robot)
        self._lean = lean
        self.memory = memory_for(controller)
        check_step_length(world, options.time_step, Fraction(1, UNIT))
        motion = MOTIONS.get(options.motion)
        self._cells = np.array(world.walls, np.uint8, order="C")
        self.events = self.memory.own(_event_rows(world, options.time_step))
        self._disturbances = PackedDisturbances(world, robot, options.time_step, self.memory)
        self.settings: Any = self.memory.new("WgSettings *")
        # Fill the settings first: the tables depend on the speed and the sensors.
        self._fill_settings(motion.code, motion.overlap_tolerance)
        self._near = self.memory.own(near_masks(self._cells))
        self._clearance = self.memory.own(self._clearance_table())
        self._wanted = self._cells_to_cover()
        self._beams = None
        # Beam tables hold for one map only, so they are not made if the walls change.
        if len(self.events) == 0:
            self._beams = beam_tables(self._cells, self.settings, self.memory)

    def _cells_to_cover(self) -> npt.NDArray[np.uint8] | None:
        """Return the cells that a coverage task asks for; ``None`` for another task.

        The target then ends no run, so its disc gets a squared radius that no distance has.

        Raises:
            InvalidWorld: If the world changes, or there is nothing to cover but the start's cell.
        """
        if self.options.task != COVER:
            return None
        self.settings.target_radius_sq = -1
        wanted = np.ascontiguousarray(reachable_cells(self.world), np.uint8)
        if np.count_nonzero(wanted) < 2:
            raise InvalidWorld(
                "nothing-to-cover",
                "the robot can reach the centre of no second cell, so there is nothing to cover",
                "take a larger world or a smaller robot",
            )
        return wanted

    def _fill_settings(self, motion_code: int, tolerance: float) -> None:
        # Start, target and disc, in lattice units.
        world = self.world
        settings = self.settings
        step = self.options.time_step
        settings.clear_sq, settings.reach = disc_numbers(world)
        settings.start_x, settings.start_y, settings.start_heading = self.start_of(world.start)
        settings.target_x = metres_to_lattice(world.target.x, world.cell_size)
        settings.target_y = metres_to_lattice(world.target.y, world.cell_size)
        settings.target_radius_sq = target_sq(world)
        settings.motion = motion_code
        settings.seed = self.options.seed

        # Factors between the lattice and SI units.
        settings.metres = float(exact(world.cell_size) / UNIT)
        settings.speed = float(exact(step) / exact(world.cell_size) * UNIT)
        settings.turn = step * (TURN / (2.0 * math.pi))
        settings.radians = 2.0 * math.pi / TURN
        settings.time_step = step
        settings.top_speed = world.robot_speed
        settings.radius = world.robot_radius
        settings.tolerance = tolerance * UNIT
        # A compiled controller may set its own initial speed.
        if isinstance(self.controller, CompiledController):
            settings.start_speed = min(self.controller.start_speed, world.robot_speed)
        self._fill_dynamics()
        self._fill_sensors()

    def _fill_dynamics(self) -> None:
        """Fill in the dynamics; an option that is off becomes a limit that is never reached."""
        settings = self.settings
        robot = self.options.robot
        gain = self.options.time_step * settings.speed * lib.WG_SPEED_UNIT
        settings.turn_limit = robot.turn_limit or math.inf
        settings.gain = max(1.0, robot.acceleration * gain) if robot.acceleration else math.inf
        settings.loss = max(1.0, robot.friction * gain) if robot.friction else math.inf
        settings.wall_friction = robot.wall_friction
        settings.slip = robot.slip
        settings.odometry_noise = robot.odometry_noise
        self._disturbances.fill(settings)
        settings.lattice = UNIT // robot.lattice if robot.lattice else 1

    def _fill_sensors(self) -> None:
        settings = self.settings
        robot = self.options.robot
        unit = settings.metres
        settings.senses = senses_of(self.controller) & ~(0 if robot.beams else lib.WG_SENSE_BEAMS)
        settings.sensor_cells = robot.sensor_cells
        settings.signal = SIGNALS.index(robot.signal)
        settings.plain_sensor = int(robot.plain_sensor)
        settings.sensor_range = robot.sensor_range / unit if robot.sensor_range else math.inf
        settings.sensor_field = _units(robot.sensor_field or 2 * math.pi) / 2
        settings.sensor_noise = robot.sensor_noise
        settings.smoke = robot.smoke
        settings.smoke_reach = robot.smoke_reach
        settings.beams = robot.beams
        settings.neighbours = robot.neighbours
        settings.neighbour_range = robot.neighbour_range / unit
        settings.beam_range = robot.beam_range / unit
        settings.beam_field = _units(robot.beam_field or 2 * math.pi)
        settings.beam_noise = robot.beam_noise
        settings.beam_dropout = robot.beam_dropout
        settings.coin = robot.coin

    def _clearance_table(self) -> npt.NDArray[np.int32]:
        """Return distances to cells that are ever not free.

        The table is empty if the masks around each cell reach as far as the fastest step.
        """
        fastest = int(self.settings.top_speed * self.settings.speed) + 1
        fastest += int(self.settings.drift_reach)
        if self.settings.reach + fastest <= lib.WG_NEAR * UNIT:
            return np.zeros((0, 0), np.int32)
        closing = self.world.timeline.cells_that_become(
            CellState.SOLID, CellState.BURNING, shape=self._cells.shape
        )
        ever = self._cells | closing
        table = np.zeros(ever.shape, np.int32)
        lib.wg_chessboard_clearance(grid_of(ever), writable(ffi, table, np.int32))
        return table

    def start_of(self, pose: Pose) -> tuple[int, int, int]:
        """Return a start as lattice x, y and heading.

        The position becomes the nearest lattice point at which the robot is clear of walls, among
        the nine closest ones.

        Raises:
            InvalidWorld: If none of them is clear.
        """
        start = next(self.starts_near(pose), None)
        if start is None:
            raise start_overlaps(replace(self.world, start=pose))
        return start

    def starts_near(self, pose: Pose) -> Iterator[tuple[int, int, int]]:
        """Yield the lattice points next to a start at which the robot is clear, nearest first."""
        side = self.world.cell_size
        settings = self.settings
        x = metres_to_lattice(pose.x, side)
        y = metres_to_lattice(pose.y, side)
        grid = grid_of(self._cells)
        disc = ffi.new("WgDisc *", (settings.clear_sq, settings.reach))[0]
        near = sorted(
            ((i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)),
            key=lambda d: (d[0] ** 2 + d[1] ** 2, d),
        )
        for dx, dy in near:
            if lib.wg_disc_is_clear(grid, lib.WG_SOLID, disc, x + dx, y + dy):
                yield x + dx, y + dy, heading_to_lattice(pose.heading)

    @property
    def last_event_step(self) -> int:
        """Last step in which the world changes or something pushes the robot; 0 if there is none."""
        changed = int(self.events[-1, 0]) if len(self.events) else 0
        return max(changed, self._disturbances.last_step)

    @property
    def reach_of_a_step(self) -> float:
        """How far from its centre the robot can touch another one in a step, m, or more."""
        settings = self.settings
        fastest = settings.top_speed * settings.speed + settings.drift_reach + settings.lattice
        return float((settings.reach + fastest + _FLEET_SLACK) * settings.metres)

    @property
    def reach_of_senses(self) -> float:
        """The longest range of a sensor that notices other robots, m; 0 if there is none."""
        robot = self.options.robot
        return max(robot.neighbour_range, robot.beam_range if robot.beams else 0.0)

    def run(self, steps: int, *, find_loop: bool, record: bool, digest: bool = True) -> Outcome:
        """Simulate up to ``steps`` steps from the start; see :meth:`sim.outcome.Runnable.run`."""
        self.settings.steps = steps
        self.settings.digest = int(digest)
        self.settings.find_loop = (
            lib.WG_SEEK_LOOP if find_loop and self.can_loop else lib.WG_NO_LOOP
        )
        if isinstance(self.controller, CompiledController):
            return self._run_compiled(self.controller, record)[0]
        loop = PythonLoop(self.controller, self.arena(), self.settings, self.world)
        loop.run(steps, record=record)
        return self.outcome_of(loop.episode, loop.recording(), loop.complete, loop.fault)

    def run_and_recall(self, steps: int, *, find_loop: bool) -> tuple[Outcome, Floats]:
        """Simulate a controller from the start, and return its memory at the end, too.

        Returns:
            The outcome, and (m,) the memory.

        Raises:
            InvalidParameter: If the controller itself fails.
        """
        self.settings.steps = steps
        self.settings.digest = 0
        self.settings.find_loop = (
            lib.WG_SEEK_LOOP if find_loop and self.can_loop else lib.WG_NO_LOOP
        )
        if isinstance(self.controller, CompiledController):
            outcome, ended = self._run_compiled(self.controller, record=False)
            return outcome, _memory_of(ended)
        loop = PythonLoop(self.controller, self.arena(), self.settings, self.world)
        loop.run(steps, record=False)
        if loop.fault is not None or loop.episode is None:
            raise InvalidParameter(
                "code-failed",
                "the controller fails in training: {reason}",
                "run it, and fuzz it, before you train it",
                reason="" if loop.fault is None else loop.fault.error,
            )
        outcome = self.outcome_of(loop.episode, None, loop.complete, None)
        return outcome, _memory_of(loop.episode)

    def prove(self, entry: int, period: int, *, record: bool) -> tuple[Outcome, Words] | None:
        """Simulate a loop's first period; see :meth:`sim.outcome.Runnable.prove`.

        A controller that is not compiled may have hidden state, so it must repeat a second period
        too.
        """
        if not isinstance(self.controller, CompiledController):
            return self._prove_by_recording(entry, period, record)
        settings = self.settings
        settings.steps = entry + period
        settings.digest = 1
        settings.find_loop = lib.WG_PROVE_LOOP
        settings.loop_entry = entry
        outcome, episode = self._run_compiled(self.controller, record)
        return (outcome, episode.known_words()) if outcome.ending == Verdict.LOOP else None

    def _prove_by_recording(
        self, entry: int, period: int, record: bool
    ) -> tuple[Outcome, Words] | None:
        if record:
            check_recordable(entry + 2 * period)
        elif entry + 2 * period > MAX_RECORDED:
            # Too long to record, and no recording was requested, so the budget decides.
            return None
        whole = self.run(entry + 2 * period, find_loop=False, record=True)
        if whole.trace is None or not whole.complete or whole.trace.steps < entry + 2 * period:
            return None
        states = whole.trace.states
        if not np.array_equal(states[entry : entry + period + 1], states[entry + period :]):
            return None
        outcome = self.run(entry + period, find_loop=False, record=record)
        return replace(outcome, ending=Verdict.LOOP, period=period, entry=entry), states[entry]

    @property
    def shapes(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Shapes of the grid and of the distance table; runs in lockstep must have the same."""
        return self._cells.shape, self._clearance.shape

    @property
    def bytes_per_robot(self) -> int:
        """Bytes for one robot in lockstep: its visited cells, and its copy of a changing world."""
        own = self._cells.nbytes + self._near.nbytes if len(self.events) else 0
        return int(own + self._cells.size)

    @property
    def can_loop(self) -> bool:
        """True if a state can recur.

        It cannot if the controller reads the clock, or noise that is new in each step. Senses that
        a controller does not declare are not computed, so noise in them does not matter.
        """
        reads_clock = bool(self.settings.senses & lib.WG_SENSE_TIME)
        # Disturbances show in the odometry, which is not part of the state.
        is_displaced = self.options.robot.moved
        reads_wrong_pose = is_displaced and bool(self.settings.senses & lib.WG_SENSE_ODOMETRY)
        noisy = is_noisy(self.controller, self.options)
        return not (reads_clock or reads_wrong_pose or noisy)

    def run_many(
        self,
        controller: CompiledController,
        starts: Ints,
        seeds: npt.NDArray[np.uint64],
        *,
        digest: bool,
        stop: Ints | None = None,
    ) -> Reports:
        """Run many episodes in few calls of the core; several threads may do so at the same time.

        Args:
            controller: The controller of this run.
            starts: (n, 3) starts from :meth:`start_of`.
            seeds: (n,) uint64 seeds.
            digest: Whether to compute the traces' digests.
            stop: (1,) set to anything but 0 to make this return soon; its results are then invalid.

        Returns:
            (n,) reports of type :data:`sim.runners.core_calls.REPORT`; fewer if the controller
            failed in a run, which is then the last.
        """
        # Prepare one episode, which all runs use in turn.
        settings = copy_of(self.settings, self.memory)
        settings.steps = self.options.steps
        settings.digest = int(digest)
        settings.find_loop = lib.WG_SEEK_LOOP if self.can_loop else lib.WG_NO_LOOP
        fresh = self.arena()
        episode = CoreEpisode(self.arena(), settings, Driver(controller, controller.memory))
        reports = np.zeros(len(seeds), REPORT)
        stop = np.zeros(1, np.int64) if stop is None else stop
        if episode.guarded:
            return self._run_many_guarded(episode, settings, fresh, starts, seeds, stop)

        # Run in groups; the arrays that a call gets must stay alive until it returns.
        stop_at = pointer(ffi, stop, np.int64)
        for first in range(0, len(seeds), _MANY):
            part = slice(first, first + _MANY)
            into = ffi.cast("WgReport *", ffi.from_buffer(reports[part], require_writable=True))
            own = np.ascontiguousarray(starts[part])
            numbers = np.ascontiguousarray(seeds[part])
            places = ffi.cast("WgStart *", pointer(ffi, own, np.int64))
            check(
                lib.wg_run_many(
                    episode.c,
                    settings,
                    fresh.c,
                    places,
                    pointer(ffi, numbers, np.uint64),
                    len(numbers),
                    stop_at,
                    into,
                )
            )
            if (reports["ending"][part] == lib.WG_CRASH).any():
                return reports[
                    : first + int((reports["ending"][part] == lib.WG_CRASH).argmax()) + 1
                ]
        return reports

    def _run_many_guarded(
        self,
        episode: CoreEpisode,
        settings: Any,
        fresh: CoreArena,
        starts: Ints,
        seeds: npt.NDArray[np.uint64],
        stop: Ints,
    ) -> Reports:
        """Do the same in another process, one run at a time, to notice a request to stop."""
        memory = self.memory
        reports = memory.zeros(len(seeds), REPORT)
        own_starts = memory.own(starts)
        own_seeds = memory.own(seeds)
        goes_on = memory.zeros(1, np.int64)
        # One run per call: a crash then belongs to the run that caused it.
        for n in range(len(seeds)):
            if stop[0]:
                break
            one = slice(n, n + 1)
            objects = (
                episode.c,
                settings,
                fresh.c,
                pointer(ffi, own_starts[one], np.int64),
                pointer(ffi, own_seeds[one], np.uint64),
                pointer(ffi, goes_on, np.int64),
                ffi.from_buffer(reports[one], require_writable=True),
            )
            report = ffi.addressof(episode.report)
            try:
                check(
                    call(
                        ffi.addressof(lib, "wg_call_run_many"),
                        episode.guarded,
                        objects,
                        1,
                        report=report,
                    ).result
                )
            except ControllerDied:
                reports["ending"][n] = lib.WG_CRASH
            # Stop at the first crash; the caller decides whether to continue after it.
            if reports["ending"][n] == lib.WG_CRASH:
                return reports[: n + 1].copy()
        return reports.copy()

    def sensed_of_walls(self, states: Ints) -> Floats:
        """Return what the controller senses of the walls at some poses, before the first event.

        Contact is not included, because it depends on the last move.

        Args:
            states: (n, 3) x, y and heading, in lattice units.

        Returns:
            (n, 17 + beams) observations. Only the signal and the beams are valid, and only if the
            controller reads them.
        """
        settings = copy_of(self.settings)
        settings.senses &= lib.WG_SENSE_SIGNAL | lib.WG_SENSE_SIGNAL_HEADING | lib.WG_SENSE_BEAMS
        seen = np.zeros((len(states), SENSES + self.options.robot.beams))
        poses = np.ascontiguousarray(states)
        arena = self.arena()
        starts = ffi.cast("WgStart *", pointer(ffi, poses, np.int64))
        check(
            lib.wg_sensed_of_walls(
                arena.c, settings, starts, len(poses), writable(ffi, seen, np.float64)
            )
        )
        return seen

    def arena(self) -> CoreArena:
        """Return the surroundings before the first event, with the start marked as visited."""
        visited: npt.NDArray[np.uint8] = np.zeros_like(self._cells)
        height, width = visited.shape
        row = min(int(self.settings.start_y) // UNIT, height - 1)
        visited[row, min(int(self.settings.start_x) // UNIT, width - 1)] = 1
        near = self._near.copy() if len(self.events) else self._near
        arena = CoreArena(
            self._cells.copy(),
            near,
            self._clearance,
            self.events,
            visited,
            self._beams,
            self._wanted,
            self.memory,
        )
        # The settings point to what this run owns, and an episode outlives it.
        arena.held = self
        return arena

    def _run_compiled(
        self, controller: CompiledController, record: bool
    ) -> tuple[Outcome, CoreEpisode]:
        # Run once for the verdict. Only if a recording is wanted, run again with room for exactly
        # the steps and path points that there are.
        episode = self._episode(controller)
        episode.run_to_the_end()
        fault = self._fault(controller, episode) if episode.report.ending == lib.WG_CRASH else None
        if not record:
            return self.outcome_of(episode, None, fault=fault), episode
        done = int(episode.report.steps)
        points = int(episode.report.points)
        if self._lean and 8 * (done + 1) * (_STATE + episode.words) > MOST_HELD:
            outcome = self.outcome_of(episode, None, fault=fault)
            return replace(outcome, trace=self._lean_trace(controller, done, points)), episode
        rows = self.memory.zeros((done + 1, _STATE + episode.words), np.int64)
        path = self.memory.zeros((points, _POINT_FIELDS), np.int64)
        episode = self._episode(controller)
        rows[0, _STATE:] = episode.state_words()
        episode.record(rows[1:], path)
        episode.run_to_the_end()
        return self.outcome_of(episode, (rows, path), fault=fault), episode

    def _episode(self, controller: CompiledController) -> CoreEpisode:
        return CoreEpisode(self.arena(), self.settings, Driver(controller, controller.memory))

    def _fault(self, controller: CompiledController, failed: CoreEpisode) -> ControllerError:
        """Return the fault of an episode's last step.

        A function compiled by numba reports only that it raised. To find out what, the last step is
        run again from Python.
        """
        if isinstance(controller.act, CoreAct):
            return controller_error_of(ffi.string(failed.report.error).decode("utf-8", "replace"))
        settings = copy_of(self.settings)
        settings.find_loop = lib.WG_NO_LOOP
        episode = CoreEpisode(self.arena(), settings, Driver(controller, controller.memory))
        episode.run(int(failed.report.steps) - 1)
        # Without a function the episode stops where the controller is to act.
        episode.c.controller.act = ffi.NULL
        episode.c.controller.flat = ffi.NULL
        lib.wg_episode_step(episode.c)
        workspace = Workspace(episode)
        act = compiled_act(controller.act)
        try:
            act(
                workspace.observation,
                workspace.memory,
                np.zeros(layout.CMD_SIZE + layout.MESSAGE_SIZE),
            )
        except Exception as error:  # noqa: BLE001 - a controller may raise anything
            facts = crash_facts(error, controller) or {"message": str(error)}
            return ControllerError(Verdict.CRASH, f"{type(error).__name__}: {error}", facts)
        return ControllerError(
            Verdict.CRASH, ffi.string(failed.report.error).decode("utf-8", "replace")
        )

    def _lean_trace(self, controller: CompiledController, steps: int, points: int) -> Trace:
        """Return the recording without the memory, which another run can restore."""
        settings = copy_of(self.settings, self.memory)
        size = len(controller.memory)
        settings.find_loop = lib.WG_NO_LOOP
        rows = np.zeros((steps + 1, _STATE + STATE_WORDS), np.int64)
        path = np.zeros((points, _POINT_FIELDS), np.int64)
        filled = 0
        for portion in portions(controller, self.arena(), settings, steps):
            steps = portion.first + len(portion.rows) - 1
            new = len(portion.path)
            rows[portion.first : steps + 1] = portion.rows[:, : rows.shape[1]]
            path[filled : filled + new] = portion.path
            filled += new

        # Memories are too large to keep, so simulate again and pick those wanted.
        def recall(at: Ints, take: Callable[[int, Floats], None]) -> None:
            for first, states, _ in portions(controller, self.arena(), settings, int(at[-1])):
                memories = states[:, _STATE + STATE_WORDS :].view(np.float64)
                begin, end = np.searchsorted(at, (first, first + len(states)))
                for step in at[begin:end].tolist():
                    take(step, memories[step - first])

        return replace(
            self.trace_of(rows[: steps + 1], path[:filled], True, lean=True),
            recall=recall,
            recalled=size,
        )

    def outcome_of(
        self,
        episode: EpisodeHandle | None,
        recording: tuple[Ints, Ints] | None,
        complete: bool = True,
        fault: ControllerError | None = None,
    ) -> Outcome:
        """Return the outcome of an episode that this run has packed.

        Args:
            episode: The episode; ``None`` if the controller failed before it began.
            recording: Its rows and the points of its path, if it was recorded.
            complete: Whether the recorded state alone decides the future.
            fault: The controller's fault, if it made one.
        """
        report: Any = episode.report if episode else ffi.new("WgReport *")
        return Outcome(
            ending=fault.verdict if fault else ENDINGS[int(report.ending)],
            steps=int(report.steps),
            period=int(report.period),
            entry=episode.entry if episode else -1,
            path_length=float(report.path_length) * float(self.settings.metres),
            collisions=int(report.collisions),
            digest=f"{int(report.digest):016x}",
            last_new_cell=int(report.last_new_cell),
            hit_step=int(report.hit_step),
            hit_cell=(int(report.hit_ix), int(report.hit_iy)),
            hit_state=CellState(int(report.hit_state)).word,
            overlap_step=int(report.overlap_step),
            overlap_cell=(int(report.overlap_ix), int(report.overlap_iy)),
            random_draws=int(episode.state.draws) if episode else 0,
            cells_visited=int(report.cells_visited),
            points=int(report.points),
            cells_left=int(report.cells_left),
            cells_wanted=0 if self._wanted is None else int(np.count_nonzero(self._wanted)),
            complete=complete,
            fault=fault.evidence if fault else None,
            trace=None if recording is None else self.trace_of(*recording, complete),
        )

    def trace_of(self, rows: Ints, path: Ints, complete: bool, *, lean: bool = False) -> Trace:
        """Return a recording in metres and radians."""
        states = rows[:, _STATE:]
        side = self.world.cell_size
        turned = states[:, _HEADING]
        way = _with_stands(rows, path)
        return Trace(
            time_step=self.options.time_step,
            x=_metres(states[:, 0], side),
            y=_metres(states[:, 1], side),
            heading=np.where(turned > TURN // 2, turned - TURN, turned)
            * float(self.settings.radians),
            bump=rows[:, _BUMP] != 0,
            path_x=_metres(way[:, _POINT_X], side),
            path_y=_metres(way[:, _POINT_Y], side),
            path_step=way[:, _POINT_STEP].copy(),
            path_share=way[:, _POINT_TIME] / _STEP_TIME,
            words=np.zeros(0, np.uint64) if lean else _words(rows, path),
            states=np.ascontiguousarray(states).view(np.uint64),
            complete=complete and not lean,
            memory_at=-1 if lean else STATE_WORDS,
            robot=self.options.robot,
            task=self.options.task,
        )


def _with_stands(rows: Ints, path: Ints) -> Ints:
    """Return the path with a point added at the end of each step in which the robot stopped."""
    last = np.zeros(len(rows), np.int64)
    np.maximum.at(last, path[:, _POINT_STEP], path[:, _POINT_TIME])
    last[0] = -1  # Reserve a point for the start too.
    stands = np.flatnonzero(last < _STEP_TIME)
    ends = np.empty((len(stands), _POINT_FIELDS), np.int64)
    ends[:, _POINT_STEP] = stands
    ends[:, _POINT_TIME] = np.where(stands > 0, _STEP_TIME, 0)
    ends[:, _POINT_X] = rows[stands, _STATE]
    ends[:, _POINT_Y] = rows[stands, _STATE + 1]
    whole = np.concatenate([path, ends])
    return whole[np.lexsort((whole[:, _POINT_TIME], whole[:, _POINT_STEP]))]


def _words(rows: Ints, path: Ints) -> npt.NDArray[np.uint64]:
    """Return the words of the digest: for each step its contact, path points and final state."""
    # Sort the pieces of all steps into their order in the digest, and find where each one begins.
    steps = np.concatenate([np.arange(1, len(rows)), path[:, _POINT_STEP], np.arange(1, len(rows))])
    kinds = np.repeat([0, 1, 2], [len(rows) - 1, len(path), len(rows) - 1])
    order = np.lexsort((np.arange(len(steps)), kinds, steps))
    width = np.array([1, 3, rows.shape[1] - 1])[kinds]
    starts = np.zeros(len(steps) + 1, np.int64)
    starts[1:] = np.cumsum(width[order])
    places = np.empty(len(steps), np.int64)
    places[order] = starts[:-1]
    words = np.empty(starts[-1], np.int64)

    # Write the pieces there, one column at a time.
    words[places[kinds == 0]] = rows[1:, _BUMP]
    for k, column in enumerate((_POINT_X, _POINT_Y, _POINT_TIME)):
        words[places[kinds == 1] + k] = path[:, column]
    for k in range(rows.shape[1] - 1):
        words[places[kinds == 2] + k] = rows[1:, _STATE + k]
    return words.view(np.uint64)


def _units(radians: float) -> float:
    """Return an angle in heading units; a whole turn is exact."""
    return TURN * (radians / (2 * math.pi))


def _metres(units: Ints, cell_size: float) -> Floats:
    """Return lattice units in metres, correctly rounded, so that short decimals stay short."""
    ratio = exact(cell_size) / UNIT
    if int(np.abs(units).max(initial=0)) * ratio.numerator < 2**53 and ratio.denominator < 2**53:
        # Numerator and denominator are exact here, so this division rounds only once.
        return (units * ratio.numerator) / float(ratio.denominator)
    return np.array([lattice_to_metres(unit, cell_size) for unit in units.tolist()])


def _event_rows(world: World, time_step: float) -> Ints:
    """Return the world's events in the core's form, sorted by time."""
    rows = [
        (*event_time(event, time_step, _STEP_TIME), event.ix, event.iy, int(event.state))
        for event in world.timeline
    ]
    return np.array(rows, np.int64).reshape(-1, EVENT_FIELDS)
