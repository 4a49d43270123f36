"""Make sure that no Ctrl-C is lost: Python drops exceptions raised where no code can catch them."""

from __future__ import annotations

import _thread
import contextlib
import signal
import sys
import threading
import time
from collections.abc import Iterator
from types import FrameType

# Seconds.
_AGAIN = 0.01


@contextlib.contextmanager
def no_ctrl_c_lost() -> Iterator[None]:
    """Repeat, inside this block, a Ctrl-C whose ``KeyboardInterrupt`` would be lost.

    That happens in callbacks of ``gc`` (Hypothesis has one: in campaigns it swallowed every fourth
    Ctrl-C), in callbacks of weak references and in ``__del__``. If Ctrl-C is ignored, or handled
    elsewhere, this does nothing.
    """
    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return
    repeater = _Repeater()
    repeater.begin()
    try:
        yield
    finally:
        repeater.end()


class _Repeater:
    """Handles Ctrl-C, and sends it again if Python dropped it.

    Its flags are plain attributes: a second signal that arrives while an ``Event`` is being set
    would wait for the first one forever.
    """

    def __init__(self) -> None:
        self._main = threading.get_ident()
        self._other_hook = sys.unraisablehook
        self._raised = False
        self._is_starting = False
        self._over = False

    def begin(self) -> None:
        signal.signal(signal.SIGINT, self._interrupt)
        sys.unraisablehook = self._on_dropped

    def end(self) -> None:
        self._over = True
        if sys.unraisablehook == self._on_dropped:
            sys.unraisablehook = self._other_hook
        if signal.getsignal(signal.SIGINT) == self._interrupt:
            signal.signal(signal.SIGINT, signal.default_int_handler)

    def _interrupt(self, number: int, frame: FrameType | None) -> None:
        if not self._is_starting:
            self._raised = True
            signal.default_int_handler(number, frame)

    def _on_dropped(self, dropped: sys.UnraisableHookArgs) -> None:
        if not (self._raised and issubclass(dropped.exc_type, KeyboardInterrupt)):
            self._other_hook(dropped)
            return
        # An exception raised here would be dropped too; the thread sends Ctrl-C again anyway.
        self._is_starting = True
        self._raised = False
        try:
            _thread.start_new_thread(self._send_again, ())
        finally:
            self._is_starting = False

    def _send_again(self) -> None:
        """Send Ctrl-C until it is handled.

        A Ctrl-C that arrives just before the main thread begins to wait does not wake it.
        """
        while True:
            time.sleep(_AGAIN)
            is_ours = signal.getsignal(signal.SIGINT) == self._interrupt
            if self._raised or self._over:
                return
            if sys.platform == "win32":
                _thread.interrupt_main()
            else:
                signal.pthread_kill(self._main, signal.SIGINT)
            # Another handler has it now, and must not get it twice.
            if not is_ours:
                return
