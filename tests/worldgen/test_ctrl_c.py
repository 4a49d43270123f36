"""Ctrl-C is heard, wherever it falls."""

import gc
import signal
import time

import pytest

from worldgen.cli.ctrl_c import never_lose_ctrl_c


@pytest.fixture
def ctrl_c():
    """Ctrl-C as a command has it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    never_lose_ctrl_c()
    yield lambda: signal.raise_signal(signal.SIGINT)
    signal.signal(signal.SIGINT, before)


def wait():
    end = time.monotonic() + 30
    while time.monotonic() < end:
        time.sleep(0.001)


def test_it_is_heard_at_once(ctrl_c):
    with pytest.raises(KeyboardInterrupt):
        ctrl_c()


def test_one_that_falls_into_the_collection_of_garbage_is_heard_after_it(ctrl_c):
    calls = []

    def callback(phase, info):
        if not calls:
            calls.append(phase)
            ctrl_c()

    gc.callbacks.append(callback)
    try:
        with pytest.raises(KeyboardInterrupt):
            gc.collect()
            wait()
    finally:
        gc.callbacks.remove(callback)
    assert calls == ["start"]


def test_where_it_is_ignored_it_stays_so(ctrl_c):
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    never_lose_ctrl_c()
    assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
