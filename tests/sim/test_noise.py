"""Noise in a sense that a controller does not read changes neither a run nor its proof."""

import pytest

from sim import simulate
from sim.controllers import CONTROLLERS
from sim.controllers.noise import is_noisy
from sim.scenario import Scenario
from sim.scenario.unused import random_run, unused_options
from worldgen.families import trap

WORLD = trap(3, size=24)


@pytest.mark.parametrize(
    "text",
    [
        "q-learning+odometry_noise=0.3",
        "q-learning+sensor_noise=0.3",
        "wall-left+odometry_noise=0.3+sensor_noise=0.3",
        "turn-right+beams=8+beam_noise=0.5+beam_dropout=0.5",
    ],
)
def test_noise_that_a_controller_never_reads_costs_it_no_proof(text):
    scenario = Scenario.parse(text)
    plain = simulate(WORLD, scenario.controller, steps=4000)
    noisy = simulate(WORLD, scenario.controller, scenario.options(WORLD, 4000))
    assert plain.verdict == "loop"
    assert (noisy.verdict, noisy.trace_digest) == (plain.verdict, plain.trace_digest)
    assert not random_run(scenario)


@pytest.mark.parametrize(
    "text", ["turn-right+sensor_noise=0.1", "q-learning+beam_noise=0.1", "wall-left+slip=0.1"]
)
def test_noise_that_a_controller_reads_or_that_moves_it_makes_its_run_random(text):
    scenario = Scenario.parse(text)
    assert is_noisy(CONTROLLERS.get(scenario.controller), scenario.run)
    assert simulate(WORLD, scenario.controller, scenario.options(WORLD, 2000)).verdict != "loop"


def test_a_class_that_declares_no_senses_may_read_the_odometry(tmp_path):
    (tmp_path / "mine.py").write_text(
        "class Robot:\n    def reset(self):\n        return ()\n\n"
        "    def act(self, observation, memory):\n        return (0.0, 0.0), memory\n"
    )
    scenario = Scenario.parse(f"{tmp_path}/mine.py:Robot+odometry_noise=0.1")
    assert is_noisy(CONTROLLERS.get(scenario.controller), scenario.run)


def test_how_far_the_signal_sensor_sees_means_nothing_to_one_that_reads_its_strength_alone(
    tmp_path,
):
    (tmp_path / "mine.py").write_text(
        "class Robot:\n    senses = ('signal',)\n\n    def reset(self):\n        return ()\n\n"
        "    def act(self, observation, memory):\n        return (0.0, 0.0), memory\n"
    )
    (sentence,) = unused_options(Scenario.parse(f"{tmp_path}/mine.py:Robot+sensor_cells=3"))
    assert "does not read signal_heading" in sentence
