"""Worker processes and Ctrl-C: the driver hears it where it can bear it, the workers never."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import parent_process
from types import FrameType

__all__ = ["LISTEN", "begin_deaf", "ctrl_c_held_back", "ctrl_c_kept", "end_workers", "workers_begin_deaf"]

LISTEN = 0.1  # s between two moments at which a waiting driver hears Ctrl-C
_TO_TERMINATE = 1.0  # s that all processes have together


@contextlib.contextmanager
def ctrl_c_held_back(at_once: Callable[[], None] = lambda: None) -> Iterator[Callable[[], None]]:
    """Holds Ctrl-C back until what this yields is called, which then raises ``KeyboardInterrupt``.

    Locks of queues and futures may stay locked for ever if an exception comes between any two instructions.
    A second Ctrl-C is not held back: the way out if something hangs. Outside the main thread, which alone
    hears Ctrl-C, this does nothing.

    Args:
        at_once: Called when Ctrl-C comes.
    """
    if threading.current_thread() is not threading.main_thread():
        yield lambda: None
        return
    before = signal.getsignal(signal.SIGINT)
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

    signal.signal(signal.SIGINT, note)
    try:
        yield listen
    finally:
        signal.signal(signal.SIGINT, before)


@contextlib.contextmanager
def ctrl_c_kept() -> Iterator[Callable[[], None]]:
    """Ctrl-C as ever; where some code swallows it, what this yields raises ``KeyboardInterrupt`` when it is called.

    In campaigns 2 of 60 were swallowed. Outside the main thread this does nothing.
    """
    if threading.current_thread() is not threading.main_thread():
        yield lambda: None
        return
    before = signal.getsignal(signal.SIGINT)
    came = False

    def note(number: int, frame: FrameType | None) -> None:
        nonlocal came
        came = True
        if callable(before):
            before(number, frame)

    def listen() -> None:
        if came:
            raise KeyboardInterrupt

    if before not in (signal.SIG_IGN, None):
        signal.signal(signal.SIGINT, note)
    try:
        yield listen
    finally:
        if before is not None:
            signal.signal(signal.SIGINT, before)


@contextlib.contextmanager
def workers_begin_deaf() -> Iterator[None]:
    """Processes that are started meanwhile are deaf to Ctrl-C from their first moment on: they inherit it.

    One that arrives meanwhile is heard by this process afterwards.
    """
    if not hasattr(signal, "pthread_sigmask"):  # not on Windows, where a process group is told
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def begin_deaf() -> None:
    """What a worker does first; from then on it hears no Ctrl-C, and ends when its driver is gone, killed maybe."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_driver, daemon=True).start()


def _end_with_driver() -> None:
    driver = parent_process()
    if driver is not None:
        driver.join()
        os._exit(1)


def end_workers(pool: ProcessPoolExecutor) -> None:
    """Ends the processes of a pool at once, also those that a controller holds up."""
    processes = list((getattr(pool, "_processes", None) or {}).values())  # shutdown forgets them
    pool.shutdown(wait=False, cancel_futures=True)
    for process in processes:
        process.terminate()
    end = time.monotonic() + _TO_TERMINATE
    for process in processes:
        process.join(max(end - time.monotonic(), 0.0))
        if process.is_alive():  # a controller may have made it deaf to that, too
            process.kill()
