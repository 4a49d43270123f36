"""Run many robots in lockstep under one controller that acts for all of them at once."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from sim._core import ffi, lib
from sim.controllers.base import Memory
from sim.controllers.controller_error import ControllerError
from sim.controllers.hidden_state import hidden_state
from sim.controllers.vector import Asker
from sim.kernels.layout import OBS_SIZE, OBS_TAIL
from sim.runners.controller_host import ControllerHost, Faults
from sim.runners.core_calls import REPORT, Driver
from sim.runners.lattice import LatticeRun
from worldgen.support.arrays import Floats, Ints, Words
from worldgen.support.ccall import check, pointer, writable
from worldgen.support.results import only_results_on_stdout

Reports = npt.NDArray[Any]


def run_in_lockstep(
    host: ControllerHost,
    runs: Sequence[LatticeRun],
    world: Ints,
    starts: Ints,
    seeds: Words,
    *,
    digest: bool,
) -> Reports | None:
    """Run many episodes in worlds of one shape, and report as :func:`sim.runners.many.run_many` does.

    Args:
        host: The host of a controller that acts for all robots.
        runs: One run per world; their options are equal except for the number of steps.
        world: (n,) index of each robot's world.
        starts: (n, 3) starts from :meth:`sim.runners.lattice.LatticeRun.start_of`.
        seeds: (n,) uint64 seeds.
        digest: Whether to compute the traces' digests.

    Returns:
        The reports. ``None`` if the controller raised or changed state outside its memory: runs
        may then have influenced each other, and each robot must be run alone.
    """
    faults = Faults(host)
    with only_results_on_stdout():
        try:
            with faults:
                memory = host.begin(None)
            before = host.hidden()
            if before is None:
                return None
            with contextlib.closing(_Group(runs, world, memory)) as group:
                group.begin(starts, seeds, digest=digest)
                asker = Asker(host.controller, group.observation, group.memory, group.command)
                # Alternate between the core, which moves the robots, and the controller.
                after = np.zeros((0, len(memory)))
                count = group.step(len(world), after)
                while count:
                    after = np.empty((count, len(memory)))
                    with faults:
                        asker.ask(count, after)
                    count = group.step(count, after)
                found = group.reports()
        except ControllerError:
            return None
    return found if hidden_state(host.controller) == before else None


class _Group:
    """Robots in lockstep, in the core.

    Args:
        runs: Runs in worlds of one shape, with equally many beams.
        world: (n,) index of each robot's run.
        memory: The controller's memory at reset.
    """

    def __init__(self, runs: Sequence[LatticeRun], world: Ints, memory: Memory) -> None:
        n = len(world)
        self._of_worlds = runs  # the settings point to their data
        self._fresh = [run.arena() for run in runs]
        self._world = world
        self._driver = Driver(None, memory)
        self._settings: Any = ffi.new("WgSettings[]", n)
        self._arenas: Any = ffi.new("WgArena[]", n)
        self._runs: Any = ffi.new("WgRun[]", n)
        self._slots: Any = ffi.new("WgRun *[]", [self._runs + k for k in range(n)])
        self.observation = np.full((n, OBS_SIZE + runs[0].options.robot.beams + OBS_TAIL), np.nan)
        self.memory = np.zeros((n, len(memory)))
        self.command = np.zeros((n, 3))

        # Each robot has its own copy of what changes: the cells that it has visited and, if there
        # are events, the cells themselves.
        shape = self._fresh[0].cells.shape
        self._visited = np.zeros((n, *shape), np.uint8)
        happens = any(len(arena.events) for arena in self._fresh)
        self._cells = np.zeros((n, *shape) if happens else (0,), np.uint8)
        self._near = np.zeros((n, *shape) if happens else (0,), np.int32)

    def begin(self, starts: Ints, seeds: Words, *, digest: bool) -> None:
        """Put all robots at their starts."""
        for k, index in enumerate(self._world.tolist()):
            # Give each robot its own settings, and point its arena at its own copies.
            run = self._of_worlds[index]
            fresh = self._fresh[index]
            self._settings[k] = run.settings[0]
            settings = self._settings[k]
            settings.start_x, settings.start_y, settings.start_heading = starts[k].tolist()
            settings.seed = int(seeds[k])
            settings.digest = int(digest)
            self._arenas[k] = fresh.c[0]
            self._arenas[k].visited = writable(ffi, self._visited[k], np.uint8)
            if len(fresh.events):
                self._arenas[k].cells = writable(ffi, self._cells[k], np.uint8)
                self._arenas[k].near = writable(ffi, self._near[k], np.int32)
            budget = run.options.steps
            self._runs[k] = (ffi.NULL, self._settings + k, fresh.c, budget, run.search)
        check(lib.wg_lockstep_new(self._arenas, self._driver.c, self._runs, len(self._world)))

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

    def reports(self) -> Reports:
        """Return (n,) reports."""
        reports = np.zeros(len(self._world), REPORT)
        into = ffi.cast("WgReport *", ffi.from_buffer(reports, require_writable=True))
        for k in range(len(reports)):
            into[k] = self._runs[k].episode.robot.report
        return reports

    def close(self) -> None:
        """Free the episodes."""
        lib.wg_lockstep_free(self._runs, len(self._world))
