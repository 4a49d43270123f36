"""Ctrl-C is heard, wherever it falls."""

import gc
import signal
import sys
import time
import weakref

import pytest

from worldgen.cli.ctrl_c import never_lose_ctrl_c


@pytest.fixture
def ctrl_c():
    """Ctrl-C as a command has it."""
    handler = signal.signal(signal.SIGINT, signal.default_int_handler)
    hook = sys.unraisablehook
    never_lose_ctrl_c()
    yield lambda: signal.raise_signal(signal.SIGINT)
    sys.unraisablehook = hook
    signal.signal(signal.SIGINT, handler)


def test_it_is_heard_at_once(ctrl_c):
    with pytest.raises(KeyboardInterrupt):
        ctrl_c()


def in_callback_of_the_collection(press):
    def callback(phase, info):
        gc.callbacks.remove(callback)
        press()

    gc.callbacks.append(callback)
    gc.collect()


def in_callback_of_a_weak_reference(press):
    thing = set()
    reference = weakref.ref(thing, lambda _: press())
    del thing
    assert reference() is None


def in_a_finalizer(press):
    class Thing:
        def __del__(self):
            press()

    Thing()


@pytest.mark.parametrize("fall", [in_callback_of_the_collection, in_callback_of_a_weak_reference, in_a_finalizer])
def test_one_that_falls_where_nobody_can_catch_it_is_heard_after_it(ctrl_c, fall):
    pressed = []

    def press():
        pressed.append(True)
        ctrl_c()

    before = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        fall(press)
        time.sleep(60)
    assert pressed
    assert time.monotonic() - before < 30, "it was heard only when the waiting had ended"


def test_what_else_is_dropped_is_told_as_ever(monkeypatch, request):
    told = []
    monkeypatch.setattr(sys, "unraisablehook", told.append)
    request.getfixturevalue("ctrl_c")

    def fail():
        raise ValueError("not Ctrl-C")

    in_callback_of_a_weak_reference(fail)
    assert [str(dropped.exc_value) for dropped in told] == ["not Ctrl-C"]


def test_where_it_is_ignored_it_stays_so(ctrl_c):
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    never_lose_ctrl_c()
    assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
