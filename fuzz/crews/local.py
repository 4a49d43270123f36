"""This process, or several on this machine."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack
from multiprocessing import get_context
from types import TracebackType
from typing import ParamSpec, Self, TypeVar

from fuzz.crews.crew import Crew, WorkersLost
from worldgen.workers import begin_deaf, ctrl_c_held_back, end_workers, workers_begin_deaf

__all__ = ["Alone", "Processes", "crew_of"]

P = ParamSpec("P")
T = TypeVar("T")

_WAITING = 1  # units that wait for a worker, so that none is idle


def crew_of(workers: int) -> Crew:
    """So many processes; of one, this one."""
    return Alone() if workers == 1 else Processes(workers)


class Alone:
    """Does the work at once, in this process."""

    room = 1

    def submit(self, work: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Does it."""
        future: Future[T] = Future()
        future.set_result(work(*args, **kwargs))
        return future

    def listen(self) -> None:
        """Nothing: Ctrl-C is not held back."""

    def __enter__(self) -> Self:
        """Nothing to start."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Nothing to end."""


class Processes:
    """Processes on this machine, deaf to Ctrl-C, ended when this one ends.

    Args:
        workers: How many.
    """

    def __init__(self, workers: int) -> None:
        self.room = workers + _WAITING
        self._workers = workers
        self._open = ExitStack()

    def submit(self, work: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Gives it to the next process that is free."""
        with workers_begin_deaf():
            return self._pool.submit(work, *args, **kwargs)

    def listen(self) -> None:
        """Raises ``KeyboardInterrupt`` if Ctrl-C came."""
        self._listen()

    def __enter__(self) -> Self:
        """Ready to start processes, one when it is first needed."""
        self._pool = ProcessPoolExecutor(self._workers, mp_context=get_context("spawn"), initializer=begin_deaf)
        self._listen = self._open.enter_context(ctrl_c_held_back())
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """Ends the processes; if something went wrong, at once.

        Raises:
            WorkersLost: If one of them died.
        """
        with self._open:
            if error is None:
                self._pool.shutdown()
            else:
                end_workers(self._pool)
        if isinstance(error, BrokenProcessPool):
            raise WorkersLost(
                f"a worker process died, perhaps killed by the controller or for want of memory ({error})"
            ) from error
