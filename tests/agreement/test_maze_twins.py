"""Mazes and their cells: plain Python and compiled code give the same bytes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from tests.helpers.tiers import some
from worldgen.families._mazes import FIT_ANY_SHAPE, METHODS, cells_of, grow, pitch, shape_mask
from worldgen.families._mazes.shapes import LEAST
from worldgen.random_streams import RandomStream

every_algorithm = pytest.mark.parametrize("algorithm", METHODS)
every_mask = pytest.mark.parametrize("mask", [name for name in LEAST if name != "square"])


def full(rows, columns):
    return np.ones((rows, columns), bool)


@pytest.mark.gate
@every_algorithm
@pytest.mark.parametrize(("columns", "rows"), some([(3, 40), (1, 1), (64, 65), (2, 2), (40, 3), (107, 141)], 3))
def test_a_compiled_maze_is_the_same_to_the_bit(algorithm, columns, rows):
    for seed in range(3):
        streams = RandomStream(seed), RandomStream(seed)
        plain = grow(streams[0], full(rows, columns), algorithm, oldest=0.25, compiled=False)
        compiled = grow(streams[1], full(rows, columns), algorithm, oldest=0.25, compiled=True)
        assert np.array_equal(plain, compiled)
        assert streams[0].next64() == streams[1].next64()


@pytest.mark.parametrize("algorithm", FIT_ANY_SHAPE)
@every_mask
def test_a_compiled_maze_in_a_shape_is_the_same_to_the_bit(algorithm, mask):
    inside = shape_mask(mask, 33)
    plain, compiled = (grow(RandomStream(4), inside, algorithm, compiled=twin) for twin in (False, True))
    assert np.array_equal(plain, compiled)


@given(
    links=hnp.arrays(np.int8, st.tuples(st.integers(1, 6), st.integers(1, 6)), elements=st.integers(0, 15)),
    wall=st.integers(1, 3),
    extra=st.integers(0, 3),
)
def test_compiled_cells_are_the_same(links, wall, extra):
    up, across = (pitch([1 + (extra >> (i % 2)) for i in range(count)], wall) for count in links.shape)
    plain, compiled = (cells_of(links, across, up, compiled=twin) for twin in (False, True))
    assert np.array_equal(plain, compiled)
