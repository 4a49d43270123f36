"""PyBullet judges what ``export --to sdf`` writes."""

import json

import numpy as np
import pytest

from tests.clients.environments import client
from tests.helpers.exact_rays import beams
from worldgen import generate
from worldgen.interop import export_world

ORIGIN = (-12.7, 3.45)
REACH = 8.0  # m, farther than these worlds are wide


@pytest.mark.parametrize("family", ["maze", "cave"])
def test_rays_hit_walls_where_they_are_and_walls_stay_there(tmp_path, family):
    pybullet = client("pybullet")
    world = generate(family, seed=4, size=31)
    export = export_world(world, "sdf", file="world.sdf", origin=ORIGIN, sidecar=False)
    (tmp_path / "world.sdf").write_bytes(export.data)
    rays = beams(world, 150, origin=ORIGIN)
    x, y = world.start.x + ORIGIN[0], world.start.y + ORIGIN[1]
    request = {"rays": [ray[:4] for ray in rays], "z": 0.5, "reach": REACH, "drop": [x, y, 0.3, 0.04]}
    (tmp_path / "request.json").write_text(json.dumps(request))
    answer = pybullet.ask("pybullet_world.py", tmp_path / "world.sdf", tmp_path / "request.json")
    assert answer["masses"] == [0.0] * len(answer["names"]) and answer["still"]
    errors = np.sort(np.abs(np.array(answer["rays"])[:, 0] - [ray.lengths[0] for ray in rays]))
    assert errors[-3] < 1e-9 and errors[-1] < 5e-3  # where a ray grazes a corner, Bullet's search ends a little early
    assert answer["drop"] == pytest.approx([x, y, 0.04], abs=1e-3)
