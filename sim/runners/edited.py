"""Run edited copies of a world without building a world or a run for each of them."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from sim._core import ffi, lib
from sim.controllers.base import CompiledController
from sim.controllers.shared.guarded import ControllerDied
from sim.options.run import RunOptions
from sim.runners.core_calls import CoreArena, CoreEpisode, Driver, copy_of, grid_of
from sim.runners.lattice import LatticeRun
from sim.runners.packing import disc_numbers, target_sq
from sim.verdict import Verdict
from worldgen.lattice import metres_to_lattice
from worldgen.support.arrays import Ints
from worldgen.support.ccall import check, pointer, writable
from worldgen.timeline import CellState
from worldgen.world import World

ANY_ENDING = int(lib.WG_ANY_ENDING)
"""Matches a run that did not go through a wall, burn or fail."""

# Steps in one call of the core, 0.02 to 2 s; Ctrl-C is noticed between calls.
_STEPS_AT_ONCE = 200_000
# Columns of an event.
_IX = 2
_IY = 3


class EditKind(IntEnum):
    """The effect of an edit on the grid; the numbers of the :class:`CellEdit` follow each name.

    Args:
        FREE_BOX: Free the solid cells in a box: ix, iy, width, height.
        FREE_RUN: Free some of the solid cells, counted row by row: first, count.
        FREE_RIM: Free the outermost cells.
        DROP_ROWS: Remove rows and move those above down: first row, count.
        DROP_COLUMNS: Remove columns and move those on the right to the left: first column, count.
    """

    FREE_BOX = lib.WG_FREE_BOX
    FREE_RUN = lib.WG_FREE_RUN
    FREE_RIM = lib.WG_FREE_RIM
    DROP_ROWS = lib.WG_DROP_ROWS
    DROP_COLUMNS = lib.WG_DROP_COLUMNS


class CellEdit(NamedTuple):
    """A simpler grid: an :class:`EditKind` and its numbers."""

    kind: int
    a: int = 0
    b: int = 0
    c: int = 0
    d: int = 0

    @property
    def frees(self) -> bool:
        """Whether it only frees cells, so that every existing path remains."""
        return self.kind < EditKind.DROP_ROWS

    def shape(self, height: int, width: int) -> tuple[int, int]:
        """Return the grid's height and width after the edit."""
        return (
            height - (self.b if self.kind == EditKind.DROP_ROWS else 0),
            width - (self.b if self.kind == EditKind.DROP_COLUMNS else 0),
        )


class Wanted(NamedTuple):
    """How the run of an edited world should end.

    Args:
        ending: The core's ending, such as ``WG_LIMIT``; :data:`ANY_ENDING` for one of ``WG_LIMIT``,
            ``WG_REACHED`` and ``WG_LOOP``.
        overlap: Whether with an overlap; ``None`` if that does not matter.
        crash: Whether the controller should crash instead.
        hang: Whether a step of the controller should hang instead.
    """

    ending: int
    overlap: bool | None = None
    crash: bool = False
    hang: bool = False


class EditedRuns:
    """Tries edits of one world's cells under one compiled controller, entirely in compiled code.

    Args:
        world: The world to edit.
        controller: The controller that drives in the edited worlds.
        options: Options of the runs.

    Raises:
        InvalidWorld: If the start is not clear of walls.
    """

    def __init__(self, world: World, controller: CompiledController, options: RunOptions) -> None:
        self._run = run = LatticeRun(world, controller, options)
        run.settings.steps = options.steps
        run.settings.digest = 0
        run.settings.find_loop = run.search
        run.settings.start_x = metres_to_lattice(world.start.x, world.cell_size)
        run.settings.start_y = metres_to_lattice(world.start.y, world.cell_size)
        self._controller = controller
        self._world = world
        self.trials = 0

    def first(
        self, edits: Sequence[CellEdit], wanted: Wanted, *, way: bool
    ) -> tuple[int | None, int]:
        """Try edits in order, for as long as they give grids of one shape.

        Args:
            edits: The edits, at least one.
            wanted: How the run should end.
            way: Whether an edit that drops rows or columns must leave the target surely reachable.

        Returns:
            The index of the first edit whose run ends as requested, ``None`` if none has yet, and
            how many edits were tried.
        """
        shape = edits[0].shape(*self._world.walls.shape)
        alike = 1
        if min(shape) < 1:
            return None, 1
        # In a changing world, each edit that drops cells has its own list of events.
        changing = self._world.is_dynamic and not edits[0].frees
        while (
            not changing
            and alike < len(edits)
            and edits[alike].shape(*self._world.walls.shape) == shape
        ):
            alike += 1
        found, done = self._try(edits[:alike], shape, wanted, way=way)
        return (done - 1 if found else None), done

    def _try(
        self, edits: Sequence[CellEdit], shape: tuple[int, int], wanted: Wanted, *, way: bool
    ) -> tuple[bool, int]:
        # Lay out the edited surroundings, which each edit overwrites.
        run = self._run
        controller = self._controller
        fresh = run.arena()
        events = run.events if edits[0].frees else _moved_events(run.events, edits[0])
        clearance = np.zeros(shape if len(fresh.clearance) else (0, 0), np.int32)
        cells = np.zeros(shape, np.uint8)
        near = np.zeros(shape, np.int32)
        visited = np.zeros(shape, np.uint8)
        work = CoreArena(cells, near, clearance, events, visited, memory=run.memory)
        settings = copy_of(run.settings, run.memory)
        driver = Driver(controller, controller.memory, settings)
        episode = CoreEpisode(work, settings, driver)

        # Describe the requested ending, and the progress of the search.
        fails = wanted.crash or wanted.hang
        wanted_struct = run.memory.new("WgWanted *")
        wanted_struct.ending = lib.WG_CRASH if fails else wanted.ending
        wanted_struct.overlap = -1 if wanted.overlap is None or fails else int(wanted.overlap)
        wanted_struct.by_way = way
        wanted_struct.steps = _STEPS_AT_ONCE
        tried = run.memory.new("WgTried *")
        todo = run.memory.own(np.array(edits, np.int64))
        rows = ffi.cast("WgEdit *", pointer(ffi, todo, np.int64))
        grid = run.memory.new("WgGrid *", grid_of(fresh.cells))

        # Try the edits. One call may end within a run, which the next call then continues. If the
        # process that runs them dies, the controller failed in the last edit's run.
        objects = (episode.c, settings, run.settings, grid, rows, wanted_struct, tried)
        count = len(todo)
        try:
            while count > tried.next or tried.running:
                check(episode.call("wg_call_first_edit", objects, count, (tried,)))
                count = tried.next
        except ControllerDied as death:
            tried.running = 0
            tried.found = wanted.hang if death.verdict == Verdict.HANG else wanted.crash
        self.trials += int(tried.runs)
        return bool(tried.found), int(tried.next)


def has_sure_path(world: World, *, regardless_of_time: bool = False) -> bool:
    """Return True if a quick check finds a path to each goal that avoids cells that ever close.

    ``False`` proves nothing. The robot's position is rounded to the lattice, so it may be off by
    half a lattice unit.

    Args:
        world: The world.
        regardless_of_time: Whether to avoid only cells that are solid forever. In a changing world,
            ``True`` is then no proof either, but if there is no such path, another is unlikely.
    """
    # Mark the cells to avoid.
    side = world.cell_size
    shape = world.walls.shape
    cells = np.array(world.walls, np.uint8, order="C")
    if regardless_of_time:
        cells[world.timeline.cells_that_become(CellState.FREE, shape=shape)] = lib.WG_FREE
    else:
        cells[world.timeline.cells_that_become(CellState.SOLID, CellState.BURNING, shape=shape)] = (
            lib.WG_SOLID
        )

    # Search a graph with a node at each corner, edge and centre of a cell.
    disc = ffi.new("WgDisc *", disc_numbers(world))[0]
    nodes = (2 * world.height + 1) * (2 * world.width + 1)
    seen = writable(ffi, np.zeros(nodes, np.uint8), np.uint8)
    stack = writable(ffi, np.zeros(nodes, np.int64), np.int64)
    for goal in world.robots[0].goals:
        points = (world.start.x, world.start.y, goal.x, goal.y)
        way = ffi.new("WgSegment *", [metres_to_lattice(metres, side) for metres in points])[0]
        within = target_sq(goal, side)
        if not lib.wg_surely_reaches(grid_of(cells), disc, way, within, seen, stack):
            return False
    return True


def _moved_events(events: Ints, edit: CellEdit) -> Ints:
    """Return the events after rows or columns are dropped."""
    column = _IY if edit.kind == EditKind.DROP_ROWS else _IX
    place = events[:, column]
    kept = events[(place < edit.a) | (place >= edit.a + edit.b)].copy()
    kept[kept[:, column] >= edit.a + edit.b, column] -= edit.b
    return kept
