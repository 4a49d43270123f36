"""With frozen time, a controller sees simulated time and seeded chance, and its runs repeat."""

import datetime
import gc
import itertools
import random
import threading
import time
from datetime import datetime as moment
from time import monotonic

import numpy as np
import pytest
from numpy.random import default_rng

from fuzz.facts.proofs import certified
from fuzz.triage.judging import failure_of
from fuzz.triage.replaying import replay
from sim import Command, RunOptions, Scenario, simulate
from sim.clock import controller_time
from sim.clock.controller_time import UNKNOWN_SOURCE, Effort
from sim.episode.differences import _examined, count_sources, note_difference
from tests.helpers.command_line import worldgen
from tests.helpers.halls import cup, hall
from tests.helpers.raising import raises
from worldgen import write_world
from worldgen.errors import InvalidParameter

HERE = "tests.sim.test_frozen_time"
SEEN = []
MINE = """import random
from time import monotonic

class Dice:
    def __init__(self):
        self.dice = random.Random()
    def reset(self): return ()
    def act(self, observation, memory):
        turn = self.dice.random() + monotonic()
        return (0.5, turn % 1.0), memory
"""


class Controller:
    def reset(self):
        return ()

    def act(self, observation, memory):
        return Command(1.0, self.turn(observation)), memory


class Looks(Controller):
    """Notes all clocks."""

    senses = ("time",)

    def turn(self, observation):
        SEEN.append(
            (
                observation.time,
                time.time(),
                monotonic(),
                time.perf_counter_ns(),
                moment.now(),
                datetime.datetime.now(datetime.UTC).timestamp(),
                datetime.date.today(),
                isinstance(datetime.datetime(2020, 1, 1), moment),
                time.localtime().tm_year,
            )
        )
        return 0.0


class Waits(Controller):
    """Sleeps, and waits for the clock."""

    def turn(self, observation):
        before = time.time()
        time.sleep(1000.0)
        slept = time.time() - before
        rounds = 0
        while time.time() < before + 1000.02:
            rounds += 1
        SEEN.append((slept, rounds))
        return 0.0


class Asks(Controller):
    """Asks another thread for the time."""

    def turn(self, observation):
        found = []
        other = threading.Thread(target=lambda: found.append(time.time()))
        other.start()
        other.join()
        SEEN.append(found[0])
        return 0.0


class Throws(Controller):
    """Draws from each generator that it can have without a seed."""

    def __init__(self):
        self.own = default_rng()
        self.older = random.Random()

    def turn(self, observation):
        numbers = self.own.random(), self.older.random(), random.random(), np.random.rand()
        return sum(numbers) + np.random.default_rng().random() + random.Random().random()


class Clock(Controller):
    def turn(self, observation):
        return time.time() % 1.0 + monotonic() % 1.0


class Dice(Controller):
    def turn(self, observation):
        return random.random()


class Own(Controller):
    """Seeds its dice itself, and counts in a variable of its module."""

    def turn(self, observation):
        random.seed(3)
        SEEN.append(0)
        return len(SEEN) * 1e-3 + random.random()


class Rounds(Controller):
    """Circles, and looks at the clock for no reason."""

    def turn(self, observation):
        time.time()
        return 512 / 65536 * 2 * np.pi / 0.015


class Collects(Controller):
    """Circles, and lets the garbage collector work in each step."""

    def turn(self, observation):
        gc.collect(0)
        return 512 / 65536 * 2 * np.pi / 0.015


class Timer(Controller):
    """Circles for a quarter of an hour."""

    def reset(self):
        self.until = time.time() + 900.0
        return ()

    def turn(self, observation):
        return 512 / 65536 * 2 * np.pi / 0.015 if time.time() < self.until else 0.0


class Fails(Controller):
    def turn(self, observation):
        raise ValueError(time.time())


@pytest.fixture(autouse=True)
def seen(monkeypatch):
    # Each generator without a seed is another one, as in real life.
    numbers = itertools.count(1)
    monkeypatch.setattr("numpy.random.bit_generator.randbits", lambda _bits: next(numbers))
    SEEN.clear()
    _examined.clear()
    return SEEN


def run(kind, seed=0, frozen_time=True, steps=50):
    return simulate(hall(), kind, frozen_time=frozen_time, seed=seed, steps=steps)


def test_the_clock_shows_the_step_times_the_time_step(seen):
    run(Looks, steps=20)
    for number, (sensed, *clocks, date, is_moment, year) in enumerate(seen, 1):
        seconds, mono, counter, now, zoned = clocks
        assert sensed == seconds == number * 0.015
        # Each further reading takes a microsecond.
        passed = [mono, counter / 1e9, (now - moment(1970, 1, 1)).total_seconds(), zoned]
        assert [one - sensed for one in passed] == pytest.approx([1e-6, 2e-6, 3e-6, 4e-6], abs=1e-6)
        assert (date, is_moment, year) == (datetime.date(1970, 1, 1), True, 1970)
    assert len(seen) == 20


def test_sleeping_takes_no_time_and_waiting_ends(seen):
    run(Waits, steps=3)
    assert [slept for slept, _ in seen] == pytest.approx([1000.0] * 3)
    assert all(0 < rounds < 100 for _, rounds in seen)


def test_other_threads_keep_the_real_clock(seen):
    run(Asks, steps=2)
    assert min(seen) > 1e9


@pytest.mark.parametrize("kind", [Throws, Clock, Dice])
def test_runs_repeat_and_depend_on_the_seed(kind):
    digests = [run(f"{HERE}:{kind.__name__}", seed).trace_digest for seed in (1, 1, 2)]
    assert digests[0] == digests[1]
    assert (digests[0] == digests[2]) == (kind is Clock)


def test_nothing_stays_frozen(seen):
    names = [time.time, datetime.datetime, random.Random, np.random.default_rng, random.seed]
    random.seed(5)
    before = random.getstate()
    assert run(Throws).steps == 50 and run(Fails).verdict == "crash"
    assert [
        time.time,
        datetime.datetime,
        random.Random,
        np.random.default_rng,
        random.seed,
    ] == names
    assert random.getstate() == before and moment is datetime.datetime and time.time() > 1e9


@pytest.mark.parametrize("frozen_time", [False, True])
def test_a_clock_that_decides_moves_makes_no_loop_and_any_other_does(frozen_time, tmp_path):
    verdicts = [run(kind, frozen_time=frozen_time, steps=4000).verdict for kind in (Rounds, Timer)]
    assert verdicts == ["loop", "stalled"]


def test_a_clock_that_measures_the_garbage_collector_is_not_the_controllers():
    real = time.perf_counter

    # Hypothesis has such a callback.
    def measure(_phase, _facts):
        real()
        time.monotonic()

    gc.callbacks.append(measure)
    try:
        assert run(Collects, frozen_time=False, steps=4000).verdict == "loop"
    finally:
        gc.callbacks.remove(measure)


def test_run_names_the_clock_that_keeps_a_loop_from_being_proved(tmp_path):
    write_world(hall(), tmp_path / "w.grid")
    run_of = ("run", tmp_path / "w.grid", "--controller")
    noted = worldgen(*run_of, f"{HERE}:Timer").err
    assert "uses time.time() (test_frozen_time.py:" in noted and "+frozen_time" in noted
    assert "time.time()" not in worldgen(*run_of, f"{HERE}:Rounds").err


def test_a_failure_by_clock_and_chance_repeats_with_frozen_time(tmp_path):
    world = certified(hall())
    failure = failure_of(world, Scenario.parse(f"{HERE}:Throws+frozen_time+time_step=0.05"))
    assert failure is not None and failure.record.parameters["frozen_time"] is True
    failure.write(tmp_path / "f.grid")
    assert replay(type(failure).read(tmp_path / "f.grid")).confirmed
    assert Scenario.parse(failure.scenario.label()).run.frozen_time


def test_what_makes_equal_runs_differ_is_named(monkeypatch, tmp_path):
    monkeypatch.setattr(controller_time, "_differences", {})
    began = Effort.so_far()
    world = certified(hall())
    # Real chance decides: a run that happens to arrive shows nothing, so there are several.
    for kind in ("Clock", "Throws"):
        known = began.since().differences
        for _ in range(20):
            assert failure_of(world, Scenario(f"{HERE}:{kind}")) is None
            if began.since().differences != known:
                break
    sources = {one.partition(" (")[0] for one in began.since().differences}
    assert sources == {
        "time.time()",
        "time.monotonic()",
        "random without a seed",
        "numpy.random without a seed",
        "random.Random() without a seed",
        "numpy.random.default_rng() without a seed",
    }
    assert all(".py:" in one for one in began.since().differences if "()" in one)


def test_a_seed_of_its_own_makes_no_runs_differ_and_the_rest_is_unknown(monkeypatch, seen):
    found = {}
    monkeypatch.setattr(controller_time, "_differences", found)
    note_difference(hall(), f"{HERE}:Dice", RunOptions(steps=50))
    assert set(found) == {"random without a seed"}
    found.clear()
    count_sources(hall(), f"{HERE}:Own", RunOptions(steps=50))
    assert set(found) == {UNKNOWN_SOURCE}


def test_only_a_class_that_acts_for_one_robot_is_frozen(tmp_path):
    write_world(hall(), tmp_path / "w.grid")
    with raises(InvalidParameter, "not-in-python"):
        run(f"{HERE}:Many")
    with raises(InvalidParameter, "option-without-effect"):
        Scenario.parse("thesis-1+frozen_time", motion="stepped")
    compiled = worldgen("run", tmp_path / "w.grid", "--controller", "bug2+frozen_time")
    assert "+frozen_time has no effect" in compiled.err


class Many:
    def reset(self):
        return ()

    def act_many(self, observation, memory):
        return Command(1.0, 0.0), memory


@pytest.mark.nightly
def test_explain_shows_the_lines_of_a_run_with_frozen_time(tmp_path):
    (tmp_path / "mine.py").write_text(MINE)
    name = f"{tmp_path}/mine.py:Dice+frozen_time"
    failure = failure_of(certified(cup()), Scenario.parse(name))
    failure.write(tmp_path / "f.grid")
    shown = worldgen("explain", "--trust", tmp_path / "f.grid").out
    assert "x     9 |" in shown and "turn = self.dice.random() + monotonic()" in shown
