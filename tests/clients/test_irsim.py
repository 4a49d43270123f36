"""IR-SIM loads exported worlds, and its lidar, collisions and goal match the world."""

import json
from dataclasses import replace

import numpy as np
import pytest

from tests.clients.environments import client
from tests.helpers.core_parts import heading_table, ray_distance
from tests.helpers.drawn_worlds import drawn
from tests.reference.sim.layout import TURN, UNIT
from worldgen.generation import generate
from worldgen.interop import export_world, write_export
from worldgen.lattice import heading_from_lattice

BEAMS = [beam * TURN // 256 - TURN // 2 for beam in range(257)]
ROOM = """
########
#......#
#S....G#
#......#
########
"""


def ranges(world, place, heading):
    """Return what our own beams measure, m; place and heading are on the lattice."""
    cells, table, longest = (
        world.walls.astype(np.uint8),
        heading_table(),
        10.0 / world.cell_size * UNIT,
    )
    ray = getattr(ray_distance, "py_func", ray_distance)
    return [
        ray(cells, table, *place, heading + beam, longest) * world.cell_size / UNIT
        for beam in BEAMS
    ]


def asked_of_irsim(world, folder, name, origin, places, drives=()):
    files = write_export(export_world(world, name, file="w.yaml", origin=origin), folder)
    metres = [
        [value * world.cell_size / UNIT + shift for value, shift in zip(at, origin, strict=True)]
        for at, _ in places
    ]
    poses = [
        [*at, heading_from_lattice(turned)] for at, (_, turned) in zip(metres, places, strict=True)
    ]
    request = json.dumps({"poses": poses, "drives": list(drives)})
    return client("irsim").ask("irsim_scan_and_drive.py", files[0], request, cwd=folder)


@pytest.mark.parametrize(("walls", "origin"), [("boxes", (-3.7, 12.25)), ("image", (0.0, 0.0))])
def test_irsims_lidar_measures_what_ours_does(walls, origin, tmp_path):
    world = generate("rooms", 5, size=24)
    rng = np.random.default_rng(1)
    free = rng.permutation(np.argwhere(~world.walls))[:4]
    places = [
        ((int(ix) * UNIT + 411, int(iy) * UNIT + 623), 2000 * index + 77)
        for index, (iy, ix) in enumerate(free)
    ]
    found = asked_of_irsim(world, tmp_path, f"irsim+lidar+walls={walls}", origin, places)
    expected = [ranges(world, *place) for place in places]
    assert np.abs(np.array(found["ranges"]) - np.array(expected)).max() < 1e-6


@pytest.mark.parametrize("walls", ["boxes", "image"])
def test_irsims_robot_collides_with_the_wall_and_arrives_at_the_target(walls, tmp_path):
    world = drawn(ROOM, robot_speed=0.5, target_radius=0.04)
    origin, start = (100.25, -7.0), [100.25 + 0.35, -7.0 + 0.25]
    drives = [
        {"pose": [*start, np.pi], "command": [0.1, 0.0], "steps": 300},
        {"pose": [*start, 0.0], "command": [0.1, 0.0], "steps": 400},
    ]
    found = asked_of_irsim(
        world, tmp_path, f"irsim+lidar+step_time=0.01+walls={walls}", origin, [], drives
    )
    into, there = found["drives"]
    assert into["collision"] and not into["arrive"] and abs(into["x"] - 100.25 - 0.17) < 2e-3
    assert there["arrive"] and not there["collision"] and abs(there["x"] - 100.25 - 0.61) < 2e-3
    assert (found["radius"], found["goal_threshold"], found["fastest"]) == pytest.approx(
        (0.07, 0.04, 0.5), abs=1e-3
    )
    assert found["goal"] == pytest.approx([100.25 + 0.65, -7.0 + 0.25])


def test_irsim_meets_a_wall_outside_a_world_whose_border_is_open(tmp_path):
    world = drawn("....\nS..G\n....", robot_speed=0.5, target_radius=0.01)
    drives = [
        {"pose": [0.15, 0.15, angle], "command": [0.1, 0.0], "steps": 400}
        for angle in (np.pi / 2, -np.pi / 2)
    ]
    found = asked_of_irsim(world, tmp_path, "irsim+step_time=0.01", (0.0, 0.0), [], drives)
    assert [round(one["y"], 2) for one in found["drives"] if one["collision"]] == [0.23, 0.07]


def test_irsim_has_each_of_several_robots_at_its_start_with_its_goal(tmp_path):
    world = generate("crossing", seed=4, robots=3)
    found = asked_of_irsim(world, tmp_path, "irsim", (0.0, 0.0), [])["robots"]
    assert len(found) == 3
    for robot, there in zip(world.robots, found, strict=True):
        start, target = robot.start, robot.target
        assert there["state"] == pytest.approx([start.x, start.y, start.heading])
        assert there["goal"] == pytest.approx([target.x, target.y])
        assert there["radius"] == pytest.approx(robot.radius)


def test_irsim_stops_a_footprint_where_its_front_meets_the_wall(tmp_path):
    world = drawn(ROOM, radius=0.3, cell_size=1.0)
    box = ((0.9, 0.2), (-0.3, 0.2), (-0.3, -0.2), (0.9, -0.2))
    target = replace(world.target, heading=1.0)
    body = replace(world.robots[0], footprint=box, target=target, speed=1.0)
    world = replace(world, robots=[body], certificate=None)
    start = [world.start.x, world.start.y, 0.0]
    drives = [{"pose": start, "command": [1.0, 0.0], "steps": 100}]
    (driven,) = asked_of_irsim(world, tmp_path, "irsim", (0.0, 0.0), [], drives)["drives"]
    # The wall begins at 7 m, and IR-SIM looks every 0.1 m.
    assert driven["collision"] and 7.0 - 0.9 <= driven["x"] + 1e-9 <= 7.0 - 0.9 + 0.1 + 1e-6
