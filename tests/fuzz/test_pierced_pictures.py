"""Walls that a robot enters, and no others, are red in every picture of its run."""

import io
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from sim import simulate
from sim.drawing.picture import drive_of, trail_of
from sim.drawing.wall_penetrations import penetrated_cells
from worldgen.files.grid import read_world
from worldgen.render import Frame, draw_gif, draw_png, draw_svg
from worldgen.render.marks import MARKS, hue, rgb
from worldgen.world import Pose, Target, World

CORPORA = Path(__file__).parents[2] / "corpora"
FAULTS = CORPORA / "thesis-faults"
CAUGHT = CORPORA / "failures" / "bug2" / "swept" / "caught-by-a-change.grid"


def room(speed):
    walls = np.zeros((10, 14), np.bool_)
    walls[2:8, 7] = True
    return World(walls, Pose(0.25, 0.45, 0.0), Target(1.25, 0.45, 0.1), robot_speed=speed)


def slide():
    world = read_world(FAULTS / "thesis-2-slide.grid")
    return world, simulate(
        world, world.failure.controller, motion="stepped", steps=3000, record=True
    )


def fast():
    world = room(20.0)
    return world, simulate(world, "turn-left", motion="endpoint", steps=300, record=True)


def decoded(picture):
    return np.asarray(picture.convert("RGB"), np.int64)


def red(pixels):
    """Return the row and column of the pixels that have the colour of entered walls."""
    return np.argwhere(np.abs(pixels - rgb(hue("pierced"))).max(axis=2) < 12)


@pytest.mark.gate
@pytest.mark.parametrize("run", [slide, fast])
def test_a_png_s_red_is_in_and_around_the_cell_that_the_verdict_names(run):
    world, episode = run()
    assert episode.verdict in ("tunnel", "overlap")
    (named,) = [cell for cell in penetrated_cells(episode, world) if cell.place]
    assert (named.ix, named.iy) == episode.evidence.cell
    frame, places = (
        Frame.of(world),
        red(decoded(Image.open(io.BytesIO(draw_png(world, trail=trail_of(episode, world)))))),
    )
    column, row = frame.to_pixels(
        (named.ix + 0.5) * world.cell_size, (named.iy + 0.5) * world.cell_size
    )
    inside = np.abs(places - (row, column)).max(axis=1) <= frame.cell / 2
    assert inside.sum() > 0.15 * frame.cell**2


@pytest.mark.parametrize("run", [slide, fast])
def test_an_svg_has_stripes_a_frame_for_each_wall_and_a_cross(run):
    world, episode = run()
    text = draw_svg(world, trail=trail_of(episode, world))
    assert f'fill="{hue("pierced")}"/></pattern>' in text
    assert (
        len(re.findall(f'<polygon [^>]*stroke="{hue("pierced")}"', text))
        == len(penetrated_cells(episode, world)) + 1
    )  # a key
    assert MARKS["pierced"].label in text


def test_a_cell_that_catches_the_robot_has_no_stripes_and_a_key_of_its_own():
    world = read_world(CAUGHT)
    episode = simulate(world, world.failure.controller, steps=3000, record=True)
    assert episode.verdict == "burned"
    text = draw_svg(world, trail=trail_of(episode, world))
    assert f'fill="{hue("pierced")}"/></pattern>' not in text
    assert len(re.findall(f'<polygon [^>]*stroke="{hue("pierced")}"', text)) == 2  # one is a key
    assert MARKS["caught"].label in text and MARKS["pierced"].label not in text


@pytest.mark.gate
@pytest.mark.parametrize("run", [slide, fast])
def test_a_gif_s_walls_turn_red_when_the_robot_goes_in(run):
    world, episode = run()
    picture = Image.open(io.BytesIO(draw_gif(world, [drive_of(episode, world)])))
    counts = []
    for k in (0, picture.n_frames - 1):
        picture.seek(k)
        counts.append(len(red(decoded(picture))))
    assert counts[0] == 0 and counts[1] > 100


def test_a_robot_that_keeps_out_of_walls_marks_none():
    world = room(2.0)
    episode = simulate(world, "turn-left", steps=300, record=True)
    assert episode.collisions and penetrated_cells(episode, world) == []
    assert (
        len(red(decoded(Image.open(io.BytesIO(draw_png(world, trail=trail_of(episode, world)))))))
        == 0
    )


def test_every_wall_that_the_centre_jumps_over_is_among_them():
    walls = np.zeros((10, 14), np.bool_)
    walls[2:8, 6:8] = True
    world = World(walls, Pose(0.25, 0.45, 0.0), Target(1.25, 0.45, 0.1), robot_speed=60.0)
    episode = simulate(world, "turn-left", motion="endpoint", steps=300, record=True)
    assert {(6, 4), (7, 4)} <= {(cell.ix, cell.iy) for cell in penetrated_cells(episode, world)}
