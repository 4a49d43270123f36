"""Hazards that a controller cannot sense are kept apart from failures, and fail a build only on
request.
"""

import json

import numpy as np
import pytest

from fuzz.failure import Failure
from fuzz.shrink import shrink
from fuzz.triage.hazards import Hazard, can_sense, doubt_in, hazard_in, is_hazard
from fuzz.triage.judging import failure_of, replay
from fuzz.triage.proofs import certified
from sim.controllers import CONTROLLERS
from sim.options.disturbances import Doubt
from sim.options.robot import RobotOptions
from sim.scenario import Scenario
from tests.helpers.command_line import worldgen
from worldgen import Pose, Target, World
from worldgen.files.grid import loads, read_world
from worldgen.generation import generate
from worldgen.timeline import CellState, Timeline

AHEAD = """
from sim import Command
class Ahead:
    def reset(self): return ()
    def act(self, observation, memory): return Command(observation.top_speed, 0.0), memory
class Planner(Ahead):
    def reset(self, world): return ()
"""


@pytest.fixture
def mine(tmp_path):
    (tmp_path / "mine.py").write_text(AHEAD)
    return f"{tmp_path}/mine.py"


def burning_world():
    """A hall whose middle burns before the robot gets there, with room to drive around it."""
    walls = np.zeros((12, 20), bool)
    cells = [(ix, iy) for ix in (9, 10) for iy in (4, 5, 6)]
    timeline = Timeline.of([(0.1, ix, iy, CellState.BURNING) for ix, iy in cells])
    return World(walls, Pose(0.25, 0.55, 0.0), Target(1.75, 0.55, 0.05), timeline=timeline)


@pytest.mark.parametrize(
    ("robot", "state", "entered", "sensed"),
    [
        (RobotOptions(), "burning", True, False),
        (RobotOptions(beams=36), "burning", True, False),
        (RobotOptions(smoke=0.2), "burning", True, True),
        (RobotOptions(smoke=0.2), "burning", False, True),
        (RobotOptions(beams=36), "solid", True, True),
        (RobotOptions(beams=36), "solid", False, False),
    ],
)
def test_only_what_a_sense_shows_can_be_known(robot, state, entered, sensed, mine):
    assert can_sense(CONTROLLERS.get(f"{mine}:Ahead"), robot, state, entered=entered) is sensed


def test_a_controller_that_declares_other_senses_does_not_see_smoke():
    assert not can_sense(
        CONTROLLERS.get("wall-left"), RobotOptions(smoke=0.2), "burning", entered=True
    )


def test_a_controller_that_plans_on_the_world_knows_when_it_burns(mine):
    assert can_sense(CONTROLLERS.get(f"{mine}:Planner"), RobotOptions(), "solid", entered=False)


@pytest.mark.parametrize(
    ("details", "hazard", "reason"),
    [
        pytest.param({}, None, "", id="none"),
        pytest.param({"hazard": "unsensed"}, Hazard.UNSENSED, "", id="unsensed"),
        pytest.param(
            {"hazard": "disturbed", "hazard_reason": "fast-drift"},
            Hazard.DISTURBED,
            Doubt.FAST_DRIFT.sentence,
            id="disturbed",
        ),
        pytest.param(
            {"hazard": "disturbed: the wind is strong"},
            Hazard.DISTURBED,
            "the wind is strong",
            id="earlier-version",
        ),
        pytest.param({"hazard": 3}, None, "", id="foreign"),
    ],
)
def test_a_record_says_which_hazard_it_is_and_why(details, hazard, reason):
    assert (hazard_in(details), doubt_in(details)) == (hazard, reason)


def test_a_robot_that_drifts_too_fast_is_a_hazard_with_its_reason():
    world = generate("trap", 3)
    failure = failure_of(world, Scenario.parse(f"wall-left+drift={world.robot_speed}"))
    details = failure.record.details
    assert hazard_in(details) == Hazard.DISTURBED
    assert details["hazard_reason"] == Doubt.FAST_DRIFT and is_hazard(failure)


@pytest.mark.parametrize(("name", "unsensed"), [("Ahead", True), ("Planner", False)])
def test_a_failure_says_whether_its_controller_could_have_known_better(name, unsensed, mine):
    world = burning_world()
    failure = failure_of(certified(world), Scenario(f"{mine}:{name}"))
    assert failure.record.verdict == "burned" and is_hazard(failure) is unsensed
    assert replay(Failure.of(loads(failure.dumps()))).confirmed


def test_a_hazard_that_is_shrunk_stays_one(mine):
    world = burning_world()
    failure = failure_of(certified(world), Scenario(f"{mine}:Ahead"))
    assert is_hazard(shrink(failure, seconds=1.0).failure)


@pytest.fixture(scope="module")
def met(tmp_path_factory):
    """A campaign of a controller that arrives wherever nothing burns."""
    out = tmp_path_factory.mktemp("hazards") / "out"
    options = (
        "--controller",
        "mapper",
        "--family",
        "fire",
        "--units",
        1,
        "--examples",
        48,
        "--seed",
        1,
    )
    return out, worldgen("fuzz", *options, "--workers", 1, "--no-shrink", "--out", out, "--json")


@pytest.mark.gate
def test_hazards_alone_do_not_make_a_build_fail_and_are_listed_apart(met):
    said = json.loads(met[1].out)
    assert said["hazards"] and not said["failures"] and met[1].code == 0
    assert all(
        one["verdict"] == "burned" and is_hazard(Failure.of(read_world(one["file"])))
        for one in said["hazards"]
    )


@pytest.mark.gate
def test_hazards_count_where_that_is_asked_for(met):
    again = worldgen("fuzz", "--resume", met[0], "--workers", 1, "--count-hazards", "--json")
    said = json.loads(again.out)
    assert again.code == 1 and said["failures"] and not said["hazards"]


def test_the_summary_says_that_there_are_no_failures_but_hazards(met):
    again = worldgen("fuzz", "--resume", met[0], "--workers", 1)
    assert again.code == 0 and "--count-hazards makes failures of" in again.err
    assert (
        "no failure of mapper under swept found, except for hazards that it cannot sense"
        in again.out
    )
