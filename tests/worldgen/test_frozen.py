"""Immutable objects share their arrays with copies made from them, and never with a writer."""

import copy
import dataclasses
import pickle

import numpy as np
import pytest

from tests.helpers.raising import raises
from worldgen.errors import InvalidWorld
from worldgen.families.parts.layout import Arena
from worldgen.files.grid import dumps, loads
from worldgen.generation import generate
from worldgen.support.frozen import freeze, frozen
from worldgen.timeline import CellState, Event, Timeline
from worldgen.world import Pose, Robot, Target, World

ENDS = (Pose(0.15, 0.15), Target(0.35, 0.35, 0.05))


def world_of(walls):
    return World(walls, *ENDS, timeline=Timeline.of([Event(1.0, 2, 2, CellState.SOLID)]))


def test_a_changed_world_shares_walls_and_timeline_with_the_first():
    world = world_of(np.zeros((5, 5), bool))
    other = dataclasses.replace(world, robot_radius=0.03)
    assert other.walls is world.walls
    assert other.timeline is world.timeline


def test_what_the_caller_writes_to_is_copied():
    walls = np.zeros((5, 5), bool)
    world = world_of(walls)
    walls[:] = True
    assert not world.walls.any()


def test_a_read_only_view_of_what_the_caller_writes_to_is_copied():
    walls = np.zeros((5, 5), bool)
    view = walls[:]
    view.setflags(write=False)
    world = world_of(view)
    walls[:] = True
    assert not world.walls.any()


def test_an_array_that_somebody_made_writable_again_is_copied():
    world = world_of(np.zeros((5, 5), bool))
    world.walls.setflags(write=True)
    assert dataclasses.replace(world).walls is not world.walls


def test_a_part_of_a_frozen_array_is_copied():
    whole = frozen(np.zeros((5, 5)), np.float64)
    assert not np.shares_memory(frozen(whole[1:], np.float64), whole)


def test_another_type_of_element_is_copied():
    assert frozen(frozen([1, 2], np.int64), np.float64).dtype == np.float64


def test_an_image_of_0_and_255_seen_as_walls_is_written_as_walls():
    image = np.zeros((5, 5), np.uint8)
    image[2, 2] = 255
    assert dumps(world_of(image.view(bool))) == dumps(world_of(image > 0))


def test_a_view_that_is_handed_over_is_copied_all_the_same():
    walls = np.zeros((5, 5), bool)
    assert frozen(freeze(walls[::-1]), np.bool_) is not walls
    assert walls.flags.writeable


def test_a_familys_walls_and_those_of_a_file_are_not_copied():
    walls = np.zeros((10, 10), bool)
    world = Arena(10, 0.1, 0.07, 2.0).world(walls, start=(3, 3), target=(7, 7), quarter=0)
    assert world.walls is walls
    assert not loads(dumps(world)).walls.flags.writeable


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda world: pickle.loads(pickle.dumps(world))])
def test_a_copied_or_unpickled_world_is_as_immutable(copied):
    world = generate("fire", 1, size=14)
    other = copied(world)
    assert other == world
    for array in (other.walls, other.timeline.times, other.certificate.x):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0


FIRST = Robot(*ENDS, radius=0.04, speed=1.0)
SECOND = Robot(Pose(0.35, 0.15), Target(0.15, 0.35, 0.05), radius=0.03)


def test_start_target_radius_and_speed_are_the_first_robots():
    world = World(np.zeros((5, 5), bool), robots=[FIRST, SECOND])
    assert world.robots == (FIRST, SECOND) and world.is_fleet
    assert Robot(world.start, world.target, world.robot_radius, world.robot_speed) == FIRST
    assert World(np.zeros((5, 5), bool), *ENDS, robot_radius=0.04, robot_speed=1.0) == world.alone(
        1
    )


@pytest.mark.parametrize(
    ("name", "part", "value"),
    [
        ("start", "start", Pose(0.1, 0.1)),
        ("target", "target", Target(0.3, 0.3, 0.05)),
        ("robot_radius", "radius", 0.02),
        ("robot_speed", "speed", 0.5),
    ],
)
def test_what_is_replaced_is_the_first_robots(name, part, value):
    world = World(np.zeros((5, 5), bool), robots=[FIRST, SECOND])
    changed = dataclasses.replace(world, **{name: value})
    assert changed.robots == (dataclasses.replace(FIRST, **{part: value}), SECOND)
    assert changed != world
    # It also replaces a part of the first of the robots that are given with it.
    other = dataclasses.replace(world, robots=(SECOND, FIRST), **{name: value})
    assert other.robots == (dataclasses.replace(SECOND, **{part: value}), FIRST)


def test_a_world_needs_a_robot():
    for ends in ({}, {"start": ENDS[0]}, {"target": ENDS[1]}):
        with raises(InvalidWorld, "no-robots"):
            World(np.zeros((5, 5), bool), **ends)
    with raises(InvalidWorld, "no-robots"):
        dataclasses.replace(World(np.zeros((5, 5), bool), *ENDS), robots=())


@pytest.mark.parametrize(
    ("robots", "came"),
    [
        ([1, 2], "robot 1 is an int"),
        ([FIRST, None], "robot 2 is None"),
        (None, "robots is None"),
        (FIRST, "robots is a Robot"),
    ],
)
def test_what_is_no_list_of_robots_is_refused(robots, came):
    with raises(InvalidWorld, "not-robots", came=came):
        World(np.zeros((5, 5), bool), robots=robots)
    with raises(InvalidWorld, "not-robots", came=came):
        dataclasses.replace(World(np.zeros((5, 5), bool), *ENDS), robots=robots)
