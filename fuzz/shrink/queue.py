"""Choose, order and shrink a campaign's failures."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from typing import Any

from fuzz.boundary import with_boundaries
from fuzz.failure import Failure
from fuzz.shrink import shrink
from fuzz.simplicity import FailureOrder
from fuzz.unit.deadline import Deadline
from fuzz.unit.result import FailureKey
from sim.clock.controller_time import Effort
from sim.clock.stopping import OutOfTime, check_time, is_out_of_time, stopping_when
from sim.controllers.catalogue.renewal import as_loaded
from worldgen.errors import WorldgenError

# Number of failures of each cause that are shrunk: three are shown, and the first one found rarely
# leads to the smallest.
MOST_SHRUNK = 4

SHRINKING_SECONDS = 30.0
"""Seconds of a slow controller's steps for shrinking one failure without a time limit.

A campaign of units would otherwise spend most of its time on it, up to an hour.
"""


@dataclass(frozen=True)
class Shrinking:
    """The result of shrinking.

    Args:
        failure: The failure.
        complete: True if shrinking finished before the time was up.
        effort: How it spent its time.
    """

    failure: Failure
    complete: bool = True
    effort: Effort = field(default_factory=Effort)


@dataclass(frozen=True, eq=False)
class ShrinkJob:
    """A failure that waits to be shrunk.

    Args:
        failure: The failure as found.
        before: Number of failures of its group that are shrunk before it.
    """

    failure: Failure
    before: int = 0


class ShrinkQueue:
    """Failures that wait to be shrunk, by group and urgency.

    Args:
        shrinks: Whether failures are shrunk at all.
        by_size: Whether small failures go first, so that most get done in time. Otherwise they keep
            their order, which does not depend on timing.
    """

    def __init__(self, *, shrinks: bool, by_size: bool) -> None:
        self._shrinks = shrinks
        self._order: Callable[[ShrinkJob], Any] = _by_size if by_size else _by_turn
        self._waiting: list[ShrinkJob] = []
        # Failures that have been queued, by group.
        self._queued: dict[str, list[Failure]] = {}
        # Failures that would have been queued if their group were not known, by group.
        self._known: dict[str, list[Failure]] = {}

    def __len__(self) -> int:
        return len(self._waiting)

    def job_for(
        self, failure: Failure, *, is_known: bool, is_interesting: bool
    ) -> ShrinkJob | None:
        """Return the work on a new failure.

        It is ``None`` if enough of its group are shrunk, or shrinking is off.

        Args:
            failure: The failure as found.
            is_known: Whether it is known. Such failures are counted, but not shrunk.
            is_interesting: Whether it is the first or the smallest with its key. Without shrinking,
                only these matter.
        """
        groups = self._known if is_known else self._queued
        before = len(groups.get(failure.group, ()))
        if not (before < MOST_SHRUNK if self._shrinks else is_interesting):
            return None
        groups.setdefault(failure.group, []).append(failure)
        return None if is_known else ShrinkJob(failure, before)

    def add(self, job: ShrinkJob) -> None:
        """Add a failure to the queue."""
        self._waiting.append(job)

    def take(self, *, first_only: bool = False) -> ShrinkJob | None:
        """Remove the most urgent failure and return it, the first of each group before others.

        Args:
            first_only: Return ``None`` if only others wait.
        """
        job = min(self._waiting, key=self._order, default=None)
        if job is None or (job.before and first_only):
            return None
        self._waiting.remove(job)
        return job

    def as_urgent_as(self, job: ShrinkJob) -> int:
        """Return the number of waiting failures that are at least as urgent."""
        return sum(one.before <= job.before for one in self._waiting)

    def unshrunk(self, best: Iterable[FailureKey]) -> list[Failure]:
        """Return the smallest failure of each group that has no shrunk one.

        Args:
            best: Keys of the shrunk failures.
        """
        done = {group for group, _ in best}
        return [
            min(waiting, key=lambda failure: failure.order)
            for group, waiting in self._queued.items()
            if group not in done
        ]


def _by_turn(job: ShrinkJob) -> tuple[int]:
    return (job.before,)


def _by_size(job: ShrinkJob) -> tuple[int, FailureOrder]:
    """Return the first failure of each group, smallest first, so that most get done in time."""
    return min(job.before, 1), job.failure.order


def shrunk_or_same(
    failure: Failure,
    *,
    seconds: float | None = None,
    end: float = math.inf,
    most_steps: float = math.inf,
) -> Shrinking:
    """Return the shrunk failure with its boundaries.

    It is returned unchanged if it is not reproducible by shrinking's own criteria.

    Args:
        failure: The failure as found.
        seconds: Time limit, after which the best result so far is used.
        end: Time by :func:`fuzz.unit.deadline.now`: if the result isn't proved by then, the
            failure stays unchanged.
        most_steps: Limit on the steps of shrinking, after which the best result so far is the
            result.
    """
    began = Effort.so_far()
    as_loaded(failure.record.controller)
    made = _shrunk_or_same(failure, seconds, end, most_steps)
    return replace(made, effort=began.since())


def _shrunk_or_same(
    failure: Failure, seconds: float | None, end: float, most_steps: float
) -> Shrinking:
    try:
        with stopping_when(Deadline(end, end).to_begin_is_over):
            check_time()
            made = shrink(failure, seconds=seconds, most_steps=most_steps)
            # A limit on the steps gives the same result whenever it is reached, and so is final.
            if not made.complete:
                is_final = seconds is None and not is_out_of_time()
                return Shrinking(made.failure, complete=is_final)
            try:
                return Shrinking(with_boundaries(made.failure, failure))
            except OutOfTime:
                # It is already shrunk and proved; a later run measures its boundaries.
                return Shrinking(made.failure, complete=False)
    except OutOfTime:
        return Shrinking(failure, complete=False)
    except WorldgenError:
        return Shrinking(failure)
