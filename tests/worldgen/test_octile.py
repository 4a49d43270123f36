"""Shortest octile paths, against a plain search and against the benchmark's published lengths."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from tests.helpers.octile_twin import octile_length
from worldgen.interop.benchmark import octile
from worldgen.interop.benchmark.landmarks import landmark_distances, rounding
from worldgen.interop.benchmark.octile import OctileMap


def drawn(*rows):
    return np.array([[letter == "#" for letter in row] for row in rows])


def solve(walls, start, goal):
    return tuple(OctileMap(walls).lengths(np.array([start]), np.array([goal]))[0])


@st.composite
def questions(draw):
    shape = draw(st.tuples(st.integers(1, 9), st.integers(1, 9)))
    walls = draw(hnp.arrays(bool, shape, elements=st.booleans(), fill=st.just(False)))
    cells = st.tuples(st.integers(0, shape[1] - 1), st.integers(0, shape[0] - 1))
    return walls, draw(cells), draw(cells)


@given(questions())
def test_the_path_is_as_long_as_a_plain_searchs(question):
    assert solve(*question) == octile_length(*question)


@pytest.mark.gate
@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.1, 0.25, 0.35, 0.45]))
def test_many_questions_on_noise_are_answered_as_one_by_one(seed, density):
    rng = np.random.default_rng(seed)
    walls = rng.random((13, 17)) < density
    starts, goals = rng.integers(0, 13, (2, 8, 2))
    found = OctileMap(walls).lengths(starts, goals)
    expected = [
        octile_length(walls, tuple(a), tuple(b))
        for a, b in zip(starts.tolist(), goals.tolist(), strict=True)
    ]
    assert found.tolist() == [list(counts) for counts in expected]


@pytest.mark.parametrize(("seed", "density"), [(1, 0.25), (2, 0.4), (3, 0.05)])
def test_landmarks_change_no_length(monkeypatch, seed, density):
    rng = np.random.default_rng(seed)
    walls = rng.random((40, 50)) < density
    starts, goals = rng.integers(0, 40, (2, 200, 2))
    found = []
    for worth in (1e9, 0.0):
        monkeypatch.setattr(octile, "_WORTH", worth)
        found.append(OctileMap(walls).lengths(starts, goals))
    assert np.array_equal(*found)


def test_landmarks_are_far_apart_and_know_their_distances():
    walls = drawn(".....", ".###.", ".#.#.", ".....")
    asked = OctileMap(walls)
    distances = landmark_distances(asked._free, asked._steps, asked._free != 0, 2)
    for lengths in distances.T:
        mark = next(cell for cell in np.flatnonzero(asked._free) if lengths[cell] == 0.0)
        for cell in np.flatnonzero(asked._free).tolist():
            ends = [(int(at) % 7 - 1, int(at) // 7 - 1) for at in (mark, cell)]
            straight, diagonal = octile_length(walls, *ends)
            assert abs(straight + diagonal * math.sqrt(2.0) - lengths[cell]) <= rounding(distances)


def test_a_diagonal_move_needs_both_cells_beside_it():
    assert solve(drawn("..", ".."), (0, 0), (1, 1)) == (0, 1)
    assert solve(drawn(".#", ".."), (0, 0), (1, 1)) == (2, 0)
    assert solve(drawn(".#", "#."), (0, 0), (1, 1)) == (-1, -1)


@pytest.mark.parametrize(("start", "goal"), [((0, 1), (1, 1)), ((1, 1), (0, 0))])
def test_an_end_in_a_wall_has_no_path(start, goal):
    assert solve(drawn("..", ".#"), start, goal) == (-1, -1)


def test_walls_that_are_stored_by_columns_are_the_same_map():
    walls = np.zeros((4, 9), bool)
    walls[1:, 4] = True
    ends = (np.array([(0, 3)]), np.array([(8, 3)]))
    by_rows = OctileMap(walls).lengths(*ends)
    assert OctileMap(np.asfortranarray(walls)).lengths(*ends).tolist() == by_rows.tolist()
