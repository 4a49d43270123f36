"""Causes, breaches and kinds of stalling are accepted only if the recorded path shows them."""

from dataclasses import replace
from functools import cache
from importlib import resources

import numpy as np
import pytest

from fuzz.chance import seeds_that_fail
from fuzz.evidence_checks import check_breach, check_evidence
from fuzz.facts.signature import failure_class
from fuzz.failure import Failure, regardless_of_walls
from fuzz.oracles import BREACH, Trial
from fuzz.triage.judging import failure_of, oracle_of, violation_in
from fuzz.triage.replaying import replay
from sim import simulate
from sim.episode import prepare
from sim.evidence import BudgetEvidence
from sim.options.run import RunOptions
from sim.scenario import Scenario
from worldgen import Cut
from worldgen.files.grid import read_world

FAULTS = resources.files("corpora") / "thesis-faults"
CAUSES = ("slide", "back-off", "corner")
OF_EACH_CAUSE = [f"thesis-2-{cause}" for cause in CAUSES]


@cache
def judged(name):
    world = read_world(FAULTS / f"{name}.grid")
    failure = Failure.of(world)
    record, options = failure.record, failure.options
    trial = Trial.recorded(world, record.controller, options)
    found = violation_in(trial, oracle_of(failure))
    assert found is not None
    return world, replace(trial.episode, evidence=found.evidence), options


def flaw_of(name, **changes):
    world, episode, options = judged(name)
    evidence = replace(episode.evidence, **changes)
    return check_evidence(episode.verdict, world, episode.trace, evidence, options.motion_model())


@pytest.mark.parametrize("name", OF_EACH_CAUSE)
def test_the_true_cause_holds(name):
    assert flaw_of(name) == ""


@pytest.mark.parametrize("claimed", CAUSES)
@pytest.mark.parametrize("name", OF_EACH_CAUSE)
def test_another_cause_is_refused_with_the_true_one_named(name, claimed):
    true = judged(name)[1].evidence.cause
    wrong = flaw_of(name, cause=claimed)
    assert wrong == "" if claimed == true else f"is not a {claimed} but a {true}" in wrong


@pytest.mark.parametrize("name", OF_EACH_CAUSE)
@pytest.mark.parametrize(
    ("later", "message"),
    [
        (-1, "the disc is clear of walls"),
        (1, "overlaps a wall even before"),
        (10**6, "is not within the run"),
    ],
)
def test_an_overlap_that_begins_in_another_step_is_refused(name, later, message):
    since = judged(name)[1].evidence.since
    assert message in flaw_of(name, since=since + later)


@pytest.mark.parametrize("since", [0, None])
def test_an_overlap_that_begins_in_no_step_is_refused(since):
    assert "is not within the run" in flaw_of("thesis-2-slide", since=since)


@pytest.mark.parametrize("cause", ["jump", ""])
def test_a_cause_that_does_not_exist_is_refused(cause):
    assert f"is not a {cause}" in flaw_of("thesis-2-slide", cause=cause)


def test_a_cause_is_refused_where_the_first_wall_is_gone():
    world, episode, options = judged("thesis-2-slide")
    ix, iy = episode.evidence.cell
    elsewhere = np.zeros_like(world.walls)
    elsewhere[iy, ix - 1] = True  # next to the cell, so that the disc meets it later
    moved = replace(world, walls=elsewhere)
    evidence = replace(episode.evidence, cell=(ix - 1, iy))
    assert check_evidence("tunnel", moved, episode.trace, evidence, options.motion_model())


def test_a_path_that_jumps_into_the_wall_is_no_move_of_the_model():
    world, episode, options = judged("thesis-2-slide")
    x = episode.trace.x.copy()
    x[episode.evidence.since :] += 1e-4  # a hundredth of a pixel to the side
    bent = replace(episode.trace, x=x)
    assert "is not a slide" in check_evidence(
        "tunnel", world, bent, episode.evidence, options.motion_model()
    )


def breach():
    world, episode, options = judged("thesis-1-breach")
    whole = simulate(world, "thesis-1", regardless_of_walls(options), record=True).trace
    return world, episode, whole


def test_a_true_breach_holds():
    world, episode, whole = breach()
    assert check_breach(world, episode.trace, whole, episode.evidence) == ""


@pytest.mark.parametrize(
    ("later", "message"), [(-1, "does not end in the target's cell"), (1, "does not include both")]
)
def test_a_target_reached_in_another_step_is_refused(later, message):
    world, episode, whole = breach()
    evidence = replace(episode.evidence, reached=episode.evidence.reached + later)
    assert message in check_breach(world, episode.trace, whole, evidence)


def test_a_target_reached_no_later_than_the_wall_is_refused():
    world, episode, whole = breach()
    evidence = replace(episode.evidence, reached=episode.evidence.step)
    assert "does not include both" in check_breach(world, episode.trace, whole, evidence)


def test_a_target_that_was_reached_before_the_wall_is_no_breach():
    world, episode, whole = breach()
    x, y = whole.x.copy(), whole.y.copy()
    x[100], y[100] = world.target.x, world.target.y
    early = replace(whole, x=x, y=y)
    assert f"reached before step {whole.steps}" in check_breach(
        world, episode.trace, early, episode.evidence
    )


def test_a_breach_by_another_run_is_refused():
    world, episode, whole = breach()
    states = whole.states.copy()
    states[10] ^= 1
    other = replace(whole, states=states)
    assert "run differs before the wall" in check_breach(
        world, episode.trace, other, episode.evidence
    )


def test_a_walled_off_target_that_nobody_reaches_is_no_failure():
    world = replace(judged("thesis-1-breach")[0], failure=None)
    assert failure_of(world, Scenario.parse("thesis-1+repaired", motion="stepped")) is None
    trial = Trial.recorded(
        world, "thesis-1", Scenario("thesis-1", RunOptions("swept")).options(world, 5000)
    )
    assert BREACH.check(trial) is None


def test_a_breach_is_not_confirmed_with_a_cut_that_does_not_hold():
    world = judged("thesis-1-breach")[0]
    assert isinstance(world.certificate, Cut) and replay(Failure.of(world)).confirmed
    open_world = replace(
        world, certificate=replace(world.certificate, cells=world.certificate.cells[:1])
    )
    assert "cut does not hold" in replay(Failure.of(open_world)).reason


def test_a_breach_is_a_class_of_its_own():
    world, episode, _ = judged("thesis-1-breach")
    without = replace(episode, evidence=replace(episode.evidence, reached=None))
    assert failure_class(world, episode) == "breach-slide-post"
    assert failure_class(world, without) == "tunnel-slide-post"


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"kind": "confined"}, "recur every 104 steps, so the run drifts"),
        ({"period": 103}, "do not recur every 103 steps"),
        ({"entry": 3900}, "is not shown 4 times"),
        ({"box": (9, 9)}, "not 9"),
        ({"box": None}, "no box"),
    ],
)
def test_false_evidence_of_drifting_is_refused(changes, message):
    assert message in flaw_of("thesis-1-drifting", **changes)


def test_a_confined_run_does_not_drift():
    wrong = flaw_of("thesis-1-confined", kind="drifting", period=104, entry=2000)
    assert "poses do not recur every 104 steps" in wrong


def test_an_exact_loop_does_not_drift():
    world, _, options = judged("thesis-1-loop-104")
    trace = prepare(world, "thesis-1", options).run(4000, find_loop=False, record=True).trace
    evidence = BudgetEvidence(last_new_cell=0, kind="drifting", period=104, entry=2000, box=(3, 3))
    assert "which is a loop" in check_evidence(
        "stalled", world, trace, evidence, options.motion_model()
    )


@pytest.mark.parametrize(
    ("robot", "randomised"),
    [
        ("thesis-3", True),
        ("thesis-1", False),
        ("thesis-1+slip=0.2", True),
        ("thesis-1+sensor_noise=0.1", True),
    ],
)
def test_seeds_are_tried_wherever_chance_has_a_part(robot, randomised):
    world = replace(judged("thesis-2-corner")[0], failure=None)
    details = seeds_that_fail(world, Scenario.parse(robot, motion="stepped"), count=5)
    assert ("failing_seeds" in details) == randomised
