"""librsvg checks the output of ``export --to svg``."""

import io
import subprocess

import numpy as np
import pytest
from PIL import Image

from tests.clients.environments import program
from tests.helpers.exported_meshes import TINY
from worldgen import generate
from worldgen.interop import export_world
from worldgen.render.marks import hue, rgb
from worldgen.support.rows import flip_rows

ORIGIN = (-12.7, 3.45)


def pixels(folder, world, side, name="svg"):
    """(rows, columns, 3) colours of the rendered plan, lowest row first; ``side`` pixels a cell."""
    path = folder / "plan.svg"
    path.write_bytes(export_world(world, name, origin=ORIGIN).data)
    size = ["-w", str(world.width * side)] if name == "svg" else []
    words = [program("rsvg-convert"), *size, path]
    done = subprocess.run(words, capture_output=True, check=True, timeout=60)
    return flip_rows(np.array(Image.open(io.BytesIO(done.stdout)).convert("RGB")))


@pytest.mark.parametrize("family", ["maze", "cave", "rubble"])
def test_the_pixels_of_a_cell_have_the_colour_of_a_wall_where_it_is_solid(tmp_path, family):
    world = generate(family, seed=5, size=31)
    picture = pixels(tmp_path, world, 8)
    assert picture.shape == (world.height * 8, world.width * 8, 3)
    inner = picture.reshape(world.height, 8, world.width, 8, 3)[:, 1:-1, :, 1:-1]
    solid = (inner == rgb(hue("wall"))).all(axis=4)
    assert np.array_equal(solid.all(axis=(1, 3)), world.walls) and np.array_equal(
        solid.any(axis=(1, 3)), world.walls
    )


def test_the_robots_disc_is_where_it_starts_and_the_print_is_to_scale(tmp_path):
    picture = pixels(
        tmp_path, TINY, 0, "svg+scale=1"
    )  # 0.6 x 0.5 m at 96 dots per inch, including the border
    assert picture.shape[:2] == pytest.approx((500 * 96 / 25.4, 600 * 96 / 25.4), abs=1)
    red, green, blue = (picture[..., channel].astype(int) for channel in range(3))
    y, x = np.nonzero((green > red + 60) & (green > blue + 20))
    metres = (
        np.array([x.mean(), y.mean()]) * 0.0254 / 96 - 0.1
    )  # from the grid's corner, a cell of border away
    assert metres == pytest.approx([TINY.start.x, TINY.start.y], abs=1e-3)
    assert len(x) * (0.0254 / 96) ** 2 == pytest.approx(np.pi * TINY.robot_radius**2, rel=0.05)
