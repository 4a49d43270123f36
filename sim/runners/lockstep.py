"""Runs many robots in lockstep under one controller that acts for all of them at once."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from sim._core import ffi, lib
from sim.controllers.base import VectorController
from sim.controllers.contract import flat_memory
from sim.controllers.vector import Asker
from sim.runners.core_calls import REPORT, SENSES, Driver
from sim.runners.lattice import LatticeRun
from sim.runners.python_loop import hidden_state
from sim.runners.stopping import OutOfTime
from worldgen.lattice import UNIT
from worldgen.support.ccall import check, pointer, writable

__all__ = ["ControllerRaised", "FleetRun", "its_own_fault"]

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]
Reports = npt.NDArray[Any]


class FleetRun:
    """Many episodes in worlds of one shape.

    Args:
        controller: Acts for all.
        runs: One for each world, with equal options but for the number of steps.
        world: (n,) index of each robot's world.
        starts: (n, 3) :meth:`sim.runners.lattice.LatticeRun.start_of`.
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
        self._controller = controller
        self._runs = runs
        self._world = world
        self._starts = starts
        self._seeds = seeds
        self._memory: Floats = np.zeros(0)

    def run(self, *, digest: bool) -> Any:
        """Runs all; as :meth:`sim.runners.lattice.LatticeRun.run_many` reports it.

        ``None`` if the controller raised, or changed what is outside its memory: then no robot's
            run can be trusted
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
        return found if hidden_state(self._controller) == before else None

    def _run(self, digest: bool) -> Reports:
        can_loop = np.array([run.can_loop for run in self._runs])[self._world]
        budgets = np.array([run.options.steps for run in self._runs])[self._world]
        everyone = np.arange(len(self._world))
        find_loop = np.where(can_loop, int(lib.WG_SEEK_LOOP), int(lib.WG_NO_LOOP))
        reports, entries = self._drive(
            everyone, budgets, find_loop, np.zeros_like(everyone), digest=digest
        )

        # Loops are run again, up to the end of their first period, which also proves them.
        looped = np.flatnonzero(reports["ending"] == int(lib.WG_LOOP))
        ends = entries[looped] + reports["period"][looped]
        prove = np.full(len(looped), int(lib.WG_PROVE_LOOP))
        reports[looped] = self._drive(looped, ends, prove, entries[looped], digest=digest)[0]

        # Where two different states had one fingerprint, the budget counts.
        unproved = looped[reports["ending"][looped] == int(lib.WG_LIMIT)]
        no_loop = np.full(len(unproved), int(lib.WG_NO_LOOP))
        again = self._drive(
            unproved, budgets[unproved], no_loop, np.zeros_like(unproved), digest=digest
        )
        reports[unproved] = again[0]
        return reports

    def _drive(
        self, robots: Ints, steps: Ints, find_loop: Ints, loop_entry: Ints, *, digest: bool
    ) -> tuple[Reports, Ints]:
        """Run some robots from their starts until each has ended.

        Args:
            robots: (n,) which.
            steps: (n,) of their runs.
            find_loop: (n,) WgSettings.find_loop.
            loop_entry: (n,) WgSettings.loop_entry.
            digest: Whether to work out the traces' digests.

        Returns:
            (n,) reports, and (n,) the first steps of loops.
        """
        if not len(robots):
            return np.zeros(0, REPORT), np.zeros(0, np.int64)
        fleet = _Fleet(self._runs, self._world[robots], self._memory)
        for k, robot in enumerate(robots.tolist()):
            settings = fleet.settings[k]
            settings.start_x, settings.start_y, settings.start_heading = self._starts[
                robot
            ].tolist()
            settings.seed = int(self._seeds[robot])
            settings.digest = int(digest)
            settings.steps = int(steps[k])
            settings.find_loop = int(find_loop[k])
            settings.loop_entry = int(loop_entry[k])
        with contextlib.closing(fleet):
            fleet.begin()
            asker = Asker(self._controller, fleet.observation, fleet.memory, fleet.command)
            after = np.zeros((0, self._memory.size))
            count = fleet.step(len(robots), after)
            while count:
                after = np.empty((count, self._memory.size))
                with its_own_fault():
                    asker.ask(count, after)
                count = fleet.step(count, after)
            return fleet.reports()


class _Fleet:
    """Robots in lockstep, in the core.

    Args:
        runs: Of worlds of one shape, with as many beams.
        world: (n,) each robot's run.
        memory: The controller's at reset.
    """

    def __init__(self, runs: Sequence[LatticeRun], world: Ints, memory: Floats) -> None:
        n = len(world)
        self._fresh = [run.arena() for run in runs]
        self._world = world
        self._driver = Driver(None, memory.tolist())
        self.settings: Any = ffi.new("WgSettings[]", n)
        self._arenas: Any = ffi.new("WgArena[]", n)
        self._episodes: Any = ffi.new("WgEpisode *[]", n)
        self._slots: Any = ffi.new("WgEpisode *[]", n)
        for k, index in enumerate(world.tolist()):
            self.settings[k] = runs[index].settings[0]
            self._arenas[k] = self._fresh[index].c[0]
        self.observation = np.full((n, SENSES + runs[0].options.robot.beams), np.nan)
        self.memory = np.zeros((n, memory.size))
        self.command = np.zeros((n, 3))

        # What changes as a robot goes is its own: where it has been, and cells in which something
        # happens.
        shape = self._fresh[0].cells.shape
        self._visited = np.zeros((n, *shape), np.uint8)
        happens = any(len(arena.events) for arena in self._fresh)
        self._cells = np.zeros((n, *shape) if happens else (0,), np.uint8)
        self._near = np.zeros((n, *shape) if happens else (0,), np.int32)

    def begin(self) -> None:
        """Put all robots at the starts that their settings name."""
        height, width = self._visited.shape[1:]
        for k, index in enumerate(self._world.tolist()):
            settings = self.settings[k]
            arena = self._arenas[k]
            row = min(settings.start_y // UNIT, height - 1)
            self._visited[k, row, min(settings.start_x // UNIT, width - 1)] = 1
            arena.visited = writable(ffi, self._visited[k], np.uint8)
            if self._cells.size:
                self._cells[k] = self._fresh[index].cells
                self._near[k] = self._fresh[index].near
                arena.cells = writable(ffi, self._cells[k], np.uint8)
                arena.near = writable(ffi, self._near[k], np.int32)
        seeks = [settings.find_loop == lib.WG_SEEK_LOOP for settings in self.settings]
        logs = np.array(
            [settings.steps * seek for settings, seek in zip(self.settings, seeks, strict=True)],
            np.int64,
        )
        n = len(self.settings)
        check(
            lib.wg_fleet_new(
                self._arenas,
                self.settings,
                self._driver.c,
                pointer(ffi, logs, np.int64),
                n,
                self._episodes,
            )
        )
        ffi.memmove(self._slots, self._episodes, ffi.sizeof(self._episodes))

    def step(self, count: int, after: Floats) -> int:
        """Let the first slots obey and go on; return how many are to act then, in the first slots.

        Args:
            count: Slots.
            after: (count, memory) as the controller wants it; without rows before it was asked.
        """
        return int(
            lib.wg_fleet_step(
                self._slots,
                count,
                pointer(ffi, self.command, np.float64),
                pointer(ffi, after, np.float64),
                writable(ffi, self.observation, np.float64),
                writable(ffi, self.memory, np.float64),
            )
        )

    def reports(self) -> tuple[Reports, Ints]:
        """Return (n,) reports, and (n,) the first steps of loops with which runs ended, else -1."""
        n = len(self.settings)
        reports = np.zeros(n, REPORT)
        entries = np.zeros(n, np.int64)
        lib.wg_fleet_reports(
            self._episodes,
            n,
            ffi.cast("WgReport *", ffi.from_buffer(reports)),
            writable(ffi, entries, np.int64),
        )
        return reports, entries

    def close(self) -> None:
        """Free the episodes."""
        lib.wg_fleet_free(self._episodes, len(self.settings))


class ControllerRaised(Exception):
    """The controller raised."""


@contextlib.contextmanager
def its_own_fault() -> Iterator[None]:
    """Tell what a controller raises from what is raised elsewhere.

    Raises:
        ControllerRaised: If anything is raised inside but ``KeyboardInterrupt`` and
            :class:`OutOfTime`.
    """
    try:
        yield
    except (KeyboardInterrupt, OutOfTime):
        raise
    except BaseException as error:
        raise ControllerRaised from error
