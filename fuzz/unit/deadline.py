"""Deadlines for the work that a campaign distributes."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

# Seconds after a stop within which running units must return their results.
TO_HAND_IN = 3.0
# Seconds after a stop during which earlier failures are still proved; less than TO_HAND_IN.
_TO_PROVE = 2.0

# In addition to the clock, this process also calls these, to learn when Ctrl-C was pressed.
_stops: list[Callable[[], float]] = []


def now() -> float:
    """Return the current time, s, by the clock of deadlines.

    It is the only clock that other processes and machines share.
    """
    return time.time()


def stop_from(stopped_at: Callable[[], float]) -> None:
    """End all work of this process at a time still unknown, regardless of its deadline.

    Args:
        stopped_at: Returns that time, by :func:`now`; infinity until it is known.
    """
    _stops[:] = [stopped_at]


@contextlib.contextmanager
def stopping_from(stopped_at: Callable[[], float]) -> Iterator[None]:
    """End work inside as :func:`stop_from` does."""
    before = [*_stops]
    _stops.append(stopped_at)
    try:
        yield
    finally:
        _stops[:] = before


@dataclass(frozen=True)
class Deadline:
    """The deadline of a piece of work.

    Args:
        begin: After this time, by :func:`now`, no world is begun and no run continues.
        prove: Failures seen before are proved until then.
    """

    begin: float = math.inf
    prove: float = math.inf

    def to_begin_is_over(self) -> bool:
        """Return True if no further work may begin."""
        return _is_over(min(self.begin, _stopped_at()))

    def to_prove_is_over(self) -> bool:
        """Return True if no proof may continue."""
        return _is_over(min(self.prove, _stopped_at() + _TO_PROVE))

    def stopped_now(self) -> Deadline:
        """Return the deadline of work that is stopped.

        No new work begins, and proofs get a short time.
        """
        at = now()
        return Deadline(min(self.begin, at), min(self.prove, at + _TO_PROVE))


NO_DEADLINE = Deadline()


def _is_over(end: float) -> bool:
    return end < math.inf and now() >= end


def _stopped_at() -> float:
    return min((stopped_at() for stopped_at in _stops), default=math.inf)
