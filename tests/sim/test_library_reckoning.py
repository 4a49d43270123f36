"""Controllers that estimate where they are, or where the target is."""

import math

import numpy as np
import pytest

from sim import simulate
from sim.controllers import CONTROLLERS
from sim.controllers.library.mapper import mapping
from sim.controllers.library.reckoning import AT, scan_mapper_robot, signal_three_layer_robot
from sim.scenario import Scenario
from sim.scenario.unused import unused_options
from tests.helpers.raising import raises
from worldgen import InvalidParameter, Pose, Target, World
from worldgen.families import cave, forest, rooms, trap

WORLDS = [trap(3, size=24), rooms(101), cave(101)]


@pytest.mark.parametrize(
    "name",
    [
        "odometry-bug",
        "scan-mapper",
        "signal-mapper",
        "signal-three-layer",
        "signal-bug",
        "subsumption",
    ],
)
def test_it_arrives_where_its_senses_are_right(name):
    for world in WORLDS:
        assert simulate(world, name).verdict == "reached"


def test_what_it_reads_is_what_it_is_for():
    senses = {name: set(CONTROLLERS.get(name).senses) for name in CONTROLLERS.names()}
    assert not {"x", "y", "heading"} & senses["odometry-bug"]
    assert not {"x", "y"} & senses["signal-mapper"]
    assert not {"x", "y", "heading", "signal"} & senses["scan-mapper"]
    for name in ("signal-three-layer", "signal-bug", "subsumption"):
        assert not {"target_heading", "target_distance"} & senses[name]
        assert {"signal", "signal_heading"} <= senses[name]


@pytest.mark.parametrize(
    "text",
    [
        "odometry-bug+odometry_noise=0.1",
        "signal-mapper+sensor_noise=0.1+odometry_noise=0.1",
        "scan-mapper+beam_noise=0.01+odometry_noise=0.1",
        "signal-three-layer+signal=blocked+sensor_field=2",
        "signal-bug+sensor_noise=0.1",
    ],
)
def test_the_options_that_make_it_hard_have_an_effect(text):
    scenario = Scenario.parse(text)
    assert unused_options(scenario) == []
    world = trap(3, size=24)
    with_it = simulate(world, scenario.controller, scenario.options(world, 300))
    without = simulate(world, scenario.controller, steps=300)
    assert with_it.trace_digest != without.trace_digest


def test_a_bug_by_dead_reckoning_ends_where_it_takes_the_target_to_be():
    world = World(np.zeros((30, 30), bool), Pose(0.3, 0.3, 0.0), Target(2.7, 2.7, 0.05))
    scenario = Scenario.parse("odometry-bug+odometry_noise=0.9")
    episode = simulate(world, "odometry-bug", scenario.options(world, 2000), record=True)
    assert episode.verdict == "stalled"
    shown = CONTROLLERS.get("odometry-bug").memory_map(episode.trace.memory(episode.steps))
    estimated = shown.places["target, estimated"]
    assert estimated == pytest.approx((2.7, 2.7), abs=1e-3)
    assert math.dist(shown.places["itself, estimated"], estimated) < 0.05
    assert math.dist((episode.trace.x[-1], episode.trace.y[-1]), estimated) > 0.05


def test_two_distances_and_the_signal_s_direction_give_the_target_s_place():
    world = World(np.zeros((30, 30), bool), Pose(0.3, 0.4, 0.0), Target(2.3, 1.7, 0.05))
    controller = CONTROLLERS.get("signal-three-layer")
    episode = simulate(world, controller, record=True)
    assert episode.verdict == "reached"
    shown = controller.memory_map(episode.trace.memory(episode.steps))
    assert shown.places["target, estimated"] == pytest.approx((2.3, 1.7), abs=0.02)


def test_a_signal_that_halves_at_another_length_needs_a_controller_that_knows_it():
    with raises(InvalidParameter, "not-positive"):
        signal_three_layer_robot(0.0)
    assert signal_three_layer_robot(0.2, "mine").name == "mine"


MANY = [make(seed) for make in (trap, rooms, cave, forest) for seed in range(100, 103)]


def farthest_estimate(world, name, noise):
    """Return how a run ends, and by how much the robot's estimate of its place is ever wrong, m."""
    episode = simulate(world, name, steps=8000, odometry_noise=noise, record=True)
    trace = episode.trace
    wrong = [
        math.dist(trace.memory(step)[[AT.x, AT.x + 1]], (trace.x[step], trace.y[step]))
        for step in range(1, episode.steps, 7)
    ]
    return episode.verdict, max(wrong)


def test_a_map_of_scans_keeps_the_place_that_the_wheels_lose():
    by_wheels = [farthest_estimate(world, "odometry-bug", 0.2) for world in MANY]
    by_scans = [farthest_estimate(world, "scan-mapper", 0.2) for world in MANY]
    assert sum(verdict == "reached" for verdict, _ in by_wheels) <= 5
    assert np.median([wrong for _, wrong in by_wheels]) > 1.0
    assert all(verdict == "reached" for verdict, _ in by_scans)
    assert max(wrong for _, wrong in by_scans) < 0.1
    assert np.median([wrong for _, wrong in by_scans]) < 0.02


def test_it_is_the_scans_that_keep_the_place():
    found = [
        simulate(world, "scan-mapper", steps=1500, odometry_noise=0.2, **blind).verdict
        for blind in ({}, {"beam_range": 0.01})
        for world in MANY[:6]
    ]
    assert found[:6] == ["reached"] * 6
    assert found[6:].count("reached") <= 1


def walled_off(side):
    """Return a square room with a box in its middle, which the target is in."""
    walls = np.zeros((side, side), bool)
    near, far = side // 2 - 2, side // 2 + 2
    walls[near : far + 1, (near, far)] = walls[(near, far), near : far + 1] = True
    middle = (side // 2 + 0.5) * 0.1
    return World(walls, Pose(0.25, 0.25, 0.4), Target(middle, middle, 0.05))


def test_without_noise_its_map_is_of_the_walls():
    controller = CONTROLLERS.get("scan-mapper")
    episode = simulate(walled_off(20), controller, steps=700, record=True)
    points = controller.memory_map(episode.trace.memory(700)).nodes

    # All of them are on a face of the room around it, or of the box seen from outside.
    faces = [abs(points[:, axis] - at) for axis in (0, 1) for at in (0.0, 2.0, 0.8, 1.3)]
    assert len(points) > 60 and np.min(faces, axis=0).max() < 0.002


def test_its_loops_are_proved():
    small = scan_mapper_robot(mapping("driven", 24), "small")
    assert simulate(walled_off(14), small, steps=8000).verdict == "loop"


def test_its_window_follows_it_through_a_world_that_is_larger():
    walls = np.zeros((12, 120), bool)
    walls[:, (20, 45, 70, 95)] = walls[3, ::7] = True
    walls[7:9, (20, 45, 70, 95)] = False
    world = World(walls, Pose(0.5, 0.8, 0.0), Target(11.5, 0.8, 0.05))
    episode = simulate(world, "scan-mapper", odometry_noise=0.1, steps=8000, record=True)
    assert episode.verdict == "reached"
    points = CONTROLLERS.get("scan-mapper").memory_map(episode.trace.memory(episode.steps)).nodes
    assert points[:, 0].min() > 11.5 - 6.4
    assert len(CONTROLLERS.get("scan-mapper").memory) == 2835
