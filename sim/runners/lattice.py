"""Pack a world for the core's episodes, run them, and read the results."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from sim._core import ffi, lib
from sim.clock.controller_time import count_differences
from sim.controllers.base import CompiledController, Controller, robot_for
from sim.controllers.controller_error import ControllerError
from sim.controllers.core_act import CoreAct
from sim.controllers.crash_frames import crash_facts, crash_text
from sim.controllers.flat_act import compiled_act
from sim.controllers.noise import is_noisy
from sim.controllers.shared.guarded import CoreMemory
from sim.evidence import BudgetEvidence
from sim.kernels import layout
from sim.options.run import (
    COVER,
    MAX_RECORDED,
    TIME_STEPS,
    RunOptions,
    check_recordable,
    check_step_length,
)
from sim.outcome import ENDINGS, Outcome
from sim.runners.controller_host import ControllerHost, host_of
from sim.runners.core_calls import (
    EVENT_FIELDS,
    STATE_WORDS,
    CoreArena,
    CoreEpisode,
    Driver,
    EpisodeHandle,
    Workspace,
    beam_tables,
    copy_of,
    grid_of,
    headings,
    memory_for,
    near_masks,
)
from sim.runners.drifting import with_memory_drift
from sim.runners.long_runs import MOST_HELD, portions
from sim.runners.packing import STEP_TIME, event_time, start_overlaps
from sim.runners.python_loop import run_in_python
from sim.runners.recording import FIRST_OF_STATE, POINT_FIELDS, has_waypoints, trace_of
from sim.runners.settings import PackedDisturbances, fill_settings
from sim.trace import Trace
from sim.verdict import Verdict
from worldgen.errors import InvalidParameter, InvalidWorld
from worldgen.lattice import UNIT, heading_to_lattice, metres_to_lattice
from worldgen.reach.still.cells import reachable_cells
from worldgen.support.arrays import Bytes, Floats, Ints, Words
from worldgen.support.ccall import check, kept, pointer, writable
from worldgen.timeline import CellState
from worldgen.world import Pose, World

# Lattice units that robots of a fleet look further than they move, and what rounding adds to that.
_FLEET_SLACK = 40


class LatticeRun:
    """One world, controller and set of options, ready to run any number of times.

    Args:
        world: The world to drive in.
        controller: The controller, or its host.
        options: Options of the run.
        lean: Whether the recording of a compiled controller omits its memory if that is large.
        memory: Where the core will look for everything; chosen by the controller if None.

    Raises:
        InvalidWorld: If the start is not clear of walls.
        InvalidParameter: If the world has several robots, or the controller does not compile.
    """

    def __init__(
        self,
        world: World,
        controller: Controller | ControllerHost,
        options: RunOptions,
        *,
        lean: bool = False,
        memory: CoreMemory | None = None,
    ) -> None:
        # Without this, callers that do not handle fleets would ignore all robots but one.
        if world.is_fleet:
            raise InvalidParameter(
                "world-of-several-robots",
                "this runs one robot, but the world has {robots}",
                "use a world with one robot, or worldgen run",
                at_terminal=True,
                robots=len(world.robots),
            )
        self.host = host_of(controller)
        self.host.check(options)
        self.controller: Any = self.host.controller
        robot = robot_for(self.controller, options.robot)
        self.world = world
        self.options = replace(options, robot=robot)
        self._lean = lean
        self.memory = memory_for(self.controller) if memory is None else memory
        check_step_length(world, options.time_step, Fraction(1, UNIT))
        self._cells = np.array(world.walls, np.uint8, order="C")
        self.events = self.memory.own(_event_rows(world, options.time_step))
        self._disturbances = PackedDisturbances(world, robot, options.time_step, self.memory)
        self.settings: Any = kept(ffi, self.memory.new("WgSettings *"), self._disturbances)
        # Fill the settings first: the tables depend on the speed and the sensors.
        settings = self.settings
        fill_settings(settings, world, self.host, self.options)
        settings.start_x, settings.start_y, settings.start_heading = self.start_of(world.start)
        self._disturbances.fill(settings)
        self._near = self.memory.own(near_masks(self._cells))
        self._clearance = self.memory.own(self._clearance_table())
        self._wanted = self._cells_to_cover()
        self._beams = None
        # Beam tables hold for one map only, so they are not made if the walls change.
        if len(self.events) == 0:
            self._beams = beam_tables(self._cells, self.settings, self.memory)

    def _cells_to_cover(self) -> Bytes | None:
        """Return the cells that a coverage task asks for; ``None`` for another task.

        Reaching the target then does not end a run: its disc gets a squared radius that no distance
        matches, and there are no waypoints.

        Raises:
            InvalidWorld: If the world changes, or there is nothing to cover but the start's cell.
        """
        if self.options.task != COVER:
            return None
        self.settings.target.radius_sq = -1
        self.settings.waypoint_count = 0
        robot = self.world.robots[0]
        if robot.footprint or robot.drive.is_car:
            raise InvalidParameter(
                "nothing-to-cover",
                "task=cover is for a disc that turns on the spot, and the cells that a {noun} can "
                "reach are not known",
                "omit --task, or cover the world with a disc",
                at_terminal=True,
                noun="car" if robot.drive.is_car else "body",
            )
        wanted = np.ascontiguousarray(reachable_cells(self.world), np.uint8)
        if np.count_nonzero(wanted) < 2:
            raise InvalidWorld(
                "nothing-to-cover",
                "the robot cannot reach the centre of a second cell, so there is nothing to cover",
                "use a larger world or a smaller robot",
            )
        return wanted

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
        heading = heading_to_lattice(pose.heading)
        table = pointer(ffi, headings(), np.int64)
        near = sorted(
            ((i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)),
            key=lambda d: (d[0] ** 2 + d[1] ** 2, d),
        )
        for dx, dy in near:
            at = (x + dx, y + dy, heading)
            if lib.wg_robot_is_clear(grid, lib.WG_SOLID, table, settings, *at):
                yield at

    @property
    def last_event_step(self) -> int:
        """Last step in which the world changes or something pushes the robot; 0 if none."""
        changed = int(self.events[-1, 0]) if len(self.events) else 0
        return max(changed, self._disturbances.last_step)

    @property
    def reach_of_a_step(self) -> float:
        """How far from its centre the robot can touch another one in a step, m, or more."""
        settings = self.settings
        fastest = settings.top_speed * settings.speed + settings.drift_reach + 1
        return float((settings.reach + fastest + _FLEET_SLACK) * settings.metres)

    @property
    def reach_of_senses(self) -> float:
        """The longest range of a sensor that notices other robots, m; 0 if there is none."""
        robot = self.options.robot
        return max(robot.neighbour_range, robot.beam_range if robot.beams else 0.0)

    def run(self, steps: int, *, find_loop: bool, record: bool, digest: bool = True) -> Outcome:
        """Simulate up to ``steps`` steps from the start; see :meth:`sim.outcome.Runnable.run`."""
        return self._run(steps, find_loop=find_loop, record=record, digest=digest)[0]

    def _run(
        self,
        steps: int,
        *,
        find_loop: bool,
        record: bool,
        digest: bool = True,
        watches: int | None = None,
        options: RunOptions | None = None,
    ) -> tuple[Outcome, CoreEpisode | None]:
        """Run once; there is no episode if the controller failed before it began.

        Args:
            steps: As for :meth:`run`, like the next three.
            find_loop: See there.
            record: See there.
            digest: See there.
            watches: See :meth:`ControllerHost.freezing`.
            options: Other options for the clock that it sees.
        """
        self.settings.steps = steps
        self.settings.digest = int(digest)
        self.settings.find_loop = self.search if find_loop else lib.WG_NO_LOOP
        if self.host.in_core:
            return self._run_compiled(record)
        ended = run_in_python(
            self.host,
            self.arena,
            self.settings,
            self.world,
            self.options if options is None else options,
            record=record,
            watches=watches,
        )
        return self.outcome_of(*ended), ended.episode

    def run_and_recall(self, steps: int, *, find_loop: bool) -> tuple[Outcome, Floats]:
        """Simulate a controller from the start, and return its memory at the end, too.

        Returns:
            The outcome, and (m,) the memory.

        Raises:
            InvalidParameter: If the controller itself fails.
        """
        outcome, ended = self._run(steps, find_loop=find_loop, record=False, digest=False)
        if ended is None or (outcome.fault is not None and not self.host.in_core):
            raise InvalidParameter(
                "code-failed",
                "the controller fails in training: {reason}",
                "run it, and fuzz it, before you train it",
                reason="" if outcome.fault is None else outcome.fault.error,
            )
        size = int(ended.c.controller.memory_size)
        return outcome, ended.state_words()[STATE_WORDS : STATE_WORDS + size].view(np.float64)

    def prove(self, entry: int, period: int, *, record: bool) -> tuple[Outcome, Words] | None:
        """Simulate a loop's first period; see :meth:`sim.outcome.Runnable.prove`.

        A controller that is not compiled may have hidden state, so it must repeat a second period
        too.
        """
        if not self.host.in_core:
            return self._prove_by_recording(entry, period, record)
        settings = self.settings
        settings.steps = entry + period
        settings.digest = 1
        settings.find_loop = lib.WG_PROVE_LOOP
        settings.loop_entry = entry
        outcome, episode = self._run_compiled(record)
        return (outcome, episode.known_words()) if outcome.ending == Verdict.LOOP else None

    def _prove_by_recording(
        self, entry: int, period: int, record: bool
    ) -> tuple[Outcome, Words] | None:
        if record:
            check_recordable(entry + 2 * period)
        elif entry + 2 * period > MAX_RECORDED:
            # Too long to record, and no recording was requested, so the budget decides.
            return None
        whole, _ = self._run(
            entry + 2 * period, find_loop=False, record=True, watches=entry + period
        )
        # Nothing shows what such a clock does, and the run may already have gone another way.
        if self.host.has_read_real:
            count_differences(self.host.sources)
            return None
        if whole.trace is None or not whole.complete or whole.trace.steps < entry + 2 * period:
            return None
        states = whole.trace.states
        if not np.array_equal(states[entry : entry + period + 1], states[entry + period :]):
            return None
        sources = self.host.sources
        if self.host.has_read_clock and not self._is_the_same_by_another_clock(whole.trace):
            # No state recurs while a clock runs that it heeds.
            count_differences(sources)
            return None
        outcome = self.run(entry + period, find_loop=False, record=record)
        # State outside the memory must be the same at both ends of the second period.
        if not outcome.complete:
            return None
        return replace(outcome, ending=Verdict.LOOP, period=period, entry=entry), states[entry]

    def _is_the_same_by_another_clock(self, trace: Trace) -> bool:
        """Return True if a controller's run does not depend on the clock that it reads."""
        hurried = replace(self.options, frozen_time=True, time_step=TIME_STEPS[1])
        other, _ = self._run(trace.steps, find_loop=False, record=True, options=hurried)
        return other.trace is not None and np.array_equal(other.trace.states, trace.states)

    def with_confinement(self, evidence: BudgetEvidence, outcome: Outcome) -> BudgetEvidence:
        """Add to a recorded run's evidence that its poses repeat and its memory nearly does.

        Poses on the lattice do not drift, but a memory may.
        """
        return evidence if outcome.trace is None else with_memory_drift(evidence, outcome.trace)

    @property
    def shapes(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Shapes of the grid and of the distance table; runs in lockstep must have the same."""
        return self._cells.shape, self._clearance.shape

    @property
    def bytes_per_robot(self) -> int:
        """Bytes for one robot in lockstep: its visited cells, and its copy of a changing world."""
        own = self._cells.nbytes + self._near.nbytes if len(self.events) else 0
        return int(own + self._cells.size)

    @functools.cached_property
    def can_loop(self) -> bool:
        """True if the recorded state, with the controller's memory, decides the future.

        It does not if that memory cannot be seen, or the controller reads the clock, or noise that
        is new in each step. Senses that a controller does not declare are not computed, so noise in
        them does not matter.
        """
        reads_clock = bool(self.settings.senses & lib.WG_SENSE_TIME)
        # Disturbances show in the odometry, which is not part of the state.
        is_displaced = self.options.robot.moved
        reads_wrong_pose = is_displaced and bool(self.settings.senses & lib.WG_SENSE_ODOMETRY)
        noisy = is_noisy(self.controller, self.options)
        return self.host.shows_memory and not (reads_clock or reads_wrong_pose or noisy)

    @property
    def search(self) -> int:
        """``WgSettings.find_loop`` of a run that ends with its first recurrence, if it can have one."""
        return int(lib.WG_SEEK_LOOP if self.can_loop else lib.WG_NO_LOOP)

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
        seen = np.zeros((len(states), layout.OBS_SIZE + self.options.robot.beams))
        poses = np.ascontiguousarray(states)
        arena = self.arena()
        starts = ffi.cast("WgStart *", pointer(ffi, poses, np.int64))
        into = writable(ffi, seen, np.float64)
        check(lib.wg_sensed_of_walls(arena.c, settings, starts, len(poses), into))
        return seen

    def arena(self) -> CoreArena:
        """Return the surroundings before the first event, with the start marked as visited."""
        visited: Bytes = np.zeros_like(self._cells)
        height, width = visited.shape
        row = min(int(self.settings.start_y) // UNIT, height - 1)
        visited[row, min(int(self.settings.start_x) // UNIT, width - 1)] = 1
        near = self._near.copy() if len(self.events) else self._near
        return CoreArena(
            self._cells.copy(),
            near,
            self._clearance,
            self.events,
            visited,
            self._beams,
            self._wanted,
            self.memory,
        )

    def _run_compiled(self, record: bool) -> tuple[Outcome, CoreEpisode]:
        # Run once for the verdict. Only if a recording is wanted, run again with room for exactly
        # the steps and path points that there are.
        episode = self.episode()
        episode.run_to_the_end()
        fault = self._fault(episode) if episode.report.ending == lib.WG_CRASH else None
        if not record:
            return self.outcome_of(episode, None, fault=fault), episode
        done = int(episode.report.steps)
        points = int(episode.report.points)
        if self._lean and 8 * (done + 1) * (FIRST_OF_STATE + episode.words) > MOST_HELD:
            outcome = self.outcome_of(episode, None, fault=fault)
            return replace(outcome, trace=self._lean_trace(done, points)), episode
        rows = self.memory.zeros((done + 1, FIRST_OF_STATE + episode.words), np.int64)
        path = self.memory.zeros((points, POINT_FIELDS), np.int64)
        episode = self.episode()
        rows[0, FIRST_OF_STATE:] = episode.state_words()
        episode.record(rows[1:], path)
        episode.run_to_the_end()
        path = episode.with_headings(path)
        if episode.report.ending == lib.WG_CRASH:
            # The failed step is not part of the recording.
            rows = rows[:-1]
            path = path[(path[:, 0] > 0) & (path[:, 0] < done)]
        return self.outcome_of(episode, (rows, path), fault=fault), episode

    def episode(self, settings: Any = None) -> CoreEpisode:
        """Return an episode of a compiled controller at its start.

        Args:
            settings: WgSettings other than the run's own.
        """
        settings = settings or self.settings
        return CoreEpisode(self.arena(), settings, self.driver(settings))

    def driver(self, settings: Any = None) -> Driver:
        """Return a compiled controller in the form in which the core calls it."""
        return self.host.driver(self.host.begin(None), settings or self.settings)

    def _fault(self, failed: CoreEpisode) -> ControllerError:
        """Return the fault of an episode's last step.

        A function compiled by numba reports only that it raised. To find out what, the last step is
        run again from Python.
        """
        if failed.fault is not None:
            return failed.fault
        if isinstance(self.controller.act, CoreAct):
            return self.host.fault_of(failed.report.error)
        # Repeat the run up to the step before that.
        settings = copy_of(self.settings)
        settings.find_loop = lib.WG_NO_LOOP
        episode = self.episode(settings)
        while int(episode.report.steps) < int(failed.report.steps) - 1:
            episode.run(int(failed.report.steps) - 1 - int(episode.report.steps))
        # Without a function, the episode stops whenever the controller must act.
        episode.c.controller.act = ffi.NULL
        episode.c.controller.flat = ffi.NULL
        lib.wg_episode_step(episode.c)
        workspace = Workspace(episode, with_tail=True)
        act = compiled_act(self.controller.act)
        command = np.zeros(layout.CMD_SIZE + layout.MESSAGE_SIZE)
        try:
            act(workspace.observation, workspace.memory, command)
        except Exception as error:  # noqa: BLE001 - a controller may raise anything
            text = crash_text(error)
            name = type(error).__name__
            facts = crash_facts(error, self.controller) or {"message": text.partition(": ")[2]}
            return ControllerError(Verdict.CRASH, text, {"exception": name, **facts})
        return ControllerError(
            Verdict.CRASH, ffi.string(failed.report.error).decode("utf-8", "replace")
        )

    def _lean_trace(self, steps: int, points: int) -> Trace:
        """Return the recording without the memory, which another run can restore."""
        # Run in portions, and keep everything but the memories of each.
        controller: CompiledController = self.controller
        settings = copy_of(self.settings, self.memory)
        size = len(controller.memory)
        settings.find_loop = lib.WG_NO_LOOP
        rows = np.zeros((steps + 1, FIRST_OF_STATE + STATE_WORDS), np.int64)
        has_headings = lib.wg_carriage_words(settings) > 0
        passed = np.zeros(steps + 1 if has_waypoints(self.world, self.options) else 0, np.int64)
        path = np.zeros((points, POINT_FIELDS + has_headings), np.int64)
        filled = 0
        for portion in portions(controller, self.arena(), settings, steps):
            steps = portion.first + len(portion.rows) - 1
            new = len(portion.path)
            rows[portion.first : steps + 1] = portion.rows[:, : rows.shape[1]]
            if len(passed):
                passed[portion.first : steps + 1] = portion.rows[:, rows.shape[1] + size]
            path[filled : filled + new, : portion.path.shape[1]] = portion.path
            filled += new

        # Memories are too large to keep, so simulate again and pick the requested ones.
        def recall(at: Ints, take: Callable[[int, Floats], None]) -> None:
            for first, states, _ in portions(controller, self.arena(), settings, int(at[-1])):
                first_number = FIRST_OF_STATE + STATE_WORDS
                memories = states[:, first_number : first_number + size].view(np.float64)
                begin, end = np.searchsorted(at, (first, first + len(states)))
                for step in at[begin:end].tolist():
                    take(step, memories[step - first])

        seen = (rows[: steps + 1], path[:filled])
        trace = trace_of(
            self.world,
            self.options,
            *seen,
            complete=self.can_loop,
            lean=True,
            passed=passed[: steps + 1],
        )
        return replace(trace, recall=recall, recalled=size)

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
            complete: Whether all of the controller's memory is recorded.
            fault: The controller's fault, if it made one.
        """
        complete = complete and self.can_loop
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
            goals=int(report.goals),
            cells_wanted=0 if self._wanted is None else int(np.count_nonzero(self._wanted)),
            complete=complete,
            fault=fault.evidence if fault else None,
            shortfall=episode.shortfall if episode else None,
            trace=None
            if recording is None
            else trace_of(self.world, self.options, *recording, complete=complete),
        )


def _event_rows(world: World, time_step: float) -> Ints:
    """Return the world's events in the core's form, sorted by time."""
    rows = [
        (*event_time(event, time_step, STEP_TIME), event.ix, event.iy, int(event.state))
        for event in world.timeline
    ]
    return np.array(rows, np.int64).reshape(-1, EVENT_FIELDS)
