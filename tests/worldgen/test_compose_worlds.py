"""Composed worlds: proved like every world, or refused in one sentence."""

import math
from dataclasses import replace

import numpy as np
from hypothesis import given, reject
from hypothesis import strategies as st

from tests.helpers.raising import raises
from worldgen.compose import of_cells, of_family, of_world
from worldgen.errors import GenerationFailed, InvalidParameter, InvalidWorld
from worldgen.family import family
from worldgen.reach import check_certificate
from worldgen.robot import Drive
from worldgen.world import Pose, Robot, Target, Witness, World

HOSTS, PARTS = ("trap", "rooms", "forest"), ("cave", "fire", "maze", "trap")


def free(width, height):
    """Return a piece of free cells."""
    return of_cells(np.zeros((height, width), bool))


@given(st.sampled_from(HOSTS), st.sampled_from(PARTS), st.integers(0, 50), st.integers(0, 3))
def test_the_independent_checker_accepts_the_witness_of_a_composed_world(
    host, piece, seed, quarters
):
    @family("composed", version=1)
    def composed(rng):
        part = of_family(piece, rng.child("piece"), size=14).rotate(quarters).crop(1, 1, 12, 12)
        ground = of_family(host, rng.child("host"), size=32)
        return ground.place(part, at="way", seed=rng.child("place")).layout()

    try:
        world = composed(seed=seed)
    except (
        GenerationFailed,
        InvalidParameter,
        InvalidWorld,
    ):  # the piece may close the path in every layout
        reject()
    report = check_certificate(world)
    assert isinstance(world.certificate, Witness) and report.valid, report.reason


def test_a_trap_goes_into_a_maze_in_one_line():
    maze, trap = (
        of_family("maze", seed=7, size=60),
        of_family("trap", seed=3, size=20).crop(1, 1, 18, 18),
    )
    world = maze.place(trap, at="way", seed=5).world()
    assert check_certificate(world).valid and (world.width, world.height) == (60, 60)


def test_fire_burns_in_its_part_of_the_world_alone():
    host, fire = of_family("rooms", 1, size=40), of_family("fire", 2, size=16)
    line = host.place(fire.crop(1, 1, 14, 14), at=(25, 25)).layout().timeline
    assert len(line) and line.ix.min() >= 25 and line.iy.min() >= 25


def test_a_world_that_cannot_be_solved_is_said_to_be_blocked_and_why():
    room = free(9, 9).border().with_start(2, 2).with_target(9, 9)
    with raises(GenerationFailed, "not-reachable", result="blocked"):
        room.place(of_cells(np.ones((1, 11), bool)), at=(0, 5)).world()


def test_no_way_to_put_a_piece_on_is_said():
    cells = np.zeros((3, 5), bool)
    cells[:, 2] = True
    walled = of_cells(cells).border().with_start(1.5, 2.5).with_target(5.5, 2.5)
    with raises(InvalidWorld, "not-reachable"):
        walled.place(free(1, 1), at="way", seed=1)


def test_where_no_start_is_given_it_is_placed_far_from_the_target():
    world = free(30, 6).border().with_target(3.5, 3.5).world()
    assert world.start.x > 2.5 and check_certificate(world).valid


def test_a_composed_world_keeps_the_robot_s_goal_body_and_drive_and_turns_the_goal_with_it():
    goal = Target(0.75, 0.35, 0.05, 0.5, 0.1, "stop", 0.2, 0.3, "stop")
    robot = Robot(
        Pose(0.35, 0.35, 0.2),
        goal,
        speed=1.0,
        footprint=((0.1, 0.1), (-0.1, 0.1), (-0.1, -0.1), (0.1, -0.1)),
        drive=Drive(0.3, reverse=True, steering_rate=2.0),
    )
    world = World(np.zeros((8, 12), bool), robots=[robot])
    turned = of_world(world).rotate(1).mirror("x").layout().robots[0]
    # x = height - y and y = x, with left and right swapped again: a mirror image at the diagonal.
    assert (turned.target.x, turned.target.y) == (0.35, 0.75)
    assert math.isclose(turned.target.heading, math.pi / 2 - 0.5, abs_tol=1e-4)
    assert math.isclose(turned.start.heading, math.pi / 2 - 0.2, abs_tol=1e-4)
    kept = replace(
        turned,
        start=robot.start,
        target=replace(turned.target, x=goal.x, y=goal.y, heading=goal.heading),
    )
    assert kept == robot
    host = free(20, 20)
    assert host.place(of_world(world), at=[3, 3]).layout().target.arrival == "stop"
