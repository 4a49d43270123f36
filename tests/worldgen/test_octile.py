"""Shortest octile paths, compared with a plain search that shares no code."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from tests.helpers.octile_twin import octile_length
from worldgen.interop.geometry.octile import octile_moves


def drawn(*rows):
    return np.array([[letter == "#" for letter in row] for row in rows])


def solve(walls, start, goal):
    return octile_moves(walls, start, goal) or (-1, -1)


@st.composite
def questions(draw):
    shape = draw(st.tuples(st.integers(1, 9), st.integers(1, 9)))
    walls = draw(hnp.arrays(bool, shape, elements=st.booleans(), fill=st.just(False)))
    cells = st.tuples(st.integers(0, shape[1] - 1), st.integers(0, shape[0] - 1))
    return walls, draw(cells), draw(cells)


@given(questions())
def test_the_path_is_as_long_as_a_plain_searchs(question):
    assert solve(*question) == octile_length(*question)


def test_a_diagonal_move_needs_both_cells_beside_it():
    assert solve(drawn("..", ".."), (0, 0), (1, 1)) == (0, 1)
    assert solve(drawn(".#", ".."), (0, 0), (1, 1)) == (2, 0)
    assert solve(drawn(".#", "#."), (0, 0), (1, 1)) == (-1, -1)


@pytest.mark.parametrize(("start", "goal"), [((0, 1), (1, 1)), ((1, 1), (0, 0)), ((1, 1), (1, 1))])
def test_an_end_in_a_wall_has_no_path(start, goal):
    walls = drawn("..", ".#")
    assert solve(walls, start, goal) == (-1, -1)


def test_walls_that_are_stored_by_columns_are_the_same_map():
    walls = np.zeros((4, 9), bool)
    walls[1:, 4] = True
    by_columns = np.asfortranarray(walls)
    assert solve(by_columns, (0, 3), (8, 3)) == solve(walls, (0, 3), (8, 3))
