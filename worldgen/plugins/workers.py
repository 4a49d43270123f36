"""Worker processes and Ctrl-C: the driver handles it at safe points, the workers never see it."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from multiprocessing import get_context, parent_process, resource_tracker
from types import FrameType
from typing import Any, ParamSpec, TypeVar

from worldgen.plugins.trust import Inherited

P = ParamSpec("P")
T = TypeVar("T")

# Seconds between two checks for Ctrl-C in a waiting driver.
LISTEN = 0.1
# Environment variable that keeps Python from importing from the current folder. Any text turns it
# on, and ours tells a worker that worldgen did, so that the worker turns it off again.
_SAFE_PATH = "PYTHONSAFEPATH"
_OURS = "worldgen"
# Seconds for all processes together.
_TO_TERMINATE = 1.0


@contextlib.contextmanager
def ctrl_c_held_back(at_once: Callable[[], None] = lambda: None) -> Iterator[Callable[[], None]]:
    """Hold back Ctrl-C until the yielded function is called, which raises ``KeyboardInterrupt``.

    All code that distributes work handles Ctrl-C this way. An exception between any two
    instructions could leave locks of queues and futures locked forever, or be swallowed by other
    code. A second Ctrl-C is raised immediately, in case something hangs. Outside the main thread,
    which is the only one that receives Ctrl-C, this does nothing; the same is true
    if Ctrl-C is ignored.

    Args:
        at_once: Called when Ctrl-C comes.
    """
    # Only the main thread gets Ctrl-C, and only if it is not ignored.
    if threading.current_thread() is not threading.main_thread():
        yield lambda: None
        return
    before = signal.getsignal(signal.SIGINT)
    if before in (signal.SIG_IGN, None):
        yield lambda: None
        return
    came = False

    def note(_signal: int, _frame: FrameType | None) -> None:
        nonlocal came
        came = True
        signal.signal(signal.SIGINT, before)
        at_once()

    def listen() -> None:
        nonlocal came
        if came:
            came = False
            signal.signal(signal.SIGINT, note)
            raise KeyboardInterrupt

    # Until the caller checks, Ctrl-C is only recorded.
    signal.signal(signal.SIGINT, note)
    try:
        yield listen
    finally:
        signal.signal(signal.SIGINT, before)


class WorkerPool(ProcessPoolExecutor):
    """Processes that ignore Ctrl-C and end with the process that started them, even if killed.

    They are started when work is first submitted.

    Args:
        workers: Number of processes.
        initializer: Called first in each process; it and its arguments must be picklable.
        *args: Its arguments; objects of ``get_context("spawn")`` among them are shared.
    """

    def __init__(
        self, workers: int, initializer: Callable[..., None] | None = None, *args: Any
    ) -> None:
        # pdb takes the specification away from the main module, and a new process reads it.
        vars(sys.modules["__main__"]).setdefault("__spec__", None)
        with current_folder_hidden():
            super().__init__(
                workers,
                mp_context=get_context("spawn"),
                initializer=_start_worker,
                initargs=(Inherited(), initializer, args),
            )

    def submit(self, work: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Submit it to the next free process."""
        with sigint_blocked():
            return super().submit(work, *args, **kwargs)

    def end(self) -> None:
        """End the processes now, even one that is stuck in a controller.

        Unfinished work is lost.
        """
        # shutdown() forgets its processes, so they are copied first.
        processes = list((self._processes or {}).values())
        self.shutdown(wait=False, cancel_futures=True)
        for process in processes:
            process.terminate()
        end = time.monotonic() + _TO_TERMINATE
        for process in processes:
            process.join(max(end - time.monotonic(), 0.0))
            # A controller may have blocked SIGTERM.
            if process.is_alive():
                process.kill()


@contextlib.contextmanager
def current_folder_hidden() -> Iterator[None]:
    """Start processes inside that import nothing from the current folder.

    A new Python looks there first, even for its own modules, until it gets this process's path. So
    a file ``pickle.py`` in a folder of a stranger's worlds would run.
    """
    before = os.environ.get(_SAFE_PATH)
    os.environ[_SAFE_PATH] = before or _OURS
    try:
        yield
    finally:
        del os.environ[_SAFE_PATH]
        if before is not None:
            os.environ[_SAFE_PATH] = before


@contextlib.contextmanager
def sigint_blocked() -> Iterator[None]:
    """Start processes inside with SIGINT blocked, which they inherit.

    They ignore Ctrl-C from their first moment. If a Ctrl-C arrives in the meantime, this process
    gets it afterwards. They import nothing from the current folder while they start.
    """
    with current_folder_hidden(), _sigint_blocked():
        yield


@contextlib.contextmanager
def _sigint_blocked() -> Iterator[None]:
    # Windows signals a process group instead.
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    # Otherwise it would start with the first process, and starting it lifts the block.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _start_worker(
    _: Inherited, initializer: Callable[..., None] | None, args: tuple[Any, ...]
) -> None:
    become_worker()
    if initializer is not None:
        initializer(*args)


def become_worker() -> None:
    """Ignore Ctrl-C, and end this process with the one that started it, even if that is killed."""
    # The programs that it starts are the user's, and find their modules as always.
    if os.environ.get(_SAFE_PATH) == _OURS:
        del os.environ[_SAFE_PATH]
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_driver, daemon=True).start()


def _end_with_driver() -> None:
    driver = parent_process()
    if driver is not None:
        driver.join()
        os._exit(1)
