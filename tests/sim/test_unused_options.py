"""Options that cannot change a run are reported, and no others."""

import json

import numpy as np
import pytest

from sim import simulate
from sim.scenario import Scenario
from sim.scenario.unused import coarse_forces, missing_beams, random_run, unused_options
from tests.helpers.command_line import worldgen
from worldgen.world import Pose, Target, World


@pytest.mark.parametrize(
    ("text", "motion", "reason"),
    [
        (
            "random-walk+sensor_noise=0.1",
            "swept",
            "random-walk does not read signal or signal_heading",
        ),
        ("turn-right+odometry_noise=0.1", "swept", "turn-right does not read odometry_x"),
        ("turn-right+beams=8", "swept", "turn-right does not read beams"),
        ("turn-right+beam_noise=0.1", "swept", "+beam_noise has no effect without +beams"),
        ("turn-right+smoke_reach=3", "swept", "+smoke_reach has no effect without +smoke"),
        ("thesis-1+draws=0.5", "stepped", "thesis-1 draws no random numbers"),
        ("thesis-3+turn_angle=1.0", "stepped", "thesis-3 draws its angles"),
    ],
)
def test_an_option_that_changes_nothing_is_named_with_the_reason(text, motion, reason):
    (sentence,) = unused_options(Scenario.parse(text, motion=motion))
    assert reason in sentence


@pytest.mark.parametrize(
    ("text", "motion"),
    [
        ("turn-right+sensor_noise=0.1+slip=0.1", "swept"),
        ("tangent-bug+beams=16+beam_noise=0.1", "swept"),
        # These controllers switch on their beams and their sense of neighbours themselves.
        ("tangent-bug+beam_noise=0.1", "swept"),
        ("pibt+message=6", "swept"),
        ("turn-right+smoke=0.5+smoke_reach=3", "swept"),
        ("thesis-3+draws=0.5", "stepped"),
        ("thesis-1+turn_angle=1.0+noise", "stepped"),
    ],
)
def test_an_option_that_matters_is_not_named(text, motion):
    assert unused_options(Scenario.parse(text, motion=motion)) == []


@pytest.mark.parametrize("force", ["acceleration=2", "friction=1", "wall_friction=0.5", "slip=0.1"])
def test_forces_under_stepped_are_said_to_move_whole_pixels(force):
    (sentence,) = coarse_forces(Scenario.parse(f"thesis-1+{force}", motion="stepped"))
    assert "whole pixels" in sentence
    assert "0.67 m/s" in sentence
    assert coarse_forces(Scenario.parse(f"turn-left+{force}", motion="swept")) == []


def test_a_robot_below_a_pixel_a_tick_stands_still_under_stepped():
    cells = np.zeros((30, 30), bool)
    slow, fast = (
        simulate(
            World(cells, Pose(1.5, 1.5, 0.0), Target(0.3, 0.3, 0.05), robot_speed=speed),
            "thesis-1",
            motion="stepped",
        )
        for speed in (0.66, 0.68)
    )
    assert slow.path_length == 0.0 < fast.path_length


def test_a_class_that_does_not_declare_its_senses_may_read_everything(tmp_path):
    (tmp_path / "mine.py").write_text(
        "class Robot:\n    def reset(self):\n        return ()\n\n"
        "    def act(self, observation, memory):\n        return (0.0, 0.0), memory\n"
    )
    assert (
        unused_options(Scenario.parse(f"{tmp_path}/mine.py:Robot+odometry_noise=0.1+beams=3")) == []
    )


@pytest.mark.parametrize(
    ("text", "expected"),
    [("turn-left", False), ("turn-random", True), ("turn-left+slip=0.1", True)],
)
def test_a_seed_matters_where_something_is_random(text, expected):
    assert random_run(Scenario.parse(text)) is expected


@pytest.fixture
def world(tmp_path):
    worldgen("trap", "--seed", 1, "--no-metrics", "--out", tmp_path / "w.grid")
    return tmp_path / "w.grid"


def test_run_notes_it_on_stderr_and_goes_on(world):
    result = worldgen("run", world, "--controller", "turn-left+beams=8", "--seed", 3, "--json")
    assert "verdict" in json.loads(result.out)
    assert "note: +beams has no effect: turn-left does not read beams\n" in result.err
    assert "note: --seed has no effect" in result.err


def test_a_seed_that_nobody_typed_is_not_noted(world):
    assert "no effect" not in worldgen("run", world, "--controller", "turn-left").err


def test_a_quiet_run_notes_nothing(world):
    assert worldgen("run", world, "--controller", "turn-left+beams=8", "-q").err == ""


def test_compare_takes_controllers_one_by_one(world):
    arguments = ("--controller", "turn-left", "--controller", "turn-right", "--seeds", 2, "--json")
    result = worldgen("compare", world, *arguments)
    assert json.loads(result.out)["controllers"] == ["turn-left", "turn-right"]
    assert "note: --seeds has no effect: nothing in these runs is random" in result.err


def test_earlier_names_are_not_shown():
    shown = worldgen("maze", "--help").out
    assert not any(name in shown for name in ("--robot-radius", "--robot-speed"))


@pytest.mark.parametrize(
    ("words", "option"),
    [
        ("compare w.grid --controllers bug1,bug2", "controller"),
        ("shrink w.grid --seconds 5s", "budget"),
    ],
)
def test_an_option_that_is_gone_is_answered_with_the_one_that_replaces_it(words, option):
    done = worldgen(*words.split())
    assert done.code == 2
    assert f"did you mean --{option}?" in done.err


def test_a_missing_option_is_named_by_its_own_name_only(tmp_path):
    world = tmp_path / "w.grid"
    world.touch()
    error = worldgen("compare", world).err
    assert "--controller" in error
    assert "--controllers" not in error


@pytest.mark.parametrize("names", [("--radius", "--speed"), ("--robot-radius", "--robot-speed")])
def test_a_familys_robot_is_given_by_the_names_of_every_other_command(names):
    made = worldgen("trap", names[0], 0.1, names[1], 1.5, "--seed", 1, "--json")
    assert (
        json.loads(made.out)["params"] | {"robot_radius": 0.1, "robot_speed": 1.5}
        == json.loads(made.out)["params"]
    )


@pytest.mark.parametrize(
    ("attributes", "reads", "option", "missing"),
    [
        ("", "min(observation.beams, default=1.0)", "", True),
        # A class attribute of this name does not give the robot any beams.
        ("beams = 36", "min(observation.beams, default=1.0)", "", True),
        ("beams = 36", "self.beams / 36", "", False),
        ("", "min(observation.beams, default=1.0)", "+beams=8", False),
        ("needs = RobotOptions(beams=8)", "min(observation.beams, default=1.0)", "", False),
        ("", "1.0", "", False),
    ],
)
def test_beams_that_a_controller_reads_but_does_not_have_are_named(
    tmp_path, attributes, reads, option, missing
):
    (tmp_path / "mine.py").write_text(
        "from sim import Command, RobotOptions\n"
        "class Robot:\n"
        f"    {attributes}\n"
        "    def reset(self):\n"
        "        return ()\n"
        "    def act(self, observation, memory):\n"
        f"        return Command({reads}, 0.0), memory\n"
    )
    sentences = missing_beams(Scenario.parse(f"{tmp_path}/mine.py:Robot{option}"))
    assert ["needs = RobotOptions(beams=36)" in one for one in sentences] == [True] * missing
