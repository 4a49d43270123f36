"""Runs that end when the time is up, even in the middle of a step that does not end."""

import signal

import pytest

from sim import Command, simulate
from sim.clock.stopping import OutOfTime, breakable, steps_broken_off, stopping_when, unbreakable
from sim.episode.try_out import try_out
from sim.scenario import Scenario
from tests.helpers.raising import raises
from worldgen import InvalidParameter, generate

TICKS = 5  # longer than any remaining step


def tick():
    """Let the clock check a step that takes forever."""
    for _ in range(TICKS):
        signal.raise_signal(signal.SIGALRM)


class TakesForever:
    """In its third step the time is up, and the step continues."""

    def __init__(self):
        self.steps = 0

    def is_over(self):
        return self.steps >= 3

    def reset(self):
        return ()

    def act(self, observation, memory):
        self.steps += 1
        tick()
        return Command(observation.top_speed), memory


class Swallows(TakesForever):
    """Catches every exception that it can."""

    def act(self, observation, memory):
        try:
            return super().act(observation, memory)
        except Exception:  # noqa: BLE001 - as careless controllers do
            return Command(), memory


@pytest.mark.parametrize("kind", [TakesForever, Swallows])
def test_a_step_that_goes_on_when_the_time_is_over_is_broken_off(kind):
    controller = kind()
    before = steps_broken_off()
    with pytest.raises(OutOfTime), stopping_when(controller.is_over):
        simulate(generate("corridor", 1), controller, steps=50)
    assert controller.steps == 3
    assert steps_broken_off() == before + 1


def test_no_step_is_broken_off_while_there_is_time():
    controller = TakesForever()
    with stopping_when(lambda: False):
        simulate(generate("corridor", 1), controller, steps=9)
    assert controller.steps == 9


def test_nothing_but_a_step_is_broken_off():
    with stopping_when(lambda: True):
        tick()


def test_what_must_not_be_broken_off_goes_on_in_a_step():
    @unbreakable
    def ends_by_itself():
        tick()

    @breakable
    def step():
        ends_by_itself()

    with stopping_when(lambda: True):
        step()


def test_the_signal_is_given_back():
    with stopping_when(lambda: False), stopping_when(lambda: False):
        pass
    assert signal.getsignal(signal.SIGALRM) is signal.SIG_DFL
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)


def test_a_handler_of_somebody_else_stays():
    heard = []
    signal.signal(signal.SIGALRM, lambda number, _: heard.append(number))
    try:
        with stopping_when(lambda: True):
            tick()
    finally:
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
    assert len(heard) == TICKS


def test_a_class_that_is_too_slow_for_two_steps_is_refused():
    with raises(InvalidParameter, "first-steps-too-slow"):
        try_out(Scenario("sim.controllers.examples.python:Example"), seconds=-1.0)


@pytest.mark.parametrize(
    "controller",
    [
        "sim.controllers.examples.python:Example",
        "sim.controllers.examples.vector:Example",
        "turn-right",
    ],
)
def test_a_controller_with_time_enough_is_tried_out(controller):
    assert try_out(Scenario(controller), seconds=1e9).steps == 2
