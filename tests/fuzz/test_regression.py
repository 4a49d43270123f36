"""Worlds as regression tests.

What counts as fixed or confirmed, and what is kept of a failing run.
"""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fuzz.facts.proofs import certificate_fault
from fuzz.failure import Failure
from fuzz.regression.answer import State, answer, describe_summary
from fuzz.regression.checks import CONFIRMED, check, run, tell
from fuzz.regression.fixed import RegressionRun
from fuzz.triage.judging import failure_of
from fuzz.triage.replaying import replay
from sim.scenario import Scenario
from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter, InvalidWorld
from worldgen.files.grid import read_world, write_world
from worldgen.generation import generate
from worldgen.reach import decide
from worldgen.world import Pose, Target, World

BREACH = Path("corpora/thesis-faults/thesis-1-breach.grid")


@pytest.fixture(scope="module")
def trap():
    return generate("trap", 0, shape="U")


@pytest.fixture(scope="module")
def failure(trap):
    return failure_of(trap, Scenario("turn-right"))


@pytest.fixture
def stored(failure, tmp_path):
    failure.write(tmp_path / "loop.grid")
    return tmp_path / "loop.grid"


def walled_off(**changes):
    cells = np.zeros((12, 12), bool)
    cells[:, 6] = True
    return World(cells, Pose(0.25, 0.65, 0.0), Target(0.95, 0.65, 0.05), **changes)


def test_a_failure_that_still_fails_is_confirmed_but_not_fixed(stored):
    assert check(stored, CONFIRMED).reason == ""
    assert "turn-right under swept: loop forever" in check(stored).reason


def test_a_failure_in_which_another_controller_arrives_is_fixed_but_not_confirmed(stored):
    assert check(stored, controller="bug2").reason == ""
    reason = check(stored, CONFIRMED, "bug2").reason
    assert "arrives now in" in reason and reason.endswith(
        "(was: loop, period 545); the test should now expect it to be fixed"
    )


def test_a_repaired_controller_gets_the_witness_s_budget_even_if_the_failure_was_short(
    failure, tmp_path
):
    record = replace(failure.record, parameters={**failure.record.parameters, "steps": 3})
    replace(failure, record=record).write(tmp_path / "short.grid")
    assert check(tmp_path / "short.grid", controller="bug2").reason == ""


def test_a_failure_without_its_witness_is_never_fixed(failure, tmp_path):
    replace(failure, world=replace(failure.world, certificate=None)).write(tmp_path / "bare.grid")
    assert "the file proves nothing" in check(tmp_path / "bare.grid", controller="bug2").reason


def test_where_the_target_is_walled_off_fixed_means_that_the_robot_stays_out(tmp_path):
    assert "but the target is walled off" in check(BREACH).reason
    breach = read_world(BREACH)
    write_world(
        replace(breach, failure=replace(breach.failure, motion="swept", parameters={})),
        tmp_path / "b.grid",
    )
    assert check(tmp_path / "b.grid", controller="bug2").reason == ""


@pytest.mark.parametrize(("motion", "reason"), [("swept", ""), ("stepped", "whole cell")])
def test_a_cut_need_separate_the_target_s_whole_cell_only_for_the_thesis_s_robot(motion, reason):
    # The target's cell is next to a doorway that is too narrow: the disc can lean into its other end.
    walls = np.zeros((11, 11), bool)
    walls[:, 5] = [row != 5 for row in range(11)]
    world = World(walls, Pose(0.15, 0.15, 0.0), Target(0.62, 0.55, 0.02), robot_radius=0.07)
    cut = decide(world).certificate
    fault = certificate_fault(replace(world, certificate=cut), motion)
    assert reason in fault and bool(fault) == bool(reason)


def test_a_world_without_a_failure_is_a_test_for_the_controller_that_is_named(trap, tmp_path):
    write_world(trap, tmp_path / "w.grid")
    assert check(tmp_path / "w.grid", controller="bug2").reason == ""
    assert (
        "but the target can be reached"
        in check(tmp_path / "w.grid", controller="turn-right").reason
    )
    with raises(InvalidParameter, "no-failure"):
        check(tmp_path / "w.grid")


def test_a_world_whose_target_cannot_be_reached_is_no_test(tmp_path):
    write_world(walled_off(), tmp_path / "w.grid")
    with raises(InvalidWorld, "not-proved-reachable"):
        check(tmp_path / "w.grid", controller="bug2")


def test_the_world_of_a_failing_run_is_kept_as_a_failure_that_replays(trap, tmp_path):
    seen, episode = run(trap, "turn-right", 5)
    told = tell(seen, tmp_path / "new" / "w.grid")
    assert (
        episode.verdict == "loop"
        and told.properties["replay"] == f"worldgen replay {tmp_path}/new/w.grid"
    )
    assert replay(Failure.read(tmp_path / "new" / "w.grid")).confirmed


def test_the_world_of_a_run_that_arrives_is_kept_with_the_command_that_runs_it(trap, tmp_path):
    told = tell(run(trap, "bug2+time_step=0.02", 5)[0], tmp_path / "w.grid")
    assert read_world(tmp_path / "w.grid") == trap
    assert f"run {tmp_path}/w.grid --controller bug2+time_step=0.02 --seed 5" in told.text


def test_a_world_in_which_nothing_ran_is_kept_with_the_command_that_draws_it(trap, tmp_path):
    assert (
        tell(RegressionRun(trap), tmp_path / "w.grid").properties["replay"]
        == f"worldgen show {tmp_path}/w.grid"
    )


def test_a_world_that_cannot_be_kept_is_shown_all_the_same(trap, tmp_path):
    (tmp_path / "file").write_text("")
    told = tell(run(trap, "turn-right")[0], tmp_path / "file" / "w.grid")
    assert "the world could not be saved" in told.text and "S start  G target" in told.text
    assert not told.properties


def test_the_picture_has_no_colours(trap, monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    assert tell(run(trap, "turn-right")[0], None).text.isascii()


@pytest.mark.parametrize(
    ("controller", "state", "words"),
    [
        (None, State.SAME, r"the same, bit for bit: loop, period 545"),
        ("bug2", State.ARRIVES, r"arrives now in \d+\.?\d* s \(was: loop, period 545\)"),
        ("turn-left", State.FAILS, r"still fails: loop, period \d+ \(was 545\)"),
        ("nobody", State.UNPROVED, r"cannot be run: .*nobody.*"),
    ],
)
def test_a_replay_says_how_a_failure_stands_now(stored, controller, state, words):
    now = answer(Failure.read(stored), controller)
    assert now.state is state and re.fullmatch(words, now.words), now.words


def test_a_robot_that_is_only_late_with_the_stored_steps_arrives_now(stored):
    failure = Failure.read(stored)
    hurried = replace(failure.record, parameters={**failure.record.parameters, "steps": 20})
    assert answer(replace(failure, record=hurried), "bug2").state is State.ARRIVES


def test_a_summary_counts_what_still_fails_and_what_arrives():
    states = [State.SAME, State.FAILS, State.ARRIVES, State.ARRIVES]
    assert describe_summary(states) == "1 of 4 confirmed; 1 still fails, 2 arrive now"
