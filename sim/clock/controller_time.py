"""Measure how much of this process's time goes into controllers' own code.

That includes the calls of classes, and the time spent waiting for programs. A compiled controller
runs inside the core, where it cannot be measured.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import ParamSpec, Self, TypeVar

from sim.clock.stopping import steps_broken_off

P = ParamSpec("P")
T = TypeVar("T")

MEASURED_EVERY = 17
"""One call in this many is measured, and counts for all of them.

Measuring each call would take a third of a quick class's time. The number is a prime, because a
controller may do its heavy work in every tenth or sixteenth step. The first call is always measured
and counts once, because many controllers do work in it that they do only once.
"""

UNKNOWN_SOURCE = "something that changes between runs, such as a file or another process"
"""What makes equal runs differ if nothing that is known does."""

# Seconds spent in controllers' own code, over the life of this process.
_spent = [0.0]

# What controllers have kept from one run to the next in this process, and when that was last seen.
_survivors: dict[str, float] = {}

# The same about what makes their equal runs differ.
_differences: dict[str, float] = {}

# The same about lines of a controller's file that ran for the first time.
_lines: dict[int, float] = {}


@dataclass(frozen=True)
class Effort:
    """How much time was spent, and how much of it in controllers' own code.

    Args:
        seconds: All of the time, s.
        own: Time in controllers' own code, s.
        broken: Steps that were interrupted because they did not end in time.
        survivors: What was found to survive the controllers' ``reset``, such as ``self.hits``. A
            reading has none; other controllers may have run before it.
        differences: What makes equal runs differ, such as ``time.time() (mine.py:12)``.
        lines: First lines of statements in the controller's file that ran, and had not before in
            this process.
    """

    seconds: float = 0.0
    own: float = 0.0
    broken: int = 0
    survivors: frozenset[str] = frozenset()
    differences: frozenset[str] = frozenset()
    lines: frozenset[int] = frozenset()

    @classmethod
    def so_far(cls) -> Self:
        """Return a reading of this process; the effort is the difference between two readings."""
        return cls(time.perf_counter(), _spent[0], steps_broken_off())

    def since(self) -> Effort:
        """Return the effort since a reading."""
        now = Effort.so_far()
        survivors, differences = (
            frozenset(name for name, seen in names.items() if seen >= self.seconds)
            for names in (_survivors, _differences)
        )
        return Effort(
            now.seconds - self.seconds,
            now.own - self.own,
            now.broken - self.broken,
            survivors,
            differences,
            frozenset(line for line, seen in _lines.items() if seen >= self.seconds),
        )

    def __add__(self, other: Effort) -> Effort:
        """Return the sum of both efforts."""
        return Effort(
            self.seconds + other.seconds,
            self.own + other.own,
            self.broken + other.broken,
            self.survivors | other.survivors,
            self.differences | other.differences,
            self.lines | other.lines,
        )

    @property
    def share(self) -> float:
        """Fraction of the time spent in controllers' own code; 0 before any time has passed."""
        return min(self.own / self.seconds, 1.0) if self.seconds else 0.0


def count_survivors(names: Iterable[str]) -> None:
    """Note that runs changed these parts of a controller and ``reset`` did not clear them."""
    _survivors.update(dict.fromkeys(names, time.perf_counter()))


def count_differences(names: Iterable[str]) -> None:
    """Note that these parts of a controller's surroundings make equal runs differ."""
    names = [*names]
    # What is known replaces what was not.
    if names and UNKNOWN_SOURCE not in names:
        _differences.pop(UNKNOWN_SOURCE, None)
    _differences.update(dict.fromkeys(names, time.perf_counter()))


def count_lines(lines: Iterable[int]) -> None:
    """Note that the statements of a controller's file that begin in these lines ran."""
    _lines.update(dict.fromkeys(lines, time.perf_counter()))


def count_hang(before: float, began: float) -> None:
    """Count the time of steps that were interrupted as the controller's own: the last one hung.

    Args:
        before: What :func:`own_seconds` was before the steps.
        began: When they began, by ``time.perf_counter``.
    """
    _spent[0] = before + time.perf_counter() - began


def own_seconds() -> float:
    """Return the seconds spent in controllers' own code, over the life of this process."""
    return _spent[0]


def timed(call: Callable[P, T], weight: int = 1) -> Callable[P, T]:
    """Wrap a function so that its time counts as a controller's own.

    Args:
        call: The function to measure.
        weight: How many calls each measured call counts for.
    """

    def measured(*args: P.args, **kwargs: P.kwargs) -> T:
        began = time.perf_counter()
        try:
            return call(*args, **kwargs)
        finally:
            _spent[0] += weight * (time.perf_counter() - began)

    return measured
