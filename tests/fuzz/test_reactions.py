"""What a robot does by what is around it."""

import math

import numpy as np
import pytest

from fuzz.facts.contacts import nearest_walls
from fuzz.triage.reactions import Reactions
from sim import Command, RobotOptions, simulate
from tests.helpers.halls import hall
from worldgen import generate

HERE = "tests.fuzz.test_reactions"


class Avoids:
    """Turns by 7 degrees away from walls that are near, and else towards the target."""

    sign = 1.0
    needs = RobotOptions(beams=24)

    def reset(self):
        return ()

    def act(self, observation, memory):
        nearest = min(observation.beams)
        aim = math.remainder(observation.target_heading - observation.heading, math.tau)
        turn = math.copysign(math.radians(3), aim)
        if nearest < 2 * observation.radius:
            side = math.tau * observation.beams.index(nearest) / len(observation.beams)
            turn = -self.sign * math.copysign(math.radians(7), math.remainder(side, math.tau))
        return Command(observation.top_speed / 2, turn / observation.time_step), ()


class WrongSign(Avoids):
    """Turns towards walls."""

    sign = -1.0


class AtOnce:
    """Turns left by a right angle in the step in which it touches a wall."""

    def reset(self):
        return ()

    def act(self, observation, memory):
        turn = math.pi / 2 if observation.bump else 0.0
        return Command(observation.top_speed, turn / observation.time_step), ()


class InTheNextStep(AtOnce):
    """Turns one step after it has touched a wall."""

    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        turn = math.pi / 2 if memory[0] else 0.0
        return Command(observation.top_speed, turn / observation.time_step), (
            float(observation.bump),
        )


def rows(name, seeds=4):
    found = Reactions()
    for seed in range(seeds):
        world = generate("rubble", seed)
        found.add(world, simulate(world, f"{HERE}:{name}", record=True, steps=3000).trace)
    return {row.situation: row for row in found.rows()}


@pytest.mark.parametrize(("name", "way"), [("Avoids", "away from it"), ("WrongSign", "towards it")])
def test_the_sign_of_a_reaction_to_walls_shows(name, way):
    found = rows(name)
    for situation in ("touching a wall on its left", "near a wall on its left"):
        assert found[situation].turns.startswith(f"{way} by 7 degrees")


@pytest.mark.parametrize("name", ["AtOnce", "InTheNextStep"])
def test_a_turn_belongs_to_the_touch_before_it(name):
    touched = rows(name)["touching a wall ahead"]
    assert touched.turns.startswith("left by 90 degrees")


def test_speed_is_a_share_of_the_top_speed():
    open_floor = rows("Avoids")["no wall near, target ahead"]
    assert open_floor.moves == "drives at 50 % of its top speed"


def test_top_speed_is_a_hundred_percent_although_poses_are_rounded():
    open_floor = rows("AtOnce")["near a wall behind"]
    assert open_floor.moves == "drives at 100 % of its top speed"


def test_nearest_walls_are_where_a_search_cell_by_cell_finds_them():
    world = generate("cave", 3)
    trace = simulate(world, "wall-left", record=True).trace
    steps = np.arange(0, trace.steps, 7)
    within = 3.0 * world.robot_radius
    far, direction = nearest_walls(world, trace, steps, within)
    solid = np.argwhere(np.pad(world.walls, 4, constant_values=True)) - 4
    for step, gap, way in zip(steps, far, direction, strict=True):
        x = trace.x[step] / world.cell_size
        y = trace.y[step] / world.cell_size
        dx = np.clip(x, solid[:, 1], solid[:, 1] + 1) - x
        dy = np.clip(y, solid[:, 0], solid[:, 0] + 1) - y
        least = np.hypot(dx, dy).min() * world.cell_size
        if least > within:
            assert math.isinf(gap)
        else:
            assert gap == pytest.approx(least)
            at_x = x + math.cos(way) * gap / world.cell_size
            at_y = y + math.sin(way) * gap / world.cell_size
            assert np.hypot(at_x - x - dx, at_y - y - dy).min() < 1e-9


def test_a_run_of_no_steps_adds_nothing():
    world = hall()
    found = Reactions()
    found.add(world, simulate(world, "turn-right", record=True, steps=1).trace)
    assert found.rows() == []
