"""Hazards that a controller cannot sense are kept apart from failures, and fail a build only on
request.
"""

import json
import pickle

import numpy as np
import pytest

from fuzz.cause import Cause
from fuzz.facts.hazards import Hazard, can_sense, doubt_in, hazard_in, is_hazard
from fuzz.facts.proofs import certified
from fuzz.failure import Failure
from fuzz.overview.natural import _run
from fuzz.shrink import shrink
from fuzz.simplicity import Case
from fuzz.triage.judging import failure_of
from fuzz.triage.replaying import replay
from sim import simulate
from sim.controllers import CONTROLLERS
from sim.controllers.timeline_reads import noting_reads, world_to_read
from sim.options.disturbances import Doubt
from sim.options.robot import RobotOptions
from sim.scenario import Scenario
from tests.helpers.command_line import worldgen
from worldgen import Pose, Target, World
from worldgen.files.grid import loads, read_world
from worldgen.generation import generate
from worldgen.timeline import CellState, Timeline

AHEAD = """
import copy
import pickle
from dataclasses import replace
import numpy as np
from sim import Command
from worldgen import World
from worldgen.difficulty.bottleneck import bottleneck
from worldgen.reach import decide
from worldgen.timeline import Timeline
class Ahead:
    def reset(self): return ()
    def act(self, observation, memory): return Command(observation.top_speed, 0.0), memory
class Walls(Ahead):
    def reset(self, world):
        self.free = ~world.walls
        self.waits = world.is_dynamic
        return ()
class Copies(Ahead):
    def reset(self, world):
        larger = replace(world, robot_radius=world.robot_radius * 1.1)
        assert larger != world and copy.deepcopy(world) == copy.copy(world) == world
        assert isinstance(larger, World) and isinstance(world.timeline, Timeline)
        self.world = replace(larger, robots=larger.robots)
        self.gap = bottleneck(world, world.walls)
        return ()
class Looks(Ahead):
    def reset(self, world): return (float(world.timeline.last_time),)
class LooksAtACopy(Ahead):
    def reset(self, world): return (float(replace(world, robot_radius=0.05).bare.timeline.times[0]),)
class LooksLater(Ahead):
    def reset(self, world):
        self.world = world
        return (0.0,)
    def act(self, observation, memory):
        burning = self.world.cells_at(observation.time)
        return Command(observation.top_speed, 0.0), memory
class AsksAHelper(Ahead):
    def reset(self, world):
        return (1.0,) if decide(world).result == "reachable" else (0.0,)
class SendsItAway(Ahead):
    def reset(self, world):
        self.sent = pickle.dumps(world)
        return ()
"""
NOT_READ = ("Ahead", "Walls", "Copies")
READ = ("Looks", "LooksAtACopy", "LooksLater", "AsksAHelper", "SendsItAway")


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


@pytest.mark.parametrize(
    ("name", "unsensed"), [(name, True) for name in NOT_READ] + [(name, False) for name in READ]
)
def test_a_failure_says_whether_its_controller_could_have_known_better(name, unsensed, mine):
    world = burning_world()
    failure = failure_of(certified(world), Scenario(f"{mine}:{name}"))
    assert failure.record.verdict == "burned" and is_hazard(failure) is unsensed
    assert replay(Failure.of(loads(failure.dumps()))).confirmed


def test_noting_what_is_read_changes_nothing_in_the_run(mine):
    world = certified(burning_world())
    for name in (*NOT_READ, *READ):
        plain = simulate(world, f"{mine}:{name}", steps=300)
        with noting_reads() as reads:
            noted = simulate(world, f"{mine}:{name}", steps=300)
        assert (noted.trace_digest, noted.evidence) == (plain.trace_digest, plain.evidence)
        assert reads.any is (name in READ)


def test_a_timeline_that_notes_reading_is_compared_pickled_and_replaced_like_any_other():
    world = burning_world()
    with noting_reads() as reads:
        noting = world_to_read(world)
    assert noting == world and world == noting and not reads.any
    assert pickle.dumps(noting.timeline) == pickle.dumps(world.timeline) and reads.any
    later = noting.timeline.with_time(5, 9.0)
    assert type(later) is Timeline and later == world.timeline.with_time(5, 9.0)
    assert world_to_read(world) is world


GAPS = """
import math
import numpy as np
from sim import Command
class Plans:
    senses = ("x", "y", "heading", "bump")
    def reset(self, world):
        rows = np.flatnonzero(~world.walls[:, 10])
        return (float((rows.mean() + 0.5) * world.cell_size),)
    def act(self, seen, memory):
        x, y = (1.05, memory[0]) if seen.x < 1.04 else (1.75, 0.55)
        turn = math.remainder(math.atan2(y - seen.y, x - seen.x) - seen.heading, 2 * math.pi)
        return Command(seen.top_speed, turn / seen.time_step), memory
class Waits(Plans):
    def reset(self, world):
        self.last = world.timeline.last_time
        return super().reset(world)
class HasBeams(Plans):
    senses = (*Plans.senses, "beams")
class Guesses(Plans):
    def reset(self): return (0.35,)
"""


def gap_that_moves():
    """A hall in two halves: the lower gap between them closes, and the upper one opens."""
    walls = np.zeros((12, 20), bool)
    walls[:, 10] = True
    walls[2:5, 10] = False
    closes = [(0.1, 10, iy, CellState.SOLID) for iy in (2, 3, 4)]
    opens = [(0.1, 10, iy, CellState.FREE) for iy in (7, 8, 9)]
    timeline = Timeline.of(closes + opens)
    return World(walls, Pose(0.25, 0.55, 0.0), Target(1.75, 0.55, 0.05), timeline=timeline)


@pytest.mark.gate
@pytest.mark.parametrize(
    ("controller", "unsensed"),
    [("Plans", True), ("Plans+beams=36", True), ("HasBeams+beams=36", False), ("Waits", False)],
)
def test_a_plan_that_a_moved_wall_spoils_is_judged_by_what_was_read(controller, unsensed, tmp_path):
    (tmp_path / "gaps.py").write_text(GAPS)
    scenario = Scenario.parse(f"{tmp_path}/gaps.py:{controller}")
    failure = failure_of(certified(gap_that_moves()), scenario)
    assert failure.record.verdict in ("loop", "stalled") and is_hazard(failure) is unsensed
    cause = Cause.HARMED_UNSENSED if unsensed else Cause.PUSHES_A_WALL
    assert failure.record.details["cause"] == cause
    assert _run(Case(certified(gap_that_moves()), scenario))[1] == cause
    assert replay(failure).confirmed


def test_a_planner_that_fails_in_the_changed_world_too_is_at_fault(tmp_path):
    (tmp_path / "gaps.py").write_text(GAPS.replace("seen.x < 1.04", "True"))
    failure = failure_of(certified(gap_that_moves()), Scenario(f"{tmp_path}/gaps.py:Plans"))
    assert not is_hazard(failure)


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


@pytest.mark.gate
def test_the_summary_says_that_there_are_no_failures_but_hazards(met):
    again = worldgen("fuzz", "--resume", met[0], "--workers", 1)
    assert again.code == 0 and "--count-hazards makes failures of" in again.err
    assert (
        "no failure of mapper under swept found, except for hazards that it cannot sense"
        in again.out
    )
