"""Failures of several robots: judged, checked, sorted, shrunk and found."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import strategies as st

from fuzz.boundary import Subject, run_subject
from fuzz.campaign.configure import configure
from fuzz.cause import Cause, Circumstance, Diagnosis
from fuzz.evidence_checks import check_fleet
from fuzz.facts.changed_worlds import OtherWorlds
from fuzz.facts.proofs import certified
from fuzz.facts.signature import Standoff, standoff
from fuzz.failure import Failure
from fuzz.oracles import Trial
from fuzz.search.drawn import explore, poses_on, strategy_worlds
from fuzz.search.fleets import fleet_worlds
from fuzz.shrink import removable, shrink
from fuzz.shrink.predicate import StillFails
from fuzz.strategies import scenarios_in
from fuzz.triage.diagnosis import cause_of_run, diagnosis_of, diagnosis_of_run
from fuzz.triage.judging import failure_of
from fuzz.triage.replaying import replay
from fuzz.unit.options import CampaignOptions
from sim import simulate
from sim.controllers.base import Command, Memory, Observation
from sim.episode.describe import describe_evidence
from sim.evidence import JointLoopEvidence
from sim.fleet import fleet_traces
from sim.motion import MOTIONS
from sim.options.run import RunOptions
from sim.scenario import Scenario
from sim.verdict import JOINT_LOOPS, Verdict
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from tests.helpers.straight import Straight
from worldgen import generate
from worldgen.errors import InvalidParameter
from worldgen.files.grid import write_world
from worldgen.world import JointWitness, Pose, Robot, Target, World

SHIPPED = Path(__file__).parents[2] / "corpora/failures"

STRAIGHT = Scenario.parse("tests.helpers.straight:Straight")


def alley(*, third: bool = False) -> World:
    """A passage for one robot with a bay, in which two want to change places; a third one parks."""
    walls = np.ones((4, 15), bool)
    walls[:2] = False
    walls[2:, 6:8] = False
    robots = [
        Robot(Pose(0.35, 0.1), Target(1.25, 0.1, 0.05)),
        Robot(Pose(1.25, 0.1, math.pi), Target(0.35, 0.1, 0.05)),
    ]
    if third:
        robots.append(Robot(Pose(0.08, 0.1), Target(0.08, 0.1, 0.05)))
    proved = certified(World(walls, robots=robots))
    assert proved is not None
    return proved


def deadlock(*, third: bool = False) -> Failure:
    """Two robots that meet in an alley and block each other."""
    failure = failure_of(alley(third=third), STRAIGHT)
    assert failure is not None
    return failure


def joint_loop(**changes: object) -> JointLoopEvidence:
    """Evidence of two robots that stand face to face, with changes."""
    usual = JointLoopEvidence(
        entry=10, period=1, state_digest="", waiting=(1, 2), moving=(), blocked=(), parked=()
    )
    return replace(usual, **changes)  # type: ignore[arg-type]


def test_two_robots_that_block_each_other_are_a_failure_with_a_joint_witness() -> None:
    failure = deadlock()
    assert failure.verdict == Verdict.DEADLOCK
    assert failure.signature == "deadlock-face-to-face"
    assert isinstance(failure.world.certificate, JointWitness)
    assert diagnosis_of(failure) == Diagnosis(Cause.HELD_UP_BY_ROBOTS, Circumstance.FACE_TO_FACE)


def test_a_deadlock_replays_from_its_bytes() -> None:
    failure = deadlock()
    assert replay(Failure.of(failure.stored)).confirmed


@pytest.mark.parametrize(
    "changes",
    [
        {"moving": (1,)},
        {"waiting": (1,)},
        {"entry": 0},
        {"parked": ((2, 5),), "waiting": (1,)},
        {"period": 0},
        {"blocked": ((1, 1),)},
        {"blocked": ((1, 3),)},
    ],
    ids=[
        "moving",
        "one missing",
        "too early",
        "not parked",
        "no period",
        "blocked by itself",
        "blocked by nobody",
    ],
)
def test_false_evidence_of_a_deadlock_is_refused(changes: dict[str, object]) -> None:
    failure = deadlock()
    evidence = failure.evidence
    assert isinstance(evidence, JointLoopEvidence)
    steps = evidence.entry + 2 * evidence.period
    traces = fleet_traces(failure.world, STRAIGHT.controller, failure.options, steps)
    found = [trace for trace in traces if trace is not None]
    swept = MOTIONS.get("swept")
    assert check_fleet(failure.world, found, Verdict.DEADLOCK, evidence, swept) == ""
    false = replace(evidence, **changes)  # type: ignore[arg-type]
    assert check_fleet(failure.world, found, Verdict.DEADLOCK, false, swept)
    assert check_fleet(failure.world, found, Verdict.LIVELOCK, evidence, swept)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"periods": ((1, 369),)}, "are not the waiting ones"),
        ({"periods": ((1, 369), (2, 546))}, "do not all return"),
        ({"periods": ((1, 545), (2, 369))}, "the second period differs"),
        ({"periods": ((1, 123), (2, 545)), "period": 67_035}, "the second period differs"),
    ],
    ids=["one missing", "another multiple", "exchanged", "too short"],
)
def test_false_evidence_of_loops_apart_is_refused(changes: dict[str, object], said: str) -> None:
    world = generate("doorway", seed=1, robots=2)
    swept = MOTIONS.get("swept")
    scenario = Scenario.parse("turn-right")
    evidence = simulate(world, "turn-right").evidence
    assert isinstance(evidence, JointLoopEvidence)
    steps = evidence.entry + 2 * evidence.driven_period
    traces = fleet_traces(world, scenario.controller, scenario.options(world), steps)
    found = [trace for trace in traces if trace is not None]
    assert check_fleet(world, found, Verdict.LIVELOCK, evidence, swept) == ""
    false = replace(evidence, **changes)  # type: ignore[arg-type]
    assert said in check_fleet(world, found, Verdict.LIVELOCK, false, swept)


def test_loops_of_robots_that_could_touch_in_a_step_are_not_apart() -> None:
    world = generate("doorway", seed=1, robots=2)
    scenario = Scenario.parse("turn-right")
    evidence = simulate(world, "turn-right").evidence
    assert isinstance(evidence, JointLoopEvidence)
    steps = evidence.entry + 2 * evidence.driven_period
    traces = fleet_traces(world, scenario.controller, scenario.options(world), steps)
    found = [trace for trace in traces if trace is not None]
    fast = replace(world, robots=(world.robots[0], replace(world.robots[1], speed=200.0)))
    said = check_fleet(fast, found, Verdict.LIVELOCK, evidence, MOTIONS.get("swept"))
    assert "come within" in said


def test_loops_apart_from_each_other_are_a_failure_that_replays() -> None:
    failure = failure_of(generate("doorway", seed=1, robots=2), Scenario.parse("turn-right"))
    assert failure is not None
    assert failure.signature == "livelock-apart"
    assert replay(Failure.of(failure.stored)).confirmed


def test_robots_that_are_far_apart_cannot_block_each_other() -> None:
    world = alley()
    evidence = joint_loop(entry=1, blocked=((1, 2),))
    traces = fleet_traces(world, STRAIGHT.controller, STRAIGHT.options(world), 3)
    found = [trace for trace in traces if trace is not None]
    said = check_fleet(world, found, Verdict.DEADLOCK, evidence, MOTIONS.get("swept"))
    assert "cannot block each other" in said


def test_robots_that_overlap_are_noticed() -> None:
    failure = deadlock()
    trial = Trial.recorded(failure.world, STRAIGHT.controller, failure.options)
    first = trial.recorded_run.robots[0].trace  # type: ignore[attr-defined]
    evidence = failure.evidence
    assert evidence is not None
    twice = [first, first]
    assert "overlap" in check_fleet(
        failure.world, twice, Verdict.DEADLOCK, evidence, MOTIONS.get("swept")
    )


@pytest.mark.parametrize(
    ("evidence", "expected"),
    [
        (joint_loop(blocked=((1, 2), (2, 1))), Standoff.FACE_TO_FACE),
        (joint_loop(blocked=((1, 2), (2, 3), (3, 1)), waiting=(1, 2, 3)), Standoff.CIRCULAR_WAIT),
        (joint_loop(blocked=((1, 2),), waiting=(1,), parked=((2, 5),)), Standoff.BEHIND_PARKED),
        (joint_loop(blocked=((1, 2),)), Standoff.QUEUE),
        (joint_loop(moving=(1, 2)), Standoff.OSCILLATION),
        (joint_loop(), Standoff.APART),
    ],
    ids=lambda value: value if isinstance(value, Standoff) else "",
)
def test_a_standoff_is_named_after_who_drives_into_whom(
    evidence: JointLoopEvidence, expected: Standoff
) -> None:
    assert standoff(evidence) == expected


def arrives(answer: bool) -> OtherWorlds:
    """Return runs in other worlds in which the robot always arrives, or never."""

    class Same(OtherWorlds):
        def arrives(self, world: World) -> bool:
            return answer

    return Same("naive", RunOptions())


class CountingStraight(Straight):
    """The same with a counter, so no loop can be proved."""

    def reset(self) -> Memory:
        return (0.0,)

    def act(self, observation: Observation, memory: Memory) -> tuple[Command, Memory]:
        return super().act(observation, ())[0], (memory[0] + 1.0,)


HELD_UP = Diagnosis(Cause.HELD_UP_BY_ROBOTS)


@pytest.mark.gate
def test_robots_that_stop_for_each_other_without_a_proof_wait_for_others() -> None:
    world = alley()
    episode = simulate(world, CountingStraight, record=True)
    assert episode.verdict == Verdict.STALLED
    assert diagnosis_of_run(world, episode, arrives(True)) == HELD_UP
    # If one of them fails even alone, or if they are far apart, its own cause counts.
    assert cause_of_run(world, episode, arrives(False)) == Cause.PUSHES_A_WALL

    walls = np.zeros((20, 30), bool)
    walls[:, 14:16] = True
    ends = [(Pose(0.3, 0.3), Target(2.7, 0.3, 0.05)), (Pose(2.7, 1.7), Target(0.3, 1.7, 0.05))]
    apart = World(walls, robots=[Robot(*of_one) for of_one in ends])
    episode = simulate(apart, CountingStraight, record=True)
    assert episode.verdict == Verdict.STALLED
    assert cause_of_run(apart, episode, arrives(True)) == Cause.PUSHES_A_WALL


def test_robots_that_never_meet_do_not_give_way() -> None:
    path = SHIPPED / "turn-right/swept/returns-to-a-wall.grid"
    failure = Failure.read(path)
    room = failure.world
    # The same room twice, with a wall between: each robot loops on its own.
    wall = np.ones((room.height, 3), bool)
    right = (room.width + 3) * room.cell_size
    (first,) = room.robots
    second = replace(
        first,
        start=replace(room.start, x=room.start.x + right),
        target=replace(room.target, x=room.target.x + right),
    )
    rooms = replace(
        room,
        walls=np.hstack([room.walls, wall, room.walls]),
        robots=(first, second),
        certificate=None,
    )
    episode = simulate(rooms, "turn-right", failure.options, record=True)
    assert episode.verdict == Verdict.LIVELOCK
    own = OtherWorlds("turn-right", failure.options)
    assert cause_of_run(rooms, episode, own) == Cause.RETURNS_TO_A_WALL
    # Robots that would arrive alone stop each other.
    assert diagnosis_of_run(rooms, episode, arrives(True)) == Diagnosis(
        Cause.HELD_UP_BY_ROBOTS, Circumstance.GIVING_WAY
    )


def test_robots_that_only_wait_are_told_from_one_that_fails_alone() -> None:
    # In a room of 4 x 4 cells, pibt's robots of 1.4 cells stop before they touch.
    room = np.zeros((4, 4), bool)
    first = Robot(Pose(0.15, 0.25), Target(0.25, 0.15, 0.05))
    second = Robot(Pose(0.25, 0.15), Target(0.15, 0.25, 0.05))
    polite = World(room, robots=(first, second))
    episode = simulate(polite, "pibt", record=True)
    assert episode.verdict == Verdict.DEADLOCK and episode.evidence.blocked == ()
    assert diagnosis_of_run(polite, episode, arrives(True)) == HELD_UP
    assert cause_of_run(polite, episode, arrives(False)) == Cause.STANDS_STILL

    # A robot that has parked in a passage stops the other one without touching it.
    passage = np.ones((4, 15), bool)
    passage[:2] = False
    parked = Robot(Pose(0.75, 0.1), Target(0.8, 0.1, 0.05))
    driver = Robot(Pose(0.35, 0.1), Target(1.25, 0.1, 0.05))
    closed = World(passage, robots=(driver, parked))
    episode = simulate(closed, "pibt", record=True)
    assert episode.verdict == Verdict.STARVED and episode.evidence.blocked == ()
    found = diagnosis_of_run(closed, episode, arrives(True))
    assert found == Diagnosis(Cause.HELD_UP_BY_ROBOTS, Circumstance.PARKED_ROBOT)
    # Of several robots, a sentence does not say "it".
    sentences = [Diagnosis(one).sentence(closed) for one in Cause]
    sentences += [
        Diagnosis(Cause.STANDS_STILL, circumstance).sentence(closed)
        for circumstance in Circumstance
    ]
    assert not [text for text in sentences if text.startswith(("It ", "Its "))]
    assert Diagnosis(Cause.PUSHES_A_WALL).sentence(closed).startswith("A robot keeps driving")
    # The verdict's words must not deny what the cause's sentence says.
    assert "another robot's way" in found.sentence(closed)
    assert describe_evidence(episode).endswith(
        "never arrives, and no robot drives into another; robot 2 has parked)"
    )


@pytest.mark.gate
def test_shrinking_drops_the_robot_that_is_not_needed_and_all_walls() -> None:
    shrunk = shrink(deadlock(third=True))
    world = shrunk.failure.world
    assert len(world.robots) == 2
    assert world.solid_cells == 0
    assert shrunk.failure.verdict == Verdict.DEADLOCK
    assert replay(shrunk.failure).confirmed
    assert removable(world, StillFails.of(shrunk.failure)) == []


@pytest.mark.nightly
def test_a_campaign_with_two_robots_ends_with_small_proved_failures(tmp_path) -> None:
    out = tmp_path / "f"
    result = worldgen(
        "fuzz", "--robots", 2, "--controller", "vfh", "--strategy", "features", "--units", 1,
        "--examples", 30, "--seed", 1, "--workers", 1, "--out", out,
    )  # fmt: skip
    assert result.code == 1
    failures = [Failure.read(path) for path in sorted(out.glob("*.grid"))]
    proved = [failure for failure in failures if failure.verdict in JOINT_LOOPS]
    assert min(failure.world.walls.size for failure in proved) <= 40
    assert all(replay(failure).confirmed for failure in failures)


@pytest.mark.gate
def test_a_campaign_keeps_only_the_two_robots_that_block_each_other(tmp_path) -> None:
    out = tmp_path / "f"
    result = worldgen(
        "fuzz", "--family", "doorway", "--family", "junction", "--robots", 3, "--controller",
        "naive", "--units", 2, "--examples", 25, "--seed", 2, "--workers", 1, "--out", out,
    )  # fmt: skip
    assert result.code == 1
    failures = {path.stem: Failure.read(path) for path in out.glob("*.grid")}
    assert "deadlock-face-to-face" in {one.signature for one in failures.values()}
    assert {name: len(failure.world.robots) for name, failure in failures.items()} == dict.fromkeys(
        failures, 2
    )


def test_shrinking_drops_a_robot_that_only_waits_behind_the_two_that_are_needed() -> None:
    bare = alley().bare
    # The third robot follows the first one, and stops behind it.
    follower = Robot(Pose(0.15, 0.1), Target(1.1, 0.1, 0.05))
    failure = failure_of(replace(bare, robots=(*bare.robots, follower)), STRAIGHT)
    assert failure is not None and failure.evidence.waiting == (1, 2, 3)
    shrunk = shrink(failure).failure
    assert shrunk.signature == failure.signature == "deadlock-face-to-face"
    assert len(shrunk.world.robots) == 2


@pytest.mark.gate
@pytest.mark.parametrize(
    ("family", "robots"),
    [
        ("maze", 7),
        ("corridor", 2),
        ("./examples/compose/trap_in_maze.py:trap_in_maze", 2),
        ("doorway", 3),
    ],
)
def test_a_campaign_draws_several_robots_in_worlds_of_any_family(tmp_path, family, robots) -> None:
    out = tmp_path / "f"
    result = worldgen(
        "fuzz", "--family", family, "--robots", robots, "--controller", "naive", "--units", 1,
        "--examples", 24, "--seed", 1, "--workers", 1, "--no-shrink", "--out", out,
    )  # fmt: skip
    assert result.code == 1
    failures = [Failure.read(path) for path in out.glob("*.grid")]
    assert {len(failure.world.robots) for failure in failures} == {robots}


def worlds_from(where: st.SearchStrategy[World], draws: int) -> list[World]:
    """Return the worlds that a campaign's unit makes from a number of draws."""
    drawn: list[World] = []

    def visit(world: World, _: Scenario) -> str:
        drawn.append(world)
        return ""

    explore(scenarios_in(where, STRAIGHT, (0.05,), ()), 1, draws, visit)
    return drawn


def test_worlds_drawn_for_many_robots_have_room_for_them() -> None:
    drawn = worlds_from(strategy_worlds("maze", robots=20), 4)
    assert [len(world.robots) for world in drawn] == [20] * 4
    assert all(isinstance(world.certificate, JointWitness) for world in drawn)


def fleet_map(tmp_path: Path) -> Path:
    """A maze for three robots, of which the last is smaller and slower."""
    world = generate("maze", seed=5, robots=3)
    last = replace(world.robots[2], radius=0.05, speed=1.0)
    path = tmp_path / "fleet.grid"
    write_world(replace(world.bare, robots=(*world.robots[:2], last)), path)
    return path


def test_a_campaign_on_the_map_of_a_fleet_finds_failures_of_all_its_robots(tmp_path) -> None:
    out = tmp_path / "f"
    result = worldgen(
        "fuzz", "--world", fleet_map(tmp_path), "--controller", "naive", "--units", 1,
        "--examples", 40, "--seed", 1, "--workers", 1, "--out", out,
    )  # fmt: skip
    assert result.code == 1
    failures = [Failure.read(path) for path in sorted(out.glob("*.grid"))]
    assert {len(failure.world.robots) for failure in failures} == {3}
    for failure in failures:
        first, second, third = failure.world.robots
        assert second.radius == first.radius
        assert third.radius == pytest.approx(first.radius * 5 / 7, abs=1e-6)
        assert (first.speed, second.speed, third.speed) == (2.0, 2.0, 1.0)


@pytest.mark.parametrize(("robots", "drawn"), [(None, 3), (4, 4)])
def test_a_campaign_has_the_robots_of_its_map_and_more_on_demand(tmp_path, robots, drawn) -> None:
    options = CampaignOptions(controller="naive", world=fleet_map(tmp_path), robots=robots)
    assert configure(options, 1).robots == drawn


@pytest.mark.parametrize("robots", [1, 2])
def test_fewer_robots_than_the_map_has_are_refused(robots, tmp_path) -> None:
    options = CampaignOptions(controller="naive", world=fleet_map(tmp_path), robots=robots)
    with raises(InvalidParameter, code="fewer-robots", robots=robots, own=3):
        configure(options, 1)
    command = ["fuzz", "--world", tmp_path / "fleet.grid", "--controller", "naive", "--robots", "1"]
    result = worldgen(*command, "--units", "1", "--seed", "1", "--out", tmp_path / "out")
    assert result.code == 2 and "has 3 robots, not 1; omit --robots" in result.err


@pytest.mark.gate
def test_a_map_without_space_for_the_robots_asks_for_fewer(tmp_path) -> None:
    command = ["fuzz", "--world", fleet_map(tmp_path), "--controller", "naive", "--robots", "90"]
    command += ["--units", "1", "--examples", "2", "--seed", "1"]
    result = worldgen(*command, "--out", tmp_path / "out")
    assert result.code == 2 and "use fewer robots" in result.err


def test_more_robots_on_a_map_than_a_campaign_can_have_are_refused(tmp_path) -> None:
    starts = [(0.5 * x + 0.25, 0.5 * y + 0.25) for x in range(11) for y in range(10)]
    robots = [Robot(Pose(*place), Target(*place, 0.05)) for place in starts[:101]]
    path = tmp_path / "fleet.grid"
    write_world(World(np.zeros((60, 60), bool), robots=robots), path)
    with raises(InvalidParameter, code="too-many-robots", own=101):
        configure(CampaignOptions(controller="naive", world=path), 1)


def test_most_draws_of_many_robots_keep_them_apart() -> None:
    open_map = World(np.zeros((40, 40), bool), Pose(1.0, 1.0), Target(3.0, 3.0, 0.05))
    drawn = worlds_from(fleet_worlds(poses_on(open_map), 12, open_map), 40)
    assert len(drawn) >= 30
    assert {len(world.robots) for world in drawn} == {12}


def test_a_strategy_for_one_robot_is_refused_with_several(tmp_path) -> None:
    result = worldgen(
        "fuzz", "--robots", 2, "--controller", "vfh", "--strategy", "native", "--units", 1,
        "--seed", 1, "--out", tmp_path / "f",
    )  # fmt: skip
    assert result.code == 2
    assert result.error.code == "strategy-for-one-robot"


def test_a_boundary_is_about_all_robots() -> None:
    ran = run_subject(Subject(alley(), STRAIGHT))
    assert ran is not None
    assert ran[1].verdict == Verdict.DEADLOCK
