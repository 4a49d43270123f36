"""Counterfactuals: reported changes make the robot arrive; what cannot be explained is refused."""

import inspect
import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fuzz.boundary import AXES, run_subject, subject_of
from fuzz.facts.proofs import certified
from fuzz.failure import Failure
from fuzz.overview import counterfactual
from fuzz.overview.counterfactual import Change, Counterfactuals, counterfactuals
from fuzz.triage.judging import failure_of
from sim import Command
from sim.controllers.library.thesis import turn_right
from sim.options.robot import RobotOptions
from sim.scenario import Scenario
from sim.verdict import Verdict
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen import Pose, Target, World, generate
from worldgen.errors import InvalidParameter
from worldgen.files.grid import write_world

SHIPPED = Path(__file__).parents[2] / "corpora/failures"
WALL = SHIPPED / "turn-right/swept/returns-to-a-wall-2.grid"
FIRE = SHIPPED / "bug1/swept/caught-by-a-change.grid"
CHANCE = SHIPPED / "turn-random/stepped/wanders-3.grid"
HERE = "tests.fuzz.test_counterfactual"
HALL = World(
    np.zeros((5, 12), bool),
    start=Pose(0.15, 0.25, 0.0),
    target=Target(1.05, 0.25, 0.05),
    cell_size=0.1,
    robot_radius=0.07,
)


def arrives(subject):
    return run_subject(subject)[1].verdict == Verdict.REACHED


def test_the_robot_arrives_after_each_change_and_not_before():
    failure = Failure.read(WALL)
    subject = subject_of(failure)
    found = counterfactuals(failure)
    assert not arrives(subject) and found.is_complete
    kinds = set()
    for change in found.changes:
        kinds.add(change.what)
        if change.what == "cell":
            ix, iy = change.value
            walls = failure.world.walls.copy()
            assert walls[iy, ix]
            walls[iy, ix] = False
            world = replace(failure.world, walls=walls, certificate=None)
            assert arrives(replace(subject, world=world))
        elif change.what == "memory":
            world = replace(failure.world, start=Pose(*change.value), certificate=None)
            assert arrives(replace(subject, world=world))
        else:
            axis = AXES[change.what]
            assert change.was == axis.value(axis.index(subject))
            assert arrives(axis.at(subject, change.value))
    assert kinds == {"cell", "memory", "heading", "radius", "speed", "time-step"}


def test_a_fire_that_burns_the_robot_is_what_its_failure_depends_on():
    failure = Failure.read(FIRE)
    events = [c for c in counterfactuals(failure).changes if c.what == "event"]
    (dropped,) = events
    timeline = failure.world.timeline
    at = [[event.ix, event.iy] == dropped.value for event in timeline].index(True)
    kept = [number != at for number in range(len(timeline))]
    world = replace(failure.world, timeline=timeline.only(kept), certificate=None)
    assert arrives(replace(subject_of(failure), world=world))


class Tires:
    """Drives straight on for twenty steps, and then never moves again."""

    senses = ("bump",)

    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        speed = observation.top_speed if memory[0] < 20.0 else 0.0
        return Command(speed, 0.0), (min(memory[0] + 1.0, 20.0),)


class Rests(Tires):
    """Never drives, whatever it remembers."""

    def act(self, observation, memory):
        return Command(0.0, 0.0), memory


class Shuttles(Tires):
    """Every fourth step, stops and turns around."""

    def act(self, observation, memory):
        number = int(memory[0])
        if number == 0:
            return Command(0.0, math.pi / observation.time_step), (1.0,)
        return Command(observation.top_speed, 0.0), (float((number + 1) % 4),)


def test_a_robot_that_only_its_memory_holds_arrives_from_there_without_it():
    failure = failure_of(certified(HALL), Scenario(f"{HERE}:Tires"))
    found = counterfactuals(failure)
    (change,) = (one for one in found.changes if one.what == "memory")
    assert 0.5 < change.value[0] < 0.9 and change.value[1:] == [0.25, 0.0]
    assert "if its memory is cleared in the loop" in found.describe()

    still = failure_of(failure.world, Scenario(f"{HERE}:Rests"))
    assert not any(one.what == "memory" for one in counterfactuals(still).changes)


@pytest.mark.parametrize("name", ["naive", "right-hand"])
def test_a_robot_without_memory_is_not_said_to_depend_on_it(name):
    # Started in its loop, each would be pushed again, and arrive for that reason.
    pushed = Scenario.parse(f"{name}+pushes=0.5:0.3:0.3:1.5")
    found = counterfactuals(failure_of(generate("forest", 4), pushed))
    assert not any(one.what == "memory" for one in found.changes)


def test_a_robot_is_not_restarted_where_it_would_be_pushed_again():
    """Its memory is not the reason, even if it has one."""
    assert restarts("Tires")
    assert restarts("Tires", pushes=(0.03, 0.0, 0.01, 0.0)) == []


def test_each_place_of_a_short_loop_is_restarted_once():
    (start,) = restarts("Rests")
    assert (start.x, start.y) == (0.15, 0.25)


def test_a_robot_is_restarted_only_where_it_has_the_speed_of_a_start():
    """Restarting it elsewhere would stop it first, and it might arrive only because of that."""
    assert [start.heading for start in restarts("Shuttles")] == [0.0, math.pi]


def restarts(name, **options):
    """Return the poses from which a robot in a hall is started without its memory."""
    failure = failure_of(
        certified(HALL), Scenario(f"{HERE}:{name}").with_run(robot=RobotOptions(**options))
    )
    assert failure.verdict == Verdict.LOOP
    tries = counterfactual._restarts(subject_of(failure), failure.run())
    return [one.subject.world.start for one in tries]


def test_equal_failures_give_equal_answers():
    assert counterfactuals(Failure.read(WALL)) == counterfactuals(Failure.read(WALL))


def test_an_explanation_that_takes_too_many_steps_says_so(monkeypatch):
    monkeypatch.setattr(counterfactual, "_MOST_STEPS", 5_000)
    found = counterfactuals(Failure.read(WALL))
    assert not found.is_complete and len(found.changes) < 5


def test_a_failure_by_chance_is_refused():
    with raises(InvalidParameter, "no-counterfactual") as caught:
        counterfactuals(Failure.read(CHANCE))
    assert "may fail by chance" in str(caught.value)


# As a library in C that declares no senses, and so may use random numbers.
MAY_DRAW = replace(turn_right, name="may-draw", randomised=True)


def test_a_controller_that_may_draw_and_does_not_is_explained_as_any_other():
    failure = Failure.read(WALL)
    assert counterfactuals(failure.driven_by(f"{HERE}:MAY_DRAW")) == counterfactuals(failure)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ([Change("cell", [3, 4])], "arrives if cell (3, 4) is free"),
        (
            [Change("cell", [k, 0]) for k in range(4)],
            "arrives if one of the cells (0, 0), (1, 0), (2, 0) or one other is free",
        ),
        ([Change("event", [1, 2], 0.5)], "arrives if cell (1, 2) does not change at 0.5 s"),
        ([Change("option", "noise", True)], "arrives without +noise"),
        ([Change("option", "lag", 0.1)], "arrives without +lag=0.1"),
        (
            [
                Change("heading", 67.0, 65.0, "degrees"),
                Change("radius", 0.0708, 0.07, "m"),
                Change("speed", 3.0, 2.0, "m/s"),
            ],
            "arrives with speed 3 m/s instead of 2 m/s, or with a slightly different heading or radius",
        ),
        (
            [Change("radius", 0.06, 0.07, "m"), Change("time-step", 0.01, 0.015, "s")],
            "arrives with radius 0.06 m instead of 0.07 m, or with time step 0.01 s instead of 0.015 s",
        ),
        ([Change("footprint", 0.7, 1.0)], "arrives with a footprint of 0.7 times its size"),
        ([], "fails with each of 9 single changes of its walls, robot and options"),
    ],
)
def test_changes_are_described_in_one_sentence(changes, sentence):
    assert Counterfactuals(tuple(changes), 9, is_complete=True).describe() == sentence


def test_the_command_explains_a_file():
    result = worldgen("explain", WALL)
    assert result.code == 0 and "It arrives if cell (0, 0) is free" in result.out


def test_the_picture_of_an_explanation_marks_the_cells_that_the_sentence_names(tmp_path):
    assert worldgen("explain", WALL, "--picture", tmp_path / "why.svg").code == 0
    svg = (tmp_path / "why.svg").read_text()
    assert "loop: arrives if cell (0, 0) is free" in svg
    assert "cell named in the text" in svg
    assert worldgen("explain", WALL, "--picture", tmp_path / "why.png").code == 0
    assert (tmp_path / "why.png").read_bytes().startswith(b"\x89PNG")
    # A picture holds one failure, and does not replace a file.
    assert worldgen("explain", WALL, FIRE, "--picture", tmp_path / "two.png").code == 2
    assert worldgen("explain", WALL, "--picture", tmp_path / "why.png").code == 2


def test_replay_marks_the_cells_that_its_explanation_names():
    result = worldgen("replay", WALL, "--show")
    assert "arrives if cell (0, 0) is free" in result.out
    assert "? cell named in the text" in result.out


def test_json_has_the_changes_as_data():
    found = json.loads(worldgen("explain", WALL, "--json").out)
    assert found["explained"] == 1
    (failure,) = found["failures"]
    assert failure["verdict"] == "loop" and failure["complete"] is True
    assert failure["changes"][0] == {"what": "cell", "value": [0, 0], "was": None, "unit": ""}


def test_a_failure_that_cannot_be_explained_is_reported_with_exit_code_2(tmp_path):
    write_world(generate("corridor", 1), tmp_path / "w.grid")
    result = worldgen("explain", CHANCE, tmp_path / "w.grid")
    assert result.code == 2 and len(result.err.splitlines()) == 2
    assert "touching a wall ahead" in result.out and "arrives" not in result.out


@pytest.mark.nightly
def test_an_option_on_which_the_failure_depends_is_named():
    world = generate("corridor", 0)
    assert failure_of(world, Scenario.parse("bug2")) is None
    found = counterfactuals(failure_of(world, Scenario.parse("bug2+turn_limit=1")))
    options = [change for change in found.changes if change.what == "option"]
    assert options == [Change("option", "turn_limit", 1.0)]


@pytest.mark.gate
def test_an_option_of_the_controller_itself_is_named():
    world = generate("maze", 1)
    found = counterfactuals(failure_of(world, Scenario.parse("topological+places=4")))
    options = [change for change in found.changes if change.what == "option"]
    assert options == [Change("option", "places", "4")]
    assert "without +places=4" in found.describe()


def test_every_kind_of_change_has_its_place_in_the_order_of_a_report():
    source = inspect.getsource(counterfactual)
    kinds = set(re.findall(r'\bChange\("(\w+)"', source))
    assert {"cell", "memory", "footprint"} <= kinds <= set(counterfactual._ORDER)
