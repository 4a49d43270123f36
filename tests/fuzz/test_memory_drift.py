"""A memory that drifts by rounding errors while the pose repeats is reported, and is no loop."""

import math
from dataclasses import replace

import pytest

from fuzz.evidence_checks import check_evidence
from fuzz.facts.proofs import certified
from fuzz.overview.building import explained
from fuzz.overview.describe import describe
from fuzz.triage.judging import failure_of, repeatable
from fuzz.triage.replaying import replay
from sim import Command, Scenario, simulate
from sim.evidence import BudgetEvidence, evidence_table, read_evidence
from sim.motion import MOTIONS
from sim.verdict import Verdict
from tests.helpers.command_line import worldgen
from tests.helpers.halls import cup
from worldgen import write_world

HERE = "tests.fuzz.test_memory_drift"
SWEPT = MOTIONS.get("swept")


class Ahead:
    """Drives towards the target, into the bottom of the cup."""

    senses = ("heading", "target_heading")

    def reset(self):
        return (1.0, 0.0)

    def act(self, observation, memory):
        turn = math.remainder(observation.target_heading - observation.heading, math.tau)
        return Command(2.0, turn / 0.015), (1.0, self.changed(memory[1]))


class Drifts(Ahead):
    def changed(self, number):
        return number + 2e-18


class Counts(Ahead):
    def changed(self, number):
        return number + 1.0


class Large(Ahead):
    """Begins with a large number, as a counter of steps or a clock does."""

    def __init__(self, first, change):
        self.first = first
        self.change = change

    def reset(self):
        return (1.0, self.first)

    def changed(self, number):
        return number + self.change


class Settles(Ahead):
    def changed(self, number):
        return number / 2 if number > 1e-300 else 0.0


@pytest.fixture(scope="module")
def world():
    return certified(cup())


@pytest.fixture(scope="module")
def episode(world):
    return simulate(world, Drifts(), record=True)


def test_a_memory_that_only_rounding_changes_is_evidence_of_a_stalled_run(world, episode):
    evidence = episode.evidence
    assert episode.verdict == "stalled" and evidence.period == 1
    number, change = evidence.memory_drift
    assert number == 1 and change == pytest.approx(2e-18)
    assert read_evidence(Verdict.STALLED, evidence_table(evidence)) == evidence
    assert check_evidence("stalled", world, episode.trace, evidence, SWEPT) == ""


def test_a_counter_is_no_drift_and_a_memory_that_settles_is_a_loop(world):
    counted = simulate(world, Counts(), record=True)
    assert counted.verdict == "stalled" and counted.evidence.memory_drift is None
    assert simulate(world, Settles(), record=True).verdict == "loop"


@pytest.mark.parametrize(
    ("first", "change"),
    [(1.7e9, 1e-3), (1e15, 1.0), (0.0, 1e-12), (2.0**60, 2.0**10)],
    ids=["clock", "counter", "small-counter", "large-counter"],
)
def test_a_clock_or_a_counter_with_large_numbers_is_no_drift(world, first, change):
    counted = simulate(world, Large(first, change), record=True)
    assert counted.verdict == "stalled" and counted.evidence.memory_drift is None


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"memory_drift": (0, 2e-18)}, "is not the number that changes most"),
        ({"memory_drift": (9, 2e-18)}, "is not the number that changes most"),
        ({"memory_drift": (1, 3e-18)}, "does not change by 3e-18 a step"),
        ({"entry": 0}, "is not shown 4 times"),
        ({"period": 0}, "is not shown 4 times"),
    ],
)
def test_false_evidence_of_a_drift_is_refused(world, episode, change, message):
    false = replace(episode.evidence, **change)
    assert message in check_evidence("stalled", world, episode.trace, false, SWEPT)


def test_evidence_of_a_drift_is_refused_for_a_counter(world, episode):
    counted = simulate(world, Counts(), record=True)
    wrong = check_evidence("stalled", world, counted.trace, episode.evidence, SWEPT)
    assert "more than rounding errors" in wrong


def test_run_explain_and_replay_name_the_number_and_the_way_out(world, tmp_path):
    write_world(world, tmp_path / "w.grid")
    ran = worldgen("run", tmp_path / "w.grid", "--controller", f"{HERE}:Drifts")
    words = "memory[1] changes by 2e-18 a step: round it, and the loop may be proved"
    assert ran.out.startswith("stalled (the pose repeats in every step; " + words)
    failure = failure_of(world, Scenario(f"{HERE}:Drifts"))
    assert f"its pose repeats, and {words}" in describe(
        failure, tmp_path / "f.grid", why=explained(failure)
    )
    assert replay(failure).confirmed
    # A file of an older version does not name the drift.
    old = replace(failure.record, evidence=repeatable(failure.record.evidence))
    assert "memory_drift" not in old.evidence and replay(replace(failure, record=old)).confirmed


def test_evidence_of_stepped_runs_keeps_its_period():
    drifting = BudgetEvidence(last_new_cell=3, kind="drifting", entry=4, period=2, box=(3, 1))
    assert "period" in repeatable(evidence_table(drifting))
