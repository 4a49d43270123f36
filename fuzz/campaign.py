"""Campaigns: units on one or several processes, shrinking what they find. Yields events; prints nothing."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, wait
from dataclasses import dataclass, field
from multiprocessing import get_context
from typing import Any

from fuzz.config import CampaignConfig
from fuzz.result import Memory, UnitResult
from fuzz.shrink import shrink
from fuzz.unit import run_unit
from worldgen.errors import WorldgenError
from worldgen.grid_file import dumps
from worldgen.workers import LISTEN, begin_deaf, ctrl_c_held_back, end_workers, workers_begin_deaf
from worldgen.world import World

__all__ = ["Campaign", "CampaignState", "Find", "Found", "Progress", "UnitDone"]

_RESTARTS = 3  # failures of one class that are shrunk; the smallest result stays
_WAITING = 1  # units that wait for a worker, so that none is idle


@dataclass(frozen=True)
class UnitDone:
    """A unit has been merged, in order of unit numbers."""

    unit: int
    state: CampaignState


@dataclass(frozen=True)
class Found:
    """A failure is new in its class, or smaller than what was known.

    Args:
        kind: Its class.
        world: The failure.
        replaces: Whether the class had one already.
    """

    kind: str
    world: World
    replaces: bool


Progress = UnitDone | Found


@dataclass(frozen=True)
class Find:
    """A class was met for the first time, or in a smaller world than before.

    Args:
        unit: That met it.
        lane: Of that unit.
        kind: The class.
        solid_cells: Of its world, before shrinking.
        worlds: Of the campaign up to that unit, and with it.
        steps: Likewise.
    """

    unit: int
    lane: str
    kind: str
    solid_cells: int
    worlds: int
    steps: int


@dataclass
class CampaignState:
    """Totals so far.

    Args:
        units: Done and merged.
        worlds: Scenarios simulated.
        steps: Steps simulated.
        verdicts: At first look.
        met: How often each class was met.
        best: By class, the smallest failure, shrunk.
        memory: What the lanes brought, and what later units know of it.
        finds: In the order of units.
    """

    units: int = 0
    worlds: int = 0
    steps: int = 0
    verdicts: Counter[str] = field(default_factory=Counter)
    met: Counter[str] = field(default_factory=Counter)
    best: dict[str, World] = field(default_factory=dict)
    memory: Memory = field(default_factory=Memory)
    finds: list[Find] = field(default_factory=list)


class Campaign:
    """A budgeted search.

    Args:
        config: What to look for.
        units: Amount of work; the corpus then depends on the seed alone.
        seconds: Stop handing out work after this time; ignored if ``units`` is given.
        workers: Processes; 1 works in this one.

    Iterating over :meth:`run` does the work. Whatever stops it, ``state.best`` and :meth:`pending` keep all
    that was found.
    """

    def __init__(
        self,
        config: CampaignConfig,
        *,
        units: int | None = None,
        seconds: float | None = None,
        workers: int = 1,
    ) -> None:
        self.config, self.units, self.seconds, self.workers = config, units, seconds, workers
        self.state = CampaignState()
        self._shrunk_per_class: Counter[str] = Counter()
        self._unshrunk: dict[str, list[World]] = {}
        self._known = [Memory(), Memory()]  # by epoch

    def pending(self) -> dict[str, World]:
        """Failures by class that are proved but not shrunk yet; of use after an interruption."""
        return {kind: min(worlds, key=_size) for kind, worlds in self._unshrunk.items() if worlds}

    def run(self) -> Iterator[Progress]:
        """Does the campaign."""
        if self.workers == 1:
            yield from self._serially()
        else:
            yield from self._in_parallel()

    def _serially(self) -> Iterator[Progress]:
        started, unit = time.monotonic(), 0
        while not self._enough(unit, started):
            todo = self._merge(unit, run_unit(self.config, unit, self._memory_for(unit)))
            yield UnitDone(unit, self.state)
            for kind, failure in todo:
                yield from self._keep(kind, failure, shrunk_or_same(failure, self.config.shrink))
            unit += 1

    def _enough(self, unit: int, started: float) -> bool:
        if self.units is not None:
            return unit >= self.units
        return self.seconds is not None and time.monotonic() - started >= self.seconds

    def _in_parallel(self) -> Iterator[Progress]:
        pool = ProcessPoolExecutor(self.workers, mp_context=get_context("spawn"), initializer=_worker_start)
        with ctrl_c_held_back() as listen:
            try:
                yield from self._with_pool(pool, listen)
            except BaseException:
                end_workers(pool)
                raise
            pool.shutdown()

    def _with_pool(self, pool: Executor, listen: Callable[[], None]) -> Iterator[Progress]:
        started, submitted, merged = time.monotonic(), 0, 0
        units: dict[int, Future[UnitResult]] = {}
        shrinks: dict[Future[World], tuple[str, World]] = {}
        while True:
            while self._takes_more(len(units), submitted) and not self._enough(submitted, started):
                with workers_begin_deaf():
                    units[submitted] = pool.submit(run_unit, self.config, submitted, self._memory_for(submitted))
                submitted += 1
            if not units and not shrinks:
                return
            under_way: list[Future[Any]] = [*units.values(), *shrinks]
            while not wait(under_way, LISTEN, return_when=FIRST_COMPLETED).done:
                listen()
            listen()
            while merged in units and units[merged].done():
                for kind, failure in self._merge(merged, units.pop(merged).result()):
                    with workers_begin_deaf():
                        shrinks[pool.submit(shrunk_or_same, failure, self.config.shrink)] = (kind, failure)
                yield UnitDone(merged, self.state)
                merged += 1
            for future in [future for future in shrinks if future.done()]:
                kind, failure = shrinks.pop(future)
                yield from self._keep(kind, failure, future.result())

    def _takes_more(self, under_way: int, unit: int) -> bool:
        """Whether a worker is free for a unit, and what the unit is to know is known."""
        return under_way < self.workers + _WAITING and unit // self.config.epoch < len(self._known)

    def _memory_for(self, unit: int) -> Memory:
        return self._known[unit // self.config.epoch]

    def _merge(self, unit: int, result: UnitResult) -> list[tuple[str, World]]:
        """Adds a unit's result; returns the failures that are to be shrunk, the same for any timing."""
        state = self.state
        state.units = unit + 1
        state.worlds += result.worlds
        state.steps += result.steps
        state.verdicts += result.verdicts
        state.met += result.met
        todo = []
        for kind, failure in sorted(result.failures.items()):
            if state.memory.is_news(kind, failure):
                state.finds.append(Find(unit, result.lane, kind, failure.solid_cells, state.worlds, state.steps))
            if self._shrunk_per_class[kind] < _RESTARTS:
                self._shrunk_per_class[kind] += 1
                self._unshrunk.setdefault(kind, []).append(failure)
                todo.append((kind, failure))
        state.memory = state.memory.after(result)
        if (unit + 1) % self.config.epoch == 0:
            self._known.append(state.memory)
        return todo

    def _keep(self, kind: str, failure: World, shrunk: World) -> Iterator[Found]:
        self._unshrunk[kind].remove(failure)
        final = str(shrunk.failure.details["class"]) if shrunk.failure else kind
        before = self.state.best.get(final)
        if before is None or _size(shrunk) < _size(before):
            self.state.best[final] = shrunk
            yield Found(final, shrunk, before is not None)


def shrunk_or_same(failure: World, wanted: bool) -> World:
    """The failure shrunk; as it was if that is not wanted, or it does not hold by shrinking's own terms."""
    if not wanted:
        return failure
    try:
        return shrink(failure).world
    except WorldgenError:
        return failure


def _size(world: World) -> tuple[int, int, bytes]:
    return world.solid_cells, world.width * world.height, dumps(world)


def _worker_start() -> None:
    begin_deaf()  # the driver decides when a campaign ends
