"""Feature layouts: any bytes make a world, and zeros make the simplest one."""

import numpy as np
from hypothesis import given

from fuzz.layouts.features import decode_world
from fuzz.layouts.layout_bytes import LAYOUT_BYTES
from fuzz.strategies import feature_worlds, layouts
from sim.controllers import CONTROLLERS
from sim.options.run import RunOptions
from sim.runners.lattice import LatticeRun
from worldgen import check_certificate


@given(layouts())
def test_any_layout_has_a_border_and_room_for_the_robot(data):
    world = decode_world(data)
    border = np.concatenate(
        [world.walls[0], world.walls[-1], world.walls[:, 0], world.walls[:, -1]]
    )
    assert border.all()
    LatticeRun(
        world, CONTROLLERS.get("turn-left"), RunOptions()
    )  # raises if the start is in a wall


def test_zero_bytes_are_an_empty_arena():
    world = decode_world(bytes(LAYOUT_BYTES))
    assert not world.walls[1:-1, 1:-1].any() and world.walls.shape == (8, 8)


@given(feature_worlds())
def test_feature_worlds_carry_a_witness_that_holds(world):
    assert check_certificate(world).valid


def test_layouts_draw_many_different_shapes():
    rng = np.random.default_rng(5)
    worlds = [decode_world(rng.bytes(LAYOUT_BYTES)) for _ in range(50)]
    assert len({world.walls.tobytes() for world in worlds}) == 50
    assert len({world.walls.shape for world in worlds}) > 30
