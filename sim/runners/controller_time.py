"""How much of this process's time goes into controllers' own code.

Classes that act, and programs that are waited for. A compiled controller is part of a kernel, where
nothing can be measured.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import ParamSpec, Self, TypeVar

from sim.runners.stopping import steps_broken_off

__all__ = ["MEASURED_EVERY", "Effort", "timed"]

P = ParamSpec("P")
T = TypeVar("T")

MEASURED_EVERY = 17
"""One call in so many is measured and counts for all.

Measuring each would take a third of a quick class's time. It is a prime, because a controller may
do its heavy work in every tenth or sixteenth step. The first call is always measured, and counts
    once: many controllers do in it what they do only once.
"""

_spent = [0.0]  # s of this process, in all


@dataclass(frozen=True)
class Effort:
    """Where time went.

    Args:
        seconds: In all.
        own: Of these, in controllers' own code.
        broken: Steps that were broken off, because they did not end when the time was over.
    """

    seconds: float = 0.0
    own: float = 0.0
    broken: int = 0

    @classmethod
    def so_far(cls) -> Self:
        """Return a reading of this process; the difference of two is the effort between them."""
        return cls(time.perf_counter(), _spent[0], steps_broken_off())

    def since(self) -> Effort:
        """Return the effort since a reading."""
        now = Effort.so_far()
        return Effort(now.seconds - self.seconds, now.own - self.own, now.broken - self.broken)

    def __add__(self, other: Effort) -> Effort:
        """Return both together."""
        return Effort(
            self.seconds + other.seconds, self.own + other.own, self.broken + other.broken
        )

    @property
    def share(self) -> float:
        """Share of the time that went into controllers' own code; 0 if there was no time."""
        return min(self.own / self.seconds, 1.0) if self.seconds else 0.0


def timed(call: Callable[P, T], weight: int = 1) -> Callable[P, T]:
    """Return a function that does the same, and counts as a controller's own code.

    Args:
        call: What is measured.
        weight: For how many calls each one counts.
    """

    def measured(*args: P.args, **kwargs: P.kwargs) -> T:
        began = time.perf_counter()
        try:
            return call(*args, **kwargs)
        finally:
            _spent[0] += weight * (time.perf_counter() - began)

    return measured
