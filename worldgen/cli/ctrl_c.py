"""Ctrl-C that is not lost: Python drops what is raised while garbage is collected."""

from __future__ import annotations

import signal
from types import FrameType

__all__ = ["never_lose_ctrl_c"]

_AGAIN = 0.01  # s


def never_lose_ctrl_c() -> None:
    """Puts Ctrl-C off where ``KeyboardInterrupt`` would be printed and forgotten: in callbacks of ``gc``.

    Hypothesis has such a callback; in a campaign every fourth Ctrl-C fell into it. Where Ctrl-C is ignored, or somebody
    else handles it, this does nothing.
    """
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupt)


def _interrupt(number: int, frame: FrameType | None) -> None:
    if _is_collecting(frame):
        import _thread
        import threading

        threading.Timer(_AGAIN, _thread.interrupt_main).start()
    else:
        signal.default_int_handler(number, frame)


def _is_collecting(frame: FrameType | None) -> bool:
    import gc

    callbacks = [getattr(callback, "__code__", None) for callback in gc.callbacks]
    while frame is not None:
        if frame.f_code in callbacks:
            return True
        frame = frame.f_back
    return False
