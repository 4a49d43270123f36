"""Ends runs that are under way when whoever asked for them has no more time: a campaign whose budget is spent, say.

A run of a Python controller may take minutes, and nothing but the run itself can end it without harm. So it asks.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

__all__ = ["OutOfTime", "check_time", "in_time", "is_out_of_time", "stopping_when"]

_EVERY = 16  # steps between two looks at the clock

_is_over: ContextVar[Callable[[], bool] | None] = ContextVar("is_over", default=None)


class OutOfTime(BaseException):
    """Raised in the middle of work that has no more time; no ``Exception``, lest it pass for a controller's fault."""


@contextmanager
def stopping_when(is_over: Callable[[], bool]) -> Iterator[None]:
    """End what is done inside with :class:`OutOfTime` once ``is_over`` says so; an outer one no longer counts."""
    token = _is_over.set(is_over)
    try:
        yield
    finally:
        _is_over.reset(token)


def is_out_of_time() -> bool:
    """Return whether the time is over."""
    is_over = _is_over.get()
    return is_over is not None and is_over()


def check_time() -> None:
    """Look at the clock once.

    Raises:
        OutOfTime: If the time is over.
    """
    if is_out_of_time():
        raise OutOfTime


def in_time(steps: Iterable[int]) -> Iterable[int]:
    """Return the same steps, with a look at the clock every few of them.

    Raises:
        OutOfTime: While iterating, once the time is over.
    """
    is_over = _is_over.get()
    return steps if is_over is None else itertools.chain.from_iterable(_batches(iter(steps), is_over))


def _batches(steps: Iterator[int], is_over: Callable[[], bool]) -> Iterator[Iterable[int]]:
    """Yield short runs of steps; chained in C, they cost a step nothing that could be measured."""
    for step in steps:
        if is_over():
            raise OutOfTime
        yield (step,)
        yield itertools.islice(steps, _EVERY - 1)
