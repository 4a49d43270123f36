"""What a notebook shows of an episode."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from sim import simulate
from tests.helpers.raising import raises
from worldgen import Pose, Target, World
from worldgen.errors import InvalidParameter


def room():
    walls = np.zeros((10, 14), np.bool_)
    walls[2:8, 7] = True
    return World(walls, Pose(0.25, 0.45, 0.0), Target(1.25, 0.45, 0.1))


def test_a_recorded_episode_has_a_picture_and_a_player():
    episode = simulate(room(), "bug2", record=True)
    assert episode._repr_png_().startswith(b"\x89PNG")
    framed = episode.show()._repr_html_()
    assert framed.startswith('<iframe srcdoc="') and "bug2: reached" in framed
    assert "allow-same-origin" not in framed


def test_an_episode_that_was_not_recorded_says_how_to_record_it():
    episode = simulate(room(), "bug2")
    assert episode._repr_png_() is None
    with raises(InvalidParameter, "not-recorded"):
        episode.show()


def test_what_was_run_changes_neither_equality_nor_what_travels():
    episode = simulate(room(), "bug2", record=True)
    again = pickle.loads(pickle.dumps(episode))
    assert again.ran is None and again.trace_digest == episode.trace_digest
    assert "ran" not in repr(episode)


@pytest.mark.parametrize("controllers", ["bug2", {1: "bug2", 2: "vfh"}])
def test_several_robots_have_one_player(controllers):
    world = room()
    second = replace(world.robots[0], start=Pose(0.25, 0.85, 0.0), target=Target(1.25, 0.85, 0.1))
    fleet = World(world.walls, robots=(world.robots[0], second))
    episode = simulate(fleet, controllers, record=True)
    assert "bug2" in episode.show()._repr_html_()
