"""Layouts: a world as boxes, and what edits do not change."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from fuzz.find.layout import Layout
from worldgen import Pose, Target, World
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


@given(worlds(), SEEDS)
def test_edits_keep_the_border_and_leave_start_and_target_clear(world, seed):
    for layout in edits(Layout.of(world), seed):
        walls = layout.world().walls
        assert walls[[0, -1]].all() and walls[:, [0, -1]].all()
        assert not walls[SIDE - 3, 2] and not walls[target_cell(layout)]


def target_cell(layout):
    target = layout.empty.target
    return int(target.y * 10), int(target.x * 10)


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
