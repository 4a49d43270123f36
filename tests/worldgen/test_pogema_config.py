"""POGEMA's YAML files: configurations and files of named maps, read and written."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.command_line import worldgen
from tests.helpers.raising import raises
from worldgen.errors import FormatError, InvalidWorld
from worldgen.interop import export_world, find_format, import_world, read_map, write_export
from worldgen.world import Pose, Robot, Target, World

CONFIG = """# Two agents change places.
map: |-
  .#...
  .....
  .#..#
agents_xy: [[0, 0], [2, 2]]
targets_xy:
  - [1, 4]
  - [0, 0]
num_agents: 2
seed: 7
obs_radius: 3
"""
MAPS = "puzzle-00: |-\n  .....\n  .#.#.\npuzzle-01: |-\n  #.#\n  ...\n  #.#\n"
ALL = "pogema+agents=all"


@pytest.fixture
def write(tmp_path):
    def write_file(text, name="w.yaml"):
        (tmp_path / name).write_text(text)
        return tmp_path / name

    return write_file


def rows_of(found):
    return ["".join(".#"[int(solid)] for solid in row) for row in found.walls[::-1]]


def places(found):
    """Start and target of each robot, in cells from the top left: row and column."""
    height = found.walls.shape[0]
    robots = [(one.start, one.target) for one in found.robots]
    return [
        [(height - 1 - int(point[1] / 0.1), int(point[0] / 0.1)) for point in robot]
        for robot in robots
    ]


def test_a_configuration_is_recognised_and_read(write):
    path = write(CONFIG)
    assert find_format(path).name == "pogema"
    found = read_map(path, ALL)
    assert rows_of(found) == [".#...", ".....", ".#..#"]
    assert places(found) == [[(0, 0), (1, 4)], [(2, 2), (0, 0)]]


def test_one_agent_of_a_configuration_is_the_robot(write):
    found = read_map(write(CONFIG), "pogema+agent=b")
    assert places(found) == [[(2, 2), (0, 0)]]
    assert "agent b of 2" in found.notes[0]


def test_letters_in_the_map_of_a_configuration_are_agents(write):
    found = read_map(write("map: |\n  a#B\n  ...\n  b.A\nseed: 1\n"), ALL)
    assert places(found) == [[(0, 0), (2, 2)], [(2, 0), (0, 2)]]


def test_a_map_may_be_lists_of_0_and_1(write):
    text = "map: [[0, 1, 0], [0, 0, 0]]\nagents_xy: [[0, 0]]\ntargets_xy: [[0, 2]]\n"
    found = read_map(write(text))
    assert rows_of(found) == [".#.", "..."]
    assert places(found) == [[(0, 0), (0, 2)]]


def test_more_places_than_agents_are_cut_as_pogema_does(write):
    found = read_map(write(CONFIG.replace("num_agents: 2", "num_agents: 1")), ALL)
    assert places(found) == [[(0, 0), (1, 4)]]


def test_an_agent_in_a_wall_frees_its_cell(write):
    found = read_map(write(CONFIG.replace("[2, 2]", "[2, 1]")), ALL)
    assert rows_of(found)[2] == "....#"
    assert "walls in the map: 1;" in found.warnings[0]


@pytest.mark.parametrize("name", ["puzzle-01", ""])
def test_one_of_several_named_maps_is_read_if_it_is_named(write, name):
    path = write(MAPS, "maps.yaml")
    assert find_format(path).name == "pogema"
    if name:
        found = read_map(path, f"pogema+map_name={name}")
        assert rows_of(found) == ["#.#", "...", "#.#"]
        assert found.params["map_name"] == name
    else:
        with raises(FormatError, "unknown-name", count=2, known=["puzzle-00", "puzzle-01"]):
            read_map(path)


def test_the_only_named_map_needs_no_name(write):
    assert rows_of(read_map(write("maze: |\n  ...\n  .#.\n"))) == ["...", ".#."]


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("agents_xy: [[0, 0], [2, 2]]\n", "", "random-places"),
        ("targets_xy:\n  - [1, 4]\n  - [0, 0]\n", "", "random-places"),
        ("seed: 7", "on_target: restart", "random-places"),
        ("map: |-\n  .#...\n  .....\n  .#..#\n", "size: 8\n", "random-map"),
        ("  .....\n", "  ....\n", "ragged-rows"),
        ("  .....\n", "  ..0..\n", "unknown-sign"),
        ("  .....\n", "  a..A.\n", "twice"),
        ("[1, 4]", "[1, 5]", "outside-grid"),
        ("[1, 4]", "[1, 4, 0]", "wrong-count"),
        ("[1, 4]", "[1, 3.5]", "wrong-count"),
        ("num_agents: 2", "num_agents: 3", "wrong-count"),
        ("num_agents: 2\n", "targets: [[0, 0]]\nagents_xy: [[0, 0]]\n", "twice"),
        ("num_agents: 2", "num_agents: 0", "empty"),
    ],
)
def test_a_fault_in_a_configuration_is_one_message(write, old, new, code):
    assert old in CONFIG
    path = write(CONFIG.replace(old, new, 1))
    with raises(FormatError, code):
        read_map(path, ALL)


def test_a_configuration_without_places_is_refused_in_one_sentence(write):
    path = write("map: |\n  ...\n  .#.\nnum_agents: 2\nseed: 3\n")
    done = worldgen("import", str(path), "--out", str(path.with_suffix(".grid")))
    assert done.code == 2
    assert "at random" in done.err
    assert len(done.err.strip().splitlines()) == 1


@pytest.mark.parametrize(
    ("text", "name"), [("a.A\n...\n", "x"), (CONFIG, "x"), (MAPS, "puzzle-02")]
)
def test_a_map_that_is_not_there_is_refused(write, text, name):
    with raises(FormatError, "unknown-name", name=name):
        read_map(write(text), f"pogema+map_name={name}")


def crowd(count, columns=10):
    """Robots in the middle of every second cell, each with the next robot's start as its target."""
    height = 2 * -(-count // columns) + 1
    walls = np.zeros((height, 2 * columns + 1), bool)
    middles = [
        (0.15 + 0.2 * (number % columns), 0.15 + 0.2 * (number // columns))
        for number in range(count)
    ]
    robots = [
        Robot(Pose(*at), Target(*to, 0.04), 0.04)
        for at, to in zip(middles, [*middles[1:], middles[0]], strict=True)
    ]
    return World(walls, robots=robots)


def test_more_robots_than_letters_come_back_from_a_configuration(tmp_path):
    world = crowd(27)
    path = write_export(export_world(world, "pogema", file="w.yaml"), tmp_path)[0]
    assert "num_agents: 27" in path.read_text()
    assert find_format(path).name == "pogema"
    found = read_map(path, ALL)
    assert rows_of(found) == ["." * 21] * 7
    assert len(found.robots) == 27
    for robot, other in zip(world.robots[1:], found.robots[1:], strict=True):
        assert other.start == pytest.approx((robot.start.x, robot.start.y, robot.start.heading))
        assert other.target == pytest.approx((robot.target.x, robot.target.y, 0.04))


def test_agents_of_a_configuration_with_one_target_are_refused():
    world = crowd(27)
    *others, last = world.robots
    twice = replace(last, target=Target(0.37, 0.15, 0.04))
    faulty = replace(world, robots=(*others, twice))
    with raises(InvalidWorld, "cells-taken", number=27):
        export_world(faulty, "pogema")


def test_a_configuration_is_decided(write):
    found = import_world(write(CONFIG), name=ALL)
    assert found.decision.result == "reachable"
    assert len(found.world.robots) == 2
