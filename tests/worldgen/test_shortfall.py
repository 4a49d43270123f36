"""Pictures of a robot that repeats itself show how near it gets to its target, and what is between."""

import dataclasses

import numpy as np
import pytest

from worldgen import Event, Pose, Target, Timeline, Witness, World
from worldgen.render import Frame, Trail, draw_svg
from worldgen.render.marks import MARKS
from worldgen.render.scene import card_content, card_parts
from worldgen.render.shortfall import shortfall_of
from worldgen.render.shortfall_parts import barred_parts
from worldgen.timeline import CellState


def room(*solid, target=(1.55, 0.55), **changes):
    walls = np.zeros((11, 20), bool)
    for ix, iy in solid:
        walls[iy, ix] = True
    world = World(walls, Pose(0.35, 0.55), Target(*target, 0.05))
    return dataclasses.replace(world, **changes)


def back_and_forth(**changes):
    """From the start to the right and back, forever; nearest to the target at (0.95, 0.55)."""
    trail = Trail([0.35, 0.55, 0.95, 0.55], [0.55, 0.55, 0.55, 0.55], 1)
    return dataclasses.replace(trail, **changes)


def test_without_a_wall_in_between_the_rest_of_the_way_is_measured():
    short = shortfall_of(room(), back_and_forth())
    assert short.row == 2 and short.contact is None
    assert short.distance == pytest.approx(0.6 - 0.05)
    assert ">0.55 m<" in draw_svg(room(), trail=back_and_forth())


def test_a_wall_in_between_stops_the_robot_where_its_rim_touches_it():
    short = shortfall_of(room((12, 5)), back_and_forth())
    # Its radius is 0.07 m, and the wall begins at 1.2 m.
    assert short.end[0] == pytest.approx(1.13, abs=0.01)
    assert short.contact == pytest.approx((1.2, 0.55))


def test_a_key_explains_only_the_one_of_both_marks_that_is_in_the_picture():
    marks = MARKS["short"].label, MARKS["barred"].label
    for world, shown in ((room(), marks[0]), (room((12, 5)), marks[1])):
        text = draw_svg(world, trail=back_and_forth())
        assert [words for words in marks if words in text] == [shown]


def test_an_arrow_from_the_robot_ends_at_the_wall_that_stops_it_in_the_middle_of_a_bar():
    # Its disc meets the corner of the cell, which is not straight ahead.
    world = room((12, 6), target=(1.55, 0.58))
    content = card_content(world, back_and_forth(), Frame.of(world, 400))
    line, *_, bar = barred_parts(content, MARKS["barred"])
    start, contact = content.frame.points([content.shortfall.place, content.shortfall.contact])
    assert line.points == pytest.approx(np.array((start, contact)))
    assert bar.points.mean(axis=0) == pytest.approx(contact)


def test_words_hide_no_part_of_a_small_robot_and_its_target():
    # Above and below the line between them, the distance's words would be on both.
    assert hidden_by_words(room(target=(1.15, 0.55)), back_and_forth()) == 0


@pytest.mark.parametrize("x", [1.4, 1.5])
def test_words_of_a_cell_that_changes_hide_no_part_of_the_target(x):
    # They would be on the cell's right, where the target is.
    change = Timeline.of([Event(1.3, 12, 4, CellState.SOLID)])
    assert hidden_by_words(room(target=(x, 0.45), timeline=change), back_and_forth()) == 0


def hidden_by_words(world, trail):
    """Return how many of the robot, where it is nearest, and its target are partly under words."""
    content = card_content(world, trail, Frame.of(world, 400))
    card_parts(content)
    assert content.words
    nearest = trail.points[content.shortfall.row]
    target = world.target
    places = content.frame.points(np.array((nearest, (target.x, target.y))))
    reach = np.array((content.robot(0).radius, target.radius)) * content.frame.scale
    hidden = 0
    for low, high in content.words:
        gaps = np.linalg.norm(np.clip(places, low, high) - places, axis=1)
        hidden += int((gaps < reach - 0.1).sum())
    return hidden


def test_a_wall_that_comes_later_is_in_between_and_one_that_goes_is_not():
    comes = Timeline.of([Event(1.0, 12, 5, CellState.SOLID)])
    goes = Timeline.of([Event(1.0, 12, 5, CellState.FREE)])
    assert shortfall_of(room(timeline=comes), back_and_forth()).contact is not None
    assert shortfall_of(room((12, 5), timeline=goes), back_and_forth()).contact is None


def test_a_target_at_a_wall_is_not_behind_it():
    # The disc cannot be at the target's middle, but it can be in it.
    world = room(target=(1.55, 0.02), certificate=None)
    assert shortfall_of(world, back_and_forth()).contact is not None
    proof = Witness(np.array([0.0, 5.0]), np.array([0.35, 1.55]), np.array([0.55, 0.07]), 0.0)
    reached = dataclasses.replace(world, certificate=proof)
    assert shortfall_of(reached, back_and_forth()).contact is None


@pytest.mark.parametrize(
    "trail",
    [back_and_forth(loop_from=None), back_and_forth(missed=np.zeros((11, 20), bool))],
    ids=["a run that ends", "a coverage task"],
)
def test_other_runs_have_none(trail):
    assert shortfall_of(room(), trail) is None


def test_a_robot_that_passes_through_its_target_has_none():
    assert shortfall_of(room(target=(0.75, 0.55)), Trail([0.35, 0.75], [0.55, 0.55], 0)) is None


def test_a_run_that_reaches_nothing_new_shows_that_without_a_proof():
    svg = draw_svg(room(), trail=back_and_forth(loop_from=None, stays_from=1))
    assert "second half of the run: nothing new" in svg and "repeated forever" not in svg


@pytest.mark.parametrize(
    ("state", "walls", "words"),
    [
        (CellState.SOLID, (), "wall at 1.3 s"),
        (CellState.BURNING, (), "fire at 1.3 s"),
        (CellState.FREE, ((12, 8),), "free at 1.3 s"),
    ],
)
def test_cells_that_change_say_what_they_become_and_when(state, walls, words):
    world = room(*walls, timeline=Timeline.of([Event(1.26, 12, 8, state)]))
    assert f">{words}<" in draw_svg(world)
