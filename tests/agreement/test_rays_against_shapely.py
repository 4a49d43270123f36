"""Range beams and lines of sight against shapely, and against the functions they were compiled
from.
"""

import math

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tests.helpers.core_parts import (
    beam_heading,
    heading_table,
    ray_distance,
    smoke_on_the_way,
    walls_on_the_way,
)
from tests.reference.sim.layout import TURN, UNIT

SIDE = 8
HEADINGS = heading_table()
FREE_PLACE = st.tuples(st.integers(0, SIDE * UNIT - 1), st.integers(0, SIDE * UNIT - 1))
ROUND = st.integers(0, TURN - 1) | st.sampled_from([k * TURN // 8 for k in range(8)])


def plain(kernel):
    return getattr(kernel, "py_func", kernel)


@st.composite
def rooms(draw):
    cells = np.frombuffer(draw(st.binary(min_size=SIDE * SIDE, max_size=SIDE * SIDE)), np.uint8)
    return (cells.reshape(SIDE, SIDE) < draw(st.sampled_from([5, 40, 90]))).astype(np.uint8)


def boxes(cells):
    padded = np.pad(cells, 1, constant_values=1)
    return [
        shapely.box((ix - 1) * UNIT, (iy - 1) * UNIT, ix * UNIT, iy * UNIT)
        for iy, ix in np.argwhere(padded)
    ]


@pytest.mark.gate
@settings(max_examples=200)
@given(rooms(), FREE_PLACE, ROUND, st.floats(0.5, 12.0))
def test_a_beam_is_as_long_as_shapely_says(cells, place, heading, cells_far):
    x, y = place
    cells[y // UNIT, x // UNIT] = 0
    assume(shapely.union_all(boxes(cells)).distance(shapely.Point(x, y)) > 1)
    longest = cells_far * UNIT
    found = ray_distance(cells, HEADINGS, x, y, heading, longest)
    assert found == plain(ray_distance)(cells, HEADINGS, x, y, heading, longest)
    angle = heading / TURN * 2 * math.pi
    ray = shapely.LineString(
        [(x, y), (x + longest * math.cos(angle), y + longest * math.sin(angle))]
    )
    inner = [
        box.buffer(-1e-3, join_style="mitre") for box in boxes(cells)
    ]  # a ray does not hit cells that it only grazes
    outer = [box.buffer(1e-3, join_style="mitre") for box in boxes(cells)]
    nearest, farthest = (
        min(
            (
                shapely.Point(x, y).distance(ray.intersection(box))
                for box in grown
                if ray.intersects(box)
            ),
            default=longest,
        )
        for grown in (outer, inner)
    )
    assert nearest - 1e-2 <= found <= farthest + 1e-2


@given(rooms(), FREE_PLACE, st.integers(0, TURN - 1))
def test_a_beam_that_goes_through_no_corner_agrees_to_a_billionth_of_a_millimetre(
    cells, place, heading
):
    x, y = place
    cells[y // UNIT, x // UNIT] = 0
    angle = heading / TURN * 2 * math.pi
    far = 20.0 * UNIT
    ray = shapely.LineString([(x, y), (x + far * math.cos(angle), y + far * math.sin(angle))])
    walls = shapely.union_all(boxes(cells))
    corners = shapely.MultiPoint(
        [(i * UNIT, j * UNIT) for i in range(SIDE + 1) for j in range(SIDE + 1)]
    )
    assume(ray.distance(corners) > 1e-3 and walls.distance(shapely.Point(x, y)) > 1)
    metres = 0.1 / UNIT
    expected = shapely.Point(x, y).distance(ray.intersection(walls)) * metres
    assert abs(ray_distance(cells, HEADINGS, x, y, heading, far) * metres - expected) <= 1e-12


def test_a_beam_of_a_hundred_metres_is_right_to_a_billionth_of_a_metre():
    side = 1000
    cells = np.zeros((side, side), np.uint8)
    for k in range(2000):
        x, y, heading = (
            1 + 511 * k % (side * UNIT - 1),
            1 + 977 * k % (side * UNIT - 1),
            37 * k % TURN,
        )
        along, across = (
            math.cos(heading / TURN * 2 * math.pi),
            math.sin(heading / TURN * 2 * math.pi),
        )
        ways = [
            ((side * UNIT if step > 0 else 0) - at) / step
            for at, step in ((x, along), (y, across))
            if abs(step) > 1e-9
        ]
        assert (
            abs(ray_distance(cells, HEADINGS, x, y, heading, 1e9) - min(ways)) * 0.1 / UNIT <= 1e-9
        )


def test_a_beam_does_not_pass_between_two_cells_that_touch_at_a_corner():
    cells = np.zeros((SIDE, SIDE), np.uint8)
    cells[4, 3] = cells[3, 4] = 1
    start = (int(3.5 * UNIT), int(3.5 * UNIT))
    assert ray_distance(cells, HEADINGS, *start, TURN // 8, 9999.0) == pytest.approx(
        UNIT / 2 * 2**0.5, abs=1e-12
    )
    cells[4, 3] = 0
    assert ray_distance(cells, HEADINGS, *start, TURN // 8, 3000.0) == 3000.0


def test_beams_are_spread_over_their_field():
    assert [beam_heading(100, k, 4, float(TURN)) for k in range(4)] == [
        100 + k * TURN // 4 for k in range(4)
    ]
    assert [beam_heading(0, k, 3, TURN / 2) for k in range(3)] == [-TURN // 4, 0, TURN // 4]
    assert beam_heading(7, 0, 1, TURN / 2) == 7


@given(rooms(), FREE_PLACE, FREE_PLACE)
def test_walls_on_the_way_are_the_cells_whose_inside_the_line_meets(cells, one, other):
    found = walls_on_the_way(cells, *one, *other)
    assert found == plain(walls_on_the_way)(cells, *one, *other)
    line = shapely.LineString([one, other]) if one != other else shapely.Point(one)
    ends = {(x // UNIT, y // UNIT) for x, y in (one, other)}
    solid = [(ix, iy) for iy, ix in np.argwhere(cells) if (ix, iy) not in ends]
    grid = [shapely.box(ix * UNIT, iy * UNIT, (ix + 1) * UNIT, (iy + 1) * UNIT) for ix, iy in solid]
    sure = sum(
        line.intersection(box.buffer(-1e-3, join_style="mitre")).length > 1e-2 for box in grid
    )
    possible = sum(line.intersects(box.buffer(1e-3, join_style="mitre")) for box in grid)
    assert sure <= found <= possible


@given(rooms(), FREE_PLACE, FREE_PLACE, st.integers(0, 3))
def test_smoke_on_the_way_is_in_the_cells_near_flames_whose_inside_the_line_meets(
    cells, one, other, reach
):
    cells *= 2  # they burn
    found = smoke_on_the_way(cells, *one, *other, reach)
    assert found == plain(smoke_on_the_way)(cells, *one, *other, reach)
    line = shapely.LineString([one, other]) if one != other else shapely.Point(one)
    fires = np.argwhere(cells)
    smoky = [
        cell
        for cell in np.ndindex(cells.shape)
        if len(fires) and np.abs(fires - cell).max(axis=1).min() <= reach
    ]
    ends = {(y // UNIT, x // UNIT) for x, y in (one, other)}
    grid = [shapely.box(ix * UNIT, iy * UNIT, (ix + 1) * UNIT, (iy + 1) * UNIT) for iy, ix in smoky]
    inside = [
        line.intersection(box.buffer(-1e-3, join_style="mitre")).length > 1e-2 for box in grid
    ]
    sure = sum(meets or cell in ends for cell, meets in zip(smoky, inside, strict=True))
    assert (
        sure <= found <= sum(line.intersects(box.buffer(1e-3, join_style="mitre")) for box in grid)
    )


@given(rooms(), FREE_PLACE, FREE_PLACE)
def test_flames_that_reach_nowhere_and_walls_are_counted_alike_between_the_ends(cells, one, other):
    ends = {(y // UNIT, x // UNIT) for x, y in (one, other)}
    at_ends = sum(int(cells[end]) for end in ends)
    assert (
        smoke_on_the_way(cells * 2, *one, *other, 0)
        == walls_on_the_way(cells, *one, *other) + at_ends
    )
