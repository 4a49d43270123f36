"""OpenUSD, Pixar's own library, checks the output of ``export --to usd``."""

import numpy as np
import pytest

from tests.clients.environments import client
from tests.helpers.exported_meshes import TINY
from worldgen import generate
from worldgen.interop import export_world

ORIGIN = (-12.7, 3.45)


def asked(folder, world, name):
    path = folder / "w.usda"
    path.write_bytes(export_world(world, name, origin=ORIGIN).data)
    return client("usd").ask("usd_stage.py", path)


@pytest.mark.parametrize("family", ["maze", "cave", "rubble"])
def test_the_validator_has_no_objection_and_colliding_cubes_fill_exactly_the_walls(
    tmp_path, family
):
    world = generate(family, seed=5, size=31)
    said = asked(tmp_path, world, "usd+height=0.5")
    assert said["objections"] == [] and said["up"] == "Z" and said["unit"] == 1.0
    filled = np.zeros(world.walls.shape, int)
    for low, high in said["colliders"]:
        cells = (np.array([low[:2], high[:2]]) - ORIGIN) / world.cell_size
        assert np.allclose(cells, cells.round(), atol=1e-6) and (low[2], high[2]) == pytest.approx(
            (0.0, 0.5)
        )
        (left, bottom), (right, top) = cells.round().astype(int).tolist()
        filled[bottom:top, left:right] += 1
    assert np.array_equal(filled, world.walls)


def test_start_and_target_are_frames_with_guides_and_numbers_custom_data(tmp_path):
    said = asked(tmp_path, TINY, "usd+floor")
    assert said["objections"] == [] and said["default"] == "/World"
    assert said["start"] == pytest.approx([-12.55, 3.6, 0.0]) and said["target"] == pytest.approx(
        [-12.35, 3.6, 0.0]
    )
    assert said["facing"] == pytest.approx([np.cos(0.5), np.sin(0.5), 0.0])
    assert said["guides"] == ["/World/start/disc", "/World/target/disc"]
    assert said["custom"]["robot_speed"] == 1.5 and said["custom"]["origin"] == list(ORIGIN)
    assert said["custom"]["size"] == [4, 3] and said["custom"]["heading"] == 0.5
