"""End runs that are under way when their caller runs out of time.

A campaign's budget may run out in the middle of a run, and a run of a Python controller may take
minutes. Only the run itself can end without harm, so it checks the clock between its steps. A
single step that does not end is interrupted by a signal. That works in the main thread and in
Python code only, so a step inside a compiled library ends when the library returns.
"""

from __future__ import annotations

import itertools
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, nullcontext
from contextvars import ContextVar
from types import CodeType, FrameType
from typing import NamedTuple, ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")

# Steps between two checks of the clock, for a fast controller.
_MOST_STEPS = 16

# Steps in a portion without a deadline.
_UNWATCHED = 1 << 10

# Seconds. After a batch of steps that took longer than this, the clock is checked before each step.
_SLOW = 0.1

# Seconds between two checks of the clock in the middle of a step.
_TICK = 0.2

# Number of late checks before a step is interrupted. Most steps end by themselves before that.
_PATIENT = 2


class _Watch(NamedTuple):
    """The conditions that end the runs, and the clock, in seconds, that measures their steps."""

    is_over: Callable[[], bool]
    clock: Callable[[], float]


_watch: ContextVar[_Watch | None] = ContextVar("watch", default=None)
# Interrupted steps, over the life of this process.
_broken_off = [0]

# Whether the code that each registered function calls may be interrupted.
_may_break: dict[CodeType, bool] = {}


class OutOfTime(BaseException):
    """Raised in the middle of work that has run out of time.

    It is not an ``Exception``, so that it never counts as a controller's fault.
    """


@contextmanager
def stopping_when(
    is_over: Callable[[], bool], clock: Callable[[], float] = time.monotonic
) -> Iterator[None]:
    """End the work in this block with :class:`OutOfTime` once ``is_over`` returns True.

    An inner block replaces an outer one. In the main thread, a step of a controller that continues
    for a while after the deadline is interrupted too, unless the program uses SIGALRM itself or
    ``clock`` is not the system's.

    Args:
        is_over: Returns True when there is no more time. A signal handler calls it too, at any
            moment, so it must not wait for a lock.
        clock: Returns seconds; tells slow steps from fast ones.
    """
    token = _watch.set(_Watch(is_over, clock))
    try:
        with _ticking() if clock is time.monotonic else nullcontext():
            yield
    finally:
        _watch.reset(token)


@contextmanager
def _ticking() -> Iterator[None]:
    """Check the clock on a timer signal, unless an outer block does or no signal is available."""
    is_main = threading.current_thread() is threading.main_thread()
    # Signals reach only the main thread, and a handler of the user's is left alone.
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
        # Interrupt only inside a step: elsewhere the state might be half written.
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
    """Return True if the innermost registered function on the stack may be interrupted.

    A trace function is never interrupted: Python would remove it, and a debugger may be waiting in
    it for its user.
    """
    running = set()
    tracing = {_code_of(sys.gettrace()), _code_of(sys.getprofile())}
    while frame is not None:
        running.add(frame.f_code)
        tracing.add(_code_of(frame.f_trace))
        if frame.f_code in _may_break:
            return _may_break[frame.f_code] and running.isdisjoint(tracing)
        frame = frame.f_back
    return False


def _code_of(function: object) -> CodeType | None:
    """Return the code of a function or method in Python; ``None`` for anything else."""
    return getattr(getattr(function, "__func__", function), "__code__", None)


def breakable(function: Callable[P, T]) -> Callable[P, T]:
    """Allow :class:`OutOfTime` to be raised anywhere in a function, or below it in the stack."""
    _may_break[function.__code__] = True
    return function


def unbreakable(function: Callable[P, T]) -> Callable[P, T]:
    """Protect a function from interruption when a breakable function calls it."""
    _may_break[function.__code__] = False
    return function


def is_out_of_time() -> bool:
    """Return True if there is no more time."""
    watch = _watch.get()
    return watch is not None and watch.is_over()


def steps_broken_off() -> int:
    """Return how many steps of this process were interrupted."""
    return _broken_off[0]


def check_time() -> None:
    """Check the clock once.

    Raises:
        OutOfTime: If there is no more time.
    """
    if is_out_of_time():
        raise OutOfTime


def portions() -> Iterator[int]:
    """Yield endlessly how many steps to run next, checking the clock before each portion.

    Raises:
        OutOfTime: While iterating, once there is no more time.
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

        # The portion is done. Sizes begin small and grow, because even a first step may take
        # seconds.
        now = watch.clock()
        size = 1 if now - began > _SLOW else min(2 * size, _MOST_STEPS)
        began = now


def in_time(steps: Iterable[int]) -> Iterable[int]:
    """Return the same steps, checking the clock every few of them, or before each slow one.

    Raises:
        OutOfTime: While iterating, once there is no more time.
    """
    return steps if _watch.get() is None else itertools.chain.from_iterable(_batches(iter(steps)))


def _batches(steps: Iterator[int]) -> Iterator[Iterable[int]]:
    """Yield short runs of steps; chaining them in C adds no measurable cost to a step."""
    for step, size in zip(steps, portions(), strict=False):
        yield (step,)
        yield itertools.islice(steps, size - 1)
