"""Runs of edited copies of a world, without a world or a run of its own for each."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any, NamedTuple

import numba
import numpy as np
import numpy.typing as npt

from sim.controllers.base import CompiledController, compiled_act, numba_config
from sim.kernel_types import episode_types, typed_kernel
from sim.kernels import lattice_edits as at
from sim.kernels import layout
from sim.kernels.lattice_flood import surely_reaches
from sim.kernels.lattice_state import Arena, new_robot, new_room
from sim.lattice_run import LatticeRun
from sim.packing import disc_numbers, target_sq
from sim.run_options import RunOptions
from worldgen.lattice import metres_to_lattice
from worldgen.world import World

__all__ = ["CellEdit", "EditedRuns", "Wanted", "has_sure_way"]

_STEPS_AT_ONCE = 200_000  # then Ctrl-C is heard: 0.02 to 2 s

Ints = npt.NDArray[np.int64]


class CellEdit(NamedTuple):
    """A simpler grid: ``FREE_`` or ``DROP_`` of :mod:`sim.kernels.lattice_edits`, and its numbers."""

    kind: int
    a: int = 0
    b: int = 0
    c: int = 0
    d: int = 0

    @property
    def frees(self) -> bool:
        """Whether it only frees cells, so that whatever way there is remains."""
        return self.kind < at.DROP_ROWS

    def shape(self, height: int, width: int) -> tuple[int, int]:
        """Of the grid after the edit."""
        return (
            height - (self.b if self.kind == at.DROP_ROWS else 0),
            width - (self.b if self.kind == at.DROP_COLUMNS else 0),
        )


class Wanted(NamedTuple):
    """How an edited world's run is to end.

    Args:
        ending: Of ``layout``; ``ANY_ENDING`` for one of ``LIMIT``, ``REACHED``, ``LOOP``.
        overlap: Whether with an overlap; ``None`` if that does not matter.
        crash: Whether the controller is to crash instead.
    """

    ending: int
    overlap: bool | None = None
    crash: bool = False


@functools.cache
def _kernel() -> Any:
    if numba_config.DISABLE_JIT:
        return at.first_edit
    arena, robot, room, act = episode_types()
    cells, ints, floats, rows = numba.uint8[:, ::1], numba.int64[::1], numba.float64[::1], numba.int64[:, ::1]
    types: Any = numba.types
    places, flood = types.UniTuple(ints, 2), types.Tuple((cells, cells, ints))
    signature = numba.boolean(cells, arena, places, floats, act, floats, room, robot, rows, ints, flood, ints, rows)
    return typed_kernel(at.first_edit, signature)


class EditedRuns:
    """One world, compiled controller and set of options; edits of the world's cells are tried in compiled code.

    Raises:
        InvalidWorld: If the start is not clear of walls.
    """

    def __init__(self, world: World, controller: CompiledController, options: RunOptions) -> None:
        self._run = LatticeRun(world, controller, options)
        self._run.settings[layout.SET_STEPS], self._run.settings[layout.SET_DIGEST] = options.steps, 0
        self._run.settings[layout.SET_FIND_LOOP] = layout.SEEK_LOOP if self._run.can_loop else layout.NO_LOOP
        for k, metres in enumerate((world.start.x, world.start.y)):
            self._run.settings[layout.SET_X + k] = metres_to_lattice(metres, world.cell_size)
        self._controller, self._world = controller, world
        self.trials = 0

    def first(self, edits: Sequence[CellEdit], wanted: Wanted, *, way: bool) -> tuple[int | None, int]:
        """Tries edits in their order, for a while.

        Args:
            edits: Not empty.
            wanted: How the run is to end.
            way: Whether, where rows or columns go, the target is surely to be reached.

        Returns:
            Index of the first edit whose run ends so, ``None`` if there is none yet, and the number of edits done with.
        """
        shape = edits[0].shape(*self._world.walls.shape)
        alike = 1
        if min(shape) < 1:
            return None, 1
        changing = self._world.is_dynamic and not edits[0].frees  # then each has events of its own
        while not changing and alike < len(edits) and edits[alike].shape(*self._world.walls.shape) == shape:
            alike += 1
        found, done = self._try(edits[:alike], shape, wanted, way=way)
        return (done - 1 if found else None), done

    def _try(self, edits: Sequence[CellEdit], shape: tuple[int, int], wanted: Wanted, *, way: bool) -> tuple[bool, int]:
        run, memory = self._run, np.array(self._controller.memory, np.float64)
        act = compiled_act(self._controller.act)
        events = run.events if edits[0].frees else _moved_events(run.events, edits[0])
        fresh = run.arena()
        clearance = np.zeros(shape if len(fresh.clearance) else (0, 0), np.int32)
        cells, near, visited = np.zeros(shape, np.uint8), np.zeros(shape, np.int32), np.zeros(shape, np.uint8)
        work = Arena(cells, near, clearance, events, fresh.headings, visited)
        nodes = (2 * shape[0] + 1, 2 * shape[1] + 1)
        flood = np.zeros(shape, np.uint8), np.zeros(nodes, np.uint8), np.zeros(nodes[0] * nodes[1], np.int64)
        overlap = -1 if wanted.overlap is None else int(wanted.overlap)
        asked = np.array([wanted.ending, overlap, way, _STEPS_AT_ONCE], np.int64)
        done, found = np.zeros(at.DONE_SIZE, np.int64), False
        places, nothing = (run.settings, run.settings.copy()), np.zeros((0, 1), np.int64)
        room = new_room(memory.size, run.options.robot.beams, run.options.steps)
        robot = new_robot(memory.size, events)
        kernel = _kernel()
        todo = np.array(edits, np.int64)
        try:
            found = kernel(
                fresh.cells, work, places, run.scales, act, memory, room, robot, todo, asked, flood, done, nothing
            )
            found = bool(found) and not wanted.crash
        except Exception:  # noqa: BLE001 - raised in the compiled controller, which may raise anything
            found = wanted.crash
        self.trials += int(done[at.DONE_TRIALS])
        return found, int(done[at.DONE_NEXT])


def has_sure_way(world: World, *, regardless_of_time: bool = False) -> bool:
    """Whether a quick look shows that the target can be reached, without touching what is ever not free.

    ``False`` shows nothing. The robot's place is taken on the lattice, so it may be wrong by half a lattice unit.

    Args:
        world: The world.
        regardless_of_time: Whether to keep away only from what is solid for ever: then ``True`` shows nothing either
            of a world that changes, but without such a way there is hardly another.
    """
    side, line = world.cell_size, world.timeline
    cells = world.walls.astype(np.uint8)
    if regardless_of_time:
        cells[line.iy[line.states == 0], line.ix[line.states == 0]] = 0
    else:
        cells[line.iy[line.states > 0], line.ix[line.states > 0]] = layout.SOLID
    points = (world.start.x, world.start.y, world.target.x, world.target.y)
    sx, sy, tx, ty = (metres_to_lattice(metres, side) for metres in points)
    disc = disc_numbers(world)
    nodes = (2 * world.height + 1, 2 * world.width + 1)
    seen, stack = np.zeros(nodes, np.uint8), np.zeros(nodes[0] * nodes[1], np.int64)
    return bool(surely_reaches(cells, disc, (sx, sy, tx, ty), target_sq(world), seen, stack))


def _moved_events(events: Ints, edit: CellEdit) -> Ints:
    """Events after rows or columns are dropped."""
    column = layout.EVENT_IY if edit.kind == at.DROP_ROWS else layout.EVENT_IX
    place = events[:, column]
    kept = events[(place < edit.a) | (place >= edit.a + edit.b)].copy()
    kept[kept[:, column] >= edit.a + edit.b, column] -= edit.b
    return kept
