"""The swept model is checked by an independent referee.

At every pose and along every segment the disc is clear.
"""

import math
from fractions import Fraction

import numpy as np
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.referee import referee, referee_bodies
from tests.helpers.core_parts import pose_is_clear, segment_first_not_clear, swept_move
from worldgen.lattice import UNIT, clear_distance_sq
from worldgen.timeline import CellState

SOLID = int(CellState.SOLID)

SIDE = 10
RADII = st.fractions(Fraction(1, 20), Fraction(5, 2), max_denominator=20)


@st.composite
def rooms(draw):
    """Cells, some of them solid, the disc's radius in cells, and a clear lattice pose."""
    cells = np.frombuffer(draw(st.binary(min_size=SIDE * SIDE, max_size=SIDE * SIDE)), np.uint8)
    cells = (cells.reshape(SIDE, SIDE) < draw(st.sampled_from([10, 40, 80]))).astype(np.uint8)
    radius = draw(RADII)
    x, y = draw(st.integers(0, SIDE * UNIT)), draw(st.integers(0, SIDE * UNIT))
    low, high = max(0, (y - 3 * UNIT) // UNIT), (y + 3 * UNIT) // UNIT + 1
    cells[low:high, max(0, (x - 3 * UNIT) // UNIT) : (x + 3 * UNIT) // UNIT + 1] &= draw(
        st.integers(0, 1)
    )
    return cells, radius, x, y


def numbers(radius):
    clear_sq = clear_distance_sq(radius)
    return clear_sq, math.isqrt(clear_sq - 1) + 1


def solid_union(cells):
    outside = shapely.box(-9 * UNIT, -9 * UNIT, (SIDE + 9) * UNIT, (SIDE + 9) * UNIT)
    hole = shapely.box(0, 0, SIDE * UNIT, SIDE * UNIT)
    boxes = [
        shapely.box(ix * UNIT, iy * UNIT, (ix + 1) * UNIT, (iy + 1) * UNIT)
        for iy, ix in np.argwhere(cells)
    ]
    return shapely.union_all([outside.difference(hole), *boxes])


@settings(max_examples=150)
@given(
    rooms(),
    st.lists(
        st.tuples(st.integers(-9000, 9000), st.integers(-9000, 9000)), min_size=1, max_size=20
    ),
)
def test_no_segment_of_a_swept_move_cuts_a_wall(room, moves):
    cells, radius, x, y = room
    clear_sq, reach = numbers(radius)
    if not pose_is_clear(cells, SOLID, clear_sq, reach, x, y):
        return
    walls, chain = solid_union(cells), np.zeros((4, 3), np.int64)
    for dx, dy in moves:
        count, _, _ = swept_move(cells, clear_sq, reach, (x, y, dx, dy), (0.0, 1.0), 0.0, chain, 0)
        path = [(x, y), *map(tuple, chain[:count, :2].tolist())]
        x, y = path[-1]
        line = shapely.LineString(path) if count else shapely.Point(path[0])
        assert line.distance(walls) >= float(radius) * UNIT - 1e-6


@settings(max_examples=150)
@given(rooms(), st.integers(-9000, 9000), st.integers(-9000, 9000))
def test_a_segment_that_shapely_calls_clear_is_clear(room, dx, dy):
    cells, radius, x, y = room
    clear_sq, reach = numbers(radius)
    if not pose_is_clear(cells, SOLID, clear_sq, reach, x, y):
        return
    ours = not segment_first_not_clear(cells, SOLID, clear_sq, reach, (x, y, x + dx, y + dy))[0]
    line = shapely.LineString([(x, y), (x + dx, y + dy)]) if dx or dy else shapely.Point(x, y)
    gap = line.distance(solid_union(cells)) - math.sqrt(clear_sq)
    if abs(gap) > 1e-6:  # at smaller distances, GEOS's own rounding decides
        assert ours == (gap > 0)


def test_the_disc_slides_along_a_flat_wall_without_losing_way():
    cells = np.zeros((SIDE, SIDE), np.uint8)
    cells[5, :] = 1
    clear_sq, reach = numbers(Fraction(7, 10))
    chain = np.zeros((4, 3), np.int64)
    x, y = 2 * UNIT, 5 * UNIT - reach
    for _ in range(10):
        count, normal_x, normal_y = swept_move(
            cells, clear_sq, reach, (x, y, 200, 200), (0.0, 1.0), 0.0, chain, 0
        )
        x, y = chain[count - 1, :2].tolist()
        assert (normal_x, normal_y < 0) == (0.0, True)
    assert (x, y) == (2 * UNIT + 10 * 200, 5 * UNIT - reach)


def test_the_disc_passes_a_diagonal_gap_only_if_it_fits():
    cells = np.zeros((SIDE, SIDE), np.uint8)
    cells[4, :5] = 1
    cells[6:, 6] = 1
    cells[4, 6:] = 1
    moved = {}
    for tenths in (4, 6):
        clear_sq, reach = numbers(Fraction(tenths, 10))
        chain = np.zeros((4, 3), np.int64)
        x, y = 5 * UNIT + UNIT // 2, 3 * UNIT - 100
        count, _, _ = swept_move(
            cells, clear_sq, reach, (x, y, 0, 3 * UNIT), (0.0, 1.0), 0.0, chain, 0
        )
        moved[tenths] = (chain[count - 1, 1] if count else y) > 5 * UNIT
    assert moved == {4: True, 6: False}


def test_a_robot_wedged_in_a_corner_stays_there():
    cells = np.zeros((SIDE, SIDE), np.uint8)
    clear_sq, reach = numbers(Fraction(7, 10))
    chain = np.zeros((4, 3), np.int64)
    assert (
        swept_move(cells, clear_sq, reach, (reach, reach, -500, -300), (0.0, 1.0), 0.0, chain, 0)[0]
        == 0
    )


def test_a_very_long_move_stops_at_the_first_wall():
    cells = np.zeros((SIDE, 300), np.uint8)
    cells[:, 250] = 1
    clear_sq, reach = numbers(Fraction(7, 10))
    chain = np.zeros((4, 3), np.int64)
    count, _, _ = swept_move(
        cells, clear_sq, reach, (UNIT, 5 * UNIT, 299 * UNIT, 0), (0.0, 1.0), 0.0, chain, 0
    )
    assert (count, chain[0, :2].tolist()) == (1, [250 * UNIT - reach, 5 * UNIT])


def test_the_referee_of_the_benchmarks_objects_to_no_move():
    report = referee(4_000, 3)
    assert report.moves >= 4_000 and report.contacts > 1_000 and report.pieces > 3_000
    assert report.cuts == 0 and -1e-6 < report.deepest <= 1e-6


def test_the_referee_of_the_benchmarks_objects_to_no_move_or_turn_of_a_body():
    report = referee_bodies(1_000, 3)
    assert report.moves >= 1_000 and report.contacts > 500 and report.pieces > 10_000
    assert report.cuts == 0


def test_the_referee_would_object_to_bodies_that_are_a_lattice_unit_larger(monkeypatch):
    monkeypatch.setattr("benchmarks.referee.BODY_TOLERANCE", -1.0)
    assert referee_bodies(400, 3).cuts > 0
