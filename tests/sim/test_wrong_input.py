"""Arguments passed to the simulator from Python:

classes and objects are accepted, and unsuitable ones give an error message.
"""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sim import CompiledController, RobotOptions, RunOptions, simulate, simulate_many
from tests.helpers.raising import raises
from tests.sim.test_episode import Circle, GoToTarget, arena
from worldgen import InvalidParameter, InvalidWorld, Pose


def nothing(observation, memory, command):
    pass


class OneSense(GoToTarget):
    senses = "time"


class UnknownSense(GoToTarget):
    senses = ("bump", "smell")


class DictOfNeeds(GoToTarget):
    needs = {"beams": 3}  # noqa: RUF012 - the mistake that is meant


class NeedsAnArgument(GoToTarget):
    def __init__(self, gain):
        self.gain = gain


def test_a_class_drives_as_an_object_of_it():
    assert (
        simulate(arena(), GoToTarget).trace_digest == simulate(arena(), GoToTarget()).trace_digest
    )


def test_many_runs_take_a_class_and_call_it_by_its_name():
    runs = simulate_many(arena(), [GoToTarget, Circle()])
    assert runs.names == ("GoToTarget", "Circle") and runs.verdicts.tolist() == ["reached", "loop"]


@pytest.mark.parametrize("run", [simulate, simulate_many])
@pytest.mark.parametrize(
    ("thing", "expected"),
    [
        (OneSense(), {"code": "wrong-declaration", "name": "OneSense", "senses": "time"}),
        (OneSense, {"code": "wrong-declaration", "name": "OneSense", "senses": "time"}),
        (UnknownSense(), {"code": "unknown-name", "name": "UnknownSense", "sense": "smell"}),
        (DictOfNeeds(), {"code": "wrong-declaration", "name": "DictOfNeeds"}),
        (NeedsAnArgument, {"code": "code-failed", "kind": "NeedsAnArgument"}),
        (object(), {"code": "not-a-controller", "name": "object", "missing": "reset and no act"}),
        (None, {"code": "not-a-controller", "name": "NoneType", "missing": "reset and no act"}),
        (nothing, {"code": "not-a-controller", "name": "nothing", "missing": "reset and no act"}),
    ],
)
def test_what_is_no_controller_is_refused(run, thing, expected):
    with raises(InvalidParameter, **expected):
        run(arena(), thing)


@pytest.mark.parametrize(
    ("declared", "expected"),
    [
        ({"start_speed": math.nan}, {"code": "out-of-range", "name": "mine"}),
        ({"start_speed": -1.0}, {"code": "out-of-range", "name": "mine"}),
        ({"start_speed": "fast"}, {"code": "out-of-range", "name": "mine", "speed": "fast"}),
        ({"senses": "time"}, {"code": "wrong-declaration", "name": "mine", "senses": "time"}),
        ({"needs": {"beams": 3}}, {"code": "wrong-declaration", "name": "mine"}),
    ],
)
def test_a_compiled_controller_declares_nothing_wrong(declared, expected):
    with raises(InvalidParameter, **expected):
        CompiledController("mine", nothing, **declared)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"steps": "5"}, "steps='5' is not a whole number; use one from 1 to"),
        ({"steps": 5.5}, r"steps=5\.5 is not a whole number"),
        ({"steps": True}, "steps=True is not a whole number"),
        ({"steps": 10**5000}, "steps=<too many digits to show> is outside 1 to"),
        ({"time_step": "a"}, "time_step='a' is a str; use a float"),
        ({"time_step": 0}, "time_step=0 s is outside"),
        ({"time_step": math.nan}, "time_step=nan is not finite"),
        ({"time_step": 10**400}, "time_step is a number of more than 64 bits"),
        ({"motion": 3}, "motion=3 is not a motion model's name"),
    ],
)
@pytest.mark.parametrize("run", [simulate, simulate_many])
def test_a_setting_of_the_wrong_type_is_refused(run, setting, message):
    with pytest.raises(InvalidParameter, match=message):
        run(arena(), "turn-left", **setting)


@pytest.mark.parametrize("seed", [-1, 2**64, "abc", 1.5, None])
def test_a_seed_that_is_none_is_refused(seed):
    code = "out-of-range" if type(seed) is int else "not-a-whole-number"
    with raises(InvalidParameter, code, name="seed"):
        simulate(arena(), "turn-left", seed=seed)
    with raises(InvalidParameter, code, name="seed"):
        simulate_many(arena(), "turn-left", seeds=[seed])
    with raises(InvalidParameter, code, name="seeds"):
        simulate_many(arena(), "turn-left", seeds=seed)


@pytest.mark.parametrize("seeds", [3, np.int64(3), np.arange(3), [np.uint8(0), 1, 2]])
def test_numbers_of_numpy_are_numbers_of_seeds_and_seeds(seeds):
    assert simulate_many(arena(), "turn-left", seeds=seeds, steps=10).seed.tolist() == [0, 1, 2]


def test_numbers_of_numpy_are_stored_as_plain_ones():
    options = RunOptions(steps=np.int64(5), time_step=np.float64(0.03), seed=np.uint64(7))
    assert [type(value) for value in (options.steps, options.time_step, options.seed)] == [
        int,
        float,
        int,
    ]


@pytest.mark.parametrize("workers", [-1, 0, "2", 1.5])
def test_a_number_of_threads_that_is_none_is_refused(workers):
    code = "out-of-range" if type(workers) is int else "not-a-whole-number"
    with raises(InvalidParameter, code, name="workers"):
        simulate_many(arena(), "turn-left", workers=workers)


@pytest.mark.parametrize("run", [simulate, simulate_many])
@pytest.mark.parametrize("path", ["w.grid", Path("w.grid")])
def test_a_path_is_no_world_and_the_way_out_is_named(run, path):
    with raises(InvalidParameter, "wrong-type", path="w.grid"):
        run(path, "turn-left")


@pytest.mark.parametrize("worlds", [5, None, [arena(), "w.grid"]])
def test_what_is_no_list_of_worlds_is_refused(worlds):
    with raises(InvalidParameter, "wrong-type"):
        simulate_many(worlds, "turn-left")


@pytest.mark.parametrize(
    "starts", [[(0.3, 0.3)], Pose(0.3, 0.3), [Pose("a", 0.0)], [Pose(math.nan, 0.3)], "ab", 5]
)
def test_a_start_that_is_no_pose_is_refused(starts):
    with pytest.raises(InvalidParameter, match="start"):
        simulate_many(arena(), "turn-left", starts=starts)


def test_a_start_far_outside_is_refused_in_whatever_place():
    with raises(InvalidWorld, "outside-grid", name="start"):
        simulate_many(arena(), "turn-left", starts=[arena().start, Pose(1e300, 0.0)])


@pytest.mark.parametrize("options", [{"steps": 3}, 300])
def test_options_that_are_none_are_refused(options):
    with raises(InvalidParameter, "wrong-type"):
        simulate(arena(), "turn-left", options)


@pytest.mark.parametrize("wrong", [{"beams": "5"}, {"beams": 5.5}, {"slip": None}])
def test_an_option_of_the_robot_of_the_wrong_type_is_refused(wrong):
    with raises(InvalidParameter, "wrong-type"):
        RobotOptions(**wrong)


def test_options_of_the_robot_that_are_none_are_refused():
    with raises(InvalidParameter, "wrong-type", name="robot", wanted="RobotOptions"):
        RunOptions(robot={"beams": 3})


def test_a_recorded_episode_prints_itself_in_a_few_lines():
    episode = simulate(arena(), Circle(), record=True)
    assert repr(episode).splitlines() == [
        f"loop: 129 steps, 1.935 s, 0.951 m driven, 0 collisions, trace {episode.trace_digest}",
        "  entry: 1",
        "  period: 128",
        f"  state_digest: {episode.evidence.state_digest!r}",
    ]
    assert repr(replace(episode, trace=None)) == repr(episode)


def test_a_trace_prints_how_long_it_is():
    assert (
        repr(simulate(arena(), Circle(), record=True).trace)
        == "Trace(129 steps, 0.015 s each, 130 points)"
    )
