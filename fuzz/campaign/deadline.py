"""When the work that a campaign hands out is to end."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

__all__ = ["NO_DEADLINE", "TO_HAND_IN", "Deadline", "now", "stop_from", "stopping_from"]

TO_HAND_IN = 3.0  # s after a stop within which running units must return their results
# Seconds after a stop during which earlier failures are still proved; fewer than TO_HAND_IN.
_TO_PROVE = 2.0

_stops: list[
    Callable[[], float]
] = []  # what this process asks besides the clock: when did somebody press Ctrl-C?


def now() -> float:
    """Return the time that deadlines are written in, s.

    The only clock that other processes and machines share.
    """
    return time.time()


def stop_from(stopped_at: Callable[[], float]) -> None:
    """End all work of this process at a time that is not known yet, whatever its deadline.

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
    """When a piece of work is to end.

    Args:
        begin: No world is begun and no run goes on after this time, by :func:`now`.
        prove: What was seen to fail before is proved until then.
    """

    begin: float = math.inf
    prove: float = math.inf

    def to_begin_is_over(self) -> bool:
        """Return whether nothing more is to be begun."""
        return _is_over(min(self.begin, _stopped_at()))

    def to_prove_is_over(self) -> bool:
        """Return whether no proof is to go on."""
        return _is_over(min(self.prove, _stopped_at() + _TO_PROVE))

    def stopped_now(self) -> Deadline:
        """Return the deadline of work that is stopped.

        Nothing more is begun, and proofs get a short time.
        """
        at = now()
        return Deadline(min(self.begin, at), min(self.prove, at + _TO_PROVE))


NO_DEADLINE = Deadline()


def _is_over(end: float) -> bool:
    return end < math.inf and now() >= end


def _stopped_at() -> float:
    return min((stopped_at() for stopped_at in _stops), default=math.inf)
