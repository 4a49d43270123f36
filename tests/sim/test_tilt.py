"""The sense of a tilted floor, in all kinds of controllers, and a mapper that drives against it."""

import json
import math

import numpy as np
import pytest

from sim import simulate
from sim.controllers import Command, CompiledController
from sim.controllers.base import Commands, Observation
from sim.controllers.programs.process import observation_line
from sim.kernels import layout
from tests.helpers.fleets import Ahead, fleet_world, hall
from worldgen import generate
from worldgen.world import Pose, Robot, Target, World

OPEN = World(np.zeros((30, 30), bool), Pose(0.5, 1.5, 0.0), Target(2.7, 1.5, 0.02))
# Each lattice unit a step is 0.1 m / 1024 / 15 ms.
UNIT = 0.1 / 1024 / 0.015
TILTED = {"drift": 0.3, "drift_heading": 1.2}


def against(speed, heading, tilt, tilt_heading):
    """Return speed and heading that a robot must command to move as wanted in spite of a drift."""
    x = speed * math.cos(heading) - tilt * math.cos(tilt_heading)
    y = speed * math.sin(heading) - tilt * math.sin(tilt_heading)
    return math.hypot(x, y), math.atan2(y, x)


class Climber:
    """Drives straight at its target on any floor."""

    senses = ("heading", "target_heading", "time_step", "tilt", "tilt_heading")

    def reset(self):
        return ()

    def act(self, observation, memory):
        speed, aim = against(
            0.5, observation.target_heading, observation.tilt, observation.tilt_heading
        )
        turn = math.remainder(aim - observation.heading, math.tau)
        return Command(speed, turn / observation.time_step), memory


class Climbers:
    """The same for many robots."""

    senses = Climber.senses

    def reset(self):
        return ()

    def act_many(self, observations, memories):
        x = 0.5 * np.cos(observations.target_heading)
        y = 0.5 * np.sin(observations.target_heading)
        x = x - observations.tilt * np.cos(observations.tilt_heading)
        y = y - observations.tilt * np.sin(observations.tilt_heading)
        turn = np.arctan2(y, x) - observations.heading
        turn = np.remainder(turn + math.pi, math.tau) - math.pi
        return Commands(np.hypot(x, y), turn / observations.time_step), memories


def sidestep(episode):
    """Return how far the robot strayed from the straight line to its target, m."""
    return float(np.abs(episode.trace.y[2:] - 1.5).max())


def test_the_tilt_is_the_drift_in_whole_lattice_units():
    seen = []

    class Watcher(Climber):
        def act(self, observation, memory):
            seen.append((observation.tilt, observation.tilt_heading))
            return Command(), memory

    simulate(OPEN, Watcher(), steps=3, **TILTED)
    tilt, heading = seen[-1]
    assert set(seen) == {(tilt, heading)}
    assert tilt == pytest.approx(0.3, abs=UNIT) and heading == pytest.approx(1.2, abs=0.03)
    seen.clear()
    simulate(OPEN, Watcher(), steps=3)
    assert set(seen) == {(0.0, 0.0)}


@pytest.mark.parametrize("made", [Climber, Climbers], ids=["class", "vector"])
def test_who_senses_the_tilt_drives_straight_across_it(made):
    tilted = simulate(OPEN, made(), record=True, steps=600, **TILTED)
    assert tilted.verdict == "reached" and sidestep(tilted) < 0.01
    ignorant = simulate(OPEN, "naive", record=True, steps=600, **TILTED)
    assert sidestep(ignorant) > 0.1


def test_a_function_of_flat_arrays_finds_it_before_the_goal_s_heading():
    numba = pytest.importorskip("numba")
    inner = numba.njit(against)

    @numba.njit
    def act(observation, memory, command):
        speed, aim = inner(0.5, observation[7], observation[-3], observation[-2])
        turn = (aim - observation[4] + math.pi) % math.tau - math.pi
        command[0] = speed
        command[1] = turn / observation[10]

    assert (layout.OBS_TARGET_HEADING, layout.OBS_HEADING, layout.OBS_TIME_STEP) == (7, 4, 10)
    climber = CompiledController("climber", act, (), senses=Climber.senses)
    episode = simulate(OPEN, climber, record=True, steps=600, **TILTED)
    assert episode.verdict == "reached" and sidestep(episode) < 0.01


def test_a_program_is_told_of_a_tilt_and_not_of_a_level_floor():
    plain = Observation(False, *([0.0] * 16), ())
    assert "tilt" not in json.loads(observation_line(plain))
    tilted = json.loads(observation_line(plain._replace(tilt=0.3, tilt_heading=1.2)))
    assert (tilted["tilt"], tilted["tilt_heading"]) == (0.3, 1.2)


@pytest.mark.parametrize("made", [Climber, Climbers], ids=["class", "vector"])
def test_robots_of_a_fleet_sense_it_too(made):
    world = fleet_world(
        hall(),
        Robot(Pose(0.5, 0.5, 0.0), Target(3.5, 0.5, 0.03)),
        Robot(Pose(0.5, 1.5, 0.0), Target(3.5, 1.5, 0.03)),
    )
    episode = simulate(world, made(), steps=600, record=True, drift=0.2, drift_heading=1.2)
    assert episode.verdict == "reached"
    for robot, y in zip(episode.robots, (0.5, 1.5), strict=True):
        assert np.abs(robot.trace.y[2:] - y).max() < 0.01
    assert simulate(world, Ahead(), steps=60, drift=0.2, drift_heading=1.2).robots


def test_a_mapper_that_senses_the_tilt_arrives_where_the_mapper_is_carried_off():
    worlds = [generate(family, seed, size=20) for family in ("trap", "rooms") for seed in range(4)]
    mapper, tilt_mapper = (
        [simulate(world, name, steps=20_000, **TILTED).verdict for world in worlds]
        for name in ("mapper", "tilt-mapper")
    )
    assert mapper.count("reached") == 0
    assert tilt_mapper.count("reached") == len(worlds)


def test_on_a_level_floor_it_is_the_mapper():
    world = generate("trap", 3, size=20)
    runs = [simulate(world, name) for name in ("mapper", "tilt-mapper")]
    assert runs[0].steps == runs[1].steps
