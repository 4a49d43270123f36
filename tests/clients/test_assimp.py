"""Assimp checks the output of ``export --to stl``, ``obj`` and ``glb``."""

import re
import subprocess

import numpy as np
import pytest

from tests.clients.environments import program
from tests.helpers.exported_meshes import solid_volume, stl_triangles, volume
from worldgen import generate
from worldgen.interop import export_world
from worldgen.interop.geometry.boxes import merged_boxes

ORIGIN = (-12.7, 3.45)
LOW, HIGH = (-12.7, 3.45, 0.0), (-9.6, 6.55, 0.5)
Y_UP = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])


def written(folder, world, name, ending):
    path = folder / f"w.{ending}"
    path.write_bytes(export_world(world, f"{name}+height=0.5", origin=ORIGIN, sidecar=False).data)
    return path


@pytest.mark.parametrize("name", ["stl", "obj", "glb"])
def test_a_file_has_as_many_meshes_and_nodes_as_boxes_and_the_worlds_bounds(tmp_path, name):
    world = generate("cave", seed=5, size=31)
    words = [program("assimp"), "info", written(tmp_path, world, name, name)]
    said = subprocess.run(words, capture_output=True, text=True, check=True, timeout=60).stdout
    boxes = len(merged_boxes(world.walls))
    counts = {
        "stl": (2, 1),
        "obj": (boxes + 1, boxes),
        "glb": (boxes + 3, 1),
    }  # root, walls, and start and target
    assert (
        tuple(int(re.search(rf"{what}: +(\d+)", said)[1]) for what in ("Nodes", "Meshes"))
        == counts[name]
    )
    ends = [
        np.array(re.search(rf"{end} point +\((.+)\)", said)[1].split(), float)
        for end in ("Minimum", "Maximum")
    ]
    frame = Y_UP if name == "glb" else np.eye(3)
    corners = np.sort([frame @ LOW, frame @ HIGH], axis=0)
    assert np.allclose(ends, corners, atol=2e-6)


@pytest.mark.parametrize("name", ["stl", "obj", "glb"])
def test_what_comes_out_again_has_the_volume_of_the_walls(tmp_path, name):
    world = generate("cave", seed=5, size=31)
    words = [
        program("assimp"),
        "export",
        written(tmp_path, world, name, name),
        tmp_path / "again.stl",
        "-fstlb",
    ]
    subprocess.run(words, capture_output=True, check=True, timeout=60)
    triangles = stl_triangles((tmp_path / "again.stl").read_bytes())["corners"].astype(float)
    assert volume(triangles) == pytest.approx(solid_volume(world, 0.5), rel=1e-4)
