"""Corridors with a plan, narrow places, and widths in robot widths."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from tests.helpers.raising import check_says, raises
from worldgen.errors import GenerationFailed, InvalidParameter
from worldgen.families.builtin.corridor import corridor
from worldgen.families.parts.open_ground import in_sight
from worldgen.family import stream_for
from worldgen.generation import generate
from worldgen.reach import decide

SEEDS = st.integers(0, 2**64 - 1)
PLANS = st.sampled_from(["S", "T", "X", "tunnel"])
THIN = {"robot_radius": 0.05, "width": 1}  # corridors one cell wide, so that cells can be counted


def layout(seed=0, **params):
    return corridor.build(stream_for(seed, "corridor", 0), **corridor.complete(params))


def degrees(world):
    """Return for each free cell how many of its four neighbours are free, in a corridor one cell
    wide.
    """
    free = ~world.walls
    return np.where(
        free, sum(np.roll(free, shift, axis) for shift in (1, -1) for axis in (0, 1)), 0
    )


def corners(world):
    """Return free cells with exactly one free neighbour in x and one in y."""
    free = ~world.walls
    beside = [sum(np.roll(free, shift, axis).astype(int) for shift in (1, -1)) for axis in (0, 1)]
    return int((free & (beside[0] == 1) & (beside[1] == 1)).sum())


@given(SEEDS, st.integers(1, 25), st.integers(30, 60))
def test_an_s_has_its_bends_and_no_side_way(seed, bends, size):
    world = layout(seed, shape="S", bends=bends, size=size, **THIN)
    assert (
        corners(world) == bends and (degrees(world) == 1).sum() == 2 and degrees(world).max() == 2
    )


@given(SEEDS, st.integers(1, 12), st.integers(30, 60))
def test_a_t_corridor_has_its_junctions_each_with_a_blind_arm(seed, branches, size):
    world = layout(seed, shape="T", branches=branches, size=size, **THIN)
    assert (degrees(world) == 3).sum() == branches and (degrees(world) == 1).sum() == branches + 2


@given(SEEDS, st.integers(1, 8), st.integers(30, 60))
def test_crossing_corridors_all_cross(seed, branches, size):
    world = layout(seed, shape="X", branches=branches, size=size, **THIN)
    assert (degrees(world) == 4).sum() == branches**2 and (
        degrees(world) == 1
    ).sum() == 4 * branches


@given(SEEDS, st.integers(14, 60))
def test_a_tunnel_is_one_long_way(seed, size):
    world = layout(seed, shape="tunnel", size=size, **THIN)
    assert (degrees(world) == 1).sum() == 2 and degrees(world).max() == 2
    assert (~world.walls).sum() > size * size / 8


@pytest.mark.parametrize("shape", ["S", "T", "X"])
@pytest.mark.parametrize("lines", [3, 4, 5, 8, 13])
def test_the_most_that_is_allowed_fits(shape, lines):
    most = {
        "S": {"bends": 2 * lines - 3},
        "T": {"branches": lines - 2},
        "X": {"branches": lines - 2},
    }[shape]
    for seed in range(5):
        assert generate("corridor", seed, shape=shape, size=max(10, 3 * lines + 1), **most)


@given(SEEDS, PLANS, st.integers(10, 60))
def test_start_and_target_are_out_of_sight(seed, shape, size):
    world = layout(seed, shape=shape, size=size)
    ends = [(round(20 * point.x), round(20 * point.y)) for point in (world.start, world.target)]
    assert not in_sight(world.walls, *ends)


@given(
    SEEDS, PLANS, st.integers(10, 60), st.sampled_from([0.03, 0.05, 0.07, 0.1]), st.integers(-1, 0)
)
@settings(max_examples=40)
def test_no_planned_corridor_needs_a_second_attempt(seed, shape, size, robot_radius, necks):
    params = {
        "shape": shape,
        "size": size,
        "robot_radius": robot_radius,
        "necks": necks,
        "robot_widths": 2.0,
    }
    try:
        first = layout(seed, **params)
    except InvalidParameter as refusal:
        check_says(refusal, "no-room")
        assert size < 20
        return
    assert np.array_equal(generate("corridor", seed, **params).walls, first.walls)


@given(SEEDS, st.sampled_from(["bends", "S", "tunnel"]), st.integers(2, 3), st.integers(1, 4))
def test_a_narrow_place_is_as_narrow_and_as_long_as_asked(seed, shape, neck, length):
    params = {"shape": shape, "size": 60, "width": 5}
    plain = layout(seed, **params)
    filled = layout(seed, necks=-1, neck=neck, neck_length=length, **params).walls & ~plain.walls
    spans = [
        (rows.stop - rows.start, columns.stop - columns.start)
        for rows, columns in ndimage.find_objects(ndimage.label(filled)[0])
    ]
    assert all(length in span for span in spans)
    assert filled.sum() % ((5 - neck) * length) == 0 and filled.any()


def test_as_many_narrow_places_as_asked():
    for necks in (1, 2, 4):
        plain = layout(3, shape="S", size=60, width=4)
        narrowed = layout(3, shape="S", size=60, width=4, necks=necks, neck=2)
        assert (narrowed.walls & ~plain.walls).sum() == 2 * necks


def test_narrow_places_bar_a_wider_robot():
    for shape in ("S", "tunnel", "bends"):
        world = layout(5, shape=shape, size=60, width=5, necks=-1, neck=3)
        assert (
            decide(world, radius=0.15).result == "reachable"
            and decide(world, radius=0.16).result == "blocked"
        )


@pytest.mark.parametrize(("widths", "cells"), [(1.0, 2), (1.5, 3), (2.0, 3), (3.0, 5)])
def test_a_width_in_widths_of_the_robot_is_rounded_up(widths, cells):
    for shape in ("bends", "S", "X"):
        given_in_cells = layout(4, shape=shape, width=cells, size=40)
        assert np.array_equal(
            layout(4, shape=shape, robot_widths=widths, size=40).walls, given_in_cells.walls
        )


@pytest.mark.parametrize(
    ("params", "expected"),
    [
        ({"shape": "Z"}, {"code": "unknown-name", "name": "shape", "value": "Z"}),
        (
            {"shape": "S", "branches": 2},
            {"code": "no-effect", "name": "branches", "value": 2, "setting": "shape=S"},
        ),
        (
            {"shape": "T", "bends": 2},
            {"code": "no-effect", "name": "bends", "value": 2, "setting": "shape=T"},
        ),
        (
            {"shape": "tunnel", "bends": 2},
            {"code": "no-effect", "name": "bends", "value": 2, "setting": "shape=tunnel"},
        ),
        (
            {"shape": "tunnel", "branches": 2},
            {"code": "no-effect", "name": "branches", "value": 2, "setting": "shape=tunnel"},
        ),
        (
            {"shape": "S", "bends": 16},
            {"code": "out-of-range", "name": "bends", "value": 16, "high": 15},
        ),
        (
            {"shape": "X", "branches": 0},
            {"code": "out-of-range", "name": "branches", "low": 1, "high": 7},
        ),
        ({"shape": "T", "width": 13}, {"code": "no-room", "shape": "T", "lines": 2}),
        ({"robot_widths": 0.5}, {"code": "out-of-range", "name": "robot_widths", "value": 0.5}),
        (
            {"robot_widths": 2.0, "width": 3},
            {"code": "no-effect", "name": "width", "value": 3, "setting": "robot_widths=2"},
        ),
        ({"robot_widths": 500.0}, {"code": "no-room", "width": 700, "wall": 1}),
        ({"necks": -2}, {"code": "out-of-range", "name": "necks", "value": -2, "high": 1000}),
        ({"necks": 2}, {"code": "above-maximum", "neck": 2, "width": 2}),
        (
            {"necks": 2, "width": 4, "neck": 1},
            {"code": "narrower-than-robot", "name": "neck", "width": 1},
        ),
        ({"neck": 2}, {"code": "no-effect", "name": "neck", "value": 2, "setting": "necks=0"}),
        (
            {"necks": 1, "width": 4, "neck_length": 0},
            {"code": "below-minimum", "name": "neck_length", "low": 1},
        ),
    ],
    ids=lambda value: str(value)[:30],
)
def test_bad_parameters_are_refused(params, expected):
    with raises(InvalidParameter, **expected):
        layout(**params)


def test_more_narrow_places_than_there_is_room_for_are_refused():
    with raises(GenerationFailed, "no-room", most=14, necks=50):
        layout(1, necks=50, width=4)
