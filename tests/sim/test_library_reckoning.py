"""Controllers that estimate where they are, or where the target is."""

import math

import numpy as np
import pytest

from sim import simulate
from sim.controllers import CONTROLLERS
from sim.controllers.library.reckoning import signal_three_layer_robot
from sim.scenario import Scenario
from sim.scenario.unused import unused_options
from tests.helpers.raising import raises
from worldgen import InvalidParameter, Pose, Target, World
from worldgen.families import cave, rooms, trap

WORLDS = [trap(3, size=24), rooms(101), cave(101)]


@pytest.mark.parametrize(
    "name", ["odometry-bug", "signal-mapper", "signal-three-layer", "signal-bug", "subsumption"]
)
def test_it_arrives_where_its_senses_are_right(name):
    for world in WORLDS:
        assert simulate(world, name).verdict == "reached"


def test_what_it_reads_is_what_it_is_for():
    senses = {name: set(CONTROLLERS.get(name).senses) for name in CONTROLLERS.names()}
    assert not {"x", "y", "heading"} & senses["odometry-bug"]
    assert not {"x", "y"} & senses["signal-mapper"]
    for name in ("signal-three-layer", "signal-bug", "subsumption"):
        assert not {"target_heading", "target_distance"} & senses[name]
        assert {"signal", "signal_heading"} <= senses[name]


@pytest.mark.parametrize(
    "text",
    [
        "odometry-bug+odometry_noise=0.1",
        "signal-mapper+sensor_noise=0.1+odometry_noise=0.1",
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
