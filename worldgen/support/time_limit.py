"""End code that takes too long.

A thread raises an exception in the thread that runs the code. That works on every system and in
every thread, but only in Python code: a call that waits, or computes in a compiled library, must
return first.
"""

from __future__ import annotations

import contextlib
import ctypes
import queue
import threading
import time
from collections.abc import Iterator

# Seconds after which the exception is raised again, because the code may have caught it.
_AGAIN = 1.0


class TimeLimitReached(BaseException):
    """Raised in the middle of code that has used up its time.

    It is not an ``Exception``, so that most handlers let it pass.
    """


@contextlib.contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Raise :class:`TimeLimitReached` in this block once it has taken that long.

    Args:
        seconds: Time that the block may take.
    """
    thread = ctypes.c_ulong(threading.get_ident())
    raise_in = ctypes.pythonapi.PyThreadState_SetAsyncExc
    # Only atomic state is shared, because the exception may be raised between any two steps.
    wake: queue.SimpleQueue[None] = queue.SimpleQueue()
    over: list[bool] = []
    ended: list[bool] = []

    def watch() -> None:
        wait = seconds
        while not over:
            try:
                wake.get(timeout=wait)
            except queue.Empty:
                if not over:
                    raise_in(thread, ctypes.py_object(TimeLimitReached))
            wait = _AGAIN
        ended.append(True)

    def stop() -> None:
        over.append(True)
        wake.put(None)
        while not ended:
            time.sleep(0)
        # Cancel a timeout that is pending but was not raised yet.
        raise_in(thread, None)

    watcher = threading.Thread(target=watch, name="time limit", daemon=True)
    try:
        # A short limit may be reached before start() returns.
        watcher.start()
        yield
    finally:
        # The exception may still arrive while the watch stops, so stop it twice.
        try:
            stop()
        finally:
            stop()
