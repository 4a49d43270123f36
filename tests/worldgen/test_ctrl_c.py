"""Ctrl-C is noticed, whenever it is pressed."""

import _thread
import gc
import signal
import sys
import threading
import time
import weakref
from types import SimpleNamespace

import pytest

from worldgen.cli.ctrl_c import no_ctrl_c_lost


@pytest.fixture(autouse=True)
def usual():
    """Restore Python's handling of Ctrl-C, however the tests were started."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(autouse=True)
def until_nobody_repeats_it(usual, monkeypatch):
    """Waits for the threads that press Ctrl-C again, if there are any.

    ``threading`` does not know them.
    """
    ends = []

    def start(function, arguments):
        end = threading.Event()

        def run():
            try:
                function(*arguments)
            finally:
                end.set()

        ends.append(end)
        _thread.start_new_thread(run, ())

    def wait():
        for end in ends:
            end.wait()

    started = SimpleNamespace(start_new_thread=start, interrupt_main=_thread.interrupt_main)
    monkeypatch.setattr("worldgen.cli.ctrl_c._thread", started)
    yield wait
    wait()


def ctrl_c():
    signal.raise_signal(signal.SIGINT)


def test_it_is_heard_at_once():
    with pytest.raises(KeyboardInterrupt), no_ctrl_c_lost():
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


FALLS = [in_callback_of_the_collection, in_callback_of_a_weak_reference, in_a_finalizer]


@pytest.mark.parametrize("fall", FALLS)
def test_one_that_falls_where_nobody_can_catch_it_is_heard_once_after_it(
    fall, until_nobody_repeats_it
):
    happened = []

    def press():
        happened.append("pressed")
        ctrl_c()

    with no_ctrl_c_lost():
        with pytest.raises(KeyboardInterrupt):
            fall(press)
            time.sleep(60)
            happened.append("waited to the end")
        until_nobody_repeats_it()  # a second one would be raised here
    assert happened == ["pressed"]


def test_none_is_lost_beside_a_busy_thread():
    done = threading.Event()

    def busy():
        while not done.is_set():
            sum(range(1000))

    thread = threading.Thread(target=busy, daemon=True)
    thread.start()
    try:
        for _ in range(20):
            with no_ctrl_c_lost(), pytest.raises(KeyboardInterrupt):
                in_callback_of_a_weak_reference(ctrl_c)
                time.sleep(60)
    finally:
        done.set()
        thread.join()


def test_whoever_handles_it_by_then_gets_it_once(monkeypatch, until_nobody_repeats_it):
    other_is_there = threading.Event()
    monkeypatch.setattr(
        "worldgen.cli.ctrl_c.time", SimpleNamespace(sleep=lambda _: other_is_there.wait())
    )
    heard = []
    with no_ctrl_c_lost():
        in_callback_of_a_weak_reference(ctrl_c)
        signal.signal(signal.SIGINT, lambda *_: heard.append(True))
        other_is_there.set()
        until_nobody_repeats_it()
    assert heard == [True]


def test_afterwards_all_is_as_it_was():
    before = signal.getsignal(signal.SIGINT), sys.unraisablehook
    with no_ctrl_c_lost():
        assert (
            signal.getsignal(signal.SIGINT) is not before[0] and sys.unraisablehook is not before[1]
        )
    assert (signal.getsignal(signal.SIGINT), sys.unraisablehook) == before


@pytest.mark.parametrize(
    "raised", [ValueError("no Ctrl-C"), KeyboardInterrupt("of a program's own")]
)
def test_what_else_is_dropped_is_told_as_ever(monkeypatch, raised, until_nobody_repeats_it):
    told = []
    monkeypatch.setattr(sys, "unraisablehook", lambda dropped: told.append(dropped.exc_value))

    def fail():
        raise raised

    with no_ctrl_c_lost():
        in_callback_of_a_weak_reference(fail)
        until_nobody_repeats_it()
    assert told == [raised]


def test_where_it_is_ignored_it_stays_so():
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with no_ctrl_c_lost():
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
