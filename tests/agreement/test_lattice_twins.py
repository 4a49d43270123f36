"""The core's geometry, moves and senses agree to the last bit with the plain-Python reference."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers import core_parts
from tests.reference.sim import geometry, lattice_motion, lattice_rays, lattice_sense
from worldgen.lattice import TURN, UNIT
from worldgen.random_streams import RandomStream

SMALL = st.integers(-20_000, 20_000)


@given(SMALL, SMALL, st.integers(0, TURN - 1))
def test_heading_of_equals_its_reference(dx, dy, otherwise):
    assert core_parts.heading_of(dx, dy, otherwise) == lattice_sense.heading_of(dx, dy, otherwise)


@given(SMALL, SMALL)
def test_heading_of_is_within_a_unit_of_the_true_angle(dx, dy):
    if dx or dy:
        true = math.atan2(dy, dx) / (2 * math.pi) * TURN
        assert abs((core_parts.heading_of(dx, dy, 0) - true + TURN / 2) % TURN - TURN / 2) <= 0.51


@given(SMALL, SMALL)
def test_heading_of_turns_with_its_vector(dx, dy):
    if dx or dy:
        assert (
            core_parts.heading_of(-dy, dx, 0)
            == (core_parts.heading_of(dx, dy, 0) + TURN // 4) % TURN
        )


@pytest.mark.gate
@given(st.integers(0, TURN - 1), st.integers(-5000, 5000))
def test_displacement_turns_with_its_heading(heading, distance):
    table = core_parts.heading_table()
    dx, dy = core_parts.displacement(table, heading, distance)
    assert core_parts.displacement(table, (heading + TURN // 4) % TURN, distance) == (-dy, dx)


def test_no_table_entry_is_near_a_half_where_libraries_could_round_it_differently():
    angles = np.arange(TURN // 8 + 1) * (2 * math.pi / TURN)
    scaled = np.concatenate([np.cos(angles), np.sin(angles)]) * 2.0**30
    assert np.abs(scaled - np.floor(scaled) - 0.5).min() > 1e-5


@given(st.integers(0, 2**64 - 1), st.integers(0, 1000))
def test_random_draws_are_those_of_the_stream(seed, index):
    expected = RandomStream(seed).floats(index + 1)[index]
    assert core_parts.random_draw(seed, index) == expected


@given(
    st.binary(min_size=64, max_size=64), st.lists(st.tuples(SMALL, SMALL), min_size=1, max_size=8)
)
def test_swept_moves_equal_their_reference(data, moves):
    cells = (np.frombuffer(data, np.uint8).reshape(8, 8) < 40).astype(np.uint8)
    cells[3:5, 3:5] = 0
    pose, chains = (4 * UNIT, 4 * UNIT), (np.zeros((4, 3), np.int64), np.zeros((4, 3), np.int64))
    for dx, dy in moves:
        one = core_parts.swept_move(
            cells, 500_000, 708, (*pose, dx, dy), (0.0, 1.0), 0.0, chains[0], 0
        )
        two = lattice_motion.swept_move(
            cells, 500_000, 708, (*pose, dx, dy), (0.0, 1.0), 0.0, chains[1], 0
        )
        assert one == two and chains[0].tolist() == chains[1].tolist()
        pose = tuple(chains[0][one[0] - 1, :2].tolist()) if one[0] else pose


@given(st.binary(min_size=80, max_size=80))
def test_clearance_table_is_the_chessboard_distance(data):
    cells = (np.frombuffer(data, np.uint8).reshape(8, 10) < 30).astype(np.uint8)
    table = np.zeros(cells.shape, np.int32)
    core_parts.chessboard_clearance(cells, table)
    solid = np.argwhere(np.pad(cells, 1, constant_values=1))
    for iy in range(8):
        for ix in range(10):
            assert table[iy, ix] == np.abs(solid - (iy + 1, ix + 1)).max(axis=1).min()


ROOM = st.binary(min_size=64, max_size=64)
PLACE = st.integers(-UNIT, 9 * UNIT)
STEP = st.integers(-2 * UNIT, 2 * UNIT)


def masks(cells):
    near = np.zeros(cells.shape, np.int32)
    core_parts.near_masks(cells, near)
    return near


@given(ROOM, PLACE, PLACE, STEP, STEP, st.integers(1, 3 * UNIT))
def test_a_window_that_is_free_holds_no_cell_that_the_disc_could_touch(data, x, y, dx, dy, reach):
    cells = (np.frombuffer(data, np.uint8).reshape(8, 8) < 10).astype(np.uint8)
    ends = (x, y, x + dx, y + dy)
    free = core_parts.window_is_free(masks(cells), reach, ends)
    assert free == geometry.window_is_free(masks(cells), reach, ends)
    if free:
        assert not core_parts.segment_first_not_clear(cells, 1, reach * reach, reach, ends)[0]


def test_a_window_is_free_up_to_the_contact():
    cells = np.zeros((8, 8), np.uint8)
    cells[:, 5] = 1
    near, reach = masks(cells), 700
    at = 5 * UNIT - reach
    assert core_parts.window_is_free(near, reach, (at - 300, 4 * UNIT, at, 4 * UNIT))
    assert not core_parts.window_is_free(near, reach, (at - 300, 4 * UNIT, at + 1, 4 * UNIT))


@given(
    ROOM, st.lists(st.tuples(st.integers(0, 7), st.integers(0, 7), st.integers(0, 2)), max_size=12)
)
def test_masks_that_follow_events_are_those_of_the_cells(data, events):
    cells = (np.frombuffer(data, np.uint8).reshape(8, 8) % 3).astype(np.uint8)
    near = masks(cells)
    for ix, iy, state in events:
        cells[iy, ix] = state
        core_parts.mark_near(cells, near, ix, iy)
    assert (near == masks(cells)).all()


def test_the_heading_table_is_the_reference_s():
    assert (core_parts.heading_table() == lattice_sense.heading_table()).all()


@given(ROOM, PLACE, PLACE, STEP, STEP, st.integers(1, 2 * UNIT), st.integers(0, 2))
def test_clear_poses_and_paths_are_the_reference_s(data, x, y, dx, dy, reach, state):
    cells = (np.frombuffer(data, np.uint8).reshape(8, 8) % 5 % 3).astype(np.uint8)
    disc = (reach * reach - 7, reach)
    way = (x, y, x + dx, y + dy)
    clear = core_parts.pose_is_clear(cells, state, *disc, x, y)
    assert clear == geometry.pose_is_clear(cells, state, *disc, x, y)
    met = core_parts.segment_first_not_clear(cells, state, *disc, way)
    assert met == geometry.segment_first_not_clear(cells, state, *disc, way)


@given(PLACE, PLACE, STEP, STEP, st.integers(-1, 8), st.integers(-1, 8), st.floats(1.0, 2000.0))
def test_crossings_and_depths_are_the_reference_s(x, y, dx, dy, ix, iy, radius):
    numbers = (x, y, x + dx, y + dy, ix, iy)
    assert core_parts.segment_crosses_box(*numbers) == geometry.segment_crosses_box(*numbers)
    assert core_parts.segment_box_depth(radius, *numbers) == geometry.segment_box_depth(
        radius, *numbers
    )


@given(ROOM, PLACE, PLACE, STEP, STEP)
def test_endpoint_moves_equal_their_reference(data, x, y, dx, dy):
    cells = (np.frombuffer(data, np.uint8).reshape(8, 8) < 40).astype(np.uint8)
    chains = np.zeros((4, 3), np.int64), np.zeros((4, 3), np.int64)
    one = core_parts.endpoint_move(cells, 90_000, 300, (x, y, dx, dy), chains[0], 1)
    assert one == lattice_motion.endpoint_move(cells, 90_000, 300, (x, y, dx, dy), chains[1], 1)
    assert (chains[0] == chains[1]).all()


INSIDE = st.integers(0, 8 * UNIT)


@given(ROOM, INSIDE, INSIDE, INSIDE, INSIDE, st.integers(0, TURN - 1), st.floats(0.0, 20_000.0))
def test_lines_through_cells_are_the_reference_s(data, x, y, to_x, to_y, heading, longest):
    cells = (np.frombuffer(data, np.uint8).reshape(8, 8) % 7 % 3).astype(np.uint8)
    table, line = core_parts.heading_table(), (x, y, to_x, to_y)
    ray = core_parts.ray_distance(cells, table, x, y, heading, longest)
    assert ray == lattice_rays.ray_distance(cells, table, x, y, heading, longest)
    assert core_parts.walls_on_the_way(cells, *line) == lattice_rays.walls_on_the_way(cells, *line)
    assert core_parts.smoke_on_the_way(cells, *line, 1) == lattice_rays.smoke_on_the_way(
        cells, *line, 1
    )
    assert core_parts.signal_heading(cells, *line, heading) == lattice_sense.signal_heading(
        cells, *line, heading
    )


@given(
    st.integers(0, 2**32 - 1),
    INSIDE,
    INSIDE,
    st.integers(0, TURN - 1) | st.sampled_from(range(0, TURN, TURN // 16)),
    st.integers(1, 40),
    st.sampled_from([float(TURN), 12_345.6, 0.0]),
    st.floats(1.0, 1e6),
)
def test_beams_that_skip_along_their_lanes_end_where_the_reference_ends(
    seed, x, y, heading, beams, field, longest
):
    cells = (np.random.default_rng(seed).random((8, 8)) < 0.2).astype(np.uint8)
    table = core_parts.heading_table()
    found = core_parts.beams_with_tables(cells, (x, y, heading), beams, field, longest)
    towards = [lattice_rays.beam_heading(heading, beam, beams, field) for beam in range(beams)]
    assert found == [lattice_rays.ray_distance(cells, table, x, y, ray, longest) for ray in towards]
