"""A clock makes no loop, however a controller holds it, and correct code works with frozen time."""

import copy
import datetime as dates
import functools
import itertools
import os
import pickle
import random
import time
from datetime import datetime
from typing import ClassVar

import numpy as np
import pytest

from sim import Command, simulate
from tests.helpers.command_line import worldgen
from tests.helpers.halls import hall
from worldgen import write_world

TURN = 512 / 65536 * 2 * np.pi / 0.015
HERE = "tests.sim.test_held_clocks"


def turn(seconds, until):
    return TURN if seconds < until else 0.0


def in_closure(clock):
    def now():
        return clock()

    return now


class Timer:
    """Circles for a quarter of an hour."""

    def reset(self):
        self.until = self.now() + 900.0
        return ()

    def act(self, observation, memory):
        return Command(1.0, turn(self.now(), self.until)), memory


class Injected(Timer):
    def __init__(self, clock=time.monotonic):
        self.now = clock


class InClass(Timer):
    now = staticmethod(time.monotonic)


class InTable(Timer):
    table: ClassVar = {"now": time.monotonic}

    def now(self):
        return self.table["now"]()


class ByDefault(Timer):
    def now(self, clock=time.monotonic):
        return clock()


class ByKeyword(Timer):
    def now(self, *, clock=time.monotonic):
        return clock()


class InClosure(Timer):
    now = staticmethod(in_closure(time.monotonic))


class InPartial(Timer):
    now = functools.partial(lambda clock: clock(), time.monotonic)


class InTuple(Timer):
    clocks = ((time.monotonic,),)

    def now(self):
        return self.clocks[0][0]()


class ByNumber(Timer):
    def now(self):
        return time.clock_gettime(time.CLOCK_MONOTONIC)


class OfDates(Timer):
    moment = dates.datetime

    def now(self):
        return self.moment.now().timestamp()


class OfSystem(Timer):
    def now(self):
        return os.times().elapsed


class AsText(Timer):
    def now(self):
        return int(time.strftime("%Y")) * 1e3


HELD = [Injected, InClass, InTable, ByDefault, ByKeyword, InClosure, InPartial, InTuple]
HELD += [ByNumber, OfDates, OfSystem]


class Chance(Timer):
    """Turns otherwise if a number is drawn that none is."""

    def now(self):
        return 1e9 if self.draw() == 2.0 else 0.0


class OfUrandom(Chance):
    def draw(self, draw=os.urandom):
        return draw(1)


class OfSystemRandom(Chance):
    draw = random.SystemRandom().random


class OfGenerator(Chance):
    def __init__(self):
        self.draw = random.Random().gauss

    def now(self):
        return 1e9 if self.draw(0.0, 1.0) > 100.0 else 0.0


class Sometimes(InClosure):
    """Reads its clock in one step of each round."""

    def reset(self):
        super().reset()
        return (100.0,)

    def act(self, observation, memory):
        if memory[0] == 0.0 and self.now() > self.until:
            return Command(), memory
        return Command(1.0, TURN), ((memory[0] + 1.0) % 128.0,)


@pytest.mark.parametrize("kind", [Sometimes, *HELD, OfUrandom, OfSystemRandom, OfGenerator])
def test_a_clock_or_chance_makes_no_loop_however_it_is_held(kind):
    assert simulate(hall(), f"{HERE}:{kind.__name__}", steps=4000).verdict == "stalled"


@pytest.mark.parametrize("kind", [InClass, InTuple])
def test_run_names_a_clock_that_is_not_a_name_of_the_module(kind, tmp_path):
    write_world(hall(), tmp_path / "w.grid")
    noted = worldgen("run", tmp_path / "w.grid", "--controller", f"{HERE}:{kind.__name__}").err
    assert "uses time.monotonic() (test_held_clocks.py:" in noted


@pytest.mark.parametrize("kind", [InPartial, InTuple])
def test_run_with_frozen_time_names_a_clock_that_stays_real(kind, tmp_path):
    write_world(hall(), tmp_path / "w.grid")
    name = f"{HERE}:{kind.__name__}+frozen_time"
    run = ("run", tmp_path / "w.grid", "--steps", "20", "--controller")
    assert "uses time.monotonic() (test_held_clocks.py:" in worldgen(*run, name).err
    assert "uses" not in worldgen(*run, f"{HERE}:ByDefault+frozen_time").err


def test_a_generator_of_a_module_is_named(tmp_path):
    write_world(hall(), tmp_path / "w.grid")
    (tmp_path / "mine.py").write_text(MINE)
    noted = worldgen("run", tmp_path / "w.grid", "--controller", f"{tmp_path}/mine.py:Robot").err
    assert "survives reset(): the variable dice;" in noted and "make it in reset()" in noted


MINE = """import math
import random

dice = random.Random(1)
TURN = 512 / 65536 * 2 * math.pi / 0.015

class Robot:
    def reset(self): return ()
    def act(self, observation, memory): return (1.0, TURN + 0.0 * dice.random()), memory
"""
SEEN = []


class Looks:
    def reset(self):
        return ()

    def act(self, observation, memory):
        kinds = [*HELD, AsText]
        SEEN.append([kind().now() for kind in kinds if kind not in (InPartial, InTuple)])
        return Command(1.0, 0.0), memory


def test_frozen_time_reaches_a_clock_however_it_is_held():
    SEEN.clear()
    simulate(hall(), f"{HERE}:Looks", steps=2, frozen_time=True)
    *clocks, year = SEEN[0]
    assert clocks == pytest.approx([0.015] * 9, abs=1e-4) and year == 1970e3
    assert InClass.now is time.monotonic and InTable.table == {"now": time.monotonic}
    assert ByDefault.now.__defaults__ == (time.monotonic,)


class Library:
    """Does with dates and generators what correct code may do."""

    def reset(self):
        self.before = datetime(2020, 1, 1)
        return ()

    def act(self, observation, memory):
        now = datetime.now()
        assert type(now) is datetime and type(datetime.today()) is datetime
        assert type(dates.date.today()) is dates.date and type(random.Random()) is random.Random
        dice = random.Random(3)
        for one in (OLD, now, self.before, now + dates.timedelta(1), dates.date.today()):
            assert pickle.loads(pickle.dumps(one)) == copy.deepcopy(one) == one
        assert pickle.loads(pickle.dumps(datetime)) is datetime
        for one in (OLD_DICE, dice):
            assert copy.deepcopy(one).random() == pickle.loads(pickle.dumps(one)).random()

        class Own(random.Random):
            pass

        assert isinstance(Own(), Own) and not isinstance(dice, Own)
        self.kept = [now, dice]
        return Command(1.0, 0.0), memory


OLD = datetime(2020, 1, 1)
OLD_DICE = random.Random(2)


@pytest.mark.parametrize("frozen_time", [False, True])
def test_dates_and_generators_can_be_compared_and_pickled(frozen_time):
    controller = Library()
    episode = simulate(hall(), controller, steps=3, frozen_time=frozen_time)
    assert episode.verdict == "budget" or episode.steps == 3, episode.evidence
    assert pickle.loads(pickle.dumps(controller.kept))[0] == controller.kept[0]
    assert type(pickle.loads(pickle.dumps(controller.kept[0]))) is datetime


class Generators:
    def reset(self):
        return ()

    def act(self, observation, memory):
        made = [np.random.RandomState().rand()]
        made += [
            np.random.Generator(getattr(np.random, name)()).random()
            for name in ("PCG64", "MT19937", "Philox", "SFC64", "PCG64DXSM")
        ]
        made.append(np.random.default_rng(np.random.SeedSequence()).random())
        return Command(1.0, sum(made) % 1.0 * 40.0 - 20.0), memory


def test_each_kind_of_generator_begins_with_the_seed_of_the_run(monkeypatch):
    # RandomState seeds itself from the system first, and then again.
    numbers = itertools.count(1)
    monkeypatch.setattr("numpy.random.bit_generator.randbits", lambda _bits: next(numbers))
    ran = [
        simulate(hall(), f"{HERE}:Generators", steps=20, frozen_time=True, seed=seed)
        for seed in (1, 1, 2)
    ]
    assert [one.steps for one in ran] == [20] * 3, ran[0].evidence
    assert ran[0].trace_digest == ran[1].trace_digest != ran[2].trace_digest
