"""Processes beside the server.

They ignore Ctrl-C, give way to the page, and end with the server, however it ends.
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
    """Start a process beside this one.

    Args:
        target: What it does, a function of a module.
        *args: What that is called with.
        nice: By how much everything else comes first, from 0 to 19.
    """
    process = get_context("spawn").Process(target=_begin, args=(nice, target, *args), daemon=True)
    with sigint_blocked():
        process.start()
    return process


def _begin(nice: int, target: Callable[..., None], *args: Any) -> None:
    become_worker()
    # The campaigns that are started here are to hear Ctrl-C.
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    # AttributeError: Windows has no nice.
    with contextlib.suppress(OSError, AttributeError):
        os.nice(nice)
    target(*args)
