"""Searches by numbered units: workers do them in any order, and they are merged in order.

Every search hands out work, waits, handles Ctrl-C and ends in this way, whatever it looks for.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

from fuzz.campaign.executors import Executor
from fuzz.campaign.schedule import Schedule
from fuzz.unit.deadline import TO_HAND_IN
from sim.scenario import Scenario
from worldgen.plugins.workers import LISTEN

# Seconds after the end of the time in which results may still arrive.
_GRACE = 1.0
# Units that may be finished before an earlier one is.
_AHEAD = 64


class _Interruptible(Protocol):
    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C cut the unit short, after which the search must end."""


T = TypeVar("T")
ResultT = TypeVar("ResultT", bound=_Interruptible)
EventT = TypeVar("EventT")


@dataclass(frozen=True, eq=False)
class Submitted(Generic[T]):
    """Work that is done or under way, or restored from the store.

    Args:
        future: The pending result.
        seconds: Seconds of the search when it was done in an earlier run; ``None`` for new work.
    """

    future: Future[T]
    seconds: float | None = None

    @classmethod
    def restored(cls, result: T, seconds: float) -> Submitted[T]:
        """Return work that an earlier run did."""
        future: Future[T] = Future()
        future.set_result(result)
        return cls(future, seconds)

    @property
    def is_done(self) -> bool:
        """True if the result is available."""
        return self.future.done()


class UnitSearch(ABC, Generic[ResultT, EventT]):
    """A search by numbered units.

    The results are merged in order of their numbers, so that they do not depend on the workers.

    Args:
        scenarios: The controllers that the units run; they are loaded before the time begins.
        executor: What does the work.
        schedule: The clock.
        units: Number of units; ``None`` if only the time is limited.

    Iterating over :meth:`run` does the work.
    """

    def __init__(
        self,
        scenarios: Sequence[Scenario],
        executor: Executor,
        schedule: Schedule,
        units: int | None,
    ) -> None:
        self.units = units
        self._scenarios = scenarios
        self._executor = executor
        self._schedule = schedule
        # Units that workers have, or whose results wait to be merged.
        self._under_way: dict[int, Submitted[ResultT]] = {}
        # Number of the next unit to hand out, and of the next one to merge.
        self._next = 0
        self._merged = 0

    def run(self) -> Generator[EventT, None, None]:
        """Run the search, or the rest of it.

        Raises:
            KeyboardInterrupt: After Ctrl-C, once the units in progress have returned their results.
            WorkersLost: If the workers ended before the work did.
        """
        with self._executor as executor:
            try:
                yield from self._run(executor)
            except KeyboardInterrupt:
                executor.stop()
                if self._schedule.is_ready:
                    wait([one.future for one in self._under_way.values()], TO_HAND_IN)
                list(self._take_what_is_done())
                raise

    @abstractmethod
    def _hand_out_one(self, executor: Executor) -> bool:
        """Begin one piece of work, or return False if nothing may begin now."""

    @abstractmethod
    def _merge(self, unit: int, submitted: Submitted[ResultT]) -> Iterator[EventT]:
        """Add a unit's result, and yield what has changed."""

    def _has_enough(self) -> bool:
        """Return True once the units merged so far have reached the goal."""
        return False

    def _is_exhausted(self) -> bool:
        """Return True if nothing is left to do; called when no work is in progress."""
        return True

    def _others(self) -> Sequence[Submitted[Any]]:
        """Return the work in progress besides the units."""
        return ()

    def _take_others(self) -> Iterator[EventT]:
        """Collect the results of :meth:`_others` that are finished."""
        yield from ()

    def _has_more_units(self) -> bool:
        return self.units is None or self._next < self.units

    def _add_unit(self, submitted: Submitted[ResultT]) -> None:
        self._under_way[self._next] = submitted
        self._next += 1

    def _run(self, executor: Executor) -> Generator[EventT, None, None]:
        while not self._has_enough():
            self._hand_out(executor)
            if not self._under_way and not self._others():
                if self._is_exhausted():
                    return
                continue
            self._wait(executor)
            yield from self._merge_in_order()
            yield from self._take_others()
            if self._schedule.is_over(_GRACE):
                yield from self._take_what_is_done()
                break
        # Do not wait for work that is no longer needed, or does not end in time.
        if self._under_way or self._others():
            executor.stop()

    def _hand_out(self, executor: Executor) -> None:
        """Give each free worker something to do."""
        while (
            self._occupied() < executor.room
            and len(self._under_way) < executor.room + _AHEAD
            and self._hand_out_one(executor)
        ):
            pass

    def _occupied(self) -> int:
        """Return the number of workers that have work, or a result that must be merged first.

        Units that come after an unfinished one do not keep a worker busy.
        """
        units = list(self._under_way.values())
        if self._merged in self._under_way and not self._under_way[self._merged].is_done:
            units = [one for one in units if not one.is_done]
        return len(units) + len(self._others())

    def _get_ready(self, executor: Executor) -> None:
        """Wait until everything is loaded; the time begins then."""
        loading = [] if self._schedule.is_unlimited else executor.prepare(self._scenarios)
        while loading and wait(loading, LISTEN).not_done:
            executor.listen()
        self._schedule.begin(max((one.result() for one in loading), default=0.0))

    def _wait(self, executor: Executor) -> None:
        # Units after the next one to merge don't wake us up.
        units = [
            one for unit, one in self._under_way.items() if unit == self._merged or not one.is_done
        ]
        others = self._others()
        futures: list[Future[Any]] = [one.future for one in (*units, *others)]
        with self._schedule.doing(len(units), len(others)):
            while not wait(
                futures, LISTEN, return_when=FIRST_COMPLETED
            ).done and not self._schedule.is_over(_GRACE):
                executor.listen()
        executor.listen()

    def _merge_in_order(self) -> Iterator[EventT]:
        while self._merged in self._under_way and self._under_way[self._merged].is_done:
            unit = self._merged
            submitted = self._under_way.pop(unit)
            self._merged += 1
            yield from self._merge(unit, submitted)
            if submitted.future.result().interrupted:
                raise KeyboardInterrupt
            if self._has_enough():
                return

    def _take_what_is_done(self) -> Iterator[EventT]:
        """At the end, merge the units that are done, including those after an unfinished one.

        The unfinished one has lost its turn.
        """
        for unit, submitted in sorted(self._under_way.items()):
            if submitted.is_done:
                del self._under_way[unit]
                if not submitted.future.cancelled() and submitted.future.exception() is None:
                    yield from self._merge(unit, submitted)
        yield from self._take_others()
