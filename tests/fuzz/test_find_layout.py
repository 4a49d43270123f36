"""Layouts: a world as boxes, and what edits do not change."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import example, given
from hypothesis import strategies as st

from fuzz.find.layout import Layout
from tests.helpers.raising import raises
from worldgen import Pose, Target, World
from worldgen.errors import InvalidParameter
from worldgen.random_streams import RandomStream

SIDE = 14
SEEDS = st.integers(0, 2**32)


@st.composite
def worlds(draw):
    """Square worlds with a border, a few boxes, start below and target above on the diagonal."""
    walls = np.zeros((SIDE, SIDE), bool)
    corner, length = st.integers(0, SIDE - 1), st.integers(1, 6)
    for x, y, width, height in draw(
        st.lists(st.tuples(corner, corner, length, length), max_size=5)
    ):
        walls[y : y + height, x : x + width] = True
    walls[[0, -1], :] = walls[:, [0, -1]] = True
    walls[SIDE - 4 : SIDE - 1, 1:4] = walls[1:4, SIDE - 4 : SIDE - 1] = False
    return World(walls, Pose(0.25, (SIDE - 2.5) / 10, 0.0), Target((SIDE - 2.5) / 10, 0.25, 0.05))


def edits(layout, seed, count=12):
    """Yield every layout along a chain of random edits."""
    rng = RandomStream(seed)
    for _ in range(count):
        layout = layout.edited(rng) or layout
        yield layout


@given(worlds())
def test_boxes_stand_for_the_world_that_they_are_of(world):
    assert (Layout.of(world).world().walls == world.walls).all()


@pytest.mark.gate
def a_wall_that_crosses_its_mirror_image():
    walls = np.zeros((SIDE, SIDE), bool)
    walls[[0, -1]] = walls[:, [0, -1]] = True
    walls[SIDE - 5, :6] = True
    return World(walls, Pose(0.25, (SIDE - 2.5) / 10, 0.0), Target((SIDE - 2.5) / 10, 0.25, 0.05))


@given(worlds())
@example(a_wall_that_crosses_its_mirror_image())
def test_the_mirror_of_a_symmetric_world_is_that_world(world):
    both = replace(world, walls=world.walls | world.walls[::-1, ::-1].T)
    assert (both.walls == both.walls[::-1, ::-1].T).all()
    assert (Layout.of(both, mirror=True).world().walls == both.walls).all()


@given(worlds(), SEEDS)
def test_edits_keep_the_border_and_leave_start_and_target_clear(world, seed):
    for layout in edits(Layout.of(world), seed):
        walls = layout.world().walls
        assert walls[[0, -1]].all() and walls[:, [0, -1]].all()
        assert not walls[SIDE - 3, 2] and not walls[target_cell(layout)]


def target_cell(layout):
    target = layout.empty.target
    return int(target.y * 10), int(target.x * 10)


@given(worlds(), SEEDS)
def test_edits_of_a_mirrored_layout_stay_symmetric(world, seed):
    for layout in edits(Layout.of(world, mirror=True), seed):
        walls = layout.world().walls
        assert (walls == walls[::-1, ::-1].T).all()


@given(worlds(), SEEDS, st.integers(0, 3))
def test_edits_on_a_leash_stay_near_home(world, seed, leash):
    home = Layout.of(world, leash=leash)
    for layout in edits(home, seed):
        moved = np.abs(np.array(layout.boxes) - np.array(home.boxes))
        assert moved.max(initial=0) <= leash
        assert (
            max(abs(a - b) for a, b in zip(target_cell(layout), target_cell(home), strict=True))
            <= leash
        )


@given(worlds(), SEEDS)
def test_a_fixed_target_stays(world, seed):
    assert all(
        layout.empty.target == world.target
        for layout in edits(Layout.of(world, fixed_target=True), seed)
    )


@given(worlds())
def test_what_is_simpler_has_no_wall_that_was_not_there(world):
    layout = Layout.of(world)
    for simpler in layout.simpler():
        assert (
            not (simpler.world().walls & ~world.walls).any()
            and simpler.world().solid_cells < world.solid_cells
        )


def test_a_world_that_is_not_square_has_no_mirror():
    world = World(np.zeros((8, 9), bool), Pose(0.25, 0.25, 0.0), Target(0.55, 0.55, 0.05))
    with raises(InvalidParameter, "not-square", width=9, height=8):
        Layout.of(world, mirror=True)


@pytest.mark.gate
@given(st.integers(0, 2**32), st.integers(1, 4))
def test_obstacles_that_stay_together_stay_in_one_piece_and_apart(seed, leash):
    walls = np.zeros((30, 30), bool)
    walls[[0, -1], :] = walls[:, [0, -1]] = True
    walls[10:20, 16:19] = walls[16:20, 9:19] = True
    walls[4:6, 20:26] = True
    world = World(walls, Pose(0.35, 2.65, 0.0), Target(2.45, 0.85, 0.05))
    layout, rng = Layout.of(world, leash=leash, together=True), RandomStream(seed)
    for _ in range(60):
        layout = layout.edited(rng) or layout
        inner = layout.world().walls[1:-1, 1:-1]
        grown = [shapely.box(x, y, x + 1, y + 1) for y, x in np.argwhere(inner)]
        assert len(shapely.get_parts(shapely.union_all(shapely.buffer(grown, 1e-6)))) == 2
