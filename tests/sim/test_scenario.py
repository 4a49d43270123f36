"""Scenarios: options after a controller's name are parsed, written and refused."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim import RobotOptions, RunOptions, Scenario, ThesisOptions, simulate
from sim.options.run import (
    COSTLY_BUDGET,
    COVER,
    USUAL_BUDGET,
    RunBudget,
    recorded_budget,
    step_budget,
)
from tests.helpers.raising import raises
from worldgen import InvalidParameter, generate

STEPPED = {"motion": "stepped"}


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("thesis-1", Scenario("thesis-1", RunOptions("stepped"))),
        (
            "thesis-1+noise",
            Scenario("thesis-1", RunOptions("stepped", thesis=ThesisOptions(noise=True))),
        ),
        (
            "thesis-1+sensor-range=50+arbiter=A2",
            Scenario("thesis-1", RunOptions("stepped", thesis=ThesisOptions(50, arbiter="A2"))),
        ),
        ("thesis-1+noise=false", Scenario("thesis-1", RunOptions("stepped"))),
        (
            "mine+motion=endpoint+time_step=0.1",
            Scenario("mine", RunOptions("endpoint", time_step=0.1)),
        ),
        (
            "mine+slip=0.1+motion=swept",
            Scenario("mine", RunOptions("swept", robot=RobotOptions(slip=0.1))),
        ),
        (
            "mine+motion=swept+beams=36",
            Scenario("mine", RunOptions("swept", robot=RobotOptions(beams=36))),
        ),
        ("./a+b/mine.py:Robot", Scenario("./a+b/mine.py:Robot", RunOptions("stepped"))),
        ("./a+b/mine.py:Robot+motion=swept", Scenario("./a+b/mine.py:Robot", RunOptions("swept"))),
    ],
)
def test_a_controller_with_variations_is_read(text, expected):
    assert Scenario.parse(text, **STEPPED) == expected


def test_repaired_stands_for_the_three_repairs():
    thesis = Scenario.parse("thesis-1+repaired", **STEPPED).run.thesis
    assert thesis.repaired and thesis == ThesisOptions(
        repair_slide=True, repair_back_off=True, repair_corner=True
    )


THESIS = st.builds(
    ThesisOptions,
    sensor_range=st.integers(36, 1000),
    noise=st.booleans(),
    repair_slide=st.booleans(),
    repair_corner=st.booleans(),
    repair_back_off=st.booleans(),
    slip=st.floats(0, 1),
    signal=st.sampled_from(["open", "blocked"]),
    draws=st.lists(st.floats(0, 0.999)).map(tuple),
)
ROBOT = st.builds(
    RobotOptions,
    turn_limit=st.floats(0, 100),
    acceleration=st.floats(0, 100),
    odometry_noise=st.floats(0, 1),
    signal=st.sampled_from(["open", "weakened"]),
    beams=st.integers(0, 1000),
    beam_range=st.floats(0.1, 100),
)


@given(
    st.builds(lambda thesis: ("stepped", {"thesis": thesis}), THESIS)
    | st.builds(
        lambda motion, robot: (motion, {"robot": robot}),
        st.sampled_from(["swept", "endpoint"]),
        ROBOT,
    ),
    st.floats(0.001, 10),
)
def test_a_label_reads_back(switches, time_step):
    motion, sets = switches
    scenario = Scenario("thesis-2", RunOptions(motion, time_step=time_step, **sets))
    assert Scenario.parse(scenario.label("swept", 0.015)) == scenario


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", {"code": "empty-name"}),
        ("thesis-1+nosie", {"code": "unknown-name", "name": "nosie"}),
        ("thesis-1+noise=maybe", {"code": "not-a-truth-value", "name": "noise"}),
        ("thesis-1+slip", {"code": "missing-value", "name": "slip"}),
        ("thesis-1+slip=much", {"code": "not-a-number", "name": "slip", "expected": "number"}),
        (
            "thesis-3+draws=0.5:x",
            {"code": "not-a-number", "name": "draws", "expected": "list of numbers"},
        ),
        ("thesis-3+draws=0.5:1.0", {"code": "out-of-range"}),
        ("thesis-1+slip=1.5", {"code": "out-of-range", "name": "slip", "value": 1.5, "high": 1}),
        ("thesis-1+slip=nan", {"code": "not-finite", "name": "slip"}),
        ("thesis-1+slip=0.1+slip=0.2", {"code": "twice", "option": "slip"}),
        ("thesis-1+", {"code": "wrong-form"}),
        ("thesis-1+arbiter=A9", {"code": "unknown-name", "name": "arbiter", "value": "A9"}),
        ("thesis-1+time_step=soon", {"code": "not-a-number", "text": "soon"}),
        (
            "thesis-1+map_scale=0",
            {"code": "out-of-range", "name": "map_scale", "low": 1, "high": 100},
        ),
    ],
)
def test_a_wrong_variation_gets_a_sentence(text, expected):
    with raises(InvalidParameter, **expected):
        Scenario.parse(text, **STEPPED)


def test_a_failure_file_stores_only_what_was_switched():
    options = RunOptions("stepped", 99, thesis=ThesisOptions(noise=True, slip=0.5))
    stored = options.parameters()
    assert stored == {"steps": 99, "time_step": 0.015, "noise": True, "slip": 0.5}
    assert RunOptions.of("stepped", 0, stored) == options


def test_switches_of_the_thesis_mean_nothing_to_another_motion_model():
    with raises(
        InvalidParameter, "option-without-effect", option="noise", motion="swept", where="stepped"
    ):
        simulate(generate("trap", seed=1), "thesis-1", motion="swept", noise=True)


WORLDS = [
    *(generate("corridor", 1, size=size) for size in (12, 20, 60)),
    generate("crossing", 1),
    generate("maze", 2, size=40),
]


@pytest.mark.parametrize("budget", [USUAL_BUDGET, COSTLY_BUDGET])
@pytest.mark.parametrize("world", WORLDS, ids=str)
@pytest.mark.parametrize("time_step", [0.015, 0.003, 0.1])
def test_a_run_shows_the_budget_that_it_was_given(world, budget, time_step):
    run = RunOptions(time_step=time_step)
    run = replace(run, steps=step_budget(world, run, budget))
    again = recorded_budget(world, run)
    assert step_budget(world, run, again) == run.steps
    # Where both give the same steps, the usual one is as good.
    assert again in (budget, USUAL_BUDGET)


@pytest.mark.parametrize("steps", [35, 1_000, 3_328, 4_001, 90_000])
def test_steps_of_another_origin_lower_only_the_least_budget(steps):
    run = RunOptions(steps=steps)
    assert recorded_budget(WORLDS[0], run) == RunBudget(50, min(steps, 4_000))
    assert recorded_budget(WORLDS[0], replace(run, task=COVER)) == (50, min(steps, 4_000))
