"""Tests of the room with one wall: robots that get around it, and robots that bounce off it."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fuzz.cause import Cause, Circumstance
from fuzz.facts.changed_worlds import OtherWorlds
from fuzz.failure import Failure
from fuzz.triage.diagnosis import diagnosis_of
from sim.controllers import CONTROLLERS
from sim.scenario import Scenario
from worldgen.world import Pose, Target, World

SHIPPED = Path(__file__).parents[2] / "corpora/failures"


def room(cell_size: float = 0.2, radius: float = 0.07) -> World:
    """Return a small world, which only gives the size of robot and cells."""
    place = 4.0 * max(cell_size, radius)
    side = int(2.0 * place / cell_size) + 2
    return World(
        np.zeros((side, side), np.bool_),
        Pose(place, place),
        Target(place, place, radius),
        cell_size=cell_size,
        robot_radius=radius,
    )


def gets_around(controller: str, world: World) -> bool:
    scenario = Scenario.parse(controller)
    return OtherWorlds(scenario.controller, scenario.run).gets_around_walls(world)


@pytest.mark.nightly
@pytest.mark.parametrize(("cell_size", "radius"), [(0.2, 0.07), (0.1, 0.2), (0.5, 0.1)])
@pytest.mark.parametrize(
    ("controller", "expected"),
    [
        ("bug1", True),
        ("bug2", True),
        ("wall-left", True),
        ("wall-right", True),
        ("tangent-bug", True),
        # Planners go around walls, too.
        ("mapper", True),
        ("vfh", True),
        ("three-layer", True),
        ("fuzz.faults:bug1_lost_wall_wrong_side", True),
        ("naive", False),
        ("turn-right", False),
        ("turn-random", False),
        ("random-walk", False),
        ("q-learning", False),
        ("potential-field", False),
    ],
)
def test_a_robot_gets_around_a_wall_at_any_size(controller, expected, cell_size, radius):
    assert gets_around(controller, room(cell_size, radius)) is expected


FOLLOWER = """
import math
from sim import Command


class Robot:
    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        if observation.bump:
            return Command(0.0, TURN / observation.time_step), (1.0,)
        # After a touch, it keeps turning back to the wall in small arcs.
        rate = -math.radians(8) / observation.time_step if memory[0] else 0.0
        if not memory[0]:
            rate = (observation.target_heading - observation.heading) / observation.time_step
        return Command(observation.top_speed, rate), memory
"""


def test_an_edited_controller_is_tried_again(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(FOLLOWER.replace("TURN", "math.radians(25)"))
    name = f"{file}:Robot"
    assert gets_around(name, room())
    file.write_text(FOLLOWER.replace("TURN", "math.pi"))
    os.utime(file, ns=(1, 1))
    CONTROLLERS.forget(str(file))
    assert not gets_around(name, room())


def test_neither_the_budget_nor_the_seed_of_a_run_changes_the_answer():
    scenario = Scenario.parse("bug2")
    short = replace(scenario.run, steps=1, seed=7)
    assert OtherWorlds("bug2", short).gets_around_walls(room())


def test_a_controller_that_crashes_there_does_not_get_around():
    assert not gets_around("fuzz.faults:vfh_beam_beyond_the_last", room())


@pytest.mark.parametrize(
    ("controller", "follows"),
    [("mapper-small", True), ("tangent-bug", True), ("q-learning", False), ("turn-right", False)],
)
def test_only_a_robot_that_gets_around_walls_leaves_one_too_early(controller, follows):
    failures = map(Failure.read, sorted((SHIPPED / controller).rglob("*.grid")))
    found = [diagnosis_of(failure) for failure in failures if failure.verdict == "loop"]
    at_walls = [one for one in found if one.cause == Cause.RETURNS_TO_A_WALL]
    circumstance = None if follows else Circumstance.FOLLOWS_NO_WALL
    assert at_walls and {one.circumstance for one in at_walls} == {circumstance}
