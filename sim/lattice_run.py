"""Packs a world for the lattice kernels, runs them, and reads the result back. No maths of its own."""

from __future__ import annotations

import functools
import math
from fractions import Fraction
from typing import Any

import numba
import numpy as np
import numpy.typing as npt

from sim.controllers.base import CompiledController, Controller, compiled_act, numba_config, senses_of
from sim.controllers.program import Misbehaviour
from sim.kernels import layout
from sim.kernels.geometry import NEAR, chessboard_clearance, near_masks, pose_is_clear
from sim.kernels.lattice_episode import Arena, lattice_episode
from sim.kernels.lattice_sense import heading_table
from sim.motion import MOTIONS
from sim.outcome import Outcome
from sim.packing import disc_numbers, event_step, start_overlaps
from sim.python_loop import PythonLoop
from sim.run_options import RunOptions, check_step_length
from sim.trace import Trace
from worldgen.jit import kernel
from worldgen.lattice import (
    TURN,
    UNIT,
    exact,
    heading_to_lattice,
    in_cells,
    lattice_to_metres,
    metres_to_lattice,
)
from worldgen.timeline import CellState
from worldgen.world import MAX_SIDE, World

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
def _episode_kernel() -> Any:
    """The episode kernel, typed for any compiled controller, so that it compiles once for all of them."""
    python = getattr(lattice_episode, "py_func", lattice_episode)
    if numba_config.DISABLE_JIT:
        return python
    types: Any = numba.types
    ints, floats, bytes_2d = numba.int64[::1], numba.float64[::1], numba.uint8[:, ::1]
    rows = numba.int64[:, ::1]
    table = numba.int32[:, ::1]
    arena = types.NamedTuple((bytes_2d, table, table, rows, ints, bytes_2d), Arena)
    act = types.FunctionType(numba.void(floats, floats, floats))
    return kernel(python, signature=numba.void(arena, ints, floats, act, floats, ints, floats, rows))


class LatticeRun:
    """One world, controller and set of options, ready to run any number of times.

    Raises:
        InvalidWorld: If the start is not clear of walls.
        InvalidParameter: If the controller does not compile.
    """

    def __init__(self, world: World, controller: Controller, options: RunOptions) -> None:
        self.world, self.controller, self.options = world, controller, options
        check_step_length(world, options.time_step, Fraction(1, UNIT))
        motion = MOTIONS.get(options.motion)
        self._cells = world.walls.astype(np.uint8)
        self._events = _event_rows(world, options.time_step)
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
        settings[layout.SET_X], settings[layout.SET_Y] = self._clear_start(clear_sq, reach)
        settings[layout.SET_HEADING] = heading_to_lattice(world.start.heading)
        settings[layout.SET_TARGET_X] = metres_to_lattice(world.target.x, world.cell_size)
        settings[layout.SET_TARGET_Y] = metres_to_lattice(world.target.y, world.cell_size)
        within = in_cells(world.target.radius, world.cell_size) * UNIT
        within = min(within, Fraction(4 * MAX_SIDE * UNIT))  # already more than any world
        settings[layout.SET_TARGET_SQ] = math.floor(within * within)
        settings[layout.SET_MOTION] = motion_code
        settings[layout.SET_SENSES] = senses_of(self.controller)
        settings[layout.SET_SEED] = np.uint64(self.options.seed).astype(np.int64)

    def _fill_scales(self, tolerance: float) -> None:
        world, scales, step = self.world, self.scales, self.options.time_step
        scales[layout.SCALE_METRES] = float(exact(world.cell_size) / UNIT)
        scales[layout.SCALE_SPEED] = float(exact(step) / exact(world.cell_size) * UNIT)
        scales[layout.SCALE_TURN] = step * (TURN / (2.0 * math.pi))
        scales[layout.SCALE_RADIANS] = 2.0 * math.pi / TURN
        scales[layout.SCALE_TIME_STEP] = step
        scales[layout.SCALE_TOP_SPEED] = world.robot_speed
        scales[layout.SCALE_TOLERANCE] = tolerance * UNIT
        if isinstance(self.controller, CompiledController):
            scales[layout.SCALE_START_SPEED] = min(self.controller.start_speed, world.robot_speed)

    def _clearance_table(self) -> npt.NDArray[np.int32]:
        """Distances to cells that are ever not free; of no rows where the masks reach as far as the fastest step."""
        fastest = int(self.scales[layout.SCALE_TOP_SPEED] * self.scales[layout.SCALE_SPEED]) + 1
        if self.settings[layout.SET_REACH] + fastest <= NEAR * UNIT:
            return np.zeros((0, 0), np.int32)
        ever, line = self._cells.copy(), self.world.timeline
        ever[line.iy, line.ix] = np.maximum(ever[line.iy, line.ix], line.states)
        table = np.zeros(ever.shape, np.int32)
        chessboard_clearance(ever, table)
        return table

    def _clear_start(self, clear_sq: int, reach: int) -> tuple[int, int]:
        """The lattice point nearest to the start that is clear, among the nine next to it."""
        world = self.world
        x = metres_to_lattice(world.start.x, world.cell_size)
        y = metres_to_lattice(world.start.y, world.cell_size)
        near = sorted(((i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)), key=lambda d: (d[0] ** 2 + d[1] ** 2, d))
        for dx, dy in near:
            if pose_is_clear(self._cells, layout.SOLID, clear_sq, reach, x + dx, y + dy):
                return x + dx, y + dy
        raise start_overlaps(world)

    @property
    def last_event_step(self) -> int:
        """Step at whose beginning the world changes for the last time; 0 if it never does."""
        return int(self._events[-1, 0]) if len(self._events) else 0

    def run(self, steps: int, *, find_loop: bool, record: bool, digest: bool = True) -> Outcome:
        """Runs up to ``steps`` steps from the start; with ``find_loop`` a recurrence ends the run."""
        self.settings[layout.SET_STEPS], self.settings[layout.SET_DIGEST] = steps, int(digest)
        self.settings[layout.SET_FIND_LOOP] = int(find_loop)
        visited = np.zeros(self._cells.shape, np.uint8)
        visited[self._cell_of(layout.SET_Y, 0), self._cell_of(layout.SET_X, 1)] = 1
        arena = Arena(self._cells.copy(), self._near.copy(), self._clearance, self._events, _headings(), visited)
        if isinstance(self.controller, CompiledController):
            return self._run_compiled(self.controller, arena, steps, record)
        loop = PythonLoop(self.controller, arena, self.settings, self.scales)
        loop.run(steps, find_loop=find_loop, record=record)
        rows = np.stack(loop.rows) if record and loop.rows else None
        return self._outcome(loop.counts, loop.sums, rows, loop.complete, loop.fault)

    def _cell_of(self, setting: int, axis: int) -> int:
        """Row or column of the start."""
        return int(min(self.settings[setting] // UNIT, self._cells.shape[axis] - 1))

    def _run_compiled(self, controller: CompiledController, arena: Arena, steps: int, record: bool) -> Outcome:
        memory = np.array(controller.memory, np.float64)
        counts, sums = np.zeros(layout.OUT_SIZE, np.int64), np.zeros(layout.SUM_SIZE)
        width = layout.ROW_STATE + layout.STATE_MEMORY + memory.size
        rows = np.zeros((steps + 1 if record else 0, width), np.int64)
        act = compiled_act(controller.act)
        fault = None
        try:
            _episode_kernel()(arena, self.settings, self.scales, act, memory, counts, sums, rows)
        except (ArithmeticError, LookupError, ValueError, TypeError) as error:  # raised in the compiled controller
            fault = Misbehaviour("crash", f"{type(error).__name__}: {error}")
        return self._outcome(counts, sums, rows[: counts[layout.OUT_STEPS] + 1] if record else None, fault=fault)

    def _outcome(
        self, counts: Ints, sums: Floats, rows: Ints | None, complete: bool = True, fault: Misbehaviour | None = None
    ) -> Outcome:
        def cell(first: int) -> tuple[int, int]:
            return int(counts[first]), int(counts[first + 1])

        return Outcome(
            ending=fault.verdict if fault else _ENDINGS[int(counts[layout.OUT_ENDING])],
            steps=int(counts[layout.OUT_STEPS]),
            period=int(counts[layout.OUT_PERIOD]),
            path_length=float(sums[layout.SUM_PATH]) * float(self.scales[layout.SCALE_METRES]),
            collisions=int(counts[layout.OUT_COLLISIONS]),
            digest=f"{int(counts[layout.OUT_DIGEST]) & (2**64 - 1):016x}",
            last_new_cell=int(counts[layout.OUT_LAST_NEW_CELL]),
            hit_step=int(counts[layout.OUT_HIT_STEP]),
            hit_cell=cell(layout.OUT_HIT_IX),
            hit_state=CellState(int(counts[layout.OUT_HIT_STATE])).word,
            overlap_step=int(counts[layout.OUT_OVERLAP_STEP]),
            overlap_cell=cell(layout.OUT_OVERLAP_IX),
            random_draws=int(counts[layout.OUT_DRAWS]),
            complete=complete,
            fault={"error": fault.error, **fault.evidence} if fault else {},
            trace=None if rows is None else self._trace(rows, complete),
        )

    def _trace(self, rows: Ints, complete: bool) -> Trace:
        """The recorded rows in metres and radians."""
        states = rows[:, layout.ROW_STATE :]
        side = self.world.cell_size
        used = rows[:, layout.ROW_CORNERS]
        points = np.zeros((len(rows), 3, 2), np.int64)
        points[:, 0], points[:, 1] = rows[:, 2:4], rows[:, 4:6]
        points[:, 2] = states[:, :2]
        keep = np.stack([used > 0, used > 1, np.ones(len(rows), bool)], axis=1)
        turned = states[:, layout.STATE_HEADING]
        return Trace(
            time_step=self.options.time_step,
            x=_metres(states[:, layout.STATE_X], side),
            y=_metres(states[:, layout.STATE_Y], side),
            heading=np.where(turned > TURN // 2, turned - TURN, turned) * float(self.scales[layout.SCALE_RADIANS]),
            bump=rows[:, layout.ROW_BUMP] != 0,
            path_x=_metres(points[keep][:, 0], side),
            path_y=_metres(points[keep][:, 1], side),
            path_step=np.repeat(np.arange(len(rows)), keep.sum(axis=1)),
            words=rows[1:].view(np.uint64),
            states=np.ascontiguousarray(states).view(np.uint64),
            complete=complete,
        )


def _metres(units: Ints, cell_size: float) -> Floats:
    """Lattice units as metres, correctly rounded, so that short decimals stay short."""
    ratio = exact(cell_size) / UNIT
    if int(np.abs(units).max(initial=0)) * ratio.numerator < 2**53 and ratio.denominator < 2**53:
        return (units * ratio.numerator) / float(ratio.denominator)  # one rounding: both are exact
    return np.array([lattice_to_metres(unit, cell_size) for unit in units.tolist()])


def _event_rows(world: World, time_step: float) -> Ints:
    """Events as (step, ix, iy, state): an event counts from the beginning of the step in which it falls."""
    rows = [(event_step(event, time_step), event.ix, event.iy, int(event.state)) for event in world.timeline]
    return np.array(rows, np.int64).reshape(-1, 4)
