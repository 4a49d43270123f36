"""Build the core's fleets from packed runs; this module only converts."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from sim._core import ffi, lib
from sim.controllers.base import Neighbour
from sim.controllers.controller_error import ControllerError
from sim.controllers.shared.guarded import ControllerDied, call
from sim.runners.core_calls import CoreArena, Driver, EpisodeHandle, run_in_portions
from sim.runners.lattice import LatticeRun
from worldgen.lattice import clear_distance_sq, radius_in_cells
from worldgen.support.arrays import Ints, Words
from worldgen.support.ccall import check, kept, pointer

# Steps in the first call of a run; later calls grow until they take long enough.
_FIRST_PORTION = 1 << 8


class FleetMember(EpisodeHandle):
    """One robot of a fleet; its ``c`` is a WgEpisode.

    Args:
        fleet: Its fleet, which it keeps alive.
        number: Its index.
    """

    def __init__(self, fleet: CoreFleet, number: int) -> None:
        self._fleet = fleet
        self.c = fleet.c.members[number]
        self.words = int(self.c.search.words)  # with its memory and its message

    def neighbours(self) -> tuple[Neighbour, ...]:
        """Return what the robot senses of others, the nearest first."""
        seen = self.c.workspace.observation
        size = int(seen.message_size)
        found = (seen.neighbours[k] for k in range(int(seen.neighbour_count)))
        return tuple(
            Neighbour(one.x, one.y, one.heading, one.speed, one.radius, tuple(one.message[0:size]))
            for one in found
        )

    def send(self, message: Sequence[float]) -> None:
        """Send numbers, at most as many as its channel has, to the robots that sense this one."""
        for k, number in enumerate(message):
            self.c.workspace.command.message[k] = number

    @property
    def sent(self) -> tuple[float, ...]:
        """The numbers that it has sent in this step."""
        message = self.c.workspace.command.message
        size = int(self.c.workspace.observation.message_size)
        return tuple(message[0:size]) if message else ()


class CoreFleet:
    """A fleet of the core, at its start.

    Args:
        runs: One run for each robot, in worlds that differ only in the robot.
        drivers: (n,) each robot's controller, in the form in which the core calls it.
        steps: Budget.
        find_loop: ``WG_NO_LOOP``, ``WG_SEEK_LOOP`` or ``WG_PROVE_LOOP``.
        loop_entry: For ``WG_PROVE_LOOP``.

    Attributes:
        faults: How controllers in another process failed, by their robots' numbers.

    Raises:
        MemoryError: If there is not enough memory.
    """

    def __init__(
        self,
        runs: Sequence[LatticeRun],
        drivers: Sequence[Driver],
        steps: int,
        find_loop: int,
        loop_entry: int = 0,
    ) -> None:
        # All robots share the cells, which the timeline changes for all of them at once.
        # Give the robots one arena and one set of settings.
        first = runs[0].arena()
        arenas = [first, *(_in_the_same_cells(run, first) for run in runs[1:])]
        memory = runs[0].memory
        kinds, clear_sq = (memory.own(array) for array in _distances(runs))
        settings = memory.new("WgFleetSettings *")
        settings.motion = runs[0].settings.motion
        settings.steps = steps
        settings.find_loop = find_loop
        settings.loop_entry = loop_entry
        settings.log_steps = steps if find_loop == lib.WG_SEEK_LOOP else 0
        settings.message = max(run.options.robot.message for run in runs)
        settings.kinds = len(clear_sq)
        settings.kind = pointer(ffi, kinds, np.int64)
        settings.clear_sq = pointer(ffi, clear_sq, np.int64)
        for run in runs:
            run.settings.steps = steps
            run.settings.find_loop = lib.WG_NO_LOOP
        # Make the fleet, which owns everything that it points to.
        made = ffi.new("WgFleet **")
        block = ffi.new("WgBlock *")
        robots = (
            ffi.new("WgArena *[]", [arena.c for arena in arenas]),
            ffi.new("WgSettings *[]", [run.settings for run in runs]),
            ffi.new("WgController *[]", [driver.c for driver in drivers]),
        )
        check(lib.wg_fleet_new(settings, *robots, len(runs), block, made))
        bytes_of_fleet = None
        if memory.is_shared:
            # Now that its size is known, make it where the other process finds it.
            lib.wg_fleet_free(made[0])
            bytes_of_fleet = memory.new("char[]", block.used)
            block.bytes = bytes_of_fleet
            block.size = block.used
            check(lib.wg_fleet_new(settings, *robots, len(runs), block, made))
        held = (arenas, settings, kinds, clear_sq, list(runs), list(drivers), bytes_of_fleet)
        self.c: Any = kept(ffi, made[0], *held, free=lib.wg_fleet_free)
        self._drivers = drivers
        self._cages = [driver.cage for driver in drivers if driver.cage is not None]
        self.faults: dict[int, ControllerError] = {}
        self.members = tuple(FleetMember(self, number) for number in range(len(runs)))
        check(lib.wg_fleet_begin(self.c))

    @property
    def report(self) -> Any:
        """The WgFleetReport of the run so far."""
        return self.c.report

    def moved(self) -> list[int]:
        """Return the last step in which each robot's centre moved; 0 if it never did."""
        return [int(self.c.moved[number]) for number in range(len(self.members))]

    def blocks(self) -> list[tuple[int, int]]:
        """Return which robots drove into which others while a loop was proved, by their indices."""
        count = len(self.members)
        blocked = np.frombuffer(ffi.buffer(self.c.blocked, count * count), np.uint8)
        return [(robot, by) for robot, by in np.argwhere(blocked.reshape(count, count)).tolist()]

    def known_words(self) -> Words:
        """Return the joint state at the entry of a loop that was proved."""
        count = int(self.c.search.words)
        return np.frombuffer(ffi.buffer(self.c.search.known, 8 * count), np.uint64).copy()

    def fail(self, number: int) -> None:
        """End the run as a crash of one robot's controller."""
        lib.wg_fleet_fail(self.c, number)

    def run(self, steps: int) -> int:
        """Run at most this many steps.

        Returns:
            ``WG_GOES_ON``, ``WG_OVER``, or ``WG_ACTS`` if controllers outside the core must act.
        """
        if not self._cages:
            return int(lib.wg_fleet_run(self.c, steps))
        acts = {driver.guarded for driver in self._drivers if driver.guarded}
        progress = (ffi.addressof(self.c, "step"),)
        work = ffi.addressof(lib, "wg_call_fleet")
        try:
            return call(work, acts, (self.c,), steps, progress=progress, cages=self._cages)
        except ControllerDied as death:
            acting = (
                number
                for number, driver in enumerate(self._drivers)
                if driver.cage is not None and driver.cage.c.acts
            )
            number = next(acting, 0)
            self.faults[number] = death
            self.fail(number)
            return int(lib.WG_OVER)

    def run_to_the_end(self) -> None:
        """Run in portions, so that Ctrl-C is noticed between them; all controllers are compiled."""
        run_in_portions(lambda steps: self.run(steps) == lib.WG_GOES_ON, _FIRST_PORTION)


def _in_the_same_cells(run: LatticeRun, first: CoreArena) -> CoreArena:
    own = run.arena()
    shared = (first.cells, first.near, own.clearance, first.events)
    return CoreArena(*shared, own.visited, own.beams, memory=run.memory)


def _distances(runs: Sequence[LatticeRun]) -> tuple[Ints, Ints]:
    """Return each robot's size by number, and the squared distances that two sizes keep."""
    radii = [radius_in_cells(run.world) for run in runs]
    sizes: list[Fraction] = sorted(set(radii))
    kinds = np.array([sizes.index(radius) for radius in radii], np.int64)
    clear_sq = [[clear_distance_sq(one + other) for other in sizes] for one in sizes]
    return kinds, np.array(clear_sq, np.int64)
