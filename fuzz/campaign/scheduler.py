"""The loop of every campaign: hand out work, wait for results, and merge them.

A goal decides what the next piece of work is and what a result means. Handing out, order, Ctrl-C
and the end of the time are the same for all goals.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Generic, TypeVar

from fuzz.campaign.executors import Executor
from fuzz.campaign.schedule import Schedule
from fuzz.unit.deadline import TO_HAND_IN
from sim.scenario import Scenario
from worldgen.plugins.workers import LISTEN

# Seconds after the end of the time in which results may still arrive.
_GRACE = 1.0
# Units that may be finished before an earlier one is.
_AHEAD = 64

T = TypeVar("T")
EventT = TypeVar("EventT")


@dataclass(eq=False)
class Work(Generic[EventT]):
    """A piece of work.

    Args:
        call: A pure function with its arguments, which any worker may run.
        take: Merges the result, and returns what has changed.
        is_unit: True for the next unit: units are merged in order, and the campaign ends as if by
            Ctrl-C if one returns a result that is ``interrupted``. Other results are merged as soon
            as they are available.
        future: The result.
    """

    call: partial[Any]
    take: Callable[[Any], Iterable[EventT]]
    is_unit: bool = True
    future: Future[Any] = field(default_factory=Future)

    @classmethod
    def done(cls, result: T, take: Callable[[T], Iterable[EventT]]) -> Work[EventT]:
        """Return a unit that an earlier run did."""
        work = cls(partial(lambda: result), take)
        work.future.set_result(result)
        return work


class Goal(ABC, Generic[EventT]):
    """What a campaign looks for."""

    @abstractmethod
    def next_work(self) -> Work[EventT] | None:
        """Return the next piece of work, or ``None`` if nothing may begin now."""

    def is_reached(self) -> bool:
        """Return True once the units merged so far are enough, whatever is left to do."""
        return False

    def conclude(self) -> Iterable[EventT]:
        """Yield what the work ends with, while the workers are still there."""
        return ()


class Scheduler:
    """Runs the work of a goal.

    The results of units are merged in order of their numbers, so that they do not depend on the
    workers.

    Args:
        scenarios: The controllers that the units run; they are loaded before the time begins.
        executor: What does the work.
        schedule: The clock.
        units: Number of units; ``None`` if only the time is limited.
    """

    def __init__(
        self,
        scenarios: Sequence[Scenario],
        executor: Executor,
        schedule: Schedule,
        units: int | None,
    ) -> None:
        self.executor = executor
        self.schedule = schedule
        # Units that workers have, or whose results wait to be merged, by number; and other work.
        self.units: dict[int, Work[Any]] = {}
        self.others: list[Work[Any]] = []
        # Work that is being handed out. A single worker is this process, which does it meanwhile.
        self._begun: Work[Any] | None = None
        # Number of the next unit to hand out, and of the next one to merge.
        self.next_unit = 0
        self.next_merged = 0
        self._scenarios = scenarios
        self._limit = units

    @property
    def has_more_units(self) -> bool:
        """True unless the number of units is limited and all are handed out."""
        return self._limit is None or self.next_unit < self._limit

    @property
    def is_searching(self) -> bool:
        """True while units are in progress, or wait to be merged."""
        begun = self._begun
        return bool(self.units) or (begun is not None and begun.is_unit)

    @property
    def others_in_progress(self) -> int:
        """Number of pieces of other work in progress."""
        begun = self._begun
        return len(self.others) + (begun is not None and not begun.is_unit)

    def run(self, goal: Goal[EventT]) -> Generator[EventT, None, None]:
        """Work until the goal is reached, the time is over, or nothing is left to do.

        Raises:
            KeyboardInterrupt: After Ctrl-C, once the units in progress have returned their results.
            WorkersLost: If the workers ended before the work did.
        """
        with self.executor as executor:
            try:
                while not goal.is_reached():
                    # Give each free worker something to do.
                    while self._has_room() and (work := goal.next_work()) is not None:
                        if not work.future.done():
                            self._begun = work
                            with self.schedule.doing(work.is_unit, not work.is_unit):
                                call = work.call
                                work.future = executor.submit(
                                    call.func, *call.args, **call.keywords
                                )
                        self._keep(work)
                        self._begun = None
                    if not (self.units or self.others):
                        break
                    # Merge what is finished.
                    self._wait()
                    for work in self._finished():
                        result = work.future.result()
                        yield from work.take(result)
                        if work.is_unit and result.interrupted:
                            raise KeyboardInterrupt
                        if goal.is_reached():
                            break
                    if self.schedule.is_over(_GRACE):
                        for work in self._all_finished():
                            yield from work.take(work.future.result())
                        break
                # Do not wait for work that is no longer needed, or does not end in time.
                if self.units or self.others:
                    executor.stop()
                yield from goal.conclude()
            except KeyboardInterrupt:
                executor.stop()
                if self.schedule.is_ready:
                    wait([one.future for one in self.units.values()], TO_HAND_IN)
                for work in self._all_finished():
                    list(work.take(work.future.result()))
                raise

    def get_ready(self) -> None:
        """Wait until everything is loaded, when the time begins; called before any new work."""
        if self.schedule.is_ready:
            return
        loading = [] if self.schedule.is_unlimited else self.executor.prepare(self._scenarios)
        while loading and wait(loading, LISTEN).not_done:
            self.executor.listen()
        self.schedule.begin(max((one.result() for one in loading), default=0.0))

    def _keep(self, work: Work[Any]) -> None:
        if work.is_unit:
            self.units[self.next_unit] = work
            self.next_unit += 1
        else:
            self.others.append(work)

    def _has_room(self) -> bool:
        """Return True if a worker is free, and not too many results wait for an earlier one.

        Units that come after an unfinished one do not keep a worker busy.
        """
        units = list(self.units.values())
        if self.next_merged in self.units and not self.units[self.next_merged].future.done():
            units = [one for one in units if not one.future.done()]
        room = self.executor.room
        return len(units) + len(self.others) < room and len(self.units) < room + _AHEAD

    def _wait(self) -> None:
        # Units after the next one to merge don't wake us up.
        units = [
            one
            for unit, one in self.units.items()
            if unit == self.next_merged or not one.future.done()
        ]
        futures = [one.future for one in (*units, *self.others)]
        with self.schedule.doing(len(units), len(self.others)):
            while not wait(
                futures, LISTEN, return_when=FIRST_COMPLETED
            ).done and not self.schedule.is_over(_GRACE):
                self.executor.listen()
        self.executor.listen()

    def _finished(self) -> Iterator[Work[Any]]:
        """Yield the finished work: units in order of their numbers, then the rest."""
        while self.next_merged in self.units and self.units[self.next_merged].future.done():
            self.next_merged += 1
            yield self.units.pop(self.next_merged - 1)
        for work in [one for one in self.others if one.future.done()]:
            self.others.remove(work)
            yield work

    def _all_finished(self) -> Iterator[Work[Any]]:
        """Yield the finished work at the end, including units after an unfinished one.

        Units that are still running are skipped, and so is work that failed.
        """
        for unit, work in sorted(self.units.items()):
            if work.future.done():
                del self.units[unit]
                if not work.future.cancelled() and work.future.exception() is None:
                    yield work
        for work in [one for one in self.others if one.future.done()]:
            self.others.remove(work)
            yield work
