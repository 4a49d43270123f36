"""Ends runs that are under way when whoever asked for them has no more time.

A campaign whose budget is spent, say. A run of a Python controller may take minutes, and nothing
but the run itself can end it without harm. So it asks before its steps. A single step that does not
end is broken off by a signal; that needs the main thread and Python code, so a step inside a
compiled library ends when the library returns.
"""

from __future__ import annotations

import itertools
import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, nullcontext
from contextvars import ContextVar
from types import CodeType, FrameType
from typing import NamedTuple, ParamSpec, TypeVar

__all__ = [
    "OutOfTime",
    "breakable",
    "check_time",
    "in_time",
    "is_out_of_time",
    "portions",
    "steps_broken_off",
    "stopping_when",
    "unbreakable",
]

P = ParamSpec("P")
T = TypeVar("T")

_MOST_STEPS = 16  # steps between two looks at the clock, of a fast controller
_UNWATCHED = 1 << 10  # steps of a portion where nobody looks at the clock
_SLOW = 0.1  # s: after a batch of steps that took longer, each step is looked at
_TICK = 0.2  # s between two looks at the clock in the middle of a step
# Such looks that find the time over before a step is broken off: most steps end by themselves.
_PATIENT = 2


class _Watch(NamedTuple):
    """What ends the runs, and the clock (s) by which their steps are measured."""

    is_over: Callable[[], bool]
    clock: Callable[[], float]


_watch: ContextVar[_Watch | None] = ContextVar("watch", default=None)
_broken_off = [0]  # steps of this process
_may_break: dict[CodeType, bool] = {}  # by function, whether what it has called may be broken off


class OutOfTime(BaseException):
    """Raised in the middle of work that has no more time.

    No ``Exception``, lest it pass for a controller's fault.
    """


@contextmanager
def stopping_when(
    is_over: Callable[[], bool], clock: Callable[[], float] = time.monotonic
) -> Iterator[None]:
    """End what is done inside with :class:`OutOfTime` once ``is_over`` returns True.

    An outer one no longer counts. In the main thread a controller's step that goes on for a while
    after that is broken off, too; not where a program uses SIGALRM itself, nor by another clock
    than the system's.

    Args:
        is_over: Returns True when there is no more time. A signal asks it too, in the middle of
            anything, so it must not wait for a lock.
        clock: Seconds, by which slow steps are told from fast ones.
    """
    token = _watch.set(_Watch(is_over, clock))
    try:
        with _ticking() if clock is time.monotonic else nullcontext():
            yield
    finally:
        _watch.reset(token)


@contextmanager
def _ticking() -> Iterator[None]:
    """Look at the clock by a signal, unless an outer block does, or the signal is not to be had."""
    is_main = threading.current_thread() is threading.main_thread()
    if (
        not is_main
        or not hasattr(signal, "setitimer")
        or signal.getsignal(signal.SIGALRM) is not signal.SIG_DFL
    ):
        yield
        return
    late = 0

    def tick(_number: int, frame: FrameType | None) -> None:
        nonlocal late
        late = late + 1 if is_out_of_time() else 0
        if late >= _PATIENT and _is_in_a_step(frame):
            _broken_off[0] += 1
            raise OutOfTime

    signal.signal(signal.SIGALRM, tick)
    signal.setitimer(signal.ITIMER_REAL, _TICK, _TICK)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, signal.SIG_DFL)


def _is_in_a_step(frame: FrameType | None) -> bool:
    """Return True if the innermost function that says anything about it may be broken off."""
    while frame is not None:
        if frame.f_code in _may_break:
            return _may_break[frame.f_code]
        frame = frame.f_back
    return False


def breakable(function: Callable[P, T]) -> Callable[P, T]:
    """Let :class:`OutOfTime` be raised at any place in a function, and in whatever it calls."""
    _may_break[function.__code__] = True
    return function


def unbreakable(function: Callable[P, T]) -> Callable[P, T]:
    """Make an exception of a function that a breakable one calls."""
    _may_break[function.__code__] = False
    return function


def is_out_of_time() -> bool:
    """Return whether the time is over."""
    watch = _watch.get()
    return watch is not None and watch.is_over()


def steps_broken_off() -> int:
    """Return how many steps of this process did not end by themselves."""
    return _broken_off[0]


def check_time() -> None:
    """Look at the clock once.

    Raises:
        OutOfTime: If the time is over.
    """
    if is_out_of_time():
        raise OutOfTime


def portions() -> Iterator[int]:
    """Return endlessly how many steps to do next, with a look at the clock before each portion.

    Raises:
        OutOfTime: While iterating, once the time is over.
    """
    watch = _watch.get()
    return itertools.repeat(_UNWATCHED) if watch is None else _watched_portions(watch)


def _watched_portions(watch: _Watch) -> Iterator[int]:
    size = 1
    began = watch.clock()
    while True:
        if watch.is_over():
            raise OutOfTime
        yield size

        # Here the portion is done. Begin small and grow, because a first step may already take
        # seconds.
        now = watch.clock()
        size = 1 if now - began > _SLOW else min(2 * size, _MOST_STEPS)
        began = now


def in_time(steps: Iterable[int]) -> Iterable[int]:
    """Return the same steps, with a look at the clock every few of them.

    Before each one if they are slow.

    Raises:
        OutOfTime: While iterating, once the time is over.
    """
    return steps if _watch.get() is None else itertools.chain.from_iterable(_batches(iter(steps)))


def _batches(steps: Iterator[int]) -> Iterator[Iterable[int]]:
    """Yield short runs of steps; chained in C, they cost a step nothing that could be measured."""
    for step, size in zip(steps, portions(), strict=False):
        yield (step,)
        yield itertools.islice(steps, size - 1)
