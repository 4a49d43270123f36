"""Goals that ask for more than a touch, in searches, causes, shrinking and the studio."""

import math
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzz.cause import Cause, Diagnosis
from fuzz.facts.changed_worlds import OtherWorlds
from fuzz.facts.proofs import certified, walled_off
from fuzz.layouts.layout_bytes import SCENE_BYTES
from fuzz.screening import evaluate
from fuzz.shrink import shrink
from fuzz.studio.requests.messages import message_of, restored
from fuzz.triage.diagnosis import diagnosis_of
from fuzz.triage.judging import failure_of
from fuzz.triage.replaying import replay
from sim import Command
from sim.episode import prepare
from sim.scenario import Scenario
from worldgen import Drive, Pose, Robot, Target, World
from worldgen.lattice import UNIT

HERE = __name__


class Still:
    """Never moves."""

    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        return Command(), memory


class Past(Still):
    """Drives ahead until a step ends within 5 cm of the target."""

    tolerance: float = 0.05

    def act(self, observation, memory):
        if memory[0] or observation.target_distance <= self.tolerance:
            return Command(), (1.0,)
        return Command(observation.top_speed), memory


class Pivots(Still):
    """Takes the point 8 cm ahead of its wheels for its place, so that a turn moves it away again."""

    latches: bool = False

    def act(self, observation, memory):
        x = observation.x + 0.08 * math.cos(observation.heading)
        y = observation.y + 0.08 * math.sin(observation.heading)
        there = math.dist((x, y), (2.0, 1.0)) < 0.05 or memory[0] > 0.0
        aim = observation.goal_heading if there else math.atan2(1.0 - y, 2.0 - x)
        off = math.remainder(aim - observation.heading, math.tau)
        turn = max(-1.0, min(1.0, off / observation.time_step))
        speed = 0.2 if abs(off) < 0.3 and not there else 0.0
        return Command(speed, turn), (float(there and self.latches),)


class Drifts(Still):
    """Arrives on time, but does not slow down before it is there."""

    def act(self, observation, memory):
        near = observation.target_distance < 0.2
        return Command(0.1 if near else 0.5, 0.0), memory


def room(start=(0.5, 0.5), target=(2.0, 1.0), radius=0.05, heading=0.0, **goal):
    walls = np.ones((20, 30), bool)
    walls[1:-1, 1:-1] = False
    return certified(
        World(
            walls,
            Pose(*start, heading),
            Target(*target, radius, **goal),
            robot_radius=0.2,
            robot_speed=2.0,
        )
    )


def found(name, world, options="+time_step=0.1"):
    failure = failure_of(world, Scenario.parse(f"{HERE}:{name}{options}"))
    assert failure is not None
    return failure


# Causes.


@pytest.mark.parametrize("arrival", ["step", "stop"])
def test_a_robot_that_drives_through_its_target_between_two_steps_passes_its_goal(arrival):
    failure = found("Past", room((0.5, 1.0), (1.61, 1.0), arrival=arrival))
    assert diagnosis_of(failure) == Diagnosis(Cause.PASSES_ITS_GOAL)
    assert failure_of(room((0.5, 1.0), (1.61, 1.0)), failure.scenario) is None


@pytest.mark.parametrize("radius", [0.05, 0.15])
def test_a_robot_that_turns_out_of_its_target_again_never_settles(radius):
    world = room(radius=radius, heading=0.1, **{"heading_tolerance": 0.1}, arrival="stop")
    world = replace(world, target=replace(world.target, heading=2.4))
    failure = found("Pivots", world, "+time_step=0.05")
    assert failure.verdict == "loop" and diagnosis_of(failure) == Diagnosis(Cause.NEVER_SETTLES)
    if radius > 0.1:
        assert failure_of(world, Scenario.parse(f"{HERE}:Pivots+latches+time_step=0.05")) is None


def test_a_robot_that_stands_in_its_target_with_another_heading_never_settles():
    world = room((2.0, 1.0))
    world = replace(world, target=replace(world.target, heading=2.0))
    assert diagnosis_of(found("Still", world)) == Diagnosis(Cause.NEVER_SETTLES)
    # Elsewhere, its motion is the reason.
    far = replace(world, start=Pose(0.5, 0.5))
    assert diagnosis_of(found("Still", certified(far))).cause == Cause.STANDS_STILL


def test_a_robot_that_pushes_a_wall_in_its_target_pushes_a_wall():
    world = room((2.0, 1.0), target=(2.7, 1.0), radius=0.1, arrival="stop")
    assert diagnosis_of(found("Drifts", world)).cause == Cause.PUSHES_A_WALL


def test_a_contact_that_the_goal_forbids_touches_a_wall():
    failure = found("Past", room((0.5, 1.0), (1.61, 1.0), arrival="step", contact="fail"))
    assert (failure.verdict, failure.evidence.cell) == ("contact", (29, 9))
    assert diagnosis_of(failure) == Diagnosis(Cause.TOUCHES_A_WALL)
    assert failure.record.details["class"] == "contact-block"


# Shrinking, replays and changed worlds keep the goal.


@pytest.mark.parametrize(
    ("name", "goal"),
    [
        ("Past", {"target": (1.61, 1.0), "arrival": "step"}),
        ("Past", {"target": (1.61, 1.0), "arrival": "step", "contact": "fail"}),
        ("Drifts", {"target": (1.5, 1.0), "arrival": "stop", "arrival_speed": 0.05}),
    ],
)
def test_a_shrunk_failure_keeps_its_goal_and_replays(name, goal):
    failure = found(name, room((0.5, 1.0), **goal))
    small = shrink(failure).failure
    assert small.world.walls.size < failure.world.walls.size
    place = {name: getattr(failure.world.target, name) for name in ("x", "y", "radius")}
    assert replace(small.world.target, **place) == failure.world.target
    assert small.record.details["one_minimal"] is True
    assert (small.verdict, diagnosis_of(small)) == (failure.verdict, diagnosis_of(failure))
    assert replay(small).confirmed


GOAL = Target(2.0, 1.0, 0.05, 0.5, 0.1, "stop", 0.2, 0.3, "stop")
CAR = Robot(
    Pose(0.5, 0.5), GOAL, speed=1.0, drive=Drive(0.4, True, 2.0),
    footprint=((0.2, 0.1), (-0.1, 0.1), (-0.1, -0.1), (0.2, -0.1)),
)  # fmt: skip


def test_a_target_that_grows_to_its_whole_cell_keeps_its_goal():
    walls = np.zeros((20, 30), bool)
    walls[:, 15] = True
    robot = replace(CAR, footprint=(), drive=Drive(), radius=0.07)
    cut = walled_off(World(walls, robots=[robot]))
    assert cut is not None and cut.target == GOAL


def test_a_world_that_the_studio_edits_keeps_what_its_page_does_not_show():
    world = World(np.zeros((20, 30), bool), robots=[CAR])
    assert restored(message_of(world)) == world
    edited = msgspec.structs.replace(
        message_of(world), start=(0.6, 0.7, 0.8), target=(1.5, 1.0, 0.1)
    )
    expected = replace(CAR, start=Pose(0.6, 0.7, 0.8), target=replace(GOAL, x=1.5, radius=0.1))
    assert restored(edited).robots == (expected,)


def test_a_room_that_tells_whether_a_robot_follows_walls_has_the_same_robot(monkeypatch):
    seen = []

    def noted(room, controller, options, **settings):
        seen.append(room.robots[0])
        raise AssertionError

    monkeypatch.setattr("fuzz.facts.changed_worlds.simulate", noted)
    world = World(np.zeros((20, 30), bool), robots=[CAR])
    with pytest.raises(AssertionError):
        OtherWorlds(f"{HERE}:Still", Scenario(f"{HERE}:Still").options(world)).gets_around_walls(
            world
        )
    (robot,) = seen
    assert (robot.footprint, robot.drive, robot.speed) == (CAR.footprint, CAR.drive, CAR.speed)
    assert robot.target.contact == "stop" and robot.target.heading is None


# Screening.

SCENE = st.binary(min_size=SCENE_BYTES, max_size=SCENE_BYTES)
GOALS = st.sampled_from(
    (
        {"robot_arrival": "step"},
        {"robot_arrival": "stop:0.5:9"},
        {"robot_target_heading": "1.2:0.5"},
        {"robot_contact": "fail"},
        {"robot_contact": "stop", "robot_arrival": "step", "robot_target_heading": "-2:1"},
    )
)


@given(SCENE, GOALS, st.sampled_from(("turn-left", "turn-right+motion=endpoint", "vfh")))
def test_a_look_at_another_goal_is_the_run_in_the_decoded_world(data, goal, name):
    scenario = Scenario.parse(name)
    looks = evaluate(np.frombuffer(data, np.uint8)[None, :], scenario, 3, 0.05, 800, **goal)
    if looks.ran[0]:
        world = looks.world(0)
        assert not world.target.is_plain
        budget = int(looks.budget[0])
        options = looks.scenario_of(0).options(world, budget)
        run = prepare(world, scenario.controller, options).run(budget, find_loop=True, record=False)
        assert looks.verdict[0] in (run.ending, "undecided", "overlap")
        assert (looks.steps[0], looks.period[0]) == (run.steps, run.period)
        assert looks.raw["hit_step"][0] == run.hit_step
        assert looks.path[0] / UNIT * world.cell_size == pytest.approx(run.path_length, rel=1e-12)


def test_looks_at_other_goals_arrive_loop_and_touch_walls():
    scenes = np.random.default_rng(1).integers(0, 256, (80, SCENE_BYTES), dtype=np.uint8)

    def count(name, verdict, **goal):
        return int((evaluate(scenes, Scenario(name), 1, 0.05, **goal).verdict == verdict).sum())

    # One that slows down at its target also stops there.
    assert count("bug2", "reached") == count("bug2", "reached", robot_arrival="stop")
    touches = count("turn-left", "reached")
    assert touches > count("turn-left", "reached", robot_arrival="step") > 0
    assert touches > count("turn-left", "reached", robot_target_heading="1:0.3") > 0
    assert count("turn-left", "loop", robot_arrival="stop") > count("turn-left", "loop")
    assert count("turn-left", "contact", robot_contact="fail") > 0
