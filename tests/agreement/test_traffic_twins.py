"""The core's controllers for several robots give the same runs as plain Python, bit for bit."""

import math

import numpy as np
import pytest

from sim import simulate
from tests.helpers.fleets import crowd, fleet_world, hall
from tests.reference.sim.controllers.traffic import Naive, Orca, RightHand
from worldgen.world import Pose, Robot, Target

TWINS = {"naive": Naive, "right-hand": RightHand, "orca": Orca}


def circle(count, radius=1.5):
    """Return robots on a circle in a hall, each with its target on the opposite side."""
    robots = []
    for number in range(count):
        angle = 2.0 * math.pi * number / count + 0.01 * number * number
        x = radius * math.cos(angle)
        y = radius * math.sin(angle)
        start = Pose(round(2.2 + x, 4), round(2.2 + y, 4), angle + math.pi)
        target = Target(round(2.2 - x, 4), round(2.2 - y, 4), 0.05)
        robots.append(Robot(start, target, 0.07, 1.0))
    return fleet_world(hall(44, 44), *robots)


@pytest.mark.gate
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", TWINS)
def test_a_controller_drives_as_its_plain_python_does(name, seed):
    world = crowd(np.random.default_rng(seed)) if seed else circle(7)
    one = simulate(world, name, steps=250)
    two = simulate(world, TWINS[name], steps=250)
    assert one.steps > 20
    assert [robot.trace_digest for robot in one.robots] == [
        robot.trace_digest for robot in two.robots
    ]


def test_orca_keeps_clear_where_the_naive_robots_block_each_other():
    world = circle(7)
    assert simulate(world, "naive", steps=3_000).verdict == "deadlock"
    avoiding = simulate(world, "orca", steps=3_000)
    assert (avoiding.verdict, avoiding.collisions) == ("reached", 0)


def test_a_robot_that_keeps_right_leaves_oncoming_ones_on_its_left():
    world = circle(2)
    episode = simulate(world, "right-hand", steps=3_000, record=True)
    assert (episode.verdict, episode.collisions) == ("reached", 0)
    for robot, one in zip(world.robots, episode.robots, strict=True):
        # Where it passes the middle, it is to the right of the straight line.
        ahead = np.array([robot.target.x - robot.start.x, robot.target.y - robot.start.y])
        place = np.array([one.trace.x - robot.start.x, one.trace.y - robot.start.y])
        aside = ahead[0] * place[1] - ahead[1] * place[0]
        middle = int(np.argmin(np.abs(ahead @ place - 0.5 * ahead @ ahead)))
        assert aside[middle] < 0.0
