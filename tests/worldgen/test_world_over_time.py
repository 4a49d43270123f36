"""Questions about a world's cells over time."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.raising import raises
from worldgen.errors import InvalidWorld
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
        (
            1.0,
            [[0, 0, 0], [0, 0, 1]],
        ),  # if two events have the same cell and time, the later one counts
        (2.0, [[0, 0, 0], [0, 0, 0]]),
        (9.0, [[0, 0, 0], [0, 0, 0]]),
    ],
)
def test_cells_at_a_time_are_what_the_events_until_then_left(time, states):
    assert WORLD.cells_at(time).tolist() == states


def test_cells_before_the_first_event_are_the_walls():
    assert np.array_equal(WORLD.cells_at(-1.0) == CellState.SOLID, WALLS)


def test_a_timeline_marks_the_cells_that_become_one_of_some_states():
    assert np.argwhere(LINE.cells_that_become(CellState.SOLID, shape=WALLS.shape)).tolist() == [
        [0, 1]
    ]
    both = LINE.cells_that_become(CellState.FREE, CellState.BURNING, shape=WALLS.shape)
    assert np.argwhere(both).tolist() == [[0, 1], [1, 2]]
    assert np.array_equal(LINE.cells_that_become(shape=WALLS.shape), both)


def test_a_timeline_keeps_only_the_events_asked_for():
    events = list(LINE)
    assert list(LINE.only(np.array([True, False, False, True]))) == [events[0], events[3]]
    assert list(LINE.until(1.0)) == events[:3] and list(LINE.after(1.0)) == events[3:]
    assert list(LINE.until(0.9)) == events[:1] and list(LINE.after(0.0)) == events[1:]
    assert list(LINE.in_cell(1, 0)) == events[:3] and not LINE.in_cell(0, 1)
    assert list(LINE.without(1)) == [events[0], *events[2:]] and not LINE.without(0, 9)


def test_a_timeline_and_its_columns_are_the_same():
    assert Timeline(*LINE.columns) == LINE == Timeline.of(LINE)


def test_an_event_can_be_moved_in_time_but_not_beyond_its_neighbours():
    assert [event.time for event in LINE.with_time(1, 0.5)] == [0.0, 0.5, 1.0, 2.0]
    with raises(InvalidWorld, "not-sorted"):
        LINE.with_time(1, 1.5)


def test_events_move_with_their_cells():
    turned = LINE.moved(lambda ix, iy: (1 - iy, ix))
    assert [(event.ix, event.iy) for event in turned] == [(1, 1), (1, 1), (1, 1), (0, 2)]
    assert np.array_equal(turned.times, LINE.times) and np.array_equal(turned.states, LINE.states)


@given(st.data())
def test_events_disappear_with_rows_and_columns_and_move_up_behind_them(data):
    cells = data.draw(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 4))))
    line = Timeline.of([(float(k), *cell, CellState.SOLID) for k, cell in enumerate(cells)])
    axis = data.draw(st.sampled_from([0, 1]))
    first = data.draw(st.integers(0, 4 + axis))
    count = data.draw(st.integers(1, 5 + axis - first))
    # Deleting rows or columns from the grid of marks is the same as deleting them from the events.
    marked = np.delete(line.cells_that_become(shape=(5, 6)), np.s_[first : first + count], axis)
    left = line.without_cells(first, count, axis)
    assert np.array_equal(left.cells_that_become(shape=marked.shape), marked)


def test_spans_say_how_long_each_cell_is_in_which_state():
    walls = np.array([[False, True, False], [False, False, True]])
    spans = zip(*(column.tolist() for column in LINE.spans(walls)), strict=True)
    assert list(spans) == [
        (1, -np.inf, 0.0, CellState.SOLID),
        (1, 0.0, 1.0, CellState.BURNING),
        (1, 1.0, np.inf, CellState.FREE),  # if two events have the same time, the later one counts
        (5, -np.inf, 2.0, CellState.SOLID),
        (5, 2.0, np.inf, CellState.FREE),
    ]


@given(
    st.lists(
        st.tuples(
            st.sampled_from([0.0, 0.5, 1.0, 2.0]),
            st.integers(0, 2),
            st.integers(0, 1),
            st.sampled_from(list(CellState)),
        )
    ),
    st.sampled_from([0.0, 0.25, 0.5, 1.5, 2.0, 9.0]),
)
def test_the_spans_at_a_time_are_the_cells_at_that_time(events, time):
    world = replace(WORLD, timeline=Timeline.of(events))
    cells, since, until, states = world.timeline.spans(world.walls)
    now = (since <= time) & (time < until)
    seen = world.walls.astype(int)
    seen.ravel()[cells[now]] = states[now]
    assert np.array_equal(seen, world.cells_at(time))
    assert np.array_equal(np.unique(cells), np.flatnonzero(world.changing_cells))


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
