"""Waypoints in campaigns: evidence, shrinking, oracles' worlds, causes and what stays fixed."""

import math
from dataclasses import replace

import numpy as np
import pytest

from fuzz.evidence_checks import check_evidence
from fuzz.facts.proofs import certified
from fuzz.facts.signature import towards_its_goal
from fuzz.layouts.variation import WAYPOINTS, with_robot
from fuzz.oracles.worlds import mirrored, scaled, shifted, turned
from fuzz.search.native import fits as fits_native
from fuzz.shrink import shrink
from fuzz.shrink.edits import drop_lines
from fuzz.shrink.minimal import removable
from fuzz.simplicity import Case, simplicity
from fuzz.triage.judging import failure_of
from fuzz.triage.repeated_moves import describe_period
from fuzz.triage.replaying import replay
from fuzz.unit.config import CampaignConfig
from fuzz.unit.constraint import Constraint
from sim import Command, simulate
from sim.motion import MOTIONS
from sim.options.run import RunOptions
from sim.scenario import Scenario
from worldgen import Pose, Robot, Target, World

HERE = __name__
SWEPT = MOTIONS.get("swept")


class Forgets:
    """Drives to its goal, and stops for good if that is ever farther away than before."""

    senses = ("heading", "target_heading", "target_distance", "top_speed", "time_step")

    def reset(self):
        return (math.inf,)

    def act(self, seen, memory):
        if seen.target_distance > memory[0] + 0.2:
            return Command(), memory
        turn = math.remainder(seen.target_heading - seen.heading, math.tau)
        return Command(seen.top_speed, turn / seen.time_step), (seen.target_distance,)


def hall(*waypoints):
    walls = np.zeros((16, 24), bool)
    walls[[0, -1]], walls[:, [0, -1]] = True, True
    walls[4, 12:15] = True
    robot = Robot(Pose(0.55, 0.55), Target(1.95, 0.55, 0.05), waypoints=waypoints)
    return certified(World(walls, robots=[robot]))


THERE = (Target(0.55, 1.25, 0.1), Target(1.55, 1.25, 0.1), Target(1.95, 1.25, 0.1))
SCENARIO = Scenario(f"{HERE}:Forgets", RunOptions("swept"))


@pytest.fixture(scope="module")
def failure():
    return failure_of(hall(*THERE), SCENARIO)


def test_a_controller_that_forgets_to_forget_is_found_and_shrunk(failure):
    assert failure.verdict == "loop"
    small = shrink(failure).failure
    robot = small.world.robots[0]
    # One goal after another is all that it takes.
    assert len(robot.waypoints) == 1 and not small.world.walls.any()
    assert replay(small).confirmed
    assert not removable(small.world, lambda world: None)


def test_minimality_includes_waypoints(failure):
    names = removable(failure.world, certified)
    assert {f"waypoint {number} of robot 1" for number in (1, 2, 3)} <= set(names)


def test_dropped_lines_move_waypoints():
    dropped = drop_lines(hall(*THERE), 8, 2, axis=0)
    assert [round(goal.y, 9) for goal in dropped.robots[0].waypoints] == [1.05] * 3


def test_fewer_waypoints_are_simpler():
    sizes = [simplicity(Case(hall(*THERE[:count]), SCENARIO)) for count in range(4)]
    assert sizes == sorted(sizes)


def recorded(world, name=f"{HERE}:Forgets", steps=600):
    episode = simulate(world, name, RunOptions("swept", steps, 0.015, 0), record=True)
    return episode, episode.trace


def test_true_evidence_of_waypoints_holds_and_false_does_not():
    class Seeks(Forgets):
        def act(self, seen, memory):
            return super().act(seen, (math.inf,))

    world = hall(*THERE)
    episode, trace = recorded(world, Seeks)
    assert (episode.verdict, episode.goals_reached) == ("reached", 4)
    claim = ("reached", world, trace, episode.evidence, SWEPT)
    assert check_evidence(*claim) == ""
    steps = np.flatnonzero(np.diff(trace.passed)) + 1
    # A waypoint that is counted too early, two at once, and one too few.
    early, twice, few = (trace.passed.copy() for _ in range(3))
    early[steps[1] - 9 : steps[1]] = 2
    twice[steps[1] :] = 3
    few[steps[2] :] = 2
    for passed, message in ((early, "waypoint 2"), (twice, "one by one"), (few, "away")):
        fault = check_evidence(*claim[:2], replace(trace, passed=passed), *claim[3:])
        assert message in fault


@pytest.mark.parametrize("other", [turned, mirrored, shifted, scaled])
def test_corresponding_worlds_have_corresponding_waypoints(other):
    world = hall(*THERE)
    there = other(world)
    scale = 2 if other is scaled else 1
    lengths = [certified(one).certificate.length for one in (world, there)]
    assert lengths[1] == pytest.approx(scale * lengths[0], rel=1e-9)
    assert len(there.robots[0].waypoints) == 3


def test_a_cause_is_about_the_goal_that_was_never_reached():
    world = hall(*THERE)
    episode, _ = recorded(world)
    assert episode.goals_reached == 1
    assert towards_its_goal(world, episode).target.x == THERE[1].x
    assert "never reaches waypoint 2 of 3" in describe_period(world, episode)


def test_a_campaign_chooses_as_many_waypoints_as_asked_for():
    world = with_robot(hall(), {WAYPOINTS: "2"})
    assert len(world.robots[0].waypoints) == 2
    assert with_robot(world, {WAYPOINTS: "2"}) == world
    assert certified(world) is not None


def test_what_is_fixed_is_the_largest_number_of_waypoints():
    fixed = Constraint.of({WAYPOINTS: ["2"]})
    for count in range(4):
        assert fixed.allows(Case(hall(*THERE[:count]), SCENARIO)) == (count <= 2)


def test_native_search_leaves_waypoints_to_others():
    from fuzz.layouts.variation import Variation

    config = CampaignConfig(SCENARIO, 1, vary=(Variation(WAYPOINTS, ("2",)),))
    assert not fits_native(config)
