"""The frames of an animated GIF."""

import dataclasses
import io

import numpy as np
import pytest
from PIL import Image

from tests.helpers.raising import raises
from worldgen.errors import InvalidParameter
from worldgen.render import Drive, Frame, Trail, draw_gif
from worldgen.render.animation import DEFAULT_SIDE, MOST_FRAMES
from worldgen.render.marks import MARKS, hue, mix, rgb
from worldgen.timeline import CellState, Event, Timeline
from worldgen.world import Pose, Target, World


def world(**changes):
    walls = np.zeros((12, 20), bool)
    walls[2:5, 10] = True
    return dataclasses.replace(
        World(walls, Pose(0.35, 0.35, 0.0), Target(1.75, 0.95, 0.05)), **changes
    )


def eastwards(steps=40, loop_from=None):
    """From x = 0.35 to 1.55 m at y = 0.75 m, one step per second."""
    times = np.arange(steps + 1.0)
    trail = Trail(0.35 + 1.2 * times / steps, np.full(steps + 1, 0.75), loop_from)
    return Drive("east", trail, times, np.zeros(steps + 1), 1.0)


def frames(data):
    picture = Image.open(io.BytesIO(data))
    for k in range(picture.n_frames):
        picture.seek(k)
        yield np.asarray(picture.convert("RGB"), np.int64)


def at(frame, x, y):
    column, row = Frame.of(world(), DEFAULT_SIDE).to_pixels(x, y)
    return tuple(frame[int(row), int(column)])


def near(colour, other):
    return max(abs(a - b) for a, b in zip(colour, rgb(other), strict=True)) <= 12


def test_the_robot_moves_and_leaves_its_trail():
    first, *_, last = frames(draw_gif(world(), [eastwards()]))
    robot = mix(hue("floor"), hue("loop"), 0.35)
    assert near(at(first, 0.33, 0.78), robot) and near(at(last, 1.53, 0.78), robot)
    assert near(at(first, 0.95, 0.75), hue("floor")) and near(at(last, 0.95, 0.75), hue("loop"))
    assert near(at(first, 1.05, 0.35), hue("wall"))


def test_a_cell_burns_when_the_world_says_so():
    line = Timeline.of([Event(20.0, 15, 2, CellState.BURNING), Event(30.0, 15, 2, CellState.FREE)])
    shown = list(frames(draw_gif(world(timeline=line), [eastwards()])))
    flames = mix(hue("floor"), hue("fire"), MARKS["fire"].fill)
    assert [near(at(shown[k], 1.55, 0.25), flames) for k in (10, 25, 35)] == [False, True, False]


@pytest.mark.gate
def test_the_same_runs_give_the_same_bytes_of_bounded_size():
    runs = [eastwards(5000), eastwards(700)]
    data = draw_gif(
        world(),
        runs,
        title="two robots, with a title that is far too long for one line of the picture",
    )
    assert data == draw_gif(
        world(),
        runs,
        title="two robots, with a title that is far too long for one line of the picture",
    )
    assert len(list(frames(data))) == MOST_FRAMES and len(data) < 500_000


def test_a_loop_that_is_over_goes_round_again():
    drive = eastwards(loop_from=20)
    assert [drive.moment(time) for time in (15.0, 40.0, 45.0, 65.0)] == [15.0, 40.0, 25.0, 25.0]
    assert eastwards().moment(65.0) == 40.0


@pytest.mark.gate
def test_a_short_loop_after_a_long_way_is_shown_once_more_in_a_third_of_the_frames():
    shown = list(frames(draw_gif(world(), [eastwards(4000, loop_from=3900)])))
    robot = mix(hue("floor"), hue("loop"), 0.35)
    assert len(shown) == MOST_FRAMES
    assert all(near(at(frame, 1.535, 0.78), robot) for frame in shown[MOST_FRAMES * 2 // 3 :])


def test_times_that_do_not_fit_and_no_robot_at_all_are_refused():
    with raises(InvalidParameter, "wrong-length", times=3, points=41, headings=41):
        dataclasses.replace(eastwards(), times=np.arange(3.0))
    with raises(InvalidParameter, "empty"):
        draw_gif(world(), [])
