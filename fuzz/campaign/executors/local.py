"""This process, or several on this machine."""

from __future__ import annotations

import _thread
import math
import threading
from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack
from ctypes import c_double
from multiprocessing import get_context
from types import TracebackType
from typing import ParamSpec, Self, TypeVar

from fuzz.campaign.config import CampaignConfig
from fuzz.campaign.deadline import TO_HAND_IN, now, stop_from, stopping_from
from fuzz.campaign.executors.executor import Executor, WorkersLost
from fuzz.campaign.loading import load
from worldgen.support.workers import WorkerPool, ctrl_c_held_back

__all__ = ["InlineExecutor", "ProcessExecutor", "local_executor"]

P = ParamSpec("P")
T = TypeVar("T")

_WAITING = 1  # units that wait for a worker, so that none is idle


def local_executor(workers: int) -> Executor:
    """So many processes; of one, this one."""
    return InlineExecutor() if workers == 1 else ProcessExecutor(workers)


class InlineExecutor:
    """Do the work at once, in this process.

    Ctrl-C stops the work as it stops that of other processes, so that a unit hands in what it met.
    Work that does not end in time is interrupted.
    """

    room = 1

    def __init__(self) -> None:
        self._stopped_at = math.inf  # by the clock of deadlines
        self._patience: threading.Timer | None = None
        self._open = ExitStack()

    def submit(self, work: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Do it."""
        future: Future[T] = Future()
        try:
            with stopping_from(lambda: self._stopped_at):
                future.set_result(work(*args, **kwargs))
        finally:
            self._stop_waiting()
        return future

    def prepare(self, config: CampaignConfig) -> list[Future[float]]:
        """Load it here.

        Raises:
            KeyboardInterrupt: If Ctrl-C came meanwhile; nothing has been found by then.
        """
        loaded = self.submit(load, config)
        self._hear_ctrl_c()
        return [loaded]

    def listen(self) -> None:
        """Raise ``KeyboardInterrupt`` if Ctrl-C came."""
        self._hear_ctrl_c()

    def _hear_ctrl_c(self) -> None:
        self._stop_waiting()
        self._stopped_at = math.inf
        self._listen()

    def _stop(self) -> None:
        """Tell the work to end, and interrupt it if it takes too long.

        A controller that never answers does.
        """
        self._stopped_at = now()
        self._patience = threading.Timer(TO_HAND_IN, _thread.interrupt_main)
        self._patience.daemon = True
        self._patience.start()

    def _stop_waiting(self) -> None:
        if self._patience is not None:
            self._patience.cancel()

    def stop(self) -> None:
        """Do nothing: no work is under way when anyone can call this."""

    def __enter__(self) -> Self:
        """Hold Ctrl-C back from here on."""
        self._listen = self._open.enter_context(ctrl_c_held_back(self._stop))
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        """Leave Ctrl-C as it was."""
        self._stop_waiting()
        self._open.close()


class ProcessExecutor:
    """Processes on this machine, which ignore Ctrl-C and end when this one ends.

    Args:
        workers: How many.
    """

    def __init__(self, workers: int) -> None:
        self.room = workers + _WAITING
        self._workers = workers
        self._open = ExitStack()
        # One word, so it needs no lock.
        self._stopped_at = get_context("spawn").RawValue(c_double, math.inf)

    def submit(self, work: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Give it to the next process that is free."""
        return self._pool.submit(work, *args, **kwargs)

    def prepare(self, config: CampaignConfig) -> list[Future[float]]:
        """Start all processes, and load it in each."""
        return [self.submit(load, config) for _ in range(self._workers)]

    def listen(self) -> None:
        """Raise ``KeyboardInterrupt`` if Ctrl-C came."""
        self._listen()

    def stop(self) -> None:
        """Tell all processes."""
        self._stopped_at.value = now()

    def __enter__(self) -> Self:
        """Ready to start processes, one when it is first needed."""
        self._pool = WorkerPool(self._workers, _stop_from, self._stopped_at)
        self._listen = self._open.enter_context(ctrl_c_held_back())
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        """End the processes; at once if something went wrong, or they were told to stop.

        Raises:
            WorkersLost: If one of them died.
        """
        with self._open:
            if error is None and self._stopped_at.value == math.inf:
                self._pool.shutdown()
            else:
                self._pool.end()
        if isinstance(error, BrokenProcessPool):
            raise WorkersLost(
                "worker-died",
                "a worker process died, perhaps killed by the controller or for want of memory "
                "({reason})",
                reason=str(error),
            ) from error


def _stop_from(stopped_at: c_double) -> None:
    """Let all work of a worker end when the driver says so."""
    stop_from(lambda: stopped_at.value)
