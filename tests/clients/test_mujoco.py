"""MuJoCo checks the output of ``export --to mjcf``."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from tests.clients.environments import client
from tests.helpers.drawn_worlds import drawn
from tests.helpers.exact_rays import beams
from worldgen import generate
from worldgen.interop import export_world
from worldgen.world import Pose

ORIGIN = (-12.7, 3.45)
HALL = """
    ##########
    #........#
    #.S.....##
    #........#
    #G.......#
    ##########"""
WALL = 0.8  # m: where the wall on the right begins, in the start's row


def asked(tmp_path, world, request, name="mjcf"):
    """Return MuJoCo's answer to a request about the exported world."""
    mujoco = client("mujoco")
    for file, data in export_world(
        world, name, file="world.xml", origin=ORIGIN, sidecar=False
    ).files.items():
        (tmp_path / file).write_bytes(data)
    (tmp_path / "request.json").write_text(json.dumps(request))
    return mujoco.ask("mujoco_world.py", tmp_path / "world.xml", tmp_path / "request.json")


@pytest.mark.parametrize(
    ("family", "times"),
    [("maze", [0.0]), ("cave", [0.0]), ("shift", [0.0, 7.5, 20.25]), ("fire", [0.0, 2.5, 6.0])],
)
def test_rays_are_as_long_as_the_simulator_says_at_any_time(tmp_path, family, times):
    world = generate(family, seed=5, size=31, **({"chance": 1.0} if family == "shift" else {}))
    expected = beams(world, 200, times=times, origin=ORIGIN)
    lengths = np.array([beam.lengths for beam in expected]).T[:, np.newaxis]
    assert len(times) == 1 or (lengths[0] != lengths[-1]).any()
    request = {"rays": [beam[:4] for beam in expected], "z": 0.5, "times": times}
    assert np.abs(np.array(asked(tmp_path, world, request)["rays"]) - lengths).max() < 1e-9


def test_a_sphere_rests_on_the_floor_where_it_was_dropped(tmp_path):
    world = drawn(HALL)
    x, y = world.start.x + ORIGIN[0], world.start.y + ORIGIN[1]
    assert asked(tmp_path, world, {"drop": [x, y, 0.5, 0.04]})["drop"] == pytest.approx(
        [x, y, 0.04], abs=1e-3
    )


def test_the_robot_drives_at_the_speed_asked_for_and_stops_at_walls(tmp_path):
    world = drawn(HALL)
    driven = asked(tmp_path, world, {"drive": [[0.5, 0.0, 0.4], [2.0, 0.0, 2.0]]}, "mjcf+robot")[
        "drive"
    ]
    start, under_way, stopped = driven["places"]
    assert start == pytest.approx(
        [world.start.x + ORIGIN[0], world.start.y + ORIGIN[1], 0.0], abs=1e-12
    )
    assert under_way[0] - start[0] == pytest.approx(
        0.5 * (0.4 - 1 / 20), abs=2e-3
    )  # 1 kg at 20 N s/m
    assert stopped[0] == pytest.approx(ORIGIN[0] + WALL - world.robot_radius, abs=1e-3)
    assert driven["shown"] == pytest.approx(stopped[:2], abs=1e-9)


def test_a_footprint_stops_at_walls_where_its_front_is(tmp_path):
    world = drawn(HALL)
    front = 0.09
    box = ((front, 0.05), (-0.04, 0.05), (-0.04, -0.05), (front, -0.05))
    body = replace(world.robots[0], start=replace(world.start, heading=0.0), footprint=box)
    world = replace(world, robots=[body], certificate=None)
    driven = asked(tmp_path, world, {"drive": [[2.0, 0.0, 2.0]]}, "mjcf+robot")["drive"]
    assert driven["places"][-1][0] == pytest.approx(ORIGIN[0] + WALL - front, abs=1e-3)


def test_start_target_and_numbers_are_where_a_user_of_mujoco_looks(tmp_path):
    world = drawn(HALL)
    world = replace(world, start=Pose(world.start.x, world.start.y, 2.5))
    marks = asked(tmp_path, world, {"marks": True})["marks"]
    x, y = ORIGIN
    assert marks["start"] == pytest.approx(
        [world.start.x + x, world.start.y + y, world.robot_radius], abs=1e-12
    )
    assert marks["target"] == pytest.approx(
        [world.target.x + x, world.target.y + y, world.target.radius], abs=1e-12
    )
    assert marks["towards"] == pytest.approx([math.cos(2.5), math.sin(2.5)], abs=1e-12)
    assert [marks[name] for name in ("cell_size", "origin", "robot_speed")] == [
        [0.1],
        [-12.7, 3.45],
        [2.0],
    ]


def test_each_of_several_robots_is_at_its_start_and_drives_by_its_own_actuator(tmp_path):
    world = generate("crossing", seed=4, robots=3)
    names = ["robot", "robot_2", "robot_3"]
    begun, driven = asked(tmp_path, world, {"fleet": names}, "mjcf+robot")["fleet"]
    for robot, before, after in zip(world.robots, begun, driven, strict=True):
        x, y = robot.start.x + ORIGIN[0], robot.start.y + ORIGIN[1]
        assert before == pytest.approx([x, y, robot.start.heading], abs=1e-12)
        assert after[0] - x == pytest.approx(0.5 * (0.2 - 1 / 20), abs=5e-3)
        assert after[1] == pytest.approx(y, abs=1e-3)
