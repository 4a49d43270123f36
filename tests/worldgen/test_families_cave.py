"""Caves: the robot can reach all floor, halls are connected, shapes differ, and all seeds work."""

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter
from worldgen.families.builtin.cave import cave
from worldgen.families.parts.open_ground import in_sight
from worldgen.family import stream_for
from worldgen.generation import generate

SEEDS = st.integers(0, 2**64 - 1)
SHAPES = st.sampled_from(["caverns", "columns", "galleries"])
ROCK = st.sampled_from([-1, 30, 45, 55, 65])
RADII = {0.05: 1, 0.07: 2, 0.13: 3, 0.2: 4}


def layout(seed=0, **params):
    return cave.build(stream_for(seed, "cave", 0), **cave.complete(params))


def pieces(cells):
    return ndimage.label(cells, np.ones((3, 3)))[1]


@given(SEEDS, SHAPES, st.integers(14, 70), ROCK, st.integers(0, 6), st.sampled_from(sorted(RADII)))
def test_every_free_cell_can_be_reached_by_the_robots_square(
    seed, shape, size, rock, rounds, robot_radius
):
    world = layout(
        seed, shape=shape, size=size, rock=rock, rounds=rounds, robot_radius=robot_radius
    )
    square = np.ones((RADII[robot_radius],) * 2)
    places = ndimage.binary_erosion(~world.walls, square)
    assert ndimage.label(places)[1] == 1
    assert np.array_equal(ndimage.binary_opening(~world.walls, square), ~world.walls)


@given(SEEDS, SHAPES, st.integers(12, 80))
def test_a_cave_spans_the_square(seed, shape, size):
    rows, columns = np.nonzero(~layout(seed, shape=shape, size=size).walls)
    assert np.ptp(rows) >= size // 3 and np.ptp(columns) >= size // 3


@given(
    SEEDS,
    SHAPES,
    st.integers(10, 60),
    ROCK,
    st.integers(-1, 5),
    st.sampled_from([0.02, 0.07, 0.1, 0.13]),
)
@settings(max_examples=40)
def test_no_cave_needs_a_second_attempt(seed, shape, size, rock, rounds, robot_radius):
    if size - 2 < 9 and robot_radius == 0.13:
        return
    params = {
        "shape": shape,
        "size": size,
        "rock": rock,
        "rounds": rounds,
        "robot_radius": robot_radius,
    }
    assert np.array_equal(generate("cave", seed, **params).walls, layout(seed, **params).walls)


def test_more_rock_leaves_less_floor():
    floors = [
        sum((~layout(seed, size=60, rock=rock).walls).sum() for seed in range(5))
        for rock in (35, 45, 52, 60)
    ]
    assert floors == sorted(floors, reverse=True)


def test_columns_stand_free_and_galleries_have_hardly_a_way_round():
    def standing(shape):
        return sum(pieces(layout(seed, shape=shape, size=80).walls) - 1 for seed in range(5))

    assert standing("columns") > 2 * standing("caverns") > 4 * standing("galleries")


def test_the_automaton_smooths_the_rock():
    def edge(rounds):
        walls = layout(1, size=80, rock=48, rounds=rounds, robot_radius=0.05).walls
        return (walls[1:] != walls[:-1]).sum() / (~walls).sum()

    assert edge(0) > edge(1) > edge(4)


def test_a_larger_grain_makes_wider_halls():
    widths = [
        ndimage.distance_transform_cdt(~layout(2, size=120, grain=grain).walls).max()
        for grain in (1, 3, 6)
    ]
    assert widths[0] < widths[1] < widths[2]


@pytest.mark.parametrize("shape", ["caverns", "columns", "galleries"])
def test_start_and_target_are_out_of_sight(shape):
    for seed in range(30):
        world = layout(seed, shape=shape)
        ends = [(round(20 * point.x), round(20 * point.y)) for point in (world.start, world.target)]
        assert not in_sight(world.walls, *ends)


@pytest.mark.gate
def test_a_small_cave_loads_nothing_heavy():
    code = (
        "import sys; from worldgen.generation import generate; generate('cave', 1, size=60); "
        "print([name for name in ('numba', 'scipy', 'shapely') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


@pytest.mark.parametrize(
    ("params", "expected"),
    [
        ({"shape": "mine"}, {"code": "unknown-name", "name": "shape", "value": "mine"}),
        ({"rock": 29}, {"code": "out-of-range", "name": "rock", "value": 29, "low": 30}),
        ({"rock": -2}, {"code": "out-of-range", "name": "rock", "value": -2, "low": 30}),
        ({"rounds": 51}, {"code": "out-of-range", "name": "rounds", "chosen": -1, "value": 51}),
        ({"grain": 0}, {"code": "below-minimum", "name": "grain", "chosen": -1, "low": 1}),
        ({"grain": 29}, {"code": "out-of-range", "name": "grain", "value": 29, "low": -1}),
        ({"robot_radius": 0.5}, {"code": "no-room", "size": 30, "least": 32, "robot_width": 10}),
    ],
    ids=lambda value: str(value)[:30],
)
def test_bad_parameters_are_refused(params, expected):
    with raises(InvalidParameter, **expected):
        layout(**params)


def test_the_least_size_that_the_message_names_works():
    assert generate("cave", 1, size=32, robot_radius=0.5).width == 32
