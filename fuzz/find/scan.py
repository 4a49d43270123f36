"""Scan an axis: a campaign that ends when every change of outcome is between neighbouring values."""

from __future__ import annotations

import itertools
from collections.abc import Generator, Iterator
from dataclasses import dataclass
from functools import partial

from fuzz.boundary import Axis, BoundaryRun, BoundaryRuns, Subject
from fuzz.campaign.executors import local_executor
from fuzz.campaign.schedule import Schedule
from fuzz.campaign.scheduler import Goal, Scheduler, Work


@dataclass(frozen=True)
class Stretch:
    """Values of an axis, from ``first`` to ``last``, with the same outcome in all runs of the scan.

    Args:
        outcome: ``arrives``, ``fails``, or ``no proof`` if the target is not provably reachable or
            there is no such scenario.
        first: Smallest value.
        last: Largest value.
        verdicts: The different verdicts of its runs.
        runs: Number of runs.
    """

    outcome: str
    first: float
    last: float
    verdicts: tuple[str, ...]
    runs: int


class AxisScan(Goal[BoundaryRun]):
    """Runs values of an axis, and bisects between neighbours of different outcome.

    Nothing between two values of equal outcome is run, so a double change between them is missed.

    Args:
        subject: The scenario.
        axis: The number to vary.
        indices: Ascending indices of the values to run first.

    Iterating over :meth:`run` does the work and yields each run; :meth:`stretches` has the results,
    even after Ctrl-C.
    """

    def __init__(self, subject: Subject, axis: Axis, indices: range) -> None:
        self._scheduler = Scheduler([subject.scenario], local_executor(1), Schedule(None), None)
        self._axis = axis
        self._looks = BoundaryRuns(subject, axis)
        self._first = iter(indices)
        self._runs: dict[int, BoundaryRun | None] = {}

    def run(self) -> Generator[BoundaryRun, None, None]:
        """Run the scan, as :meth:`fuzz.campaign.scheduler.Scheduler.run` does."""
        return self._scheduler.run(self)

    def next_work(self) -> Work[BoundaryRun] | None:
        """Return the next value to run: those given, then those between different outcomes."""
        index = next(self._first, None)
        if index is None:
            index = next(
                (
                    (low + high) // 2
                    for low, high in itertools.pairwise(sorted(self._runs))
                    if high - low > 1 and self._outcome(low) != self._outcome(high)
                ),
                None,
            )
        if index is None:
            return None
        return Work(partial(self._looks, index), partial(self._take, index), is_unit=False)

    def stretches(self) -> list[Stretch]:
        """Return the values run so far, with neighbours of equal outcome joined."""
        joined = itertools.groupby(sorted(self._runs), self._outcome)
        return [self._stretch(outcome, [*indices]) for outcome, indices in joined]

    def _take(self, index: int, look: BoundaryRun | None) -> Iterator[BoundaryRun]:
        self._runs[index] = look
        if look is not None:
            yield look

    def _outcome(self, index: int) -> str:
        look = self._runs[index]
        return "no proof" if look is None else "arrives" if look.arrives else "fails"

    def _stretch(self, outcome: str, indices: list[int]) -> Stretch:
        looks = [look for index in indices if (look := self._runs[index]) is not None]
        verdicts = dict.fromkeys(look.outcome.verdict for look in looks)
        first, last = (self._axis.value(index) for index in (indices[0], indices[-1]))
        return Stretch(outcome, first, last, tuple(verdicts), len(indices))
