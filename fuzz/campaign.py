"""Campaigns: units done by a crew, their failures shrunk, all of it remembered. Yields events; prints nothing."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, field, replace
from typing import Any, Generic, TypeVar

from fuzz.boundary import with_boundaries
from fuzz.config import CampaignConfig
from fuzz.crews import Crew, crew_of
from fuzz.ledger import Ledger
from fuzz.ledger.entry import Done
from fuzz.result import Memory, UnitResult
from fuzz.shrink import shrink
from fuzz.unit import run_unit
from worldgen.errors import WorldgenError
from worldgen.grid_file import dumps
from worldgen.workers import LISTEN
from worldgen.world import World

__all__ = ["Campaign", "CampaignState", "Find", "Found", "Progress", "UnitDone", "shrunk_or_same"]

T = TypeVar("T")

_RESTARTS = 6  # failures of one class that are shrunk; the smallest result stays
_SEARCH = 0.75  # share of the time after which no more is searched while failures wait to be shrunk
_TO_SHRINK = 5.0  # s, at least, after the last unit; a quarter of the time if that is more


@dataclass(frozen=True)
class UnitDone:
    """A unit has been merged, in order of unit numbers.

    Args:
        unit: Its number.
        state: The campaign's, with it.
        again: Whether it was done in an earlier sitting.
    """

    unit: int
    state: CampaignState
    again: bool = False


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
        failure: As it was found, before shrinking.
        worlds: Of the campaign up to that unit, and with it.
        steps: Likewise.
        seconds: Likewise, over all sittings.
    """

    unit: int
    lane: str
    kind: str
    failure: World
    worlds: int
    steps: int
    seconds: float


@dataclass
class CampaignState:
    """Totals so far.

    Args:
        units: Done and merged.
        worlds: Scenarios simulated.
        steps: Steps simulated.
        seconds: Of all sittings together.
        verdicts: At first look.
        met: How often each class was met.
        known: Likewise, of the classes that are no news.
        best: By class, the smallest failure, shrunk.
        memory: What the lanes brought, and what later units know of it.
        finds: In the order of units.
    """

    units: int = 0
    worlds: int = 0
    steps: int = 0
    seconds: float = 0.0
    verdicts: Counter[str] = field(default_factory=Counter)
    met: Counter[str] = field(default_factory=Counter)
    known: Counter[str] = field(default_factory=Counter)
    best: dict[str, World] = field(default_factory=dict)
    memory: Memory = field(default_factory=Memory)
    finds: list[Find] = field(default_factory=list)


@dataclass(frozen=True, eq=False)
class _Under(Generic[T]):
    """Work under way, or remembered.

    Args:
        future: Its result.
        seconds: Of the campaign when it was done in an earlier sitting; ``None`` of work that is new.
    """

    future: Future[T]
    seconds: float | None = None


@dataclass(frozen=True, eq=False)
class _Job:
    """A failure that is to be shrunk.

    Args:
        failure: As it was found.
        kept: What shrinking keeps.
        before: How many failures of its class have their turn before it.
    """

    failure: World
    kept: str = "verdict"
    before: int = 0


class Campaign:
    """A budgeted search.

    Args:
        config: What to look for.
        units: Amount of work; the corpus then depends on the seed alone.
        seconds: Stop handing out work after this time; ignored if ``units`` is given. What was not shrunk until then
            is pending.
        workers: Processes; 1 works in this one.
        crew: Who does the work, instead of processes.
        ledger: Remembers what was done, so that another campaign of the same configuration goes on with it.
        is_known: Whether a failure is of a class that is no news: those are counted, but not shrunk and not kept.

    Iterating over :meth:`run` does the work. Whatever stops it, ``state.best`` and :meth:`pending` keep all
    that was found. Whatever was stopped and when, once it has gone on to as many units the state is the same.
    """

    def __init__(
        self,
        config: CampaignConfig,
        *,
        units: int | None = None,
        seconds: float | None = None,
        workers: int = 1,
        crew: Crew | None = None,
        ledger: Ledger | None = None,
        is_known: Callable[[World], bool] = lambda _: False,
    ) -> None:
        self._is_known = is_known
        self.config, self.units, self.seconds = config, units, seconds
        self.state = CampaignState()
        self._crew: Crew = crew or crew_of(workers)
        self._ledger = ledger or Ledger()
        self._candidates: dict[str, list[World]] = {}  # by class, those that are shrunk
        self._known_ones: dict[str, list[World]] = {}  # likewise, those that would be were their class no known one
        self._kept_whole: set[str] = set()  # classes that are shrunk once more, keeping the class
        self._known = [Memory(), Memory()]  # by epoch
        self._jobs: list[_Job] = []  # that wait for a worker
        self._next = 0  # unit
        self._began: float | None = None  # this sitting, when it had gone through the ledger
        self._searched = 0.0  # s, of this sitting, when the last unit was merged
        self._before = 0.0  # s, of earlier sittings

    def pending(self) -> dict[str, World]:
        """Failures by class that are proved but not shrunk yet; of use after an interruption, or when time is up."""
        best = self.state.best
        return {kind: min(worlds, key=_size) for kind, worlds in self._candidates.items() if kind not in best}

    def run(self) -> Generator[Progress, None, None]:
        """Does the campaign, or what is left of it."""
        merged = 0
        units: dict[int, _Under[UnitResult]] = {}
        shrinks: list[tuple[_Job, _Under[World]]] = []
        with self._crew as crew:
            while True:
                self._hand_out(crew, units, shrinks)
                if not units and not shrinks:
                    self._queue(self._slid(), shrinks)
                    if not shrinks and (not self._jobs or self._is_over()):
                        return
                    continue
                self._wait(crew, [*(one.future for one in units.values()), *(one.future for _, one in shrinks)])
                while merged in units and units[merged].future.done():
                    self._queue(self._merge(merged, units[merged]), shrinks)
                    yield UnitDone(merged, self.state, units.pop(merged).seconds is not None)
                    merged += 1
                    yield from self._kept(shrinks)
                yield from self._kept(shrinks)

    def _hand_out(
        self, crew: Crew, units: dict[int, _Under[UnitResult]], shrinks: list[tuple[_Job, _Under[World]]]
    ) -> None:
        """Gives each free worker something to do.

        The first failure of each class is shrunk before more is searched, the others after it, or when most of the time
        is gone. What order it is done in changes nothing of the result, but for what an end of the time leaves.
        """
        while len(units) + len(shrinks) < crew.room:
            job, unit = self._next_job(self._is_over(_SEARCH)), None
            if job is None:
                unit = self._unit(crew, self._next)
            if unit is not None:
                units[self._next], self._next = unit, self._next + 1
                continue
            job = job or self._next_job(any_of_class=True)
            if job is None:
                return
            shrinks.append((job, _Under(crew.submit(shrunk_or_same, job.failure, job.kept))))

    def _next_job(self, any_of_class: bool) -> _Job | None:
        """A failure to be shrunk, those first that are first of their class; ``None`` when there is no more time."""
        if self._is_over():
            return None
        job = min(self._jobs, key=lambda one: one.before, default=None)
        if job is None or (job.before and not any_of_class):
            return None
        self._jobs.remove(job)
        return job

    def _queue(self, jobs: list[_Job], shrinks: list[tuple[_Job, _Under[World]]]) -> None:
        """Puts what is to be shrunk with what waits; with what is done if it needs no work."""
        for job in jobs:
            done = self._ledger.shrunk(job.failure, job.kept) if self.config.shrink else job.failure
            if done is None:
                self._jobs.append(job)
            else:
                shrinks.append((job, _Under(_finished(done), 0.0)))

    def _is_over(self, share: float = 1.0) -> bool:
        """Whether so much of the time is gone; some of it is always left to shrink what the last units found."""
        if self.units is not None or self.seconds is None:
            return False
        until = share * self.seconds
        return self._sat() >= (until if share < 1.0 else max(until, self._searched + max(_TO_SHRINK, until / 4)))

    def _unit(self, crew: Crew, unit: int) -> _Under[UnitResult] | None:
        """Begins a unit, or takes it from the ledger; ``None`` if it knows too little yet, or there were enough."""
        if unit // self.config.epoch >= len(self._known) or (self.units is not None and unit >= self.units):
            return None
        done = self._ledger.unit(unit)
        if done is not None:
            self._before = max(self._before, done.seconds)
            return _Under(_finished(done.result), done.seconds)
        if self._began is None:
            self._began = time.monotonic()
        if self.units is None and self.seconds is not None and self._sat() >= self.seconds:
            return None
        return _Under(crew.submit(run_unit, self.config, unit, self._known[unit // self.config.epoch]))

    def _wait(self, crew: Crew, under_way: list[Future[Any]]) -> None:
        while not wait(under_way, LISTEN, return_when=FIRST_COMPLETED).done:
            crew.listen()
        crew.listen()

    def _merge(self, unit: int, under: _Under[UnitResult]) -> list[_Job]:
        """Adds a unit's result and remembers it; returns what is to be shrunk, the same for any timing."""
        state, result = self.state, under.future.result()
        self._searched = self._sat()
        state.seconds = self._before + self._searched if under.seconds is None else under.seconds
        state.units = unit + 1
        state.worlds += result.worlds
        state.steps += result.steps
        state.verdicts += result.verdicts
        state.met += result.met
        jobs = []
        kept: dict[str, World] = {}
        for kind, failure in sorted(result.failures.items()):
            is_known = self._is_known(failure)
            candidates = self._known_ones if is_known else self._candidates
            is_news, few = state.memory.is_news(kind, failure), len(candidates.get(kind, ())) < _RESTARTS
            if is_news:
                totals = (state.worlds, state.steps, state.seconds)
                state.finds.append(Find(unit, result.lane, kind, failure, *totals))
            if is_news or (few and self.config.shrink):
                kept[kind] = failure
            if is_known:
                state.known[kind] += result.met[kind]
            if few if self.config.shrink else is_news:
                jobs += [] if is_known else [_Job(failure, before=len(candidates.get(kind, ())))]
                candidates.setdefault(kind, []).append(failure)
        elites = {cell: elite for cell, elite in result.elites.items() if state.memory.is_better(cell, elite)}
        result = replace(result, failures=kept, elites=elites)  # so that the memory is in the ledger's order, too
        if under.seconds is None:
            self._ledger.save_unit(unit, Done(result, state.seconds))
        state.memory = state.memory.after(result)
        if (unit + 1) % self.config.epoch == 0:
            self._known.append(state.memory)
        return jobs

    def _sat(self) -> float:
        """Seconds of this sitting."""
        return 0.0 if self._began is None else time.monotonic() - self._began

    def _slid(self) -> list[_Job]:
        """Once all else is done: of classes whose worlds all slid into other classes the smallest failure."""
        kinds = [
            kind for kind in sorted(self._candidates) if kind not in self.state.best and kind not in self._kept_whole
        ]
        self._kept_whole.update(kinds)
        return [_Job(min(self._candidates[kind], key=_size), "class") for kind in kinds]  # each takes a second

    def _kept(self, shrinks: list[tuple[_Job, _Under[World]]]) -> Iterator[Found]:
        """Takes what has been shrunk out of the list, remembers it and keeps the smallest of each class."""
        for job, under in [one for one in shrinks if one[1].future.done()]:
            shrinks.remove((job, under))
            shrunk = under.future.result()
            if under.seconds is None:
                self._ledger.save_shrunk(job.failure, job.kept, shrunk)
            if self._is_known(shrunk):  # it slid there from a class that is news, which has its turn in the end
                continue
            kind = class_of(shrunk)
            before = self.state.best.get(kind)
            if before is None or _size(shrunk) < _size(before):
                self.state.best[kind] = shrunk
                yield Found(kind, shrunk, before is not None)


def shrunk_or_same(failure: World, kept: str = "verdict") -> World:
    """The failure shrunk, with where it begins; as it was if it does not hold by shrinking's own terms.

    Args:
        failure: As it was found.
        kept: What shrinking keeps, as :func:`fuzz.shrink.shrink` takes it.
    """
    try:
        return with_boundaries(shrink(failure, keep=kept).world, failure)
    except WorldgenError:
        return failure


def class_of(failure: World) -> str:
    """A failure's class."""
    return str(failure.failure.details["class"]) if failure.failure else ""


def _finished(result: T) -> Future[T]:
    future: Future[T] = Future()
    future.set_result(result)
    return future


def _size(world: World) -> tuple[int, int, bytes]:
    return world.solid_cells, world.width * world.height, dumps(world)
