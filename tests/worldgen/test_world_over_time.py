"""Questions about a world's cells over time."""

import numpy as np
import pytest

from worldgen.timeline import CellState, Timeline
from worldgen.world import Pose, Target, World

LINE = Timeline.of(
    [
        (0.0, 1, 0, CellState.BURNING),
        (1.0, 1, 0, CellState.SOLID),
        (1.0, 1, 0, CellState.FREE),
        (2.0, 2, 1, CellState.FREE),
    ]
)
WALLS = np.array([[False, False, False], [False, False, True]])
WORLD = World(WALLS, Pose(0.05, 0.05), Target(0.05, 0.15, 0.05), timeline=LINE)


@pytest.mark.parametrize(
    ("time", "states"),
    [
        (0.0, [[0, 2, 0], [0, 0, 1]]),
        (0.9, [[0, 2, 0], [0, 0, 1]]),
        (1.0, [[0, 0, 0], [0, 0, 1]]),  # of two events of one cell and time, the later one counts
        (2.0, [[0, 0, 0], [0, 0, 0]]),
        (9.0, [[0, 0, 0], [0, 0, 0]]),
    ],
)
def test_cells_at_a_time_are_what_the_events_until_then_left(time, states):
    assert WORLD.cells_at(time).tolist() == states


def test_cells_before_the_first_event_are_the_walls():
    assert np.array_equal(WORLD.cells_after(0) == CellState.SOLID, WALLS)


def test_a_timeline_marks_the_cells_that_become_one_of_some_states():
    assert np.argwhere(LINE.cells_that_become(CellState.SOLID, shape=WALLS.shape)).tolist() == [
        [0, 1]
    ]
    both = LINE.cells_that_become(CellState.FREE, CellState.BURNING, shape=WALLS.shape)
    assert np.argwhere(both).tolist() == [[0, 1], [1, 2]]
    assert np.array_equal(LINE.cells_that_become(shape=WALLS.shape), both)


def test_a_timeline_keeps_only_the_events_asked_for():
    assert list(LINE.only(LINE.times > 1.0)) == [(2.0, 2, 1, CellState.FREE)]


def test_the_last_time_is_0_where_nothing_changes():
    assert (LINE.last_time, Timeline().last_time) == (2.0, 0.0)


@pytest.mark.parametrize(
    ("width", "height", "within"), [(3, 2, True), (2, 2, False), (3, 1, False)]
)
def test_a_timeline_is_within_a_grid_that_has_all_its_cells(width, height, within):
    assert LINE.is_within(width, height) is within
    assert Timeline().is_within(1, 1)


def test_still_walls_are_the_solid_cells_without_an_event():
    walls = np.array([[True, False, False], [False, False, True]])
    world = World(walls, Pose(0.05, 0.15), Target(0.05, 0.15, 0.05), timeline=LINE)
    assert world.still_walls.tolist() == [[True, False, False], [False, False, False]]
