"""Processes that work for the server.

They ignore Ctrl-C, give the page priority, and end with the server, however it ends.
"""

from __future__ import annotations

import contextlib
import os
import signal
from collections.abc import Callable
from multiprocessing import get_context
from multiprocessing.process import BaseProcess
from typing import Any

from worldgen.support.workers import become_worker, sigint_blocked

__all__ = ["start_beside"]


def start_beside(target: Callable[..., None], *args: Any, nice: int) -> BaseProcess:
    """Start a process next to this one.

    Args:
        target: The function to run, from a module.
        *args: Its arguments.
        nice: Niceness, the priority of everything else over it, from 0 to 19.
    """
    process = get_context("spawn").Process(target=_begin, args=(nice, target, *args), daemon=True)
    with sigint_blocked():
        process.start()
    return process


def _begin(nice: int, target: Callable[..., None], *args: Any) -> None:
    become_worker()
    # Campaigns that are started in this process must receive Ctrl-C.
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    # AttributeError: Windows has no nice.
    with contextlib.suppress(OSError, AttributeError):
        os.nice(nice)
    target(*args)
