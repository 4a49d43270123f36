"""Runs many robots in lockstep under one controller that acts for all of them at once."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from sim.controllers.base import VectorController
from sim.controllers.contract import flat_memory
from sim.controllers.vector import Asker
from sim.kernels import layout
from sim.kernels._bridge import reports_of, settings_of
from sim.kernels.lattice_fleet import CLOCK_SIZE, Fleet, fleet_act, fleet_entries, fleet_move, fleet_set_out
from sim.kernels.lattice_state import new_robot
from sim.kernels.recurrence import MARKS, new_search
from sim.lattice_run import LatticeRun
from sim.python_loop import hidden_state
from sim.stopping import OutOfTime
from worldgen.lattice import UNIT

__all__ = ["ControllerRaised", "FleetRun", "its_own_fault"]

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]


class FleetRun:
    """Many episodes in worlds of one shape.

    Args:
        controller: Acts for all.
        runs: One for each world, with equal options but for the number of steps.
        world: (n,) index of each robot's world.
        starts: (n, 3) :meth:`sim.lattice_run.LatticeRun.start_of`.
        seeds: (n,).
    """

    def __init__(
        self,
        controller: VectorController,
        runs: Sequence[LatticeRun],
        world: Ints,
        starts: Ints,
        seeds: npt.NDArray[np.uint64],
    ) -> None:
        self._controller, self._runs, self._world = controller, runs, world
        self._starts, self._seeds = starts, seeds
        self._memory: Floats = np.zeros(0)

    def run(self, *, digest: bool) -> Any:
        """Runs all; as :meth:`sim.lattice_run.LatticeRun.run_many` reports it.

        ``None`` if the controller raised, or changed what is outside its memory: then no robot's run can be trusted
        to be its own, and each must be run alone.
        """
        before = hidden_state(self._controller)
        if before is None:
            return None
        with contextlib.redirect_stdout(sys.stderr):
            try:
                with its_own_fault():
                    self._memory = np.array(flat_memory(self._controller.reset()))
                found = self._run(digest)
            except ControllerRaised:
                return None
        return reports_of(*found) if hidden_state(self._controller) == before else None

    def _run(self, digest: bool) -> tuple[Ints, Floats]:
        can_loop = np.array([run.can_loop for run in self._runs])[self._world]
        budgets = np.array([run.options.steps for run in self._runs])[self._world]
        fleet = self._fleet(np.arange(len(self._world)), budgets, np.where(can_loop, layout.SEEK_LOOP, layout.NO_LOOP))
        self._drive(fleet, digest=digest)

        # Loops are run again, up to the end of their first period, which also proves them.
        looped = np.flatnonzero(fleet.counts[:, layout.OUT_ENDING] == layout.LOOP)
        entries = np.zeros(len(looped), np.int64)
        fleet_entries(fleet, looped, entries)
        self._again(
            fleet, looped, entries + fleet.counts[looped, layout.OUT_PERIOD], layout.PROVE_LOOP, entries, digest
        )

        # Where two different states had one fingerprint, the budget counts.
        unproved = looped[fleet.counts[looped, layout.OUT_ENDING] == layout.LIMIT]
        self._again(fleet, unproved, budgets[unproved], layout.NO_LOOP, np.zeros(len(unproved), np.int64), digest)
        return fleet.counts, fleet.sums

    def _again(self, fleet: Fleet, robots: Ints, steps: Ints, find_loop: int, entries: Ints, digest: bool) -> None:
        """Runs some of the robots again, in other ways, and puts their reports into the fleet."""
        if len(robots):
            again = self._fleet(robots, steps, np.full(len(robots), find_loop), entries)
            self._drive(again, digest=digest)
            fleet.counts[robots], fleet.sums[robots] = again.counts, again.sums

    def _drive(self, fleet: Fleet, *, digest: bool) -> None:
        """Steps the robots until each has ended."""
        fleet.settings[:, layout.SET_DIGEST] = int(digest)
        count = len(fleet.order)
        over = np.zeros(count, np.bool_)
        asker = Asker(self._controller, fleet.observation, fleet.memory, fleet.command)
        while count:
            if self._step(fleet, asker, count, over):
                count = _keep(fleet, ~over[:count])

    def _step(self, fleet: Fleet, asker: Asker, count: int, over: npt.NDArray[np.bool_]) -> int:
        fleet_move(fleet, count)
        after = np.empty((count, self._memory.size))
        with its_own_fault():
            asker.ask(count, after)
        return int(fleet_act(fleet, count, after, over))

    def _fleet(self, robots: Ints, steps: Ints, find_loop: Ints, entries: Ints | None = None) -> Fleet:
        """Robots at their starts.

        Args:
            robots: (n,) which.
            steps: (n,) of their runs.
            find_loop: (n,) ``SET_FIND_LOOP``.
            entries: (n,) ``SET_ENTRY``.
        """
        runs, world, size = self._runs, self._world[robots], self._memory.size
        packed = [settings_of(run.settings) for run in runs]
        arenas, counts = [run.arena() for run in runs], [run.events for run in runs]
        pages = world if any(map(len, counts)) else np.arange(len(runs))
        ends = np.cumsum([len(rows) for rows in counts])
        points = max(len(new_robot(0, rows).chain) for rows in counts)
        n, beams = len(robots), runs[0].options.robot.beams
        memory = np.zeros((n, size))
        search = new_search(layout.STATE_MEMORY + size, 0)
        log = np.where(find_loop == layout.SEEK_LOOP, steps, 0)
        height, width = arenas[0].cells.shape
        fleet = Fleet(
            shape=np.array([(height, width, arena.clearance.size > 0) for arena in arenas], np.int64),
            cells=np.stack([arenas[index].cells.ravel() for index in pages]),
            near=np.stack([arenas[index].near.ravel() for index in pages]),
            clearance=np.stack([arena.clearance.ravel() for arena in arenas]),
            events=np.concatenate(counts),
            headings=arenas[0].headings,
            visited=np.zeros((n, height * width), np.uint8),
            page=np.arange(n) if pages is world else world.copy(),
            world=world.copy(),
            span=np.stack([ends - [len(rows) for rows in counts], ends], axis=1),
            settings=np.stack([packed[index][0] for index in world]),
            scales=np.stack([scales for _, scales in packed]),
            state=np.zeros((n, layout.STATE_MEMORY + size), np.int64),
            odometry=np.zeros((n, 3)),
            chain=np.zeros((n, points, 3), np.int64),
            counts=np.zeros((n, layout.OUT_SIZE), np.int64),
            sums=np.zeros((n, layout.SUM_SIZE)),
            known=np.zeros((n, layout.STATE_MEMORY + size), np.int64),
            prints=np.zeros((n, search.prints.size), np.uint64),
            log=np.zeros((n, int(log.max()) + 1), np.uint64),
            marks=np.zeros((n, MARKS), np.int64),
            clock=np.zeros((n, CLOCK_SIZE), np.int64),
            order=np.arange(n),
            observation=np.full((n, layout.OBS_SIZE + beams), np.nan),
            memory=memory,
            words=memory.view(np.int64),
            command=np.zeros((n, layout.CMD_SIZE)),
            nothing=np.zeros((0, 1), np.int64),
        )
        settings = fleet.settings
        settings[:, layout.SET_X : layout.SET_HEADING + 1] = self._starts[robots]
        settings[:, layout.SET_SEED] = self._seeds[robots].view(np.int64)
        settings[:, layout.SET_STEPS], settings[:, layout.SET_FIND_LOOP] = steps, find_loop
        settings[:, layout.SET_ENTRY] = 0 if entries is None else entries
        column = np.minimum(settings[:, layout.SET_X] // UNIT, width - 1)
        line = np.minimum(settings[:, layout.SET_Y] // UNIT, height - 1)
        fleet.visited[np.arange(n), line * width + column] = 1
        fleet_set_out(fleet, n, self._memory)
        return fleet


class ControllerRaised(Exception):
    """The controller raised."""


@contextlib.contextmanager
def its_own_fault() -> Iterator[None]:
    """Tell what a controller raises from what is raised elsewhere.

    Raises:
        ControllerRaised: If anything is raised inside but ``KeyboardInterrupt`` and :class:`OutOfTime`.
    """
    try:
        yield
    except (KeyboardInterrupt, OutOfTime):
        raise
    except BaseException as error:
        raise ControllerRaised from error


def _keep(fleet: Fleet, wanted: npt.NDArray[np.bool_]) -> int:
    """Keeps those of the first slots that are wanted, in their order; how many they are."""
    _line_up(fleet, fleet.order[: len(wanted)][wanted])
    return int(np.count_nonzero(wanted))


def _line_up(fleet: Fleet, robots: Ints) -> None:
    """Puts robots into the first slots, each with its memory."""
    fleet.order[: len(robots)] = robots
    fleet.words[: len(robots)] = fleet.state[robots, layout.STATE_MEMORY :]
