"""PyBullet checks the output of ``export --to obj``, as the mesh of one body."""

import json

import numpy as np

from tests.clients.environments import client
from tests.helpers.exact_rays import beams
from worldgen import generate
from worldgen.interop import export_world

ORIGIN = (-12.7, 3.45)


def test_rays_against_the_mesh_are_as_long_as_the_simulator_says(tmp_path):
    world = generate("rubble", seed=5, size=31)
    (tmp_path / "w.obj").write_bytes(export_world(world, "obj", origin=ORIGIN).data)
    rays = beams(world, 200, origin=ORIGIN)
    (tmp_path / "rays.json").write_text(json.dumps([ray[:4] for ray in rays]))
    said = client("pybullet").ask(
        "pybullet_mesh.py", tmp_path / "w.obj", tmp_path / "rays.json", 0.5
    )
    lengths = np.array([ray.lengths[0] for ray in rays])
    assert np.abs(np.array(said["rays"]) - lengths).max() < 1e-4  # 32 bits, of 10 m long rays
