"""Ctrl-C while a driver waits for its worker processes."""

import os
import signal
import threading
import time

import pytest

from worldgen.plugins.workers import WorkerPool, ctrl_c_held_back

pytestmark = pytest.mark.skipif(os.name == "nt", reason="sends itself SIGINT")


def press():
    os.kill(os.getpid(), signal.SIGINT)


def test_ctrl_c_is_heard_where_the_driver_listens_and_nowhere_else():
    before = signal.getsignal(signal.SIGINT)
    with ctrl_c_held_back() as listen:
        listen()
        for _ in range(2):  # after being noticed once, it is held back again
            press()
            with pytest.raises(KeyboardInterrupt):
                listen()
            listen()
    assert signal.getsignal(signal.SIGINT) == before


def test_a_second_ctrl_c_is_not_held_back():
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt), ctrl_c_held_back():
        press()
        press()
        signal.getsignal(signal.SIGINT)  # the next code to run is interrupted
    assert signal.getsignal(signal.SIGINT) == before


def test_ctrl_c_that_is_ignored_stays_so_where_a_driver_listens():
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with ctrl_c_held_back() as listen:
            press()
            listen()
    finally:
        signal.signal(signal.SIGINT, before)


def test_outside_the_main_thread_nothing_is_changed():
    before, seen = signal.getsignal(signal.SIGINT), []

    def elsewhere():
        with ctrl_c_held_back() as listen:
            listen()
            seen.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=elsewhere)
    thread.start()
    thread.join()
    assert seen == [before]


def test_workers_of_a_pool_ignore_ctrl_c():
    with WorkerPool(1) as pool:
        assert pool.submit(signal.getsignal, signal.SIGINT).result() == signal.SIG_IGN


def test_a_pool_ends_a_worker_that_is_busy():
    pool = WorkerPool(1)
    pool.submit(signal.getsignal, signal.SIGINT).result()
    (process,) = pool._processes.values()
    pool.submit(time.sleep, 600)
    pool.end()
    # The pool's own thread also waits for the process. If it is first, join() returns before that
    # thread has stored the exit code.
    while process.exitcode is None:
        process.join(0.01)
    assert process.exitcode == -signal.SIGTERM
