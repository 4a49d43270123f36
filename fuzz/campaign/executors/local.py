"""Run work in this process, or in several on this machine."""

from __future__ import annotations

import _thread
import math
import signal
import sys
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack
from ctypes import c_double
from multiprocessing import get_context
from multiprocessing.synchronize import Barrier
from typing import Any, ParamSpec, Self, TypeVar

from fuzz.campaign.executors.executor import Executor, WorkersLost
from fuzz.facts.proofs import certified
from fuzz.unit.deadline import TO_HAND_IN, now, stop_from, stopping_from
from fuzz.unit.live import LiveCounts, count_in
from sim.clock.controller_time import Effort
from sim.controllers.lines_run import begin_lines
from sim.episode.try_out import EMPTY_ARENA, try_out
from sim.scenario import Scenario
from worldgen.plugins.workers import WorkerPool, ctrl_c_held_back, current_folder_hidden

P = ParamSpec("P")
T = TypeVar("T")

# Units waiting for a worker, so that none is idle.
_WAITING = 1

# In a worker: passed once every worker has loaded the controller.
_all_loaded: list[Barrier] = []


def local_executor(workers: int) -> Executor:
    """Return an executor for this many processes; for one, this process."""
    return InlineExecutor() if workers == 1 else ProcessExecutor(workers)


class InlineExecutor:
    """Do work immediately, in this process.

    Ctrl-C stops the work in the same way as in other processes, so a unit returns its findings.
    Work that does not end in time is interrupted.
    """

    room = 1

    def __init__(self) -> None:
        # Times are by the clock of deadlines.
        self._stopped_at = math.inf
        self._patience: threading.Timer | None = None
        self._open = ExitStack()
        with current_folder_hidden():
            self._counters = get_context("spawn").Array(c_double, 3)

    def submit(self, work: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Do the work."""
        future: Future[T] = Future()
        try:
            with stopping_from(lambda: self._stopped_at):
                future.set_result(work(*args, **kwargs))
        finally:
            self._stop_waiting()
        return future

    def prepare(self, scenarios: Sequence[Scenario]) -> list[Future[float]]:
        """Load it in this process.

        Raises:
            KeyboardInterrupt: If Ctrl-C was pressed in the meantime; nothing has been found by
                then.
        """
        loaded = self.submit(load, scenarios)
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

        A controller that never returns takes too long.
        """
        self._stopped_at = now()
        self._patience = threading.Timer(TO_HAND_IN, _interrupt_main)
        self._patience.daemon = True
        self._patience.start()

    def _stop_waiting(self) -> None:
        if self._patience is not None:
            self._patience.cancel()

    def counts(self) -> LiveCounts:
        """Return the counts of this process so far."""
        return LiveCounts.of(self._counters)

    def stop(self) -> None:
        """Do nothing: no work is in progress when this can be called."""

    def go_on(self) -> None:
        """Do nothing, as :meth:`stop` does."""

    def __enter__(self) -> Self:
        """Hold back Ctrl-C from here on, and count what this process runs."""
        count_in(self._counters)
        begin_lines()
        self._listen = self._open.enter_context(ctrl_c_held_back(self._stop))
        return self

    def __exit__(self, *_: object) -> None:
        """Restore Ctrl-C."""
        self._stop_waiting()
        self._open.close()


class ProcessExecutor:
    """Processes on this machine that ignore Ctrl-C and end when this process ends.

    Args:
        workers: Number of processes.
    """

    def __init__(self, workers: int) -> None:
        self.room = workers + _WAITING
        self._workers = workers
        self._open = ExitStack()
        # A single word, so it needs no lock.
        with current_folder_hidden():
            self._stopped_at = get_context("spawn").RawValue(c_double, math.inf)
            self._counters = get_context("spawn").Array(c_double, 3)
            self._all_loaded = get_context("spawn").Barrier(workers)

    def submit(self, work: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Submit it to the next free process."""
        return self._pool.submit(work, *args, **kwargs)

    def prepare(self, scenarios: Sequence[Scenario]) -> list[Future[float]]:
        """Start all processes, and load it in each."""
        return [self.submit(_load_with_others, scenarios) for _ in range(self._workers)]

    def listen(self) -> None:
        """Raise ``KeyboardInterrupt`` if Ctrl-C came."""
        self._listen()

    def counts(self) -> LiveCounts:
        """Return the counts of all processes so far."""
        return LiveCounts.of(self._counters)

    def stop(self) -> None:
        """Tell all processes to end."""
        self._stopped_at.value = now()

    def go_on(self) -> None:
        """Let further work run; units that were told to end have deadlines of their own."""
        self._stopped_at.value = math.inf

    def __enter__(self) -> Self:
        """Prepare to start processes, the first when it is needed."""
        self._pool = WorkerPool(
            self._workers, _begin, self._stopped_at, self._counters, self._all_loaded
        )
        self._listen = self._open.enter_context(ctrl_c_held_back())
        return self

    def __exit__(self, _kind: object, error: BaseException | None, _at: object) -> None:
        """End the processes, immediately if there was an error or they were told to stop.

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
                "a worker process died, perhaps killed by the controller or for lack of memory "
                "({reason})",
                reason=str(error),
            ) from error


def _interrupt_main() -> None:
    """Send Ctrl-C to the main thread, even while it waits in a call of the system."""
    main = threading.main_thread().ident
    if sys.platform == "win32" or main is None:
        _thread.interrupt_main()
    else:
        signal.pthread_kill(main, signal.SIGINT)


def load(scenarios: Sequence[Scenario]) -> float:
    """Load what a search's first units need: the library and the controllers.

    Each controller takes two steps, and a world is proved.

    Args:
        scenarios: The controllers, and how they run.

    Returns:
        Seconds of this spent in the controllers' own code.
    """
    began = Effort.so_far()
    for scenario in scenarios:
        try_out(scenario)
    certified(EMPTY_ARENA)
    return began.since().own


def _load_with_others(scenarios: Sequence[Scenario]) -> float:
    """Load it, and wait until all other processes have loaded it.

    Otherwise the first process might do it twice, and the last one start in the campaign's time.
    """
    try:
        return load(scenarios)
    finally:
        _all_loaded[0].wait()


def _begin(stopped_at: c_double, counters: Any, all_loaded: Barrier) -> None:
    """End a worker's work when the main process requests it, and count its runs."""
    _all_loaded[:] = [all_loaded]
    stop_from(lambda: stopped_at.value)
    count_in(counters)
    begin_lines()
