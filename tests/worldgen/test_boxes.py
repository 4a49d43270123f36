"""Merged boxes are compared with an exhaustive search."""

import functools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from worldgen.interop import export_world
from worldgen.interop.geometry.boxes import merged_boxes
from worldgen.timeline import CellState, Timeline
from worldgen.world import Pose, Target, World

SIDES = (5, 4)


def masks(height, width):
    bits = st.lists(st.booleans(), min_size=height * width, max_size=height * width)
    return bits.map(lambda values: np.array(values, np.bool_).reshape(height, width))


@functools.cache
def fewest(bits):
    """Return how many boxes cover the bits of a grid of ``SIDES``, each exactly once.

    Some box has the first cell as a corner.
    """
    width, height = SIDES
    if not bits:
        return 0
    first = (bits & -bits).bit_length() - 1
    y, x = divmod(first, width)
    best = width * height
    for right in range(x + 1, width + 1):
        for top in range(y + 1, height + 1):
            box = sum(1 << (iy * width + ix) for iy in range(y, top) for ix in range(x, right))
            if box & bits != box:
                break
            best = min(best, 1 + fewest(bits & ~box))
    return best


@settings(max_examples=150)
@given(masks(4, 5))
def test_no_other_way_has_fewer_boxes(solid):
    bits = sum(1 << index for index in np.flatnonzero(solid).tolist())
    assert len(merged_boxes(solid)) == fewest(bits)


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.3, 0.6, 0.9]))
def test_every_solid_cell_lies_in_one_box_and_no_free_one_does(seed, share):
    solid = np.random.Generator(np.random.PCG64(seed)).random((23, 31)) < share
    times = np.zeros(solid.shape, np.int64)
    boxes = merged_boxes(solid)
    for ix, iy, right, top in boxes.tolist():
        times[iy:top, ix:right] += 1
    assert np.array_equal(times, solid) and boxes.tolist() == sorted(
        boxes.tolist(), key=lambda box: (box[1], box[0])
    )


@given(st.integers(0, 2**32 - 1))
def test_a_transposed_world_has_as_many_boxes(seed):
    solid = np.random.Generator(np.random.PCG64(seed)).random((40, 30)) < 0.8
    assert len(merged_boxes(solid)) == len(merged_boxes(solid.T))


@pytest.mark.parametrize("name", ["geojson", "mjcf", "sdf"])
def test_a_border_that_opens_later_has_a_wall_round_it(name):
    walls = np.pad(np.zeros((2, 2), np.bool_), 1, constant_values=True)
    opens = Timeline.of([(1.0, 0, 1, CellState.FREE)])
    world = World(
        walls, Pose(0.15, 0.15), Target(0.25, 0.25, 0.05), robot_radius=0.04, timeline=opens
    )
    assert b"border" in export_world(world, name).data
    assert b"border" not in export_world(world, name, at=0.0).data
