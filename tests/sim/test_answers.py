"""Answers of slow controllers are reused, and change no result."""

import pytest

from fuzz.facts.proofs import certified
from fuzz.oracles import Oracle, Trial, Violation
from fuzz.overview.counterfactual import counterfactuals
from fuzz.shrink import shrink
from fuzz.triage.judging import failure_of
from fuzz.triage.replaying import replay
from sim import simulate
from sim.clock import controller_time
from sim.controllers import CONTROLLERS, answers
from sim.controllers.instances import origin_of
from sim.scenario import Scenario
from tests.helpers import counting
from tests.helpers.halls import cup, hall

# Turns away from walls, always to the same side, so it repeats itself behind a wall.
BUMPER = """
import math
from sim import Command
from tests.helpers.counting import count, everything, is_odd
{before}

class Bumper:
    {field}
    def reset(self):
        {reset}
        return (0.0,)
    def act(self, observation, memory):
        count()
        {act}
        if observation.bump:
            {bump}
            return Command(0.0, 1.5 / observation.time_step), (20.0,)
        if memory[0] > 0:
            return Command(observation.top_speed, 0.0), (memory[0] - 1,)
        ahead = observation.target_heading - observation.heading
        turn = (ahead + math.pi) % math.tau - math.pi
        return Command(observation.top_speed, turn / observation.time_step), (0.0,)
"""
PARTS = {"before": "", "field": "pass", "reset": "pass", "act": "pass", "bump": "pass"}

# Where bumps are counted, and the parts that this takes.
HIDDEN = {
    "self.hits": {"reset": "self.hits = 0"},
    "Bumper.hits": {"field": "hits = 0"},
    "STATE['hits']": {"before": "STATE = {'hits': 0}"},
}


@pytest.fixture(autouse=True)
def slow(monkeypatch):
    """Let every class count as slow, whatever the machine."""
    monkeypatch.setattr(answers, "SLOW_STEP", 0.0)
    monkeypatch.setattr(controller_time, "_differences", {})


def bumper(folder, **parts):
    file = folder / "bumper.py"
    file.write_text(BUMPER.format(**PARTS | parts))
    return f"{file}:Bumper"


def calls_of(work):
    before = counting.calls()
    result = work()
    return counting.calls() - before, result


def known(name):
    return origin_of(CONTROLLERS.get(name)).answers


def test_a_run_that_is_known_hardly_calls_the_controller(tmp_path):
    name = bumper(tmp_path)
    world = certified(cup())
    first = simulate(world, name, record=True)
    calls, second = calls_of(lambda: simulate(world, name, record=True))
    assert first.verdict == "loop"
    assert (second.verdict, second.trace_digest) == (first.verdict, first.trace_digest)
    assert calls < first.steps // 8


def test_a_quick_class_is_always_called(tmp_path, monkeypatch):
    monkeypatch.setattr(answers, "SLOW_STEP", 1e9)
    name = bumper(tmp_path)
    world = hall()
    first, _ = calls_of(lambda: simulate(world, name, steps=200))
    second, _ = calls_of(lambda: simulate(world, name, steps=200))
    assert first == second
    assert known(name).is_off


@pytest.mark.parametrize("hits", HIDDEN)
def test_state_outside_the_memory_ends_reuse_and_changes_no_result(tmp_path, monkeypatch, hits):
    after = f"if {hits} > 7: return Command(observation.top_speed, 0.0), (3.0,)"
    parts = {**HIDDEN[hits], "act": after, "bump": f"{hits} += 1"}
    world = certified(cup())
    (tmp_path / "slow").mkdir()
    (tmp_path / "quick").mkdir()
    name = bumper(tmp_path / "slow", **parts)
    ours = [simulate(world, name, record=True) for _ in range(3)]
    assert known(name).is_off or hits == "self.hits"
    monkeypatch.setattr(answers, "SLOW_STEP", 1e9)
    plain = bumper(tmp_path / "quick", **parts)
    theirs = [simulate(world, plain, record=True) for _ in range(3)]
    assert [(one.verdict, one.trace_digest) for one in ours] == [
        (one.verdict, one.trace_digest) for one in theirs
    ]


# Looks for a way out to the other side after every third bump.
STATEFUL = {
    "reset": "self.hits = 0",
    "act": "if self.hits % 3 == 2 and memory[0] > 10: return Command(0.5, 0.8), (memory[0] - 1,)",
    "bump": "self.hits += 1",
}


def test_answers_of_a_class_with_state_are_reused_while_all_was_the_same(tmp_path, monkeypatch):
    (tmp_path / "slow").mkdir()
    (tmp_path / "quick").mkdir()
    name = bumper(tmp_path / "slow", **STATEFUL)
    plan = [(world, steps) for world in (cup(), cup(7), hall()) for steps in (900, 300, 700)]

    def all_runs(controller):
        runs = [simulate(one, controller, steps=n, record=True) for one, n in plan]
        return [(one.verdict, one.trace_digest, one.trace.complete) for one in runs]

    monkeypatch.setattr(answers, "_CHECKED_RUNS", 10**9)
    ours = [all_runs(name) for _ in range(2)]
    calls, third = calls_of(lambda: all_runs(name))
    assert calls == 0
    assert known(name).by_history
    monkeypatch.setattr(answers, "SLOW_STEP", 1e9)
    plain = bumper(tmp_path / "quick", **STATEFUL)
    assert [*ours, third] == [all_runs(plain)] * 3


def test_an_answer_that_differs_ends_reuse_and_is_reported(tmp_path):
    name = bumper(tmp_path, act="if everything() % 900 == 0: memory = (5.0,)")
    world = certified(cup())
    for _ in range(40):
        simulate(world, name)
        if known(name).is_off:
            break
    assert known(name).is_off
    assert set(controller_time._differences) == {controller_time.UNKNOWN_SOURCE}


def test_the_run_that_confirms_a_loop_calls_the_controller_in_two_periods(tmp_path):
    name = bumper(tmp_path)
    world = certified(cup())
    failure = failure_of(world, Scenario.parse(name), fewest_steps=4000)
    loop = failure.evidence
    calls, again = calls_of(lambda: failure_of(world, Scenario.parse(name), fewest_steps=4000))
    assert again.record == failure.record
    assert calls >= loop.entry + 2 * loop.period


def test_a_loop_is_not_run_again_if_its_proof_got_all_answers_a_second_time(tmp_path, monkeypatch):
    name = bumper(tmp_path)
    monkeypatch.setattr(Trial, "again", None)
    failure = failure_of(certified(cup()), Scenario.parse(name), fewest_steps=4000)
    assert failure.verdict == "loop"
    assert known(name).repeated_proofs == 1


class Undecided(Oracle):
    """Finds something else in each run."""

    by_verdict = False
    seen = 0

    def check(self, trial):
        self.seen += 1
        return Violation("undecided", trial.episode.evidence, "undecided", {"number": self.seen})


def test_a_finding_of_an_oracle_must_come_again_also_in_a_loop(tmp_path):
    oracle = Undecided()
    assert failure_of(certified(cup()), Scenario.parse(bumper(tmp_path)), oracle) is None
    assert oracle.seen >= 2


def test_the_run_that_confirms_a_failure_notices_what_reused_answers_hide(tmp_path, monkeypatch):
    name = bumper(tmp_path, act="if is_odd() and everything() % 3 == 0: memory = (5.0,)")
    world = certified(cup())
    scenario = Scenario.parse(name)
    assert failure_of(world, scenario) is not None
    monkeypatch.setattr(counting, "IS_ODD", True)
    monkeypatch.setattr(answers, "_CHECKED_EVERY", 10**9)
    assert simulate(world, name).verdict == "loop"
    assert failure_of(world, scenario) is None
    assert controller_time.UNKNOWN_SOURCE in controller_time._differences


def test_a_replay_calls_the_controller_in_two_periods_and_no_longer(tmp_path):
    name = bumper(tmp_path)
    failure = failure_of(certified(cup()), Scenario.parse(name), fewest_steps=4000)
    loop = failure.evidence
    known(name).forget()
    calls, replayed = calls_of(lambda: replay(failure))
    proof = loop.entry + 2 * loop.period
    assert replayed.confirmed
    assert proof <= calls < 1.25 * proof


@pytest.mark.gate
def test_an_explanation_tries_the_other_kinds_before_all_cells(tmp_path):
    name = bumper(tmp_path)
    failure = failure_of(certified(cup()), Scenario.parse(name), fewest_steps=4000)
    found = counterfactuals(failure, most_runs=100)
    assert not found.is_complete
    assert [one.what for one in found.changes] == ["speed"]


@pytest.mark.nightly
def test_shrinking_a_slow_class_with_a_time_limit_ends_in_a_world_without_a_removable_cell(
    tmp_path,
):
    name = bumper(tmp_path)
    failure = failure_of(certified(cup(3)), Scenario.parse(name), fewest_steps=4000)
    made = shrink(failure, seconds=600.0)
    assert made.complete
    assert made.left == ()
    assert made.failure.verdict == "loop"
