"""A census: the questions about every map, the paths of a point on the grid, and the counts."""

from collections import deque
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from benchmarks.census_questions import CensusOptions, Radius, counts, take_census
from benchmarks.foreign_maps import CensusMap, cell_ends, draw_ends, folder_maps
from benchmarks.grid_planners import InflationPlanners
from tests.helpers.foreign_maps import GAP, solid, write_each_kind
from worldgen.random_streams import RandomStream
from worldgen.support.rows import flip_rows
from worldgen.world import World

HALF, WIDER, WHOLE = Radius(0.5, True), Radius(0.7, True), Radius(1.0, True)
FOUR = ((0, 1), (1, 0), (0, -1), (-1, 0))
EIGHT = (*FOUR, (1, 1), (1, -1), (-1, 1), (-1, -1))


def rows_map(*rows, start=None, target=None, name="m"):
    """A drawing, top row first; start and target as (row, column) in it."""
    ends = ()
    if start is not None:
        cells = [(column, len(rows) - 1 - row) for row, column in (start, target)]
        ends = (cell_ends(*cells, 0.1),)
    return CensusMap(name, flip_rows(solid(rows)), 0.1, ends)


def asked(item, *radii, **options):
    return take_census([item], CensusOptions(radii, **options))


def one(item, radius):
    (question,) = asked(item, radius).questions
    return question


@st.composite
def questions(draw):
    """A small map, two of its cells, a radius in tenths of a cell."""
    shape = draw(st.tuples(st.integers(2, 7), st.integers(2, 7)))
    walls = draw(hnp.arrays(np.bool_, shape))
    start, target = (
        (draw(st.integers(0, shape[1] - 1)), draw(st.integers(0, shape[0] - 1))) for _ in range(2)
    )  # fmt: skip
    walls[start[::-1]] = walls[target[::-1]] = False
    item = CensusMap("m", walls, 0.1, (cell_ends(start, target, 0.1),))
    return item, Radius(draw(st.integers(1, 20)) / 10, True)


def flooded(free, start, target, moves):
    """Return whether moves over free cells lead from one to the other: a minimal planner."""
    seen, left = {start}, deque([start] if free[start] else [])
    while left:
        row, column = left.popleft()
        for by_row, by_column in moves:
            cell = row + by_row, column + by_column
            inside = all(0 <= index < side for index, side in zip(cell, free.shape, strict=True))
            if inside and cell not in seen and free[cell]:
                seen.add(cell)
                left.append(cell)
    return target in seen and bool(free[start])


def inflated(walls, blocks):
    """Return the free cells that no solid cell, or cell of the ring outside, is near enough to
    block.
    """
    padded = np.pad(walls, 1, constant_values=True)
    solid_cells = np.argwhere(padded) - 1
    free = np.zeros_like(walls)
    for cell in np.ndindex(walls.shape):
        free[cell] = not any(
            blocks(abs(cell[0] - row), abs(cell[1] - column)) for row, column in solid_cells
        )
    return free


@given(questions())
def test_planners_on_the_grid_say_what_plain_floods_say(question):
    item, radius = question
    cells = Fraction(str(radius.value))
    given_ends = item.ends[0]
    start, target = (
        (int(end.y / 0.1), int(end.x / 0.1)) for end in (given_ends.start, given_ends.target)
    )  # fmt: skip
    circle = inflated(item.walls, lambda down, across: down**2 + across**2 <= cells**2)
    square = inflated(item.walls, lambda down, across: max(down, across) <= -(-cells // 1))
    found = one(item, radius)
    assert found.four == flooded(~item.walls, start, target, FOUR)
    assert found.eight == flooded(~item.walls, start, target, EIGHT)
    metres = radius.metres(0.1)
    world = World(item.walls, given_ends.start, given_ends.target, 0.1, robot_radius=metres)
    assert InflationPlanners(item.walls).answers(world) == (
        flooded(circle, start, target, EIGHT),
        flooded(square, start, target, FOUR),
    )


@given(questions())
def test_every_answer_is_proved_and_no_disc_passes_where_a_point_does_not(question):
    found = one(*question)
    assert found.proved
    if found.result == "reachable":
        assert found.room and found.four


@given(questions())
def test_up_to_half_a_cell_a_disc_passes_exactly_where_a_point_with_four_moves_does(question):
    item, _ = question
    found = one(item, HALF)
    assert (found.result == "reachable") == found.four


@given(questions())
def test_what_a_disc_reaches_a_smaller_one_reaches_too(question):
    item, radius = question
    smaller, larger = asked(item, Radius(radius.value / 2, True), radius).questions
    assert smaller.result == "reachable" or larger.result == "blocked"


CASES = [
    ("a gap of one cell stops a wider disc", GAP, (3, 1), (3, 7), 0.7, (True, True, True)),
    ("a gap of one cell lets half a cell through", GAP, (3, 2), (3, 6), 0.5, None),
    (
        "touching corners let a point through, no disc",
        (".#", "#."),
        (0, 0),
        (1, 1),
        0.1,
        (True, False, True),
    ),
]


@pytest.mark.parametrize(
    ("rows", "start", "target", "cells", "expected"),
    [case[1:] for case in CASES],
    ids=[case[0] for case in CASES],
)
def test_a_world_that_only_the_grid_passes_is_told_apart(rows, start, target, cells, expected):
    found = one(rows_map(*rows, start=start, target=target), Radius(cells, True))
    if expected is None:
        assert found.result == "reachable" and not found.grid_only
    else:
        assert (found.grid_only, found.four, found.eight) == expected


def test_a_disc_without_room_at_the_start_is_blocked_there():
    found = one(
        rows_map("#####", "#...#", "#...#", "#...#", "#####", start=(1, 1), target=(2, 2)), WIDER
    )
    assert found.result == "blocked" and not found.room and found.grid_only


def test_every_kind_of_map_in_a_folder_gives_the_known_counts(tmp_path):
    write_each_kind(tmp_path)
    census = take_census(folder_maps([tmp_path]), CensusOptions((HALF, WIDER)))
    assert census.maps == 5 and not census.refused
    named = [question for question in census.questions if question.named]
    assert [question.map for question in named[::2]] == ["drawn.txt", "octile.map", "ours.grid"]
    narrow, wide = (
        counts([one for one in census.questions if one.asked == radius]) for radius in (HALF, WIDER)
    )
    assert narrow["reachable"] == 5
    assert wide["four_only"] == wide["blocked"] >= 3
    # The start touches the wall.
    assert sum(question.grid_only and question.room for question in named) == 0


def test_equal_seeds_draw_equal_ends_and_other_seeds_others():
    item = rows_map(*GAP)
    drawn = [draw_ends(item, 20, RandomStream(seed), None) for seed in (1, 1, 2)]
    assert drawn[0] == drawn[1] != drawn[2]
    assert all(ends.start.x != ends.target.x or ends.start.y != ends.target.y for ends in drawn[0])


def test_drawn_ends_can_be_asked_to_give_the_largest_disc_room():
    found = asked(rows_map(*GAP), HALF, WIDER, pairs=20, clear_ends=True).questions
    assert len(found) == 40 and all(question.room for question in found)


def test_what_is_drawn_on_a_map_does_not_depend_on_the_other_maps():
    first, second = rows_map(*GAP, name="a"), rows_map(*GAP, name="b")
    options = CensusOptions((HALF,))
    both, alone = take_census([first, second], options), take_census([second], options)
    assert [question for question in both.questions if question.map == "b"] == alone.questions


def test_a_map_without_room_is_refused_and_the_next_one_judged():
    full, hall = rows_map("#.", "##", name="full"), rows_map(*GAP)
    census = take_census([full, hall], CensusOptions((HALF,)))
    assert [refused.name for refused in census.refused] == ["full"] and census.maps == 1
    assert asked(hall, Radius(9.0, True), clear_ends=True).refused
