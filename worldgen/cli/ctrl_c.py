"""Ctrl-C that is not lost: Python drops what is raised where nobody can catch it."""

from __future__ import annotations

import signal
import sys
import threading
from types import FrameType

__all__ = ["never_lose_ctrl_c"]

_AGAIN = 0.01  # s


def never_lose_ctrl_c() -> None:
    """Repeats Ctrl-C where ``KeyboardInterrupt`` would be printed and forgotten.

    That is in callbacks of ``gc`` (Hypothesis has one: in a campaign every fourth Ctrl-C fell into it), in those of
    weak references (Numba has some) and in ``__del__``. Where Ctrl-C is ignored, or somebody else handles it, this
    does nothing.
    """
    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        return
    main = threading.get_ident()
    heard = threading.Event()
    others = sys.unraisablehook

    def interrupt(number: int, frame: FrameType | None) -> None:
        heard.set()
        signal.default_int_handler(number, frame)

    def hook(dropped: sys.UnraisableHookArgs) -> None:
        if issubclass(dropped.exc_type, KeyboardInterrupt):
            heard.clear()
            threading.Thread(target=_press_until_heard, args=(main, heard), daemon=True).start()
        else:
            others(dropped)

    signal.signal(signal.SIGINT, interrupt)
    sys.unraisablehook = hook


def _press_until_heard(main: int, heard: threading.Event) -> None:
    """Once is not enough: what is pressed just before the main thread begins to wait does not wake it."""
    while not heard.wait(_AGAIN) and signal.getsignal(signal.SIGINT) not in (signal.SIG_IGN, signal.SIG_DFL):
        if sys.platform == "win32":
            import _thread

            _thread.interrupt_main()
        else:
            signal.pthread_kill(main, signal.SIGINT)
