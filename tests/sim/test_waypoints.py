"""Runs through waypoints: when a goal counts, what is sensed of it, and what is told of the result."""

import json
from dataclasses import replace

import numpy as np
import pytest

from sim import Command, RobotOptions, RunOptions, simulate, simulate_many
from sim.audit import Trajectory, audit
from sim.episode.describe import describe_missed_goal, describe_unreachable
from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen import InvalidParameter, Pose, Robot, Target, World
from worldgen.files.grid import write_world
from worldgen.reach import decide
from worldgen.robot import Drive


def lane(*waypoints, target=(2.5, 0.5), **robot):
    """Return a lane of 3 x 1 m; a step of 0.1 s at 1 m/s is one cell long."""
    own = Robot(Pose(0.5, 0.5), Target(*target, 0.05), 0.1, 1.0, waypoints=waypoints, **robot)
    return World(np.zeros((10, 30), bool), cell_size=0.1, robots=[own])


class Seeks:
    """Drives to the goal that it senses."""

    senses = (
        "heading",
        "target_heading",
        "target_distance",
        "goal_heading",
        "top_speed",
        "time_step",
    )

    def reset(self):
        return ()

    def act(self, seen, memory):
        turn = (seen.target_heading - seen.heading + np.pi) % (2 * np.pi) - np.pi
        return Command(seen.top_speed, turn / seen.time_step), memory


class Notes(Seeks):
    """Keeps what it senses of its goals."""

    def __init__(self):
        self.seen = []

    def act(self, seen, memory):
        self.seen.append((seen.target_heading, seen.target_distance, seen.goal_heading))
        return super().act(seen, memory)


OPTIONS = RunOptions("swept", 400, 0.1, 0)


def passed_steps(world, controller=None):
    """Return the steps in which a run passes waypoints, and its episode."""
    episode = simulate(world, controller or Seeks(), OPTIONS, record=True)
    return (np.flatnonzero(np.diff(episode.trace.passed)) + 1).tolist(), episode


def test_goals_are_reached_in_order():
    there = [Target(1.5, 0.5, 0.1), Target(1.0, 0.5, 0.1), Target(2.0, 0.5, 0.1)]
    steps, episode = passed_steps(lane(*there))
    assert (episode.verdict, episode.goals_reached) == ("reached", 4)
    assert steps == sorted(steps) and len(steps) == 3


def test_a_step_arrives_at_one_goal_at_most():
    # A step drives across both, and the robot has to come back to the second.
    near = [Target(0.62, 0.5, 0.01), Target(0.66, 0.5, 0.01)]
    steps, episode = passed_steps(lane(*near))
    assert len(steps) == 2 and steps[1] > steps[0]
    assert episode.verdict == "reached"


def test_equal_waypoints_are_passed_in_successive_steps():
    steps, _ = passed_steps(lane(*[Target(0.5, 0.5, 0.3)] * 3))
    assert steps == [1, 2, 3]


@pytest.mark.parametrize("arrival", ["touch", "step"])
def test_the_controller_senses_the_next_goal_in_the_step_of_the_arrival(arrival):
    controller = Notes()
    there = Target(1.0, 0.5, 0.06, heading=0.0, arrival=arrival)
    steps, _ = passed_steps(lane(there, target=(0.5, 0.8)), controller)
    before, after = controller.seen[steps[0] - 2], controller.seen[steps[0] - 1]
    assert before[0] == pytest.approx(0.0) and before[2] == 0.0
    assert abs(after[0]) > 1.5 and np.isnan(after[2])


def test_a_robot_that_must_stand_passes_once_it_has_acted():
    class Stops(Notes):
        def act(self, seen, memory):
            command, memory = super().act(seen, memory)
            return (command if seen.target_distance > 0.1 else Command(0.0, 0.0)), memory

    controller = Stops()
    there = Target(1.0, 0.5, 0.1, arrival="stop")
    steps, episode = passed_steps(lane(there, target=(2.5, 0.5)), controller)
    assert controller.seen[steps[0] - 1][1] <= 0.1
    assert controller.seen[steps[0]][1] > 1.0
    # The target is only touched, and the robot stops short of its middle.
    assert episode.goals_reached >= 1


def test_a_loop_proves_that_the_next_goal_is_never_reached():
    # A wall that a robot which heads straight for its goal cannot pass.
    world = lane(Target(1.0, 0.5, 0.1), Target(2.0, 0.5, 0.1))
    walls = world.walls.copy()
    walls[1:, 15] = True
    world = replace(world, walls=walls)
    _, episode = passed_steps(world)
    assert (episode.verdict, episode.goals_reached) == ("loop", 1)
    assert describe_missed_goal(world, episode) == "never reaches waypoint 2 of 2, at (2, 0.5)"


def test_the_number_of_passed_waypoints_is_part_of_the_state():
    # The robot drives around in the same square, and only the count of goals differs.
    class Circles:
        senses = ()

        def reset(self):
            return ()

        def act(self, seen, memory):
            return Command(1.0, np.pi / 2 / 0.1), memory

    there = Target(0.5, 0.5, 0.06)
    short = simulate(lane(), Circles(), OPTIONS)
    long = simulate(lane(*[there] * 3), Circles(), OPTIONS)
    assert short.verdict == long.verdict == "loop"
    assert long.evidence.entry > short.evidence.entry and long.goals_reached == 3


@pytest.mark.parametrize(
    "kind",
    [
        {"footprint": ((0.1, 0.05), (-0.1, 0.05), (-0.1, -0.05), (0.1, -0.05))},
        {"drive": Drive(0.1)},
    ],
)
def test_bodies_and_cars_pass_waypoints_and_keep_their_words(kind):
    world = lane(Target(1.0, 0.5, 0.1), Target(2.0, 0.5, 0.1), **kind)
    _, episode = passed_steps(world)
    assert episode.verdict == "reached"
    trace = episode.trace
    words = 5 if "drive" in kind else 3
    assert trace.after_memory == words and trace.passed[-1] == 2 and trace.memory_size == 0


def test_all_drivers_agree(tmp_path):
    world = lane(Target(1.5, 0.7, 0.1), Target(0.7, 0.3, 0.1))
    world = replace(world, certificate=decide(world).certificate)
    for name in ("turn-left", "bug2", "turn-random"):
        one = simulate(world, name, OPTIONS)
        many = simulate_many([world], [name], options=OPTIONS, digest=True)
        assert many.verdicts[0] == one.verdict and many.goals_reached[0] == one.goals_reached
        assert f"{int(many.digest[0]):016x}" == one.trace_digest


def test_a_lean_recording_has_the_passed_waypoints():
    world = lane(Target(1.0, 0.5, 0.1))
    whole = simulate(world, "three-layer", OPTIONS, record=True).trace
    assert whole.memory_size > 32
    assert whole.passed[-1] == 1
    assert (whole.passed == whole.states[:, -1]).all()


def test_run_names_the_goal_that_was_never_reached(tmp_path):
    world = lane(Target(1.0, 0.5, 0.1), Target(2.0, 0.5, 0.1))
    walls = world.walls.copy()
    walls[1:, 15] = True
    path = tmp_path / "w.grid"
    write_world(replace(world, walls=walls), path)
    command = ("run", path, "--controller", "turn-left", "--steps", 3000)
    facts = json.loads(worldgen(*command, "--json").out)
    assert facts["goals"] == 3 and facts["goals_reached"] < 3
    number = facts["never_reached"]["waypoint"]
    assert number == facts["goals_reached"] + 1
    assert f"waypoint {number} of 2" in worldgen(*command).out


def test_an_audit_judges_the_goals_in_order():
    world = lane(Target(1.5, 0.5, 0.1), Target(1.0, 0.5, 0.1))
    episode = simulate(world, Seeks(), OPTIONS, record=True)
    times = np.arange(episode.steps + 1) * 0.1
    found = audit(world, Trajectory(times, episode.trace.x, episode.trace.y))
    assert found.reached == pytest.approx(episode.time, abs=0.1)
    straight = Trajectory(*np.array([[0.0, 5.0], [0.5, 2.5], [0.5, 0.5]]))
    missed = audit(world, straight)
    assert missed.reached is None
    assert any("waypoint 2 of 2" in note for note in missed.notes)


def test_stepped_and_fleets_refuse_waypoints():
    world = lane(Target(1.0, 0.5, 0.1))
    with raises(InvalidParameter, "not-for-stepped"):
        simulate(world, "turn-left", RunOptions("stepped", 100))
    other = Robot(Pose(0.5, 0.8), Target(2.5, 0.8, 0.05), 0.1, 1.0)
    fleet = replace(world, robots=(*world.robots, other))
    with pytest.raises(InvalidParameter, match="waypoints"):
        simulate(fleet, "turn-left", OPTIONS)


def test_a_coverage_task_has_no_goals():
    world = lane(Target(1.0, 0.5, 0.1))
    episode = simulate(world, "turn-random", replace(OPTIONS, task="cover", robot=RobotOptions()))
    assert episode.goals_reached is None


def test_a_blocked_world_with_waypoints_does_not_blame_the_target():
    assert "through its waypoints" in describe_unreachable(
        lane(Target(1.0, 0.5, 0.1)), undecided=False
    )
    assert "waypoint" not in describe_unreachable(lane(), undecided=False)
