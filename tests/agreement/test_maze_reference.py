"""Mazes and their cells: the C core gives the same bytes as plain Python."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from tests.helpers.tiers import some
from tests.reference.worldgen.mazes import grow as reference
from worldgen.families.parts.mazes import (
    CORNER,
    EAST,
    FIT_ANY_SHAPE,
    METHODS,
    NORTH,
    ROCK,
    cells_of,
    grow,
    pitch,
    shape_mask,
)
from worldgen.families.parts.mazes.shapes import LEAST
from worldgen.random_streams import RandomStream

every_algorithm = pytest.mark.parametrize("algorithm", METHODS)
every_mask = pytest.mark.parametrize("mask", [name for name in LEAST if name != "square"])


def full(rows, columns):
    return np.ones((rows, columns), bool)


@every_algorithm
@pytest.mark.parametrize(
    ("columns", "rows"), some([(3, 40), (1, 1), (64, 65), (2, 2), (40, 3), (107, 141)], 3)
)
def test_a_maze_is_that_of_the_reference_to_the_bit(algorithm, columns, rows):
    for seed in range(3):
        streams = RandomStream(seed), RandomStream(seed)
        plain = reference.grow(streams[0], full(rows, columns), algorithm, oldest=0.25)
        compiled = grow(streams[1], full(rows, columns), algorithm, oldest=0.25)
        assert np.array_equal(plain, compiled)
        assert streams[0].next64() == streams[1].next64()


@pytest.mark.parametrize("algorithm", FIT_ANY_SHAPE)
@every_mask
def test_a_maze_in_a_shape_is_that_of_the_reference_to_the_bit(algorithm, mask):
    inside = shape_mask(mask, 33)
    plain = reference.grow(RandomStream(4), inside, algorithm)
    assert np.array_equal(plain, grow(RandomStream(4), inside, algorithm))


def plan_of(links, across, up):
    """Return the cells of links, strip by strip."""
    plan = np.ones((len(up), len(across)), dtype=np.bool_)
    plan[1::2, 1::2] = links & ROCK
    plan[1::2, 2::2] = (links & EAST) == 0
    plan[2::2, 1::2] = (links & NORTH) == 0
    plan[2::2, 2::2] = (links & CORNER) == 0
    return plan.repeat(up, axis=0).repeat(across, axis=1)


@given(
    links=hnp.arrays(
        np.int8, st.tuples(st.integers(1, 6), st.integers(1, 6)), elements=st.integers(0, 15)
    ),
    wall=st.integers(1, 3),
    extra=st.integers(0, 3),
)
def test_cells_are_those_of_the_plan(links, wall, extra):
    up, across = (
        pitch([1 + (extra >> (i % 2)) for i in range(count)], wall) for count in links.shape
    )
    assert np.array_equal(cells_of(links, across, up), plan_of(links, across, up))
