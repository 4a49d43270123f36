"""ADMesh checks the output of ``export --to stl``."""

import re
import subprocess

import pytest

from tests.clients.environments import program
from tests.helpers.exported_meshes import solid_volume
from worldgen import generate
from worldgen.interop import export_world
from worldgen.interop.geometry.boxes import merged_boxes

FAULTS = (
    "Total disconnected facets",
    "Degenerate facets",
    "Facets removed",
    "Facets reversed",
    "Normals fixed",
)


@pytest.mark.parametrize("family", ["maze", "cave", "rubble"])
def test_every_box_is_a_part_nothing_wants_mending_and_the_volume_is_that_of_the_walls(
    tmp_path, family
):
    world, path = generate(family, seed=5, size=31), tmp_path / "w.stl"
    path.write_bytes(export_world(world, "stl+height=0.5", origin=(-12.7, 3.45)).data)
    words = [program("admesh"), path]
    said = subprocess.run(words, capture_output=True, text=True, check=True, timeout=60).stdout

    def number(name):
        return float(re.search(rf"{name} *[:=] +([-\d.]+)", said)[1])

    assert [number(name) for name in FAULTS] == [0.0] * len(FAULTS)
    assert number("Number of parts") == len(merged_boxes(world.walls))
    assert number("Volume") == pytest.approx(solid_volume(world, 0.5), rel=1e-4)
    assert [number(name) for name in ("Min X", "Max Y", "Max Z")] == pytest.approx(
        [-12.7, 6.55, 0.5], abs=1e-5
    )
