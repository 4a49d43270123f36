"""Tiled checks the output of ``export --to tiled``.

It draws the cells, and saves a map that is read back completely.
"""

import os
import subprocess

import numpy as np
import pytest
from PIL import Image

from tests.clients.environments import program
from worldgen import generate
from worldgen.interop import export_world, import_world, write_export


def run(*words):
    quiet = {**os.environ, "QT_QPA_PLATFORM": "offscreen"}
    return subprocess.run(
        [str(word) for word in words],
        env=quiet,
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )


@pytest.mark.parametrize("family", ["maze", "cave"])
def test_the_rasteriser_draws_a_tile_on_every_solid_cell_and_on_no_other(tmp_path, family):
    world = generate(family, 5, size=31)
    path = write_export(export_world(world, "tiled"), tmp_path)[0]
    run(program("tmxrasterizer"), "--hide-layer", "places", path, tmp_path / "w.png")
    with Image.open(tmp_path / "w.png") as image:
        drawn = np.asarray(image.convert("RGBA"))[:, :, 3] == 255
    assert np.array_equal(drawn, np.kron(world.walls[::-1], np.ones((16, 16), bool)))


def test_the_objects_are_drawn_where_start_and_target_lie(tmp_path):
    world = generate("maze", 5, size=31)
    path = write_export(export_world(world, "tiled"), tmp_path)[0]
    run(program("tmxrasterizer"), "--hide-layer", "walls", path, tmp_path / "w.png")
    with Image.open(tmp_path / "w.png") as image:
        drawn = np.asarray(image.convert("RGBA"))[:, :, 3] > 0
    rows, columns = np.nonzero(drawn)
    for place in (world.start, world.target):
        away = np.hypot(columns - 160 * place.x, rows - (16 * world.height - 160 * place.y))
        assert away.min() <= 12  # pixels: a marker's or the disc's outline


def test_a_map_that_tiled_has_saved_is_the_same_world(tmp_path):
    world = generate("cave", 5, size=31)
    path = write_export(export_world(world, "tiled", origin=(-1.1, 0.3)), tmp_path)[0]
    saved = tmp_path / "saved.tmj"
    program("tmxrasterizer")
    run(program("tiled"), "--export-map", "json", path, saved)
    again = import_world(saved).world
    assert np.array_equal(again.walls, world.walls)
    for name in ("start", "target", "cell_size", "robot_radius", "robot_speed"):
        assert getattr(again, name) == getattr(world, name)
    assert again.provenance.params["origin"] == [-1.1, 0.3]
