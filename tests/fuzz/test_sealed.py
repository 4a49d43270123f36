"""Layouts with a walled-off target: any bytes make one, and its target really is walled off."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from fuzz.facts.proofs import walled_off
from fuzz.search.sealed import SEALED_BYTES, decode_sealed
from sim.episode import prepare
from sim.options.run import RunOptions
from sim.scenario import Scenario
from tests.helpers.command_line import worldgen
from worldgen.files.grid import write_world
from worldgen.reach import BLOCKED, check_certificate, decide
from worldgen.world import Pose, Target, World

ANY_BYTES = st.binary(min_size=SEALED_BYTES, max_size=SEALED_BYTES)


@given(ANY_BYTES)
@example(bytes(SEALED_BYTES))
@example(b"\xff" * SEALED_BYTES)
def test_the_target_is_walled_off_and_the_cut_says_so(data):
    world = decode_sealed(data)
    assert decide(world).result == BLOCKED
    sealed = walled_off(world)
    assert sealed is not None and check_certificate(sealed).valid


@given(ANY_BYTES)
def test_the_arena_has_a_border_and_room_for_the_robot(data):
    world = decode_sealed(data)
    border = np.concatenate(
        [world.walls[0], world.walls[-1], world.walls[:, 0], world.walls[:, -1]]
    )
    assert border.all() and all(10 <= side <= 20 for side in world.walls.shape)
    prepare(
        world, "thesis-1", Scenario("thesis-1", RunOptions("stepped")).options(world, 10)
    )  # raises if the start is in a wall


@given(ANY_BYTES)
def test_the_target_itself_is_in_no_wall(data):
    world = decode_sealed(data)
    ix, iy = (int(value / world.cell_size) for value in (world.target.x, world.target.y))
    assert not world.walls[iy, ix]


def test_layouts_draw_many_different_walls_and_headings():
    rng = np.random.default_rng(5)
    worlds = [decode_sealed(rng.bytes(SEALED_BYTES)) for _ in range(60)]
    assert len({world.walls.tobytes() for world in worlds}) == 60
    assert len({world.start.heading for world in worlds}) > 40


@pytest.mark.gate
@pytest.mark.parametrize("form", range(16))
def test_verify_says_blocked_for_walls_of_every_form(form, tmp_path):
    data = bytearray(SEALED_BYTES)
    data[2] = form
    write_world(walled_off(decode_sealed(bytes(data))), tmp_path / "w.grid")
    result = worldgen("verify", tmp_path / "w.grid")
    assert "w.grid: blocked for a disc of 0.07 m, cut checked" in result.out


@pytest.mark.parametrize(("width", "sealed"), [(1, False), (2, True)])
def test_a_slot_too_narrow_for_the_robot_is_no_walled_off_target(width, sealed):
    walls = np.zeros((8, 8), bool)
    walls[:, width] = True
    side = 0.1 * width
    world = World(walls, Pose(0.55, 0.45, 0.0), Target(side / 2, 0.4, 0.05))
    assert decide(world).result == BLOCKED
    assert (walled_off(world) is not None) == sealed
