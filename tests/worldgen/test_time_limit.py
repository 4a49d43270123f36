"""Code that takes too long is stopped, in every thread."""

import threading

import pytest

from worldgen.support.time_limit import TimeLimitReached, time_limit


def endless():
    while True:
        pass


def test_a_block_that_never_ends_is_ended():
    with pytest.raises(TimeLimitReached), time_limit(0.01):
        endless()


def test_a_block_in_another_thread_is_ended():
    ended = []

    def run():
        try:
            with time_limit(0.01):
                endless()
        except TimeLimitReached:
            ended.append(True)

    thread = threading.Thread(target=run)
    thread.start()
    thread.join()
    assert ended == [True]


def test_a_block_that_catches_it_once_is_ended_again(monkeypatch):
    monkeypatch.setattr("worldgen.support.time_limit._AGAIN", 0.01)
    caught = []
    with pytest.raises(TimeLimitReached), time_limit(0.01):
        try:
            endless()
        except TimeLimitReached:
            caught.append(True)
        endless()
    assert caught == [True]


def test_many_blocks_that_end_about_in_time_leave_nothing_behind():
    for _ in range(300):
        try:
            with time_limit(0.0001):
                sum(range(2000))
        except TimeLimitReached:
            continue
    assert sum(range(100_000)) == 4_999_950_000


def test_an_inner_limit_leaves_the_outer_one():
    with pytest.raises(TimeLimitReached), time_limit(0.05):
        with time_limit(100.0):
            pass
        endless()
