"""A body against cells: the core's tests, with their error bounds, and whole numbers agree exactly."""

import itertools

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from benchmarks.referee import random_body
from sim.runners.core_calls import headings
from tests.helpers.core_parts import (
    body_first_not_clear,
    body_is_clear,
    clear_turn,
    footprint_of,
    swept_body_move,
)
from tests.reference.sim import polygon
from worldgen.lattice import TURN, UNIT
from worldgen.random_streams import RandomStream

SIDE = 9
SOLID = 1
TABLE = headings().tolist()


@st.composite
def rooms(draw):
    """Cells, a body, and a pose; many poses touch a wall exactly."""
    cells = np.frombuffer(draw(st.binary(min_size=SIDE * SIDE, max_size=SIDE * SIDE)), np.uint8)
    cells = (cells.reshape(SIDE, SIDE) < draw(st.sampled_from([4, 12, 40]))).astype(np.uint8)
    body = random_body(RandomStream(draw(st.integers(0, 2**32))))
    heading = draw(st.integers(0, TURN - 1) | st.sampled_from([0, 8192, 16384, 32768, 49152]))
    corner = draw(st.sampled_from(polygon.turned(TABLE, body, heading)))
    x, y = draw(st.integers(-UNIT, (SIDE + 1) * UNIT)), draw(st.integers(-UNIT, (SIDE + 1) * UNIT))
    if draw(st.booleans()):
        # A corner is on a line between two columns, or as near to it as a lattice point is.
        x = x // UNIT * UNIT - corner[0] // polygon.SCALE + draw(st.integers(-1, 1))
    return cells, body, (x, y, heading)


@settings(max_examples=300)
@given(rooms(), st.integers(-3000, 3000), st.integers(-3000, 3000))
def test_a_pose_and_a_move_are_clear_as_in_whole_numbers(room, dx, dy):
    cells, body, (x, y, heading) = room
    placed = polygon.turned(TABLE, body, heading)
    footprint = footprint_of(body)
    for ends in ((x, y, x, y), (x, y, x + dx, y + dy), (x, y, x + dx, y)):
        found = body_first_not_clear(cells, footprint, ends, heading)
        assert found == polygon.first_not_clear(cells, SOLID, placed, ends)


@settings(max_examples=150)
@given(rooms(), st.integers(-400, 400))
@example(
    (np.zeros((SIDE, SIDE), np.uint8), ((-UNIT, -1), (UNIT, -1), (UNIT, 1)), (UNIT, UNIT, 0)), 9
)
def test_a_turn_passes_every_heading_and_stops_at_the_last_clear_one(room, turn):
    cells, body, pose = room
    if body_is_clear(cells, footprint_of(body), *pose):
        made, _ = polygon.clear_turn(cells, TABLE, tuple(body), pose, turn)
        assert clear_turn(cells, footprint_of(body), pose, turn) == made


@settings(max_examples=150)
@given(rooms(), st.integers(-5000, 5000), st.integers(-5000, 5000))
def test_every_piece_of_a_move_is_clear_in_whole_numbers(room, dx, dy):
    cells, body, (x, y, heading) = room
    if not body_is_clear(cells, footprint_of(body), x, y, heading):
        return
    placed = polygon.turned(TABLE, body, heading)
    chain = np.zeros((4, 3), np.int64)
    count, nx, ny = swept_body_move(cells, footprint_of(body), heading, (x, y, dx, dy), chain)
    path = [(x, y), *map(tuple, chain[:count, :2].tolist())]
    for (px, py), (qx, qy) in itertools.pairwise(path):
        assert not polygon.first_not_clear(cells, SOLID, placed, (px, py, qx, qy))[0]
    is_free = not polygon.first_not_clear(cells, SOLID, placed, (x, y, x + dx, y + dy))[0]
    assert is_free == ((nx, ny) == (0.0, 0.0)) or (dx, dy) == (0, 0)
    if is_free and (dx, dy) != (0, 0):
        assert path[-1] == (x + dx, y + dy)


def corridor(width):
    """Return free rows between solid ones."""
    cells = np.ones((width + 2, 40), np.uint8)
    cells[1:-1] = 0
    return cells


BOX = ((-2 * UNIT, -UNIT), (2 * UNIT, -UNIT), (2 * UNIT, UNIT), (-2 * UNIT, UNIT))


def test_a_box_slides_along_a_wall_without_losing_way():
    cells = corridor(4)
    chain = np.zeros((4, 3), np.int64)
    x, y = 5 * UNIT, 2 * UNIT
    for _ in range(10):
        count, nx, ny = swept_body_move(cells, footprint_of(BOX), 0, (x, y, 300, -200), chain)
        x, y = chain[count - 1, :2].tolist()
        assert nx == 0.0 and ny > 0.0
    assert (x, y) == (5 * UNIT + 10 * 300, 2 * UNIT)


@pytest.mark.parametrize(("rows", "goes"), [(2, True), (1, False)])
def test_a_box_as_wide_as_a_passage_fits_exactly(rows, goes):
    cells = corridor(rows)
    middle = (rows + 2) * UNIT // 2
    if goes:
        chain = np.zeros((4, 3), np.int64)
        ends = (5 * UNIT, middle, 20 * UNIT, 0)
        count, _, _ = swept_body_move(cells, footprint_of(BOX), 0, ends, chain)
        assert chain[count - 1, 0] == 25 * UNIT
        assert clear_turn(cells, footprint_of(BOX), (5 * UNIT, middle, 0), 300) == 0
    else:
        assert not body_is_clear(cells, footprint_of(BOX), 5 * UNIT, middle, 0)


def test_a_bar_turns_until_its_corner_is_at_the_wall():
    cells = corridor(3)
    bar = ((-2 * UNIT, -10), (2 * UNIT, -10), (2 * UNIT, 10), (-2 * UNIT, 10))
    turned = clear_turn(cells, footprint_of(bar), (9 * UNIT, 5 * UNIT // 2, 0), 32_767)
    # sin(a) * 2 cells + cos(a) * 10 units = 1.5 cells
    assert 2.0 * np.sin(turned * 2 * np.pi / TURN) + 10 / 1024 * np.cos(
        turned * 2 * np.pi / TURN
    ) == (pytest.approx(1.5, abs=2e-4))
