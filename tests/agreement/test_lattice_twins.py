"""Kernels agree to the last bit with the Python functions that they were compiled from."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.kernels import geometry, lattice_motion, lattice_sense
from sim.kernels.layout import TURN, UNIT
from worldgen.random_streams import RandomStream

SMALL = st.integers(-20_000, 20_000)


def plain(kernel):
    return getattr(kernel, "py_func", kernel)


@given(SMALL, SMALL, st.integers(0, TURN - 1))
def test_heading_of_equals_its_python_twin(dx, dy, otherwise):
    assert lattice_sense.heading_of(dx, dy, otherwise) == plain(lattice_sense.heading_of)(dx, dy, otherwise)


@given(SMALL, SMALL)
def test_heading_of_is_within_a_unit_of_the_true_angle(dx, dy):
    if dx or dy:
        true = math.atan2(dy, dx) / (2 * math.pi) * TURN
        assert abs((lattice_sense.heading_of(dx, dy, 0) - true + TURN / 2) % TURN - TURN / 2) <= 0.51


@given(SMALL, SMALL)
def test_heading_of_turns_with_its_vector(dx, dy):
    if dx or dy:
        assert lattice_sense.heading_of(-dy, dx, 0) == (lattice_sense.heading_of(dx, dy, 0) + TURN // 4) % TURN


@pytest.mark.gate
@given(st.integers(0, TURN - 1), st.integers(-5000, 5000))
def test_displacement_turns_with_its_heading(heading, distance):
    table = lattice_sense.heading_table()
    dx, dy = lattice_sense.displacement(table, heading, distance)
    assert lattice_sense.displacement(table, (heading + TURN // 4) % TURN, distance) == (-dy, dx)


def test_no_table_entry_is_near_a_half_where_libraries_could_round_it_differently():
    angles = np.arange(TURN // 8 + 1) * (2 * math.pi / TURN)
    scaled = np.concatenate([np.cos(angles), np.sin(angles)]) * 2.0**30
    assert np.abs(scaled - np.floor(scaled) - 0.5).min() > 1e-5


@given(st.integers(0, 2**64 - 1), st.integers(0, 1000))
def test_random_draws_are_those_of_the_stream(seed, index):
    expected = RandomStream(seed).floats(index + 1)[index]
    assert lattice_sense.random_draw(int(np.uint64(seed).astype(np.int64)), index) == expected


@given(st.binary(min_size=64, max_size=64), st.lists(st.tuples(SMALL, SMALL), min_size=1, max_size=8))
def test_swept_moves_equal_their_python_twin(data, moves):
    cells = (np.frombuffer(data, np.uint8).reshape(8, 8) < 40).astype(np.uint8)
    cells[3:5, 3:5] = 0
    pose, chains = (4 * UNIT, 4 * UNIT), (np.zeros((4, 3), np.int64), np.zeros((4, 3), np.int64))
    for dx, dy in moves:
        one = lattice_motion.swept_move(cells, 500_000, 708, (*pose, dx, dy), (0.0, 1.0), 0.0, chains[0], 0)
        two = plain(lattice_motion.swept_move)(cells, 500_000, 708, (*pose, dx, dy), (0.0, 1.0), 0.0, chains[1], 0)
        assert one == two and chains[0].tolist() == chains[1].tolist()
        pose = tuple(chains[0][one[0] - 1, :2].tolist()) if one[0] else pose


@given(st.binary(min_size=80, max_size=80))
def test_clearance_table_is_the_chessboard_distance(data):
    cells = (np.frombuffer(data, np.uint8).reshape(8, 10) < 30).astype(np.uint8)
    table = np.zeros(cells.shape, np.int32)
    geometry.chessboard_clearance(cells, table)
    solid = np.argwhere(np.pad(cells, 1, constant_values=1))
    for iy in range(8):
        for ix in range(10):
            assert table[iy, ix] == np.abs(solid - (iy + 1, ix + 1)).max(axis=1).min()


ROOM = st.binary(min_size=64, max_size=64)
PLACE = st.integers(-UNIT, 9 * UNIT)
STEP = st.integers(-2 * UNIT, 2 * UNIT)


def masks(cells):
    near = np.zeros(cells.shape, np.int32)
    geometry.near_masks(cells, near)
    return near


@given(ROOM, PLACE, PLACE, STEP, STEP, st.integers(1, 3 * UNIT))
def test_a_window_that_is_free_holds_no_cell_that_the_disc_could_touch(data, x, y, dx, dy, reach):
    cells = (np.frombuffer(data, np.uint8).reshape(8, 8) < 10).astype(np.uint8)
    ends = (x, y, x + dx, y + dy)
    free = geometry.window_is_free(masks(cells), reach, ends)
    assert free == plain(geometry.window_is_free)(masks(cells), reach, ends)
    if free:
        assert not geometry.segment_first_not_clear(cells, 1, reach * reach, reach, ends)[0]


def test_a_window_is_free_up_to_the_contact():
    cells = np.zeros((8, 8), np.uint8)
    cells[:, 5] = 1
    near, reach = masks(cells), 700
    at = 5 * UNIT - reach
    assert geometry.window_is_free(near, reach, (at - 300, 4 * UNIT, at, 4 * UNIT))
    assert not geometry.window_is_free(near, reach, (at - 300, 4 * UNIT, at + 1, 4 * UNIT))


@given(ROOM, st.lists(st.tuples(st.integers(0, 7), st.integers(0, 7), st.integers(0, 2)), max_size=12))
def test_masks_that_follow_events_are_those_of_the_cells(data, events):
    cells = (np.frombuffer(data, np.uint8).reshape(8, 8) % 3).astype(np.uint8)
    near = masks(cells)
    for ix, iy, state in events:
        cells[iy, ix] = state
        geometry.mark_near(cells, near, ix, iy)
    assert (near == masks(cells)).all()
