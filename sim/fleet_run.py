"""Runs many robots in lockstep under one controller that acts for all of them at once."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from sim.controllers.base import VectorController
from sim.controllers.contract import flat_memory
from sim.controllers.vector import ask
from sim.kernels import layout
from sim.kernels.lattice_fleet import CLOCK_SIZE, Fleet, fleet_act, fleet_move, fleet_same, fleet_set_out
from sim.kernels.lattice_state import new_robot
from sim.lattice_run import LatticeRun
from sim.python_loop import hidden_state
from worldgen.lattice import UNIT

__all__ = ["FleetRun"]

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]

_ENDLESS = 1 << 62  # steps


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

    def run(self, *, digest: bool) -> tuple[Ints, Floats] | None:
        """Runs all; as :meth:`sim.lattice_run.LatticeRun.run_many` reports it.

        ``None`` if the controller raised, or changed what is outside its memory: then no robot's run can be trusted
        to be its own, and each must be run alone.
        """
        before = hidden_state(self._controller)
        if before is None:
            return None
        with contextlib.redirect_stdout(sys.stderr):
            try:
                with _its_own_fault():
                    self._memory = np.array(flat_memory(self._controller.reset()))
                found = self._run(digest)
            except _Raised:
                return None
        return found if hidden_state(self._controller) == before else None

    def _run(self, digest: bool) -> tuple[Ints, Floats]:
        fleet = self._fleet(np.arange(len(self._world)), digest=digest)
        fleet.settings[:, layout.SET_STEPS] = [self._runs[index].options.steps for index in self._world]
        fleet.settings[:, layout.SET_FIND_LOOP] = [self._runs[index].can_loop for index in self._world]
        self._drive(fleet, len(self._world))
        looped = np.flatnonzero(fleet.counts[:, layout.OUT_ENDING] == layout.LOOP)
        if len(looped):
            periods = fleet.counts[looped, layout.OUT_PERIOD]
            counts, sums = self._to_the_end_of_the_first_period(looped, periods, digest)
            fleet.counts[looped], fleet.sums[looped] = counts, sums
            fleet.counts[looped, layout.OUT_ENDING] = layout.LOOP
            fleet.counts[looped, layout.OUT_PERIOD] = periods
        return fleet.counts, fleet.sums

    def _drive(self, fleet: Fleet, count: int) -> None:
        """Steps the robots in the first slots, until each has ended."""
        over = np.zeros(len(fleet.order), np.bool_)
        while count:
            if self._step(fleet, count, over):
                count = _keep(fleet, ~over[:count])

    def _step(self, fleet: Fleet, count: int, over: npt.NDArray[np.bool_]) -> int:
        fleet_move(fleet, count)
        after = np.empty((count, self._memory.size))
        with _its_own_fault():
            ask(self._controller, fleet.observation[:count], fleet.memory[:count], fleet.command[:count], after)
        return int(fleet_act(fleet, count, after, over))

    def _to_the_end_of_the_first_period(self, robots: Ints, periods: Ints, digest: bool) -> tuple[Ints, Floats]:
        """Runs robots whose state recurs to the end of the first period; two equal fleets find where it begins."""
        by_period = np.argsort(-periods, kind="stable")
        slow, fast = self._fleet(robots, digest=digest), self._fleet(robots, digest=False)
        self._ahead(fast, by_period, periods)
        _line_up(slow, np.arange(len(robots)))
        _line_up(fast, np.arange(len(robots)))
        count, over = len(robots), np.zeros(len(robots), np.bool_)
        while count:
            if fleet_same(slow, fast, count, over):
                apart = ~over[:count]
                count = _keep(slow, apart)
                _keep(fast, apart)
            if count:
                self._step(slow, count, over)
                self._step(fast, count, over)
        self._ahead(slow, by_period, periods)
        return slow.counts, slow.sums

    def _ahead(self, fleet: Fleet, by_period: Ints, periods: Ints) -> None:
        """Steps each robot as often as its period says; those with the longest come first in the order given."""
        _line_up(fleet, by_period)
        left, over = periods[by_period], np.zeros(len(periods), np.bool_)
        for step in range(int(left[0])):
            self._step(fleet, int(np.searchsorted(-left, -step)), over)

    def _fleet(self, robots: Ints, *, digest: bool) -> Fleet:
        """Robots at their starts, with no end of steps and without looking for loops."""
        runs, world, size = self._runs, self._world[robots], self._memory.size
        arenas, counts = [run.arena() for run in runs], [run.events for run in runs]
        pages = world if any(map(len, counts)) else np.arange(len(runs))
        ends = np.cumsum([len(rows) for rows in counts])
        points = max(len(new_robot(0, rows).chain) for rows in counts)
        n, beams = len(robots), runs[0].options.robot.beams
        memory = np.zeros((n, size))
        fleet = Fleet(
            cells=np.stack([arenas[index].cells for index in pages]),
            near=np.stack([arenas[index].near for index in pages]),
            clearance=np.stack([arena.clearance for arena in arenas]),
            events=np.concatenate(counts),
            headings=arenas[0].headings,
            visited=np.zeros((n, *arenas[0].visited.shape), np.uint8),
            page=np.arange(n) if pages is world else world.copy(),
            world=world.copy(),
            span=np.stack([ends - [len(rows) for rows in counts], ends], axis=1),
            settings=np.stack([runs[index].settings for index in world]),
            scales=np.stack([run.scales for run in runs]),
            state=np.zeros((n, layout.STATE_MEMORY + size), np.int64),
            odometry=np.zeros((n, 3)),
            chain=np.zeros((n, points, 3), np.int64),
            counts=np.zeros((n, layout.OUT_SIZE), np.int64),
            sums=np.zeros((n, layout.SUM_SIZE)),
            anchor=np.zeros((n, layout.STATE_MEMORY + size), np.int64),
            brent=np.zeros((n, 3), np.int64),
            clock=np.zeros((n, CLOCK_SIZE), np.int64),
            order=np.arange(n),
            observation=np.full((n, layout.OBS_SIZE + beams), np.nan),
            memory=memory,
            words=memory.view(np.int64),
            command=np.zeros((n, layout.CMD_SIZE)),
            nothing=np.zeros((0, 1), np.int64),
        )
        settings, height, width = fleet.settings, *fleet.visited.shape[1:]
        settings[:, layout.SET_X : layout.SET_HEADING + 1] = self._starts[robots]
        settings[:, layout.SET_SEED] = self._seeds[robots].view(np.int64)
        settings[:, layout.SET_DIGEST], settings[:, layout.SET_STEPS] = int(digest), _ENDLESS
        settings[:, layout.SET_FIND_LOOP] = 0
        column = np.minimum(settings[:, layout.SET_X] // UNIT, width - 1)
        fleet.visited[np.arange(n), np.minimum(settings[:, layout.SET_Y] // UNIT, height - 1), column] = 1
        fleet_set_out(fleet, n, self._memory)
        return fleet


class _Raised(Exception):
    """The controller raised."""


@contextlib.contextmanager
def _its_own_fault() -> Iterator[None]:
    try:
        yield
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        raise _Raised from error


def _keep(fleet: Fleet, wanted: npt.NDArray[np.bool_]) -> int:
    """Keeps those of the first slots that are wanted, in their order; how many they are."""
    _line_up(fleet, fleet.order[: len(wanted)][wanted])
    return int(np.count_nonzero(wanted))


def _line_up(fleet: Fleet, robots: Ints) -> None:
    """Puts robots into the first slots, each with its memory."""
    fleet.order[: len(robots)] = robots
    fleet.words[: len(robots)] = fleet.state[robots, layout.STATE_MEMORY :]
