"""When the work that a campaign hands out is to end."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

__all__ = ["NO_DEADLINE", "Deadline", "now", "stop_when"]

_stopped: list[Callable[[], bool]] = []  # what this process asks besides the clock: did somebody press Ctrl-C?


def now() -> float:
    """Return the time that deadlines are written in, s: the only clock that other processes and machines share."""
    return time.time()


def stop_when(stopped: Callable[[], bool]) -> None:
    """End all work of this process, whatever its deadline, once ``stopped`` says so."""
    _stopped[:] = [stopped]


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
        return _is_over(self.begin)

    def to_prove_is_over(self) -> bool:
        """Return whether no proof is to go on."""
        return _is_over(self.prove)


NO_DEADLINE = Deadline()


def _is_over(end: float) -> bool:
    return (end < math.inf and now() >= end) or any(stopped() for stopped in _stopped)
