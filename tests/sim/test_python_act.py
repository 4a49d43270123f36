"""A Python class in the loop of the core.

Its arguments, its valid answers, and that neither leaks.
"""

import gc
import sys
from dataclasses import dataclass, field
from fractions import Fraction
from typing import NamedTuple

import numpy as np
import pytest

from sim import Command, Observation, simulate
from tests.sim.test_episode import arena


class Numbers(NamedTuple):
    """A memory with names."""

    turns: float
    rest: float


class Slower(Command):
    """A subclass of Command."""


@dataclass
class Zigzag:
    """Drives and turns with the random number, and answers in the given form."""

    form: object
    memories: list = field(default_factory=list, compare=False)

    def reset(self):
        return (0.0, 3.0)

    def act(self, observation, memory):
        self.memories.append(memory)
        turns, rest = memory
        turn = 2.0 * observation.random - 1.0 if rest == 0.0 else 0.0
        return self.form(Command(1.0, turn, rest == 0.0), (turns + 1.0, (rest - 1.0) % 4.0))


def as_it_should_be(asked, memory):
    return asked, memory


FORMS = {
    "a plain tuple": lambda asked, memory: (tuple(asked), memory),
    "a list": lambda asked, memory: [list(asked), memory],
    "a class of one's own": lambda asked, memory: (Slower(*asked), memory),
    "whole numbers": lambda asked, memory: (
        Command(1, asked.turn_rate, int(asked.used_random)),
        (*map(int, memory),),
    ),
    "NumPy's numbers": lambda asked, memory: (
        Command(*map(np.float64, asked)),
        (*map(np.float64, memory),),
    ),
    "NumPy's small numbers": lambda asked, memory: (asked, (*map(np.float32, memory),)),
    "what becomes a number": lambda asked, memory: (
        Command(Fraction(1), *asked[1:]),
        (*map(Fraction, memory),),
    ),
    "a memory with names": lambda asked, memory: (asked, Numbers(*memory)),
    "an iterator": lambda asked, memory: iter((asked, memory)),
}


@pytest.mark.parametrize("form", FORMS.values(), ids=FORMS)
def test_an_answer_of_any_form_drives_as_a_command_and_a_memory(form):
    expected = simulate(arena(), Zigzag(as_it_should_be), steps=60)
    assert simulate(arena(), Zigzag(form), steps=60).trace_digest == expected.trace_digest


@pytest.mark.parametrize("form", FORMS.values(), ids=FORMS)
def test_the_memory_comes_back_as_a_tuple_of_floats(form):
    controller = Zigzag(form)
    simulate(arena(), controller, steps=20)
    assert {type(memory) for memory in controller.memories} == {tuple}
    assert {type(number) for memory in controller.memories for number in memory} == {float}


def test_a_command_of_two_numbers_uses_no_random_number():
    plain = simulate(arena(), Zigzag(lambda asked, memory: (Command(*asked[:2]), memory)), steps=60)
    short = simulate(arena(), Zigzag(lambda asked, memory: (asked[:2], memory)), steps=60)
    assert short.trace_digest == plain.trace_digest


@dataclass
class Keeps:
    """Turns, and keeps each observation next to a copy of it."""

    kept: list = field(default_factory=list, compare=False)

    def reset(self):
        return ()

    def act(self, observation, memory):
        self.kept.append((observation, [*observation]))
        return Command(1.0, 0.5), memory


def test_an_observation_that_is_kept_stays_as_it_was():
    controller = Keeps()
    simulate(arena(), controller, steps=50, beams=3, beam_range=2.0)
    assert len({observation.x for observation, _ in controller.kept}) > 10
    assert all(repr([*observation]) == repr(copy) for observation, copy in controller.kept)


def test_an_observation_has_the_types_that_it_declares():
    controller = Keeps()
    simulate(arena(), controller, steps=3, beams=3, beam_range=2.0)
    observation, _ = controller.kept[-1]
    assert type(observation) is Observation
    assert type(observation.bump) is bool
    assert type(observation.beams) is tuple
    numbers = (one for one in observation[1:] if type(one) is not tuple)
    assert {type(number) for number in (*numbers, *observation.beams)} == {float}


def test_a_robot_without_beams_sees_an_empty_tuple():
    controller = Keeps()
    simulate(arena(), controller, steps=3)
    assert controller.kept[-1][0].beams == ()
    assert controller.kept[-1][0].neighbours == ()


@dataclass
class Answers:
    """Gives the same answer in each step."""

    answer: object
    memory: tuple = ()

    def reset(self):
        return self.memory

    def act(self, observation, memory):
        return self.answer


def observations():
    """Count the observations in memory."""
    return sum(type(thing) is Observation for thing in gc.get_objects())


@pytest.mark.nightly
@pytest.mark.parametrize(
    "form",
    [lambda asked, memory: (asked, memory), lambda asked, memory: [asked, memory]],
    ids=["quick", "settled in Python"],
)
def test_a_run_leaves_no_references(form):
    asked = Command(0.25, 0.125)
    memory = (float("2.5"), float("7.5"))
    controller = Answers(form(asked, memory), memory)
    simulate(arena(), controller, steps=5)
    gc.collect()
    kept = (asked, memory, memory[0], Command)
    before = [*map(sys.getrefcount, kept), observations()]
    simulate(arena(), controller, steps=500)
    gc.collect()
    assert [*map(sys.getrefcount, kept), observations()] == before


def test_a_memory_that_is_no_number_is_told_before_a_command_that_is_none():
    found = simulate(arena(), Answers((7, ("x",)), (0.0,)), steps=5)
    assert found.verdict == "invalid-command"
    assert found.evidence.error == "the memory is not a tuple of numbers"


@pytest.mark.parametrize("speed", ["fast", None, [1.0], 10**400])
def test_a_speed_that_is_no_number_is_an_invalid_command(speed):
    assert simulate(arena(), Answers((Command(speed), ())), steps=5).verdict == "invalid-command"


def test_a_flag_without_a_truth_is_a_crash():
    found = simulate(arena(), Answers((Command(1.0, 0.0, np.zeros(2)), ())), steps=5)
    assert found.verdict == "crash"
    assert found.evidence.error.startswith("ValueError: The truth value of an array")


def test_ctrl_c_in_a_step_ends_the_run():
    class Interrupted(Answers):
        def act(self, observation, memory):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate(arena(), Interrupted(None), steps=5)
