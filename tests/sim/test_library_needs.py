"""Controllers that declare which robot they need."""

import numpy as np

from sim import CompiledController, simulate
from sim.controllers.base import robot_for
from sim.options.robot import RobotOptions
from tests.reference.sim import layout
from worldgen import Pose, Target, World


def count_beams(observation, memory, command):
    memory[0] = observation.size - layout.OBS_SIZE


EYES = CompiledController(
    "eyes", count_beams, (0.0,), senses=("beams",), needs=RobotOptions(beams=36)
)


def beams_seen(**options):
    world = World(np.zeros((9, 9), bool), Pose(0.45, 0.45, 0.0), Target(0.75, 0.75, 0.05))
    return (
        simulate(world, EYES, steps=1, record=True, **options)
        .trace.states[1, layout.STATE_MEMORY :]
        .view(float)[0]
    )


def test_a_controller_gets_the_beams_that_it_needs():
    assert beams_seen() == 36


def test_a_run_that_says_how_many_beams_has_its_way():
    assert beams_seen(beams=8) == 8


def test_a_controller_without_needs_gets_the_run_s_robot():
    assert robot_for(
        CompiledController("plain", count_beams), RobotOptions(slip=0.1)
    ) == RobotOptions(slip=0.1)
