"""Ctrl-C with worker processes: the driver hears it, the workers do not."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Iterator

__all__ = ["begin_deaf", "workers_begin_deaf"]


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
    """What a worker does first."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
