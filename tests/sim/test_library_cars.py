"""The library's cars: hybrid A* arrives without touching a wall, and pure pursuit does not always."""

import math
from dataclasses import replace

import numpy as np
import pytest

from sim import simulate
from sim.controllers.library.hybrid_car import HybridCar
from sim.verdict import Verdict
from worldgen import Drive, Pose, Robot, Target, World, generate


def with_car(world, turning_radius, *, footprint=(), **drive):
    car = Drive(turning_radius, **drive)
    robot = replace(world.robots[0], drive=car, footprint=footprint)
    return replace(world, robots=[robot], certificate=None, provenance=None)


def dead_end(**drive):
    """An alley that is closed in front of the robot, and wide enough for three points."""
    free = np.zeros((30, 40), np.bool_)
    free[12:18, 5:38] = True
    start, target = Pose(3.5, 1.5, 0.0), Target(0.8, 1.5, 0.1)
    return World(~free, robots=[Robot(start, target, 0.07, 1.0, drive=Drive(0.3, **drive))])


@pytest.mark.parametrize("family", ["cave", "corridor", "maze", "trap"])
def test_hybrid_a_star_arrives_without_touching_a_wall(family):
    for seed in range(2):
        world = with_car(generate(family, seed=seed), 0.15, reverse=True)
        episode = simulate(world, "hybrid-car")
        assert episode.verdict == Verdict.REACHED
        assert episode.collisions == 0


def test_hybrid_a_star_drives_a_footprint():
    rectangle = [(0.1, 0.05), (-0.1, 0.05), (-0.1, -0.05), (0.1, -0.05)]
    world = with_car(generate("trap", seed=2), 0.2, footprint=rectangle, reverse=True)
    assert simulate(world, "hybrid-car").verdict == Verdict.REACHED


@pytest.mark.parametrize("arrival", ["touch", "step", "stop"])
def test_hybrid_a_star_arrives_as_the_goal_asks(arrival):
    world = dead_end(reverse=True)
    target = replace(world.target, arrival=arrival, heading=math.pi, heading_tolerance=0.2)
    robot = replace(world.robots[0], target=target)
    assert simulate(replace(world, robots=[robot]), "hybrid-car").verdict == Verdict.REACHED


def test_a_slow_steering_car_stands_while_its_wheels_turn():
    quick, slow = (dead_end(reverse=True, steering_rate=rate) for rate in (0.0, 1.0))
    runs = [simulate(world, "hybrid-car") for world in (quick, slow)]
    assert [run.verdict for run in runs] == [Verdict.REACHED] * 2
    assert runs[1].steps > runs[0].steps


@pytest.mark.parametrize("controller", ["hybrid-car", "pure-pursuit-car"])
def test_a_car_that_cannot_leave_a_dead_end_is_proved_to_loop(controller):
    assert simulate(dead_end(), controller).verdict == Verdict.LOOP
    assert simulate(dead_end(reverse=True), controller).verdict == Verdict.REACHED


@pytest.mark.parametrize("controller", ["hybrid-car", "pure-pursuit-car"])
def test_a_robot_that_turns_on_the_spot_can_run_it_too(controller):
    assert simulate(generate("forest", seed=1), controller).verdict == Verdict.REACHED


def test_equal_runs_have_equal_traces():
    world = with_car(generate("cave", seed=3), 0.2, reverse=True)
    digests = {simulate(world, HybridCar()).trace_digest for _ in range(2)}
    assert len(digests) == 1
