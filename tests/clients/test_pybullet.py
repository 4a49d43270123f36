"""PyBullet checks the output of ``export --to sdf``."""

import json

import numpy as np
import pytest

from tests.clients.environments import client
from tests.helpers.drawn_worlds import drawn
from tests.helpers.exact_rays import beams
from worldgen import generate
from worldgen.interop import export_world

ORIGIN = (-12.7, 3.45)
REACH = 8.0  # m, more than the width of these worlds
BALL = 0.04  # m
HALL = """
    ##########
    #........#
    #.S.....##
    #........#
    #G.......#
    ##########"""
WALL = 0.8  # m: where the wall on the right begins, in the start's row


def asked(tmp_path, world, rays):
    """What PyBullet answers.

    It casts rays, drops a ball on the start and drives it to the right.
    """
    pybullet = client("pybullet")
    export = export_world(world, "sdf", file="world.sdf", origin=ORIGIN, sidecar=False)
    (tmp_path / "world.sdf").write_bytes(export.data)
    drop = [world.start.x + ORIGIN[0], world.start.y + ORIGIN[1], 0.3, BALL]
    request = {
        "rays": [ray[:4] for ray in rays],
        "z": 0.5,
        "reach": REACH,
        "drop": drop,
        "push": [0.5, 0, 0],
    }
    (tmp_path / "request.json").write_text(json.dumps(request))
    return pybullet.ask("pybullet_world.py", tmp_path / "world.sdf", tmp_path / "request.json")


@pytest.mark.parametrize("family", ["maze", "cave"])
def test_rays_hit_walls_where_they_are_and_walls_stay_there(tmp_path, family):
    world = generate(family, seed=4, size=31)
    rays = beams(world, 150, origin=ORIGIN)
    answer = asked(tmp_path, world, rays)
    assert answer["masses"] == [0.0] * len(answer["names"]) and answer["still"]
    errors = np.sort(np.abs(np.array(answer["rays"])[:, 0] - [ray.lengths[0] for ray in rays]))
    assert (
        errors[-3] < 1e-9 and errors[-1] < 5e-3
    )  # where a ray grazes a corner, Bullet's search ends a little early


def test_a_ball_rests_where_it_was_dropped_and_stops_at_the_wall(tmp_path):
    world = drawn(HALL)
    answer = asked(tmp_path, world, [])
    x, y = world.start.x + ORIGIN[0], world.start.y + ORIGIN[1]
    assert answer["drop"] == pytest.approx([x, y, BALL], abs=1e-3)
    assert answer["driven"] == pytest.approx([ORIGIN[0] + WALL - BALL, y, BALL], abs=2e-3)
