"""Build the structs that the C core takes from arrays: surroundings, controllers and episodes.

This module only converts; it computes nothing itself.
"""

from __future__ import annotations

import functools
import math
import time
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from sim._core import ffi, lib
from sim.controllers.base import Act, CompiledController
from sim.controllers.controller_error import ControllerError
from sim.controllers.core_act import CoreAct
from sim.controllers.flat_act import flat_address
from sim.controllers.shared import guarded
from sim.controllers.shared.cage import Cage
from sim.controllers.shared.guarded import PRIVATE, ControllerDied, CoreMemory, before_start, call
from sim.kernels.layout import OBS_SIZE
from sim.outcome import Shortfall
from worldgen.lattice import TURN
from worldgen.support.arrays import Bytes, Floats, Ints, Words
from worldgen.support.ccall import check, kept, pointer, writable

Table = npt.NDArray[np.int32]

# Words of a state before the controller's memory.
STATE_WORDS = 5

# Fields of a WgEvent.
EVENT_FIELDS = 5

# The largest side of a grid, cells, that the beams' tables can describe in 16 bits.
_MOST_CELLS_OF_RUNS = 65535

# Points of the path that one move may add.
MOST_CORNERS = int(lib.WG_MOST_CORNERS)

# Steps in the first call of a run; later calls grow until they take long enough.
_FIRST_PORTION = 1 << 12

# Least time of a call, s: short enough to notice Ctrl-C, long enough to cost nothing.
_PORTION_TIME = 0.05


def _report_type() -> np.dtype[Any]:
    """Return WgReport as a NumPy type, so that the fields of many reports are columns."""
    kinds = {"int64_t": "<i8", "uint64_t": "<u8", "double": "<f8"}
    names = []
    formats = []
    offsets = []
    for name, field in ffi.typeof("WgReport").fields:
        if field.type.cname in kinds:
            names.append(name)
            formats.append(kinds[field.type.cname])
            offsets.append(field.offset)
    return np.dtype(
        {"names": names, "formats": formats, "offsets": offsets, "itemsize": ffi.sizeof("WgReport")}
    )


REPORT = _report_type()
"""A WgReport as a NumPy type."""


@functools.cache
def headings() -> Ints:
    """Return (131072,) int64, cosines and sines of all headings, in units of 2^-30."""
    table = np.zeros(2 * int(lib.WG_TURN), np.int64)
    lib.wg_heading_table(writable(ffi, table, np.int64))
    return table


def near_masks(cells: Bytes) -> Table:
    """Return (height, width) int32, masks of the cells around each cell that are not free."""
    near = np.zeros(cells.shape, np.int32)
    lib.wg_near_masks(grid_of(cells), writable(ffi, near, np.int32))
    return near


@functools.cache
def ray_table() -> Any:
    """Return the directions of range beams in an eighth of a turn, WgRay[8193]."""
    table = ffi.new("WgRay[]", int(lib.WG_TURN) // 8 + 1)
    lib.wg_ray_table(pointer(ffi, headings(), np.int64), table)
    return table


# Both this table and the headings that it uses are made once, in ordinary memory. Making them
# before the other process is forked gives it a copy.
before_start.append(ray_table)


class BeamTables(NamedTuple):
    """Tables that speed up range beams in cells that never change.

    Args:
        runs: (height + 2, width + 2, 4) uint16, the result of wg_free_runs.
        spread: (beams,) int64, the result of wg_beam_spread.
    """

    runs: npt.NDArray[np.uint16]
    spread: Ints


def beam_tables(cells: Bytes, settings: Any, memory: CoreMemory = PRIVATE) -> BeamTables | None:
    """Return the tables for beams, or None if it has no beams or the grid is too large.

    Args:
        cells: (height, width) cells that never change.
        settings: WgSettings of the run.
        memory: Where the core will look for the tables.
    """
    height, width = cells.shape
    if not settings.senses & lib.WG_SENSE_BEAMS or max(height, width) > _MOST_CELLS_OF_RUNS:
        return None
    runs = memory.zeros((height + 2, width + 2, 4), np.uint16)
    check(lib.wg_free_runs(grid_of(cells), writable(ffi, runs, np.uint16)))
    spread = memory.zeros(int(settings.beams), np.int64)
    lib.wg_beam_spread(settings.beams, settings.beam_field, writable(ffi, spread, np.int64))
    return BeamTables(runs, spread)


def grid_of(cells: Bytes) -> Any:
    """Return the WgGrid of some cells, which must outlive it."""
    return ffi.new("WgGrid *", (pointer(ffi, cells, np.uint8), cells.shape[1], cells.shape[0]))[0]


def memory_for(*controllers: object) -> CoreMemory:
    """Return the memory in which the core must find everything while it runs controllers."""
    is_guarded = any(
        isinstance(one, CompiledController) and _guarded_address(one) != 0 for one in controllers
    )
    return guarded.SHARED if is_guarded else PRIVATE


def _guarded_address(controller: CompiledController) -> int:
    """Return the address of a controller's function if it runs in another process, else 0."""
    act = controller.act
    return act.address if isinstance(act, CoreAct) and act.is_guarded else 0


def copy_of(settings: Any, memory: CoreMemory = PRIVATE) -> Any:
    """Return a copy of a WgSettings, which keeps what the original points to alive."""
    return kept(ffi, memory.new("WgSettings *", settings[0]), settings)


def most_points(arena: CoreArena, settings: Any, steps: int) -> int:
    """Return the most points that the path of this many steps can have.

    Each move adds a few corners: one for the step, one for each event and each push, and every step
    may end in a place that pushes.
    """
    moves = steps * (int(lib.wg_most_legs(settings)) + bool(settings.place_count)) + len(
        arena.events
    )
    return MOST_CORNERS * (moves + int(settings.push_count))


class CoreArena:
    """The surroundings of a robot; ``cells``, ``near`` and ``visited`` change during an episode.

    Args:
        cells: (height, width) uint8, current states of the cells.
        near: (height, width) int32, :func:`near_masks` of ``cells``.
        clearance: (height, width) int32, chessboard distance to cells that are ever not free; empty
            if the masks reach as far as any step.
        events: (n, 5) int64, WgEvent, sorted by step and time.
        visited: (height, width) uint8, cells that the centre has been in.
        beams: Tables that make range beams three times as fast, if the cells never change.
        wanted: (height, width) uint8, cells that a coverage task wants; empty for other tasks.
        memory: Where the core will look for all this; the arrays are copied there.
    """

    def __init__(
        self,
        cells: Bytes,
        near: Table,
        clearance: Table,
        events: Ints,
        visited: Bytes,
        beams: BeamTables | None = None,
        wanted: Bytes | None = None,
        memory: CoreMemory = PRIVATE,
    ) -> None:
        self.cells = cells = memory.own(cells)
        self.near = near = memory.own(near)
        self.clearance = clearance = memory.own(clearance)
        self.events = events = memory.own(events)
        self.headings = headings()
        self.visited = visited = memory.own(visited)
        self.memory = memory
        arena = memory.new("WgArena *")
        self.c: Any = kept(ffi, arena, cells, near, clearance, events, visited, self.headings)
        self.c.height, self.c.width = cells.shape
        self.c.cells = writable(ffi, cells, np.uint8)
        self.c.near = writable(ffi, near, np.int32)
        if clearance.size:
            self.c.clearance = writable(ffi, clearance, np.int32)
        self.c.events = ffi.cast("WgEvent *", pointer(ffi, events, np.int64))
        self.c.event_count = len(events)
        self.c.headings = pointer(ffi, self.headings, np.int64)
        self.c.visited = writable(ffi, visited, np.uint8)
        if beams is not None:
            beams = BeamTables(memory.own(beams.runs), memory.own(beams.spread))
            # If two threads request the table first, one of them gets its own copy, which the
            # cache does not keep alive.
            rays = ray_table()
            self.keep(beams, rays)
            self.c.rays = rays
            self.c.spread = pointer(ffi, beams.spread, np.int64)
            self.c.runs = pointer(ffi, beams.runs, np.uint16)
        self.beams = beams
        self.wanted = np.zeros((0, 0), np.uint8) if wanted is None else memory.own(wanted)
        if self.wanted.size:
            self.keep(self.wanted)
            self.c.wanted = pointer(ffi, self.wanted, np.uint8)

    def keep(self, *objects: object) -> None:
        """Keep objects alive as long as the core's struct."""
        self.c = kept(ffi, self.c, *objects)


class Driver:
    """A controller in the form in which the core calls it.

    Args:
        controller: The controller; None for one that acts outside the core.
        memory: Its memory at reset.
        settings: WgSettings of the run, which tell what it observes; None if that does not matter
            because it acts outside the core.

    Attributes:
        guarded: Address of the controller's function if it runs in another process, else 0.
        cage: Where that function acts; None for other functions.
    """

    def __init__(
        self, controller: CompiledController | None, memory: Sequence[float], settings: Any = None
    ) -> None:
        room = memory_for(controller)
        self.guarded = 0 if controller is None else _guarded_address(controller)
        self.cage: Cage | None = None
        own = room.own(np.array(memory, np.float64))
        self.c: Any = kept(ffi, room.new("WgController *"), own)
        self.c.memory_size = len(own)
        if len(own):
            self.c.memory = pointer(ffi, own, np.float64)
        if controller is not None:
            self._set_function(controller.act, settings)

    def _set_function(self, act: Act | CoreAct, settings: Any) -> None:
        if self.guarded:
            neighbours = int(settings.neighbours) if settings.neighbour_range else 0
            size = int(self.c.memory_size)
            self.cage = Cage(self.guarded, size, int(settings.beams), neighbours)
            self.c.cage = self.cage.c
            self.c = kept(ffi, self.c, self.cage)
        elif isinstance(act, CoreAct):
            self.c.act = ffi.cast("WgAct", act.address)
        else:
            self.c.flat = ffi.cast("WgFlatAct", flat_address(act))


class Workspace:
    """Views of the core's memory through which an episode talks to a controller outside the core.

    Args:
        episode: The episode, a :class:`CoreEpisode` or a robot of a fleet; its ``c`` is a
            WgEpisode.
        with_tail: Whether the observation ends with the goal's heading, and before it the tilt
            and its heading, if the controller declares them; only for a single robot.

    Attributes:
        observation: (17 + beams,), or up to three more, what the controller observes.
        memory: (m,) its memory.
        command: (3,) speed, turn rate, and whether the random number was used.
    """

    def __init__(self, episode: Any, *, with_tail: bool = False) -> None:
        c = episode.c
        size = int(c.controller.memory_size)
        numbers = OBS_SIZE + int(c.workspace.observation.beam_count)
        numbers += int(c.workspace.tail) if with_tail else 0
        self.observation: Floats = np.frombuffer(_buffer(episode, c.workspace.flat, numbers))
        self.memory = (
            np.frombuffer(_buffer(episode, c.robot.body.memory, size)) if size else np.zeros(0)
        )
        self.command = np.frombuffer(_buffer(episode, ffi.addressof(c.workspace, "command"), 3))


def _buffer(owner: object, address: Any, count: int) -> Any:
    """Return a number of float64s in an owner's memory as a buffer.

    The owner lives as long as the buffer and every view of it, because a user's controller may keep
    its arguments.
    """
    return ffi.buffer(kept(ffi, address, owner), 8 * count)


class EpisodeHandle:
    """An episode that can be read and recorded: one that runs alone, or a robot's in a fleet.

    Attributes:
        c: A WgEpisode.
        words: Words of the robot's complete state.
        memory: Where the core looks for its arrays.
    """

    memory: CoreMemory = PRIVATE

    c: Any
    words: int
    _recording: tuple[Ints, ...] | None = None

    @property
    def report(self) -> Any:
        """The WgReport of the run so far."""
        return self.c.robot.report

    @property
    def state(self) -> Any:
        """The robot's WgState."""
        return self.c.robot.body.state

    @property
    def entry(self) -> int:
        """First step of the loop with which the run ended; -1 if it ended otherwise."""
        return -1

    @property
    def shortfall(self) -> Shortfall | None:
        """What the robot's state lacks of an arrival; None if touching its target is enough."""
        robot, settings = self.c.robot, self.c.settings
        # The goal that counts at the end; a run that arrives has no other.
        number = int(self.report.goals)
        goal = settings.target
        if number < settings.waypoint_count:
            goal = settings.waypoints[number]
        asks_more = goal.arrival != lib.WG_ARRIVAL_TOUCH or goal.has_heading
        # Another task has no target.
        if not asks_more or goal.radius_sq < 0:
            return None
        # Only what is larger than the goal allows is missing.
        state = robot.body.state
        apart_sq = (state.x - goal.x) ** 2 + (state.y - goal.y) ** 2
        is_away = apart_sq > goal.radius_sq
        turn = abs((state.heading - goal.heading + TURN // 2) % TURN - TURN // 2)
        is_turned = goal.has_heading and turn > goal.heading_tolerance
        has_to_stop = goal.arrival == lib.WG_ARRIVAL_STOP
        moves = has_to_stop and abs(state.speed) > goal.arrival_speed
        turns = has_to_stop and abs(robot.turned) > goal.arrival_turn
        apart = math.sqrt(apart_sq) - math.sqrt(goal.radius_sq) if is_away else 0.0
        unit = 2.0 * math.pi / TURN
        metres = float(settings.metres)
        step = float(settings.time_step)
        return Shortfall(
            distance=apart * metres,
            heading=turn * unit if is_turned else 0.0,
            speed=abs(state.speed) / lib.WG_SPEED_UNIT * metres / step if moves else 0.0,
            turn_rate=abs(robot.turned) * unit / step if turns else 0.0,
        )

    def state_words(self) -> Ints:
        """Return (words,) int64, the complete state."""
        return np.frombuffer(ffi.buffer(self.c.robot.body, 8 * self.words), np.int64).copy()

    def record(self, rows: Ints, path: Ints) -> None:
        """Write the next steps into arrays.

        Args:
            rows: (n, 1 + words) int64, one for each step: whether a wall was touched, then the
                state.
            path: (points, 4) int64, WgPathPoint.
        """
        headings = PRIVATE.zeros(0, np.int64)
        if self.c.robot.chain_headings != ffi.NULL:
            headings = self.memory.zeros(len(path), np.int64)
        self._recording = (rows, path, headings)
        points = ffi.cast("WgPathPoint *", writable(ffi, path, np.int64))
        check(
            lib.wg_episode_record(
                self.c,
                writable(ffi, rows, np.int64),
                len(rows),
                points,
                writable(ffi, headings, np.int64) if len(headings) else ffi.NULL,
                len(path),
            )
        )

    def with_headings(self, path: Ints) -> Ints:
        """Return the path of the recording, with the heading on the way to each point.

        Returns:
            (points, 5) int64 for a body or a car; ``path`` for a disc that turns on the spot.
        """
        headings = np.zeros(0) if self._recording is None else self._recording[2]
        return np.column_stack((path, headings[: len(path)])) if len(headings) else path


class CoreEpisode(EpisodeHandle):
    """An episode of the core, at its start.

    Args:
        arena: The surroundings before the first event.
        settings: WgSettings of the run.
        driver: The controller.
        log_steps: Steps of the longest run in which a recurrence is searched for; 0 for no search.

    Attributes:
        words: Words of the complete state.
        guarded: Address of the controller's function if it runs in another process, else 0. In
            that case everything that a call takes, including the settings, must be in
            :data:`sim.controllers.shared.guarded.SHARED`.
        fault: How the controller failed in another process; ``None`` if it did not.

    Raises:
        MemoryError: If there is not enough memory.
    """

    def __init__(
        self, arena: CoreArena, settings: Any, driver: Driver, log_steps: int | None = None
    ) -> None:
        if log_steps is None:
            log_steps = int(settings.steps) if settings.find_loop == lib.WG_SEEK_LOOP else 0
        # A guarded episode lives in shared memory, so that the other process can continue it.
        self.memory = arena.memory
        held = (arena.c, settings, driver.c)
        if driver.cage is not None:
            self.c: Any = self._placed(arena, settings, driver, log_steps)
        else:
            made = ffi.new("WgEpisode **")
            check(lib.wg_episode_new(arena.c, settings, driver.c, log_steps, made))
            self.c = kept(ffi, made[0], *held, free=lib.wg_episode_free)
        self.words = int(self.c.search.words)
        self.guarded = driver.guarded
        self._cages = () if driver.cage is None else (driver.cage,)
        self.begin()

    @staticmethod
    def _placed(arena: CoreArena, settings: Any, driver: Driver, log_steps: int) -> Any:
        """Return a WgEpisode in shared memory, where the other process finds it."""
        sizes = ffi.new("int64_t[2]")
        check(lib.wg_episode_sizes(arena.c, settings, driver.c, log_steps, sizes))
        block = guarded.SHARED.block(sizes[0], clear=True)
        log = guarded.SHARED.block(sizes[1], clear=False) if sizes[1] else ffi.NULL
        made = lib.wg_episode_place(block, log, arena.c, settings, driver.c, log_steps)
        return kept(ffi, made, block, log, arena.c, settings, driver.c)

    def begin(self) -> None:
        """Put the robot back at its start; the arena must be as it was before the first event."""
        check(lib.wg_episode_begin(self.c))
        self.fault: ControllerError | None = None

    @property
    def entry(self) -> int:
        """First step of the loop with which the run ended; -1 if it ended otherwise."""
        return int(lib.wg_episode_entry(self.c))

    def known_words(self) -> Words:
        """Return (words,) the state at the entry of a loop that was proved."""
        return np.frombuffer(ffi.buffer(self.c.search.known, 8 * self.words), np.uint64).copy()

    def call(
        self, name: str, objects: Sequence[Any], number: int, progress: Sequence[Any] = ()
    ) -> int:
        """Make a call of the core about this episode, in the other process if that runs it.

        Args:
            name: ``wg_call_run`` or another function of that type.
            objects: Its pointer arguments.
            number: The number that it takes.
            progress: Structs that change as the work progresses, besides this episode's report.

        Raises:
            ControllerDied: If the other process ended, or a step did not return.
        """
        if self.guarded:
            work = ffi.addressof(lib, name)
            seen = (ffi.addressof(self.report), *progress)
            return call(work, (self.guarded,), objects, number, progress=seen, cages=self._cages)
        arguments = [ffi.cast("void *", one) for one in objects]
        asked = ffi.new("WgCall *", {"objects": arguments, "number": number})
        return int(getattr(lib, name)(asked))

    def run(self, steps: int) -> bool:
        """Run at most this many steps; return True if the episode is not over."""
        try:
            return bool(self.call("wg_call_run", (self.c,), steps) == lib.WG_GOES_ON)
        except ControllerDied as death:
            self.fault = death
            lib.wg_episode_fail(self.c)
            return False

    def run_to_the_end(self) -> None:
        """Run in portions, so that Ctrl-C is noticed between them."""
        run_in_portions(self.run, _FIRST_PORTION)


def run_in_portions(run: Callable[[int], bool], portion: int) -> None:
    """Call a function until it returns False, with more and more steps.

    Args:
        run: Runs this many steps, and returns True if more can follow.
        portion: Steps of the first call.
    """
    began = time.monotonic()
    while run(portion):
        now = time.monotonic()
        if now - began < _PORTION_TIME:
            portion *= 2
        began = now
