"""The checker of joint witnesses: single paths, distances in pairs, the right robot in every
reason.
"""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from worldgen.reach import check_certificate
from worldgen.world import Cut, JointWitness, Pose, Robot, Target, Witness, World

LEFT, RIGHT = (0.15, 0.25), (1.05, 0.25)


def meeting(*, lane=0.25, radius=0.07, speed=2.0):
    """Two robots in an empty room, the second on a line at height ``lane`` and in the other
    direction.
    """
    return World(
        np.zeros((5, 12), bool),
        robots=(
            Robot(Pose(*LEFT), Target(*RIGHT, 0.05)),
            Robot(Pose(1.05, lane), Target(0.15, lane, 0.05), radius, speed),
        ),
    )


def crossing(lane, *, wait=0.0):
    """Paths straight ahead; the second robot sets out after a while."""
    first = Witness([0.0, 1.0], [0.15, 1.05], [0.25, 0.25], 0.07)
    second = Witness([0.0, wait, wait + 1.0], [1.05, 1.05, 0.15], [lane, lane, lane], 0.0399)
    return JointWitness((first, second))


def test_paths_that_pass_at_the_sum_of_the_radii_hold():
    report = check_certificate(meeting(lane=0.39), crossing(0.39))
    assert report.valid
    assert report.clearance == pytest.approx(0.07)


def test_paths_that_pass_nearer_do_not_hold():
    report = check_certificate(meeting(lane=0.3899), crossing(0.3899))
    assert not report.valid
    assert "robots 1 and 2" in report.reason


def test_a_robot_stays_an_obstacle_where_its_path_ends():
    world = meeting(lane=0.25)
    first, second = world.robots
    second = replace(second, target=Target(0.65, 0.25, 0.05), radius=0.04)
    world = replace(world, robots=(first, second))
    through = Witness([0.0, 5.0, 6.0], [0.15, 0.15, 1.05], [0.25, 0.25, 0.25], 0.07)
    parked = Witness([0.0, 1.0], [1.05, 0.65], [0.25, 0.25], 0.04)
    report = check_certificate(world, JointWitness((through, parked)))
    assert not report.valid and "5." in report.reason


def test_a_path_that_leaves_its_target_does_not_hold():
    world = meeting(lane=0.39)
    joint = crossing(0.39)
    first = Witness([0.0, 1.0, 2.0, 3.0], [0.15, 1.05, 0.85, 1.05], [0.25] * 4, 0.07)
    report = check_certificate(world, JointWitness((first, joint.paths[1])))
    assert not report.valid and report.reason.startswith("robot 1: ")


def test_a_path_into_a_wall_names_its_robot():
    world = meeting(lane=0.39)  # 0.01 m below row 4, less than the radius of robot 2
    walls = np.array(world.walls)
    walls[4, 6] = True
    report = check_certificate(replace(world, walls=walls), crossing(0.39))
    assert not report.valid and report.reason.startswith("robot 2: ")


def test_a_radius_is_every_robots():
    world = meeting(lane=0.39)
    assert check_certificate(world, crossing(0.39), radius=0.05).valid
    assert not check_certificate(world, crossing(0.39), radius=0.0701).valid


def test_a_cut_is_about_its_own_robot():
    world = meeting(lane=0.39)
    walls = np.zeros((5, 12), bool)
    walls[:, 3] = True
    walls[:3, 3:] = True
    walls[:3, 4:] = False
    world = replace(
        world,
        walls=walls,
        start=Pose(0.65, 0.25),
        robots=(world.robots[0], replace(world.robots[1], target=Target(0.15, 0.35, 0.05))),
    )
    ring = [(3, y) for y in range(5)] + [(x, 5) for x in range(3, -2, -1)]
    ring += [(-1, y) for y in range(4, -2, -1)] + [(x, -1) for x in range(4)]
    cut = Cut(ring, 0.01, robot=2)
    assert check_certificate(world, cut).valid
    report = check_certificate(world, replace(cut, robot=1))
    assert not report.valid and report.reason.startswith("robot 1: ")


_steps = st.lists(st.tuples(st.integers(0, 4), st.integers(0, 4)), min_size=1, max_size=4)


@settings(max_examples=60)
@given(_steps, _steps, st.sampled_from([0.04, 0.07, 0.1]))
def test_shapely_agrees_about_two_robots(one, two, radius):
    paths = []
    for corners in (one, two):
        if len(corners) > 1:  # it reaches its target with its last piece
            before = shapely.MultiPoint(corners[:1]) if len(corners) == 2 else None
            before = before or shapely.LineString(corners[:-1])
            assume(before.distance(shapely.Point(corners[-1])) > 0.5)
        x, y = 0.1 * np.array(corners).T + 0.35
        paths.append(Witness(np.arange(len(x)), x, y, 0.1))
    world_of = [
        Robot(Pose(path.x[0], path.y[0]), Target(path.x[-1], path.y[-1], 0.05), radius)
        for path in paths
    ]
    try:
        world = World(np.zeros((12, 12), bool), robots=world_of)
    except ValueError:
        return
    times = np.arange(6.0)
    points = [np.stack([np.interp(times, p.times, v) for v in (p.x, p.y)], axis=1) for p in paths]
    apart = points[0] - points[1]
    gap = min(
        shapely.distance(shapely.LineString(apart[k : k + 2]), shapely.Point(0, 0))
        for k in range(5)
    )
    if abs(gap - 2 * radius) > 1e-9:
        report = check_certificate(world, JointWitness(tuple(paths)))
        assert report.valid == (gap > 2 * radius), report.reason


def test_a_path_across_its_target_does_not_hold():
    # Robot 1 would park halfway along the first piece, whose ends are both outside its target.
    world = replace(meeting(lane=0.39), target=Target(0.65, 0.25, 0.05))
    joint = crossing(0.39)
    across = Witness([0.0, 1.0, 2.0], [0.15, 1.05, 0.65], [0.25] * 3, 0.07)
    assert not check_certificate(world, JointWitness((across, joint.paths[1]))).valid
    straight = Witness([0.0, 1.0], [0.15, 0.65], [0.25] * 2, 0.07)
    assert check_certificate(world, JointWitness((straight, joint.paths[1]))).valid


def test_a_path_past_its_target_holds():
    # The first piece passes the target at a distance of its radius.
    world = replace(meeting(lane=0.45), target=Target(0.65, 0.3, 0.05))
    joint = crossing(0.45)
    past = Witness([0.0, 1.0, 2.0], [0.15, 1.05, 0.7], [0.25, 0.25, 0.3], 0.05)
    robots = (world.robots[0], replace(world.robots[1], radius=0.04))
    world = replace(world, robot_radius=0.05, robots=robots)
    assert check_certificate(world, JointWitness((past, joint.paths[1]))).valid
