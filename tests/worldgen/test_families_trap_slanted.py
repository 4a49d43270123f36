"""Other shapes of traps, and all shapes at any angle: closed,

as large as requested, between start and target.
"""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy import ndimage

from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter
from worldgen.families.builtin.trap import trap
from worldgen.families.parts.open_ground import in_sight
from worldgen.families.parts.raster import box, extents, fill, turned
from worldgen.family import stream_for
from worldgen.generation import generate
from worldgen.support.angles import SCALE, _sine

SEEDS = st.integers(0, 2**64 - 1)
SHAPES = st.sampled_from(["U", "L", "spiral", "V", "comb", "nested", "pair"])
FACES = st.sampled_from(["start", "target", "side"])
ANGLES = st.integers(0, 89)


def layout(seed=0, **params):
    return trap.build(stream_for(seed, "trap", 0), **trap.complete(params))


def obstacle(world):
    """Return the obstacle, cut out of the arena."""
    inside = world.walls[1:-1, 1:-1]
    rows, columns = np.flatnonzero(inside.any(axis=1)), np.flatnonzero(inside.any(axis=0))
    return inside[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]


def halves(world):
    return [(round(20 * point.x), round(20 * point.y)) for point in (world.start, world.target)]


@given(SEEDS, st.integers(2, 8), st.integers(2, 4), st.integers(1, 2), st.integers(1, 5))
def test_a_comb_has_its_teeth(seed, depth, mouth, thickness, teeth):
    world = layout(
        seed,
        size=50,
        shape="comb",
        depth=depth,
        mouth=mouth,
        thickness=thickness,
        parts=teeth,
        turn=0,
    )
    cells = obstacle(world)
    assert cells.shape == (teeth * thickness + (teeth + 1) * mouth, thickness + depth)
    assert cells[:, :thickness].all() and ndimage.label(cells[:, thickness:])[1] == teeth


@given(SEEDS, st.integers(2, 5), st.integers(2, 4), st.integers(1, 2), st.integers(1, 3))
def test_nested_traps_lie_in_each_other(seed, depth, mouth, thickness, levels):
    world = layout(
        seed,
        size=60,
        shape="nested",
        depth=depth,
        mouth=mouth,
        thickness=thickness,
        parts=levels,
        turn=0,
    )
    cells = obstacle(world)
    middle = cells[len(cells) // 2]
    walls = ndimage.label(middle)[1]
    assert walls == levels and ndimage.label(cells)[1] == levels
    assert cells.shape == (
        mouth + 2 * thickness + 2 * (levels - 1) * (thickness + mouth),
        len(middle),
    )


@given(SEEDS, st.integers(2, 8), st.integers(2, 6), st.integers(1, 2))
def test_a_pair_is_two_of_a_size_one_beside_and_behind_the_other(seed, depth, mouth, thickness):
    world = layout(
        seed, size=60, shape="pair", depth=depth, mouth=mouth, thickness=thickness, turn=0
    )
    labels, count = ndimage.label(world.walls[1:-1, 1:-1])
    rear, front = sorted(ndimage.find_objects(labels), key=lambda piece: piece[1].start)
    assert count == 2 and front[1].start - rear[1].stop == mouth
    assert {piece[0].stop - piece[0].start for piece in (rear, front)} == {mouth + 2 * thickness}
    assert abs(front[0].start - rear[0].start) == (mouth + 2 * thickness) // 2


@given(SEEDS, st.integers(2, 12), st.integers(2, 12), st.integers(1, 2))
def test_a_v_is_pointed_and_closed(seed, depth, mouth, thickness):
    cells = obstacle(
        layout(seed, size=50, shape="V", depth=depth, mouth=mouth, thickness=thickness, turn=0)
    )
    assert ndimage.label(cells)[1] == 1
    gaps = [np.diff(np.flatnonzero(column)).max() - 1 for column in cells.T if column.sum() > 1]
    assert gaps[0] < gaps[-1] and gaps[-1] >= mouth  # becomes wider towards its mouth


@given(SEEDS, SHAPES, st.integers(1, 89), st.sampled_from([1, 2]))
def test_a_slanted_wall_has_no_hole(seed, shape, angle, thickness):
    world = layout(seed, size=60, shape=shape, angle=angle, thickness=thickness)
    straight = layout(seed, size=100, shape=shape, thickness=thickness)
    pieces = [ndimage.label(obstacle(each))[1] for each in (world, straight)]
    assert shape == "nested" or pieces[0] == pieces[1]
    assert pieces[0] <= 6


@pytest.mark.gate
@given(SEEDS, SHAPES, st.integers(1, 89), st.sampled_from([0.02, 0.07, 0.13, 0.2]))
def test_a_robot_in_a_slanted_hollow_gets_out(seed, shape, angle, robot_radius):
    params = {
        "size": 90,
        "shape": shape,
        "angle": angle,
        "robot_radius": robot_radius,
        "inside": True,
    }
    assert np.array_equal(generate("trap", seed, **params).walls, layout(seed, **params).walls)


@given(SEEDS, SHAPES, FACES, ANGLES, st.booleans())
def test_the_obstacle_bars_the_straight_way(seed, shape, faces, angle, inside):
    assume(not (inside and faces == "target") and not (shape == "pair" and faces == "side"))
    world = layout(seed, size=44, shape=shape, faces=faces, angle=angle, inside=inside)
    assert not in_sight(world.walls, *halves(world))


@pytest.mark.gate
@given(SEEDS, SHAPES, FACES, ANGLES, st.integers(20, 50), st.sampled_from([0.02, 0.07, 0.1]))
@settings(max_examples=80)
def test_no_slanted_trap_needs_a_second_attempt(seed, shape, faces, angle, size, robot_radius):
    params = {
        "shape": shape,
        "faces": faces,
        "angle": angle,
        "size": size,
        "robot_radius": robot_radius,
    }
    assert np.array_equal(generate("trap", seed, **params).walls, layout(seed, **params).walls)


def test_an_angle_left_to_the_family_is_drawn():
    assert (
        len(
            {
                obstacle(layout(seed, angle=-1, depth=6, mouth=6, turn=0)).tobytes()
                for seed in range(30)
            }
        )
        > 20
    )


@pytest.mark.parametrize("shape", ["V", "comb", "nested", "pair"])
def test_a_square_of_16_cells_has_room_for_every_shape(shape):
    assert generate("trap", 1, size=16, shape=shape).width == 16


@pytest.mark.parametrize("shape", ["V", "comb", "nested", "pair"])
def test_a_square_too_small_is_told(shape):
    with raises(InvalidParameter, "no-room", size=10):
        layout(size=10, shape=shape, mouth=4)


@pytest.mark.parametrize("degrees", range(91))
def test_sines_are_rounded_to_the_last_unit(degrees):
    assert abs(_sine(degrees) - math.sin(math.radians(degrees)) * SCALE) < 0.51


@given(st.integers(1, 20), st.integers(1, 20), st.integers(-360, 360), st.integers(-9, 9))
def test_a_turned_box_keeps_its_area_and_its_extents(width, height, degrees, shift):
    polygon = turned(box(shift, shift, shift + width, shift + height), degrees)
    cells = fill([polygon])
    assert width * height * 0.8 - 4 <= cells.sum() <= (width + 1.5) * (height + 1.5)
    assert all(
        found <= most for found, most in zip(cells.shape[::-1], extents([polygon]), strict=True)
    )


@pytest.mark.parametrize("quarters", range(4))
def test_quarter_turns_of_boxes_are_exact(quarters):
    cells = fill([turned(box(0, 0, 5, 2), 90 * quarters)])
    assert cells.all() and sorted(cells.shape) == [2, 5]
