"""Measuring the time spent in controllers' own code."""

import itertools

import pytest

from sim import Command, RunOptions, simulate
from sim.clock import controller_time as module
from sim.clock.controller_time import Effort, timed
from sim.clock.stopping import OutOfTime
from sim.episode import prepare
from worldgen import generate


@pytest.fixture
def clock(monkeypatch):
    """A clock that advances by a second whenever it is read."""
    seconds = itertools.count()
    monkeypatch.setattr(module.time, "perf_counter", lambda: float(next(seconds)))


def own_time_of(work):
    before = Effort.so_far()
    work()
    return before.since().own


def test_a_timed_call_counts_as_its_controllers_own(clock):
    assert own_time_of(timed(lambda: None)) == 1.0


def test_a_timed_call_that_raises_counts_too(clock):
    def fail():
        raise ValueError("no way")

    def work():
        with pytest.raises(ValueError, match="no way"):
            timed(fail)()

    assert own_time_of(work) == 1.0


def test_a_share_is_never_more_than_all():
    assert Effort(1.0, 1.7).share == 1.0
    assert Effort().share == 0.0
    assert (Effort(1.0, 0.5) + Effort(3.0, 0.5)).share == 0.25


class Ahead:
    """Drives ahead."""

    def reset(self):
        return ()

    def act(self, observation, memory):
        return Command(observation.top_speed), memory


@pytest.mark.parametrize(
    ("calls", "seconds"), [(1, 1.0), (1 + 17, 1.0 + 17.0), (1 + 17 * 5, 1.0 + 17.0 * 5)]
)
def test_measured_steps_of_a_python_class_count_for_all(calls, seconds, clock):
    run = prepare(generate("corridor", 1), Ahead(), RunOptions(steps=calls))
    of_reset = 1.0
    work = lambda: run.run(calls, find_loop=False, record=False, digest=False)  # noqa: E731
    assert own_time_of(work) == of_reset + seconds


class Hangs(Ahead):
    """Is interrupted after a hundred seconds of its third step."""

    def act(self, observation, memory):
        if memory[0] == 2:
            for _ in range(100):
                module.time.perf_counter()
            raise OutOfTime
        return Command(observation.top_speed), (memory[0] + 1,)

    def reset(self):
        return (0,)


def test_a_step_that_is_interrupted_counts_although_it_is_not_measured(clock):
    def work():
        with pytest.raises(OutOfTime):
            simulate(generate("corridor", 1), Hangs(), steps=50)

    assert 100.0 <= own_time_of(work) < 120.0


def test_runs_of_a_compiled_controller_do_not(clock):
    assert own_time_of(lambda: simulate(generate("corridor", 1), "turn-right", steps=40)) == 0.0
