"""trimesh checks the output of ``export --to stl``, ``obj`` and ``glb``."""

import json

import numpy as np
import pytest

from tests.clients.environments import client
from tests.helpers.exact_rays import beams
from tests.helpers.exported_meshes import TINY, solid_volume
from worldgen import generate
from worldgen.interop import export_world
from worldgen.interop.geometry.boxes import closing_boxes, merged_boxes

ORIGIN = (-12.7, 3.45)


def asked(folder, world, name, rays=()):
    """Return trimesh's report on the exported world, with rays halfway up the walls."""
    path = folder / f"w.{name.partition('+')[0]}"
    path.write_bytes(export_world(world, f"{name}+height=0.5", origin=ORIGIN, sidecar=False).data)
    (folder / "rays.json").write_text(json.dumps([ray[:4] for ray in rays]))
    return client("trimesh").ask("trimesh_scene.py", path, folder / "rays.json", 0.25)


@pytest.mark.parametrize("name", ["stl", "obj", "glb"])
@pytest.mark.parametrize("family", ["maze", "rubble"])
def test_boxes_are_watertight_fill_the_walls_and_rays_are_as_long_as_the_simulator_says(
    tmp_path, name, family
):
    world = generate(family, seed=5, size=31)
    rays = beams(world, 200, origin=ORIGIN)
    said = asked(tmp_path, world, name, rays)
    assert said["watertight"] and said["boxes"] == len(merged_boxes(world.walls))
    assert said["volume"] == pytest.approx(
        solid_volume(world, 0.5), rel=1e-12 if name == "obj" else 1e-5
    )
    lengths = np.array([ray.lengths[0] for ray in rays])
    assert np.abs(np.array(said["rays"]) - lengths).max() < (2e-5 if name == "stl" else 1e-6)


def test_an_open_world_is_closed_by_four_boxes_and_the_floor_lies_below_them(tmp_path):
    said = asked(tmp_path, TINY, "obj+floor")
    assert (
        said["boxes"] == len(merged_boxes(TINY.walls)) + len(closing_boxes(TINY)) + 1
        and said["watertight"]
    )
    assert np.allclose(said["bounds"], [[-12.8, 3.35, -0.1], [-12.2, 3.85, 0.5]], atol=1e-12)


def test_start_target_and_numbers_of_a_glb_are_nodes_and_extras(tmp_path):
    said = asked(tmp_path, TINY, "glb+markers")["places"]
    assert said["start"][:2] == pytest.approx([-12.55, 3.6]) and said["target"][
        :2
    ] == pytest.approx([-12.35, 3.6])
    assert said["facing"] == pytest.approx([np.cos(0.5), np.sin(0.5), 0.0])
    assert (
        said["extras"]["robot_radius"] == 0.04
        and (said["extras"]["origin_x"], said["extras"]["origin_y"]) == ORIGIN
    )
