"""Budgets are kept: units end between worlds, long runs between steps, and findings up to then
count.
"""

import json
import math
import os
import signal
import sys
import time
from collections import deque
from contextlib import suppress
from dataclasses import replace
from itertools import count
from types import SimpleNamespace

import pytest

from fuzz.campaign.executors import InlineExecutor
from fuzz.campaign.run import Campaign
from fuzz.campaign.schedule import Beginning, Schedule
from fuzz.campaign.unit import run_unit
from fuzz.screening import evaluate
from fuzz.shrink import shrink
from fuzz.shrink.queue import shrunk_or_same
from fuzz.triage.judging import failure_of
from fuzz.triage.triage import Triage
from fuzz.unit.config import CampaignConfig
from fuzz.unit.deadline import TO_HAND_IN, Deadline
from fuzz.unit.result import UnitResult
from sim import Command, simulate
from sim.clock.stopping import OutOfTime, stopping_when
from sim.episode import prepare
from sim.scenario import Scenario
from tests.helpers.command_line import worldgen
from worldgen import generate

CONFIG = CampaignConfig(Scenario("turn-right"), seed=5, families=("features",), examples=8)


class Spins:
    """Turns on the spot, and counts its calls."""

    senses = ("time",)

    def __init__(self):
        self.asked = 0

    def reset(self):
        return ()

    def act(self, observation, memory):
        self.asked += 1
        return Command(0.0, 1.0), memory


@pytest.fixture
def clock(monkeypatch):
    """A clock that advances by a second whenever it is read."""
    looks = count()
    now = looks.__next__
    monkeypatch.setattr("fuzz.unit.deadline.time", SimpleNamespace(time=now))
    monkeypatch.setattr("fuzz.campaign.schedule.time", SimpleNamespace(monotonic=now))
    return looks


def test_a_unit_ends_at_the_world_at_which_its_time_is_over(clock):
    cut = run_unit(CONFIG, 0, deadline=Deadline(begin=4, prove=1e9))
    whole = run_unit(CONFIG, 0)
    assert cut.cut and 0 < cut.worlds < whole.worlds and not whole.cut


@pytest.mark.parametrize("strategy", ["native", "archive", "boundary", "trap"])
def test_a_unit_of_any_strategy_whose_time_is_over_does_nothing(strategy):
    result = run_unit(replace(CONFIG, families=(strategy,)), 0, deadline=Deadline(0.0, 0.0))
    assert result.cut and result.worlds == 0 and result.strategy == strategy


def test_a_long_run_of_a_slow_controller_ends_between_two_steps():
    controller = Spins()
    looks = count()
    with pytest.raises(OutOfTime), stopping_when(lambda: next(looks) >= 6, clock=lambda: 0.0):
        simulate(generate("trap", 7), controller, steps=5_000)
    assert controller.asked == 1 + 2 + 4 + 8 + 16 + 16


def test_each_step_that_takes_a_second_is_followed_by_a_look_at_the_clock():
    controller = Spins()
    with (
        pytest.raises(OutOfTime),
        stopping_when(lambda: controller.asked >= 5, clock=lambda: float(controller.asked)),
    ):
        simulate(generate("trap", 7), controller, steps=5_000)
    assert controller.asked == 5


def test_steps_that_become_slow_are_looked_at_one_by_one_after_their_batch():
    controller, looked_at = Spins(), []
    clock = lambda: max(0.0, controller.asked - 20.0)  # noqa: E731 - a second for each step after the twentieth
    with (
        pytest.raises(OutOfTime),
        stopping_when(lambda: looked_at.append(controller.asked) or controller.asked >= 34, clock),
    ):
        simulate(generate("trap", 7), controller, steps=5_000)
    assert looked_at == [0, 1, 3, 7, 15, 31, 32, 33, 34]


def test_a_run_in_time_is_the_same_as_one_that_nobody_stops():
    world = generate("trap", 7)
    with stopping_when(lambda: False):
        watched = simulate(world, Spins(), steps=100)
    assert watched == simulate(world, Spins(), steps=100)


def test_a_failure_that_was_met_counts_though_the_time_is_over():
    world = generate("trap", 7)
    scenario = Scenario("turn-right")
    result = UnitResult(strategy="trap")
    options = scenario.options(world)
    outcome = prepare(world, "turn-right", options).run(options.steps, find_loop=True, record=False)
    with pytest.raises(OutOfTime), stopping_when(lambda: True):
        Triage(CONFIG, result, Deadline(begin=0.0)).look(world, scenario, outcome)
    assert result.worlds == 1 and {one.verdict for one in result.failures.values()} == {"loop"}


def test_ctrl_c_in_a_unit_keeps_what_it_met(tmp_path, monkeypatch):
    # A variable of the file would not last, because a run that is judged loads the file again.
    monkeypatch.setattr(sys, "episodes_of_mine", count(), raising=False)
    (tmp_path / "mine.py").write_text(
        "import sys\n"
        "from sim import Command\n"
        "class Mine:\n"
        "    def reset(self):\n"
        "        if next(sys.episodes_of_mine) == 30: raise KeyboardInterrupt\n"
        "        return ()\n"
        "    def act(self, observation, memory): return Command(0.0, 0.0), memory\n"
    )
    config = replace(
        CONFIG, scenario=Scenario(f"{tmp_path}/mine.py:Mine"), examples=80, shrink=False
    )
    campaign = Campaign(config, units=2, executor=InlineExecutor())
    with pytest.raises(KeyboardInterrupt):
        for _ in campaign.run():
            pass
    assert campaign.state.cut == 1 and campaign.state.worlds and campaign.state.met


PRESSES = """
import os, signal
from itertools import count
from sim import Command

EPISODES = count()

class Mine:
    def reset(self):
        if next(EPISODES) == 30:
            os.kill(os.getpid(), signal.SIGINT)
        return ()

    def act(self, observation, memory):
        return Command(0.0, 0.0), memory
"""


@pytest.fixture
def heard():
    """Restore Python's handling of Ctrl-C, however the tests were started."""
    if os.name == "nt":
        pytest.skip("sends itself SIGINT")
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("heard")
def test_ctrl_c_in_the_first_batch_of_a_unit_keeps_what_was_met_until_then(tmp_path):
    (tmp_path / "mine.py").write_text(PRESSES)
    scenario = Scenario(f"{tmp_path}/mine.py:Mine")
    config = replace(CONFIG, scenario=scenario, families=("native",), shrink=False)
    campaign = Campaign(config, units=2, executor=InlineExecutor())
    with pytest.raises(KeyboardInterrupt):
        deque(campaign.run(), maxlen=0)
    assert campaign.state.cut == 1 and 0 < campaign.state.worlds <= 30 and campaign.state.met


@pytest.mark.usefixtures("heard")
def test_work_that_does_not_end_after_ctrl_c_is_interrupted(monkeypatch):
    monkeypatch.setattr("fuzz.campaign.executors.local.TO_HAND_IN", 0.0)

    def endless():
        os.kill(os.getpid(), signal.SIGINT)
        while True:
            pass

    with pytest.raises(KeyboardInterrupt), InlineExecutor() as executor:
        executor.submit(endless)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.usefixtures("heard")
def test_work_that_waits_in_the_system_after_ctrl_c_is_interrupted(monkeypatch):
    monkeypatch.setattr("fuzz.campaign.executors.local.TO_HAND_IN", 0.05)

    def waiting():
        signal.raise_signal(signal.SIGINT)
        time.sleep(10.0)

    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt), InlineExecutor() as executor:
        executor.submit(waiting)
    assert time.monotonic() < began + 9.0


@pytest.mark.usefixtures("heard")
def test_ctrl_c_between_two_pieces_of_work_is_heard_where_the_driver_listens():
    with InlineExecutor() as executor:
        executor.submit(int)
        signal.raise_signal(signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            executor.listen()
        executor.listen()


@pytest.mark.usefixtures("heard")
def test_ctrl_c_that_a_controller_swallows_is_heard_where_the_driver_listens():
    def swallow():
        with suppress(BaseException):
            signal.raise_signal(signal.SIGINT)

    with InlineExecutor() as executor:
        executor.submit(swallow)
        with pytest.raises(KeyboardInterrupt):
            executor.listen()


@pytest.fixture
def stopped(monkeypatch):
    """Press Ctrl-C at time 0, which a worker notices when it reads the clock a second time.

    The clock itself does not move.
    """
    at = SimpleNamespace(now=0.0)
    looks = count()
    monkeypatch.setattr("fuzz.unit.deadline.time", SimpleNamespace(time=lambda: at.now))
    monkeypatch.setattr("fuzz.unit.deadline._stops", [lambda: 0.0 if next(looks) else math.inf])
    return at


@pytest.mark.parametrize("strategy", ["native", "archive"])
def test_a_worker_that_ctrl_c_stops_proves_what_its_unit_met(stopped, strategy):
    result = run_unit(replace(CONFIG, families=(strategy,), examples=100), 0)
    assert result.cut and result.worlds and result.failures


def test_a_worker_that_ctrl_c_stops_does_not_prove_for_longer_than_anybody_waits(stopped):
    stopped.now = TO_HAND_IN
    result = run_unit(replace(CONFIG, families=("native",), examples=100), 0)
    assert result.cut and result.worlds and not result.failures


@pytest.mark.parametrize("strategy", ["native", "archive"])
def test_ctrl_c_in_a_unit_that_proves_at_its_end_keeps_what_it_met(strategy, monkeypatch):
    calls, whole = count(), evaluate

    def evaluate_or_stop(*args, **kwargs):
        if next(calls):
            raise KeyboardInterrupt
        return whole(*args, **kwargs)

    monkeypatch.setattr("fuzz.search.native.evaluate", evaluate_or_stop)
    result = run_unit(replace(CONFIG, families=(strategy,), examples=1_000), 0)
    assert result.interrupted and result.worlds and result.failures


def test_ctrl_c_in_a_proof_of_a_native_unit_keeps_the_other_proofs(monkeypatch):
    config = replace(CONFIG, families=("native",))
    calls = count()
    enter = Triage.enter

    def enter_or_stop(*args, **kwargs):
        if next(calls) == 1:
            raise KeyboardInterrupt
        return enter(*args, **kwargs)

    monkeypatch.setattr(Triage, "enter", enter_or_stop)
    result = run_unit(config, 0)
    assert result.interrupted and result.met.total() > 1


def test_a_shrunk_failure_stays_shrunk_though_there_is_no_time_to_measure_where_it_begins(
    monkeypatch,
):
    def no_time(*_):
        raise OutOfTime

    monkeypatch.setattr("fuzz.shrink.queue.with_boundaries", no_time)
    made = shrunk_or_same(failure_of(generate("trap", 7), Scenario("turn-right")))
    assert not made.complete and made.failure.shrinking == "done"


def test_shrinking_that_runs_out_of_time_keeps_the_failure_as_it_was_found():
    failure = failure_of(generate("trap", 7), Scenario("turn-right"))
    made = shrunk_or_same(failure, seconds=5.0, end=0.0)
    assert not made.complete and made.failure.dumps() == failure.dumps()


def test_shrinking_that_is_cut_short_gives_its_best_so_far(monkeypatch):
    monkeypatch.setattr("fuzz.shrink.run.time", SimpleNamespace(monotonic=count().__next__))
    made = shrink(failure_of(generate("trap", 7), Scenario("turn-right")), seconds=4.0)
    assert not made.complete and made.failure.record.details["one_minimal"] is False


def test_a_quarter_of_the_time_is_for_shrinking_and_the_search_goes_on_where_nothing_is_to_be_shrunk(
    monkeypatch,
):
    at = SimpleNamespace(now=0.0)
    monkeypatch.setattr("fuzz.campaign.schedule.time", SimpleNamespace(monotonic=lambda: at.now))
    monkeypatch.setattr("fuzz.unit.deadline.time", SimpleNamespace(time=lambda: 1000.0 + at.now))
    schedule = Schedule(100.0)
    schedule.begin()
    assert schedule.deadline() == Deadline(1075.0, 1087.5)
    assert schedule.deadline(shrinks=False) == Deadline(1090.0, 1095.0)
    at.now = 76.0
    assert schedule.deadline() == Deadline(1090.0, 1095.0)
    assert not schedule.search_comes_first and schedule.may_search
    assert schedule.for_shrinking(failures=8, workers=2) == (
        pytest.approx(4.2),
        pytest.approx(1082.0),
    )
    at.now = 100.0
    assert schedule.is_over() and not schedule.is_over(grace=1.0)


@pytest.mark.parametrize("start_up", [2.0, 60.0])
def test_what_start_up_takes_does_not_count(start_up, monkeypatch):
    at = SimpleNamespace(now=0.0)
    monkeypatch.setattr("fuzz.campaign.schedule.time", SimpleNamespace(monotonic=lambda: at.now))
    schedule = Schedule(100.0, began=Beginning(0.0))
    at.now = start_up
    schedule.begin()
    at.now = start_up + 99.99
    assert not schedule.is_over()
    at.now = start_up + 100.0
    assert schedule.is_over() and schedule.times()["start-up"] == start_up


def test_a_campaign_tells_start_up_search_and_shrinking_apart(clock):
    campaign = Campaign(CONFIG, seconds=60.0)
    for _ in campaign.run():
        pass
    times = campaign.state.times
    assert list(times) == ["start-up", "search", "shrinking"]
    assert times["search"] > 0.0
    assert times["search"] + times["shrinking"] == pytest.approx(campaign.state.seconds, abs=3.0)


def test_failures_at_every_value_of_an_axis_are_failures(tmp_path):
    (tmp_path / "still.py").write_text(
        "from sim import Command\n"
        "class Still:\n"
        "    def reset(self): return ()\n"
        "    def act(self, observation, memory): return Command(), memory\n"
    )
    config = replace(
        CONFIG,
        scenario=Scenario(f"{tmp_path}/still.py:Still"),
        families=("boundary",),
        examples=128,
    )
    result = run_unit(config, 1)
    assert result.verdicts["loop"] and result.failures


def test_json_of_a_campaign_says_how_long_each_part_took(tmp_path):
    found = worldgen("fuzz", "--controller", "turn-right", "--family", "features", "--examples", 4, "--units", 1,
                         "--workers", 1, "--seed", 1, "--out", tmp_path / "out", "--json")  # fmt: skip
    said = json.loads(found.out)
    assert set(said["times"]) == {"start-up", "search", "shrinking"} and said["units_cut"] == 0


@pytest.mark.parametrize(
    ("tried", "loading", "is_over"), [(0.0, 0.0, False), (6.0, 0.0, False), (6.0, 5.0, True)]
)
def test_what_the_controller_took_before_the_search_counts_in_full(
    tried, loading, is_over, monkeypatch
):
    monkeypatch.setattr("fuzz.campaign.schedule.time.monotonic", lambda: 100.0)
    schedule = Schedule(10.0, began=Beginning(80.0, tried))
    schedule.begin(loading)
    assert schedule.is_over() == is_over
