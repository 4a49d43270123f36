"""Run many robots in lockstep under one controller that acts for all of them at once."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from sim._core import ffi, lib
from sim.controllers.controller_error import ControllerError
from sim.controllers.hidden_state import hidden_state
from sim.controllers.vector import Asker
from sim.kernels.layout import OBS_SIZE
from sim.runners.controller_host import ControllerHost, Faults
from sim.runners.core_calls import REPORT, Driver
from sim.runners.lattice import LatticeRun
from worldgen.lattice import UNIT
from worldgen.support.arrays import Floats, Ints, Words
from worldgen.support.ccall import check, pointer, writable
from worldgen.support.results import only_results_on_stdout

Reports = npt.NDArray[Any]


class LockstepRun:
    """Many episodes in worlds of one shape.

    Args:
        host: The host of a controller that acts for all robots.
        runs: One run per world; their options are equal except for the number of steps.
        world: (n,) index of each robot's world.
        starts: (n, 3) starts from :meth:`sim.runners.lattice.LatticeRun.start_of`.
        seeds: (n,) uint64 seeds.
    """

    def __init__(
        self,
        host: ControllerHost,
        runs: Sequence[LatticeRun],
        world: Ints,
        starts: Ints,
        seeds: Words,
    ) -> None:
        self._host = host
        self._runs = runs
        self._world = world
        self._starts = starts
        self._seeds = seeds
        self._memory: Floats = np.zeros(0)

    def run(self, *, digest: bool) -> Any:
        """Run all robots, and report as :func:`sim.runners.many.run_many` does.

        Returns:
            The reports. ``None`` if the controller raised or changed state outside its memory: runs
            may then have influenced each other, and each robot must be run alone.
        """
        with only_results_on_stdout():
            try:
                with Faults(self._host):
                    self._memory = np.array(self._host.begin(None))
                before = self._host.hidden()
                if before is None:
                    return None
                found = self._run(digest)
            except ControllerError:
                return None
        return found if hidden_state(self._host.controller) == before else None

    def _run(self, digest: bool) -> Reports:
        # Run every robot with its whole budget, looking for loops.
        can_loop = np.array([run.can_loop for run in self._runs])[self._world]
        budgets = np.array([run.options.steps for run in self._runs])[self._world]
        everyone = np.arange(len(self._world))
        find_loop = np.where(can_loop, int(lib.WG_SEEK_LOOP), int(lib.WG_NO_LOOP))
        reports, entries = self._drive(
            everyone, budgets, find_loop, np.zeros_like(everyone), digest=digest
        )

        # Run loops again up to the end of their first period, which also proves them.
        looped = np.flatnonzero(reports["ending"] == int(lib.WG_LOOP))
        ends = entries[looped] + reports["period"][looped]
        prove = np.full(len(looped), int(lib.WG_PROVE_LOOP))
        reports[looped] = self._drive(looped, ends, prove, entries[looped], digest=digest)[0]

        # Two different states may share a fingerprint. Those runs did not loop, so the budget
        # decides.
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
        """Run some robots from their starts until each of them has ended.

        Args:
            robots: (n,) indices of the robots.
            steps: (n,) budgets.
            find_loop: (n,) WgSettings.find_loop.
            loop_entry: (n,) WgSettings.loop_entry.
            digest: Whether to compute the traces' digests.

        Returns:
            (n,) reports, and (n,) the first steps of the loops.
        """
        if not len(robots):
            return np.zeros(0, REPORT), np.zeros(0, np.int64)
        # Give each robot its own settings.
        group = _Group(self._runs, self._world[robots], self._memory)
        for k, robot in enumerate(robots.tolist()):
            settings = group.settings[k]
            settings.start_x, settings.start_y, settings.start_heading = self._starts[
                robot
            ].tolist()
            settings.seed = int(self._seeds[robot])
            settings.digest = int(digest)
            settings.steps = int(steps[k])
            settings.find_loop = int(find_loop[k])
            settings.loop_entry = int(loop_entry[k])

        # Alternate between the core, which moves the robots, and the controller.
        with contextlib.closing(group):
            group.begin()
            faults = Faults(self._host)
            asker = Asker(self._host.controller, group.observation, group.memory, group.command)
            after = np.zeros((0, self._memory.size))
            count = group.step(len(robots), after)
            while count:
                after = np.empty((count, self._memory.size))
                with faults:
                    asker.ask(count, after)
                count = group.step(count, after)
            return group.reports()


class _Group:
    """Robots in lockstep, in the core.

    Args:
        runs: Runs in worlds of one shape, with equally many beams.
        world: (n,) index of each robot's run.
        memory: The controller's memory at reset.
    """

    def __init__(self, runs: Sequence[LatticeRun], world: Ints, memory: Floats) -> None:
        n = len(world)
        self._runs = runs  # the settings point to their data
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
        self.observation = np.full((n, OBS_SIZE + runs[0].options.robot.beams), np.nan)
        self.memory = np.zeros((n, memory.size))
        self.command = np.zeros((n, 3))

        # Each robot has its own copy of what changes: the cells that it has visited and, if there
        # are events, the cells themselves.
        shape = self._fresh[0].cells.shape
        self._visited = np.zeros((n, *shape), np.uint8)
        happens = any(len(arena.events) for arena in self._fresh)
        self._cells = np.zeros((n, *shape) if happens else (0,), np.uint8)
        self._near = np.zeros((n, *shape) if happens else (0,), np.int32)

    def begin(self) -> None:
        """Put all robots at the starts given in their settings."""
        height, width = self._visited.shape[1:]
        for k, index in enumerate(self._world.tolist()):
            # Point the robot's arena at its own copies, and mark its start as visited.
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

        # Reserve a log for each robot whose loops are looked for.
        seek = lib.WG_SEEK_LOOP
        steps = [one.steps if one.find_loop == seek else 0 for one in self.settings]
        logs = pointer(ffi, np.array(steps, np.int64), np.int64)
        robots = (self._arenas, self.settings, self._driver.c)
        check(lib.wg_lockstep_new(*robots, logs, len(steps), self._episodes))
        ffi.memmove(self._slots, self._episodes, ffi.sizeof(self._episodes))

    def step(self, count: int, after: Floats) -> int:
        """Apply the commands of the robots in the first slots, and run until they act again.

        Args:
            count: How many slots are in use.
            after: (count, memory) the memories that the controller returned; empty on the first
                call, before it has acted.

        Returns:
            How many robots must act now; they are in the first slots.
        """
        read = (pointer(ffi, array, np.float64) for array in (self.command, after))
        filled = (writable(ffi, array, np.float64) for array in (self.observation, self.memory))
        return int(lib.wg_lockstep_step(self._slots, count, *read, *filled))

    def reports(self) -> tuple[Reports, Ints]:
        """Return (n,) reports, and (n,) the first step of each loop, or -1 without a loop."""
        n = len(self.settings)
        reports = np.zeros(n, REPORT)
        entries = np.zeros(n, np.int64)
        into = ffi.cast("WgReport *", ffi.from_buffer(reports))
        lib.wg_lockstep_reports(self._episodes, n, into, writable(ffi, entries, np.int64))
        return reports, entries

    def close(self) -> None:
        """Free the episodes."""
        lib.wg_lockstep_free(self._episodes, len(self.settings))
