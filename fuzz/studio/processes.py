"""Processes beside the server: they hear no Ctrl-C, give way to the page, and end with the server, however it ends."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from multiprocessing import resource_tracker
from multiprocessing.process import BaseProcess
from typing import Any

__all__ = ["start_beside"]


def start_beside(target: Callable[..., None], *args: Any, nice: int) -> BaseProcess:
    """Starts a process beside this one.

    Args:
        target: What it does, a function of a module.
        *args: What that is called with.
        nice: By how much everything else comes first, from 0 to 19.
    """
    context = multiprocessing.get_context("spawn")
    process = context.Process(target=_begin, args=(nice, target, *args), daemon=True)
    with _without_interrupts():
        process.start()
    return process


@contextlib.contextmanager
def _without_interrupts() -> Iterator[None]:
    """A process that is started inside hears no Ctrl-C before it says so; this one hears it afterwards."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # which would start with the process otherwise, and lets interrupts through
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin(nice: int, target: Callable[..., None], *args: Any) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the server's
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})  # for the campaigns that are started here
    threading.Thread(target=_end_with_the_server, daemon=True).start()
    with contextlib.suppress(OSError, AttributeError):  # AttributeError: there is none on Windows
        os.nice(nice)
    target(*args)


def _end_with_the_server() -> None:
    """Ends this process with the server, killed maybe, even while a controller hangs; files are whole at any time."""
    server = multiprocessing.parent_process()
    if server is not None:
        server.join()
        os._exit(1)
