"""The PettingZoo environment passes its own test, and moves like the simulator."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("pettingzoo")

from pettingzoo.test import parallel_api_test, parallel_seed_test

from sim import simulate
from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter
from worldgen.world import Pose, Robot, Target, World
from worldgen_plugins.for_pettingzoo import FleetEnv

# PettingZoo's own tests call reset() without a seed.
pytestmark = pytest.mark.usefixtures("same_system_seed")


def hall(*, robots: int = 2) -> World:
    """A hall in which robots start in a column and have their targets straight ahead."""
    placed = [
        Robot(Pose(0.25, 0.25 + 0.3 * k), Target(1.75, 0.25 + 0.3 * k, 0.1)) for k in range(robots)
    ]
    return World(np.zeros((4 + 3 * robots, 20), bool), robots=placed)


def straight(env: FleetEnv) -> dict[str, np.ndarray]:
    """Actions that drive all agents ahead at top speed."""
    return {agent: np.array([0.0, 1.0], np.float32) for agent in env.agents}


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("robot", [{}, {"neighbour_range": 2.0}], ids=["plain", "neighbours"])
def test_pettingzoos_own_test_passes(robot: dict[str, float]) -> None:
    env = FleetEnv(world=hall(), robot=robot)
    parallel_api_test(env, num_cycles=200)


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_a_seed_decides_an_episode() -> None:
    parallel_seed_test(lambda: FleetEnv(world=hall()), num_cycles=50)


def test_agents_that_arrive_are_masked_and_the_others_go_on() -> None:
    world = hall()
    near = replace(world, robots=(world.robots[0], Robot(Pose(1.5, 0.55), world.robots[1].target)))
    env = FleetEnv(world=near)
    env.reset(seed=1)
    for _ in range(15):
        *_, information = env.step(straight(env))
        if "robot_2" not in env.agents:
            break
    assert env.agents == ["robot_1"]
    assert env.arrived.tolist() == [False, True]
    assert information["robot_1"]["arrived"].tolist() == [False, True]


def test_the_robots_move_as_in_the_simulator() -> None:
    world = hall()
    env = FleetEnv(world=world)
    env.reset(seed=1)
    steps = 1
    while env.agents:
        env.step(straight(env))
        steps += 1
    assert env.arrived.all()
    assert simulate(world, "tests.helpers.straight:Straight").steps == steps


def test_robots_that_meet_are_in_contact_and_pay_for_it() -> None:
    first = Robot(Pose(0.25, 0.25), Target(1.75, 0.25, 0.1))
    second = Robot(Pose(0.75, 0.25, math.pi), Target(0.05, 0.25, 0.1))
    env = FleetEnv(world=replace(hall(), robots=(first, second)), reward={"contact": -100.0})
    env.reset(seed=1)
    least = 0.0
    for _ in range(20):
        rewards = env.step(straight(env))[1]
        least = min(least, *rewards.values())
    assert least < -50.0


def test_worlds_with_another_number_of_robots_are_refused() -> None:
    env = FleetEnv(world=hall())
    with raises(InvalidParameter, "wrong-number-of-robots"):
        env.reset(options={"world": hall(robots=3)})
    env.reset()  # as before
    assert len(env.agents) == 2
