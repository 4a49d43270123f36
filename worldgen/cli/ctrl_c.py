"""Ctrl-C that is not lost: Python drops what is raised where nobody can catch it."""

from __future__ import annotations

import _thread
import contextlib
import signal
import sys
import threading
import time
from collections.abc import Iterator
from types import FrameType

__all__ = ["no_ctrl_c_lost"]

_AGAIN = 0.01  # s


@contextlib.contextmanager
def no_ctrl_c_lost() -> Iterator[None]:
    """Repeats, inside, a Ctrl-C whose ``KeyboardInterrupt`` would be printed and forgotten.

    That is one in callbacks of ``gc`` (Hypothesis has one: in a campaign every fourth Ctrl-C fell
    into it), in those of weak references (Numba has some) and in ``__del__``. Where Ctrl-C is
    ignored, or somebody else handles it, this does nothing.
    """
    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return
    main = threading.get_ident()
    others = sys.unraisablehook
    raised = deaf = over = (
        False  # no Event: a second signal while one is being set would wait for the first, for ever
    )

    def interrupt(number: int, frame: FrameType | None) -> None:
        nonlocal raised
        if not deaf:
            raised = True
            signal.default_int_handler(number, frame)

    def hook(dropped: sys.UnraisableHookArgs) -> None:
        nonlocal raised, deaf
        if raised and issubclass(dropped.exc_type, KeyboardInterrupt):
            # what is raised in here would be dropped, too; it is pressed again anyway
            deaf = True
            raised = False
            try:
                _thread.start_new_thread(press, ())
            finally:
                deaf = False
        else:
            others(dropped)

    def press() -> None:
        """Until it is heard: what comes just before the main thread begins to wait does not wake it."""
        while True:
            time.sleep(_AGAIN)
            ours = signal.getsignal(signal.SIGINT) is interrupt
            if raised or over:
                return
            if sys.platform == "win32":
                _thread.interrupt_main()
            else:
                signal.pthread_kill(main, signal.SIGINT)
            if not ours:  # whoever handles it now has it
                return

    signal.signal(signal.SIGINT, interrupt)
    sys.unraisablehook = hook
    try:
        yield
    finally:
        over = True
        if sys.unraisablehook is hook:
            sys.unraisablehook = others
        if signal.getsignal(signal.SIGINT) is interrupt:
            signal.signal(signal.SIGINT, signal.default_int_handler)
