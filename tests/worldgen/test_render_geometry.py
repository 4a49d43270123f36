"""Outlines, pixels' shares, and drawn lines."""

import io
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from worldgen.render.caption import BAR, scale_bar
from worldgen.render.coverage import coverage
from worldgen.render.outline import corner_count, outlines
from worldgen.render.polyline import arc_length, arrow_places, corners, dashes, simplified
from worldgen.render.sheet import Panel, draw_sheet
from worldgen.world import Pose, Target, World


@st.composite
def masks(draw):
    height, width = draw(st.integers(1, 9)), draw(st.integers(1, 9))
    bits = draw(st.lists(st.booleans(), min_size=height * width, max_size=height * width))
    return np.array(bits).reshape(height, width)


def filled(lines, shape):
    """Even-odd fill: a cell is set if an odd number of horizontal edges is below its middle."""
    mask = np.zeros(shape, bool)
    for line in lines:
        for (x, y), (other_x, other_y) in zip(line, np.roll(line, -1, axis=0), strict=True):
            assert (x == other_x) != (y == other_y)
            if y == other_y:
                mask[y:, min(x, other_x) : max(x, other_x)] ^= True
    return mask


@given(masks())
def test_outlines_filled_by_the_even_odd_rule_are_the_cells(mask):
    lines = outlines(mask)
    assert np.array_equal(filled(lines, mask.shape), mask)
    assert sum(map(len, lines)) == corner_count(mask)


def test_a_rectangle_has_one_outline_of_four_corners():
    mask = np.zeros((5, 5), bool)
    mask[1:4, 2:4] = True
    assert [sorted(map(tuple, line.tolist())) for line in outlines(mask)] == [
        [(2, 1), (2, 4), (4, 1), (4, 4)]
    ]


@given(masks(), st.integers(1, 4))
def test_pixels_that_fit_the_cells_are_all_or_nothing_and_top_row_first(mask, scale):
    height, width = mask.shape
    shares = coverage(mask, width * scale, height * scale)
    assert np.array_equal(
        shares, np.kron(mask[::-1], np.ones((scale, scale), np.uint8)) * np.uint8(255)
    )


@given(masks())
def test_one_pixel_has_the_share_of_all_cells(mask):
    assert coverage(mask, 1, 1)[0, 0] == pytest.approx(255 * mask.mean(), abs=0.51)


def test_pixels_that_cut_cells_get_a_part():
    assert coverage(np.array([[True, False, False]]), 2, 1).tolist() == [[170, 0]]


coordinates = st.floats(-100.0, 100.0).map(lambda value: round(value, 3))
lines = st.lists(st.tuples(coordinates, coordinates), min_size=1, max_size=60).map(np.array)


def distance_to_line(point, line):
    if len(line) == 1:
        return float(np.hypot(*(point - line[0])))
    gaps = []
    for a, b in pairwise(line):
        square = float((b - a) @ (b - a))
        share = min(1.0, max(0.0, float((point - a) @ (b - a)) / square)) if square else 0.0
        gaps.append(float(np.hypot(*(point - a - share * (b - a)))))
    return min(gaps)


@given(lines, st.floats(0.01, 10.0))
def test_a_thinned_line_stays_within_the_tolerance(line, tolerance):
    thin = simplified(line, tolerance)
    assert all(distance_to_line(point, thin) <= tolerance + 1e-9 for point in line)
    assert np.array_equal(thin[0], line[0])
    assert np.array_equal(thin[-1], line[-1])


def test_a_bend_is_kept_if_it_is_further_than_the_tolerance():
    bend = np.array([[0.0, 0.0], [5.0, 1.5], [10.0, 0.0]])
    assert len(simplified(bend, 1.4)) == 3
    assert len(simplified(bend, 1.6)) == 2


def test_a_straight_line_is_thinned_to_its_ends():
    line = np.column_stack((np.linspace(0.0, 9.0, 1000), np.linspace(0.0, 3.0, 1000)))
    assert np.allclose(simplified(line, 0.01), [[0.0, 0.0], [9.0, 3.0]])


@given(lines.filter(lambda line: len(line) > 1))
def test_dashes_cover_their_share_of_the_line(line):
    total = float(arc_length(line)[-1])
    drawn = sum(float(arc_length(piece)[-1]) for piece in dashes(line, (3.0, 2.0)))
    assert drawn == pytest.approx(3.0 * (total // 5.0) + min(3.0, total % 5.0), abs=1e-6)


def test_heads_point_along_the_line_and_keep_off_each_other():
    there_and_back = np.array([[0.0, 0.0], [100.0, 0.0], [0.0, 0.0]])
    places = arrow_places(there_and_back, 50.0, 5.0)
    xs = sorted(x for x, _, _ in places)
    assert {round(angle, 6) for _, _, angle in places} == {0.0, round(np.pi, 6)}
    assert min(np.diff(xs)) > 12.0


def test_heads_avoid_corners():
    corner = np.array([[0.0, 0.0], [50.0, 0.0], [50.0, 50.0]])
    ((x, y, _),) = arrow_places(corner, 100.0, 5.0)
    assert abs(x - 50.0) + abs(y) >= 5.0


def test_corners_are_where_a_line_turns():
    line = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.1], [2.0, 1.0]])
    assert corners(line).tolist() == [[2.0, 0.1]]


@pytest.mark.parametrize("exponent", range(-12, 13))
def test_a_scale_bar_is_round_and_takes_a_seventh_to_a_third_of_the_width(exponent):
    width = 1.7**exponent
    bar = scale_bar(BAR * width)
    assert width / 7.2 <= bar <= 0.35 * width
    assert f"{bar:e}"[0] in "125" and float(f"{bar:.0e}") == bar


def test_the_scale_bar_of_a_sheet_covers_nothing_of_the_map():
    """The rim of solid ground below the map is whole, and the bar is below it."""
    world = World(np.zeros((6, 6), bool), Pose(0.15, 0.15), Target(0.45, 0.45, 0.05))
    sheet = Image.open(io.BytesIO(draw_sheet([Panel(world, "w", ())], []))).convert("L")
    dark = np.asarray(sheet) < 100
    rim = np.flatnonzero(dark.sum(axis=1) > 250)
    bar = np.flatnonzero(dark[rim.max() + 1 :].any(axis=1))
    assert dark[rim.max()].sum() == dark[rim.min()].sum()
    assert bar.size > 5
