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
    """

    failure: World
    kept: str


class Campaign:
    """A budgeted search.

    Args:
        config: What to look for.
        units: Amount of work; the corpus then depends on the seed alone.
        seconds: Stop handing out work after this time; ignored if ``units`` is given.
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
        self._began: float | None = None  # this sitting, when it had gone through the ledger
        self._before = 0.0  # s, of earlier sittings

    def pending(self) -> dict[str, World]:
        """Failures by class that are proved but not shrunk yet; of use after an interruption."""
        best = self.state.best
        return {kind: min(worlds, key=_size) for kind, worlds in self._candidates.items() if kind not in best}

    def run(self) -> Generator[Progress, None, None]:
        """Does the campaign, or what is left of it."""
        submitted, merged = 0, 0
        units: dict[int, _Under[UnitResult]] = {}
        shrinks: list[tuple[_Job, _Under[World]]] = []
        with self._crew as crew:
            while True:
                while self._takes_more(crew, len(units), submitted) and (unit := self._unit(crew, submitted)):
                    units[submitted], submitted = unit, submitted + 1
                if not units and not shrinks:
                    shrinks = [(job, self._shrink(crew, job)) for job in self._slid()]
                    if not shrinks:
                        return
                self._wait(crew, [*(one.future for one in units.values()), *(one.future for _, one in shrinks)])
                while merged in units and units[merged].future.done():
                    jobs = self._merge(merged, units[merged])
                    yield UnitDone(merged, self.state, units.pop(merged).seconds is not None)
                    merged += 1
                    for job in jobs:
                        shrinks.append((job, self._shrink(crew, job)))
                        yield from self._kept(shrinks)
                yield from self._kept(shrinks)

    def _takes_more(self, crew: Crew, under_way: int, unit: int) -> bool:
        """Whether a worker is free for a unit, and what the unit is to know is known."""
        return under_way < crew.room and unit // self.config.epoch < len(self._known)

    def _unit(self, crew: Crew, unit: int) -> _Under[UnitResult] | None:
        """Begins a unit, or takes it from the ledger; ``None`` if the campaign has done enough."""
        if self.units is not None and unit >= self.units:
            return None
        done = self._ledger.unit(unit)
        if done is not None:
            return _Under(_finished(done.result), done.seconds)
        if self._began is None:
            self._began = time.monotonic()
        if self.units is None and self.seconds is not None and time.monotonic() - self._began >= self.seconds:
            return None
        return _Under(crew.submit(run_unit, self.config, unit, self._known[unit // self.config.epoch]))

    def _wait(self, crew: Crew, under_way: list[Future[Any]]) -> None:
        while not wait(under_way, LISTEN, return_when=FIRST_COMPLETED).done:
            crew.listen()
        crew.listen()

    def _merge(self, unit: int, under: _Under[UnitResult]) -> list[_Job]:
        """Adds a unit's result and remembers it; returns what is to be shrunk, the same for any timing."""
        state, result = self.state, under.future.result()
        state.seconds = self._clock() if under.seconds is None else under.seconds
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
                candidates.setdefault(kind, []).append(failure)
                jobs += [] if is_known else [_Job(failure, "verdict")]
        elites = {cell: elite for cell, elite in result.elites.items() if state.memory.is_better(cell, elite)}
        result = replace(result, failures=kept, elites=elites)  # so that the memory is in the ledger's order, too
        if under.seconds is None:
            self._ledger.save_unit(unit, Done(result, state.seconds))
        state.memory = state.memory.after(result)
        if (unit + 1) % self.config.epoch == 0:
            self._known.append(state.memory)
        return jobs

    def _clock(self) -> float:
        """Seconds of all sittings."""
        return self._before + (0.0 if self._began is None else time.monotonic() - self._began)

    def _shrink(self, crew: Crew, job: _Job) -> _Under[World]:
        if not self.config.shrink:
            return _Under(_finished(job.failure), 0.0)
        before = self._ledger.shrunk(job.failure, job.kept)
        if before is not None:
            return _Under(_finished(before), 0.0)
        return _Under(crew.submit(shrunk_or_same, job.failure, job.kept))

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
