"""Ends runs that are under way when whoever asked for them has no more time: a campaign whose budget is spent, say.

A run of a Python controller may take minutes, and nothing but the run itself can end it without harm. So it asks.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import NamedTuple

__all__ = ["OutOfTime", "check_time", "in_time", "is_out_of_time", "stopping_when"]

_MOST_STEPS = 16  # steps between two looks at the clock, of a fast controller
_SLOW = 0.1  # s: after a batch of steps that took longer, each step is looked at


class _Watch(NamedTuple):
    """What ends the runs, and the clock (s) by which their steps are measured."""

    is_over: Callable[[], bool]
    clock: Callable[[], float]


_watch: ContextVar[_Watch | None] = ContextVar("watch", default=None)


class OutOfTime(BaseException):
    """Raised in the middle of work that has no more time; no ``Exception``, lest it pass for a controller's fault."""


@contextmanager
def stopping_when(is_over: Callable[[], bool], clock: Callable[[], float] = time.monotonic) -> Iterator[None]:
    """End what is done inside with :class:`OutOfTime` once ``is_over`` returns True; an outer one no longer counts.

    Args:
        is_over: Returns True when there is no more time.
        clock: Seconds, by which slow steps are told from fast ones.
    """
    token = _watch.set(_Watch(is_over, clock))
    try:
        yield
    finally:
        _watch.reset(token)


def is_out_of_time() -> bool:
    """Return whether the time is over."""
    watch = _watch.get()
    return watch is not None and watch.is_over()


def check_time() -> None:
    """Look at the clock once.

    Raises:
        OutOfTime: If the time is over.
    """
    if is_out_of_time():
        raise OutOfTime


def in_time(steps: Iterable[int]) -> Iterable[int]:
    """Return the same steps, with a look at the clock every few of them: before each one if they are slow.

    Raises:
        OutOfTime: While iterating, once the time is over.
    """
    watch = _watch.get()
    return steps if watch is None else itertools.chain.from_iterable(_batches(iter(steps), watch))


def _batches(steps: Iterator[int], watch: _Watch) -> Iterator[Iterable[int]]:
    """Yield short runs of steps; chained in C, they cost a step nothing that could be measured."""
    size = 1
    began = watch.clock()
    for step in steps:
        if watch.is_over():
            raise OutOfTime
        yield (step,)
        yield itertools.islice(steps, size - 1)

        # Here the batch is done. Begin small and grow, because a first step may already take seconds.
        now = watch.clock()
        size = 1 if now - began > _SLOW else min(2 * size, _MOST_STEPS)
        began = now
