"""A controller's memory, and the walls that a robot enters, as sent to the player."""

import base64
from dataclasses import dataclass

import numpy as np
import pytest

from fuzz.player import drawn_run
from fuzz.player.memory import BLOCKED, CELL, PLACE, PLAN
from sim import Command, MemoryField, MemoryMap, simulate
from sim.controllers import CONTROLLERS, CompiledController
from sim.motion import MOTIONS
from tests.fuzz.test_report import decoded
from tests.helpers.raising import raises
from worldgen import generate
from worldgen.errors import InvalidParameter
from worldgen.lattice import UNIT
from worldgen.world import Pose, Target, World


def room(*, speed=2.0):
    walls = np.zeros((10, 14), np.bool_)
    walls[2:8, 7] = True
    return World(walls, Pose(0.25, 0.45, 0.0), Target(1.25, 0.45, 0.1), robot_speed=speed)


def seen(world, controller, **settings):
    episode = simulate(world, controller, record=True, steps=3000, **settings)
    found = CONTROLLERS.get(controller) if isinstance(controller, str) else controller
    motion = MOTIONS.get(settings.get("motion", "swept"))
    run = drawn_run(episode, world.cell_size, motion=motion, most=30_000, controller=found)
    return run, episode


def shapes(run, kind, step=None):
    columns = {
        name: decoded(text) for name, text in run["memory"]["map"].items() if isinstance(text, str)
    }
    rows = zip(*columns.values(), strict=True)
    table = [dict(zip(columns, row, strict=True)) for row in rows]
    return [
        row
        for row in table
        if row["kind"] == kind and (step is None or row["since"] <= step < row["until"])
    ]


@pytest.mark.gate
@pytest.mark.parametrize("name", ["mapper", "mapper-small", "three-layer"])
def test_a_map_holds_walls_where_there_are_some_and_nothing_at_the_start(name):
    world = room()
    run, _ = seen(world, name)
    assert shapes(run, BLOCKED, 0) == []
    ends = [(row["x0"] + row["x1"], row["y0"] + row["y1"]) for row in shapes(run, BLOCKED)]
    assert ends
    reach = 4.5  # greatest distance, cells, of a blocked edge from a wall or the border, for a robot of this width
    for x, y in np.array(ends) / (2 * UNIT):
        assert min(abs(x - 7.5), x, 14 - x, y, 10 - y) < reach


def test_the_mapper_s_plan_begins_where_it_was_made_and_ends_at_the_target():
    run, _ = seen(room(), "mapper")
    plan = shapes(run, PLAN, 0) or shapes(run, PLAN, 1)
    ends = {(row["x0"], row["y0"]) for row in plan} ^ {(row["x1"], row["y1"]) for row in plan}
    gaps = [np.hypot(x / UNIT - 2.5, y / UNIT - 4.5) for x, y in ends]
    assert min(gaps) < 0.1 and max(gaps) > 8


def test_bug1_s_hit_point_is_where_it_met_the_wall():
    run, episode = seen(room(), "bug1")
    names = run["memory"]["map"]["names"]
    (hit,) = [row for row in shapes(run, PLACE, episode.steps) if names[row["x1"]] == "hit"]
    assert hit["x0"] / UNIT == pytest.approx(7 - 0.7, abs=0.1)


def test_named_numbers_stand_in_every_row():
    run, _ = seen(room(), "turn-left")
    (ticks,) = run["memory"]["fields"]
    assert ticks["name"] == "ticks left"
    assert len(decoded(ticks["values"])) == len(decoded(run["at"]))
    assert max(decoded(ticks["values"])) == 5000


@dataclass(frozen=True)
class Counting:
    memory_fields = (MemoryField("steps", 0),)

    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        return Command(observation.top_speed, 0.3 / observation.time_step), (memory[0] + 1.0,)

    def memory_map(self, memory):
        return MemoryMap(
            cells=np.array([[0.1, 0.2, 0.2, 0.3]]) if memory[0] > 3 else np.zeros((0, 4))
        )


def test_a_class_s_memory_is_shown_by_its_own_words():
    run, _ = seen(room(), Counting())
    assert shapes(run, CELL, 3) == []
    (held,) = shapes(run, CELL, 9)
    assert (held["x0"], held["y0"], held["x1"], held["y1"]) == (UNIT, 2 * UNIT, 2 * UNIT, 3 * UNIT)
    assert decoded(run["memory"]["fields"][0]["values"])[:3] == [0, 1000, 2000]


def test_a_memory_that_cannot_be_read_is_told_and_the_run_is_there():
    class Faulty(Counting):
        def memory_map(self, memory):
            raise ValueError("no map")

    run, episode = seen(room(), Faulty())
    assert run["memory"]["fault"] == "its memory cannot be shown: ValueError: no map"
    assert run["steps"] == episode.steps


def test_a_map_with_more_shapes_than_fit_is_held_at_fewer_steps():
    world = generate("maze", 3, size=12)
    episode = simulate(world, "mapper", record=True)
    few = drawn_run(episode, world.cell_size, most=300, controller=CONTROLLERS.get("mapper"))
    many = drawn_run(episode, world.cell_size, most=30_000, controller=CONTROLLERS.get("mapper"))
    counts = [len(decoded(run["memory"]["map"]["kind"])) for run in (few, many)]
    assert 0 < counts[0] <= 300 < counts[1]
    assert len(shapes(few, BLOCKED, episode.steps)) == len(shapes(many, BLOCKED, episode.steps))


def test_memory_fields_that_are_none_are_refused():
    with raises(InvalidParameter, "wrong-declaration", name="odd", fields="mode"):
        CompiledController("odd", lambda *_: None, memory_fields="mode")


def test_a_run_that_goes_into_a_wall_says_so():
    run, episode = seen(room(speed=20.0), "turn-left", motion="endpoint")
    assert episode.verdict in ("tunnel", "overlap") and run["tolerance"] == 0.1
    assert base64.b64decode(run["bump"])
    assert seen(room(), "turn-left")[0]["tolerance"] is None
