"""Worlds that do not change: an exact witness or cut."""

import dataclasses
import itertools
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy import ndimage

from tests.helpers.drawn_worlds import drawn, still_worlds, tight_worlds
from tests.helpers.grid_strategies import worlds_with_everything
from tests.helpers.raising import raises
from tests.reference.worldgen.chains import linked_offsets
from worldgen.errors import InvalidParameter
from worldgen.lattice import radius_in_cells
from worldgen.reach import BLOCKED, REACHABLE, check_certificate, decide
from worldgen.reach.still.cut import find_chain
from worldgen.reach.still.walls import segment_box_sq
from worldgen.world import Pose, Target, World

STAIRCASE = """
......#
.G...#.
....#..
.......
..#....
.#...S.
#......
"""
CORRIDOR = """
#####
S...G
#####
"""
BEND = """
.........
.G.......
.........
######...
.........
.S.......
.........
"""


def decided(world, **options):
    """Return the decision, after the checker has confirmed its certificate."""
    decision = decide(world, **options)
    report = check_certificate(world, decision.certificate, **options)
    assert report.valid, (decision.reason, report.reason)
    return decision


def test_cells_that_touch_at_a_corner_let_nothing_through():
    decision = decided(drawn(STAIRCASE.replace(".......", "...#..."), radius=0.001))
    assert decision.result == BLOCKED
    assert decision.certificate.clearance == 0.0


@pytest.mark.parametrize(
    ("radius", "result"),
    [
        (0.7, REACHABLE),
        (0.7071067811865475, REACHABLE),
        (0.7071067811865476, BLOCKED),
        (0.71, BLOCKED),
    ],
)
def test_a_diagonal_gap_passes_discs_up_to_half_of_its_width(radius, result):
    assert decided(drawn(STAIRCASE, radius=radius, cell_size=1.0)).result == result


@pytest.mark.parametrize("cell_size", [0.1, 0.3, 0.05, 1.0, 0.07])
def test_a_corridor_exactly_as_wide_as_the_disc_passes_it(cell_size):
    decision = decided(drawn(CORRIDOR, radius=cell_size / 2, cell_size=cell_size))
    assert decision.result == REACHABLE
    assert decision.certificate.clearance == cell_size / 2


def test_a_corridor_a_hair_narrower_than_the_disc_stops_it():
    assert decided(drawn(CORRIDOR, radius=0.0500000001)).result == BLOCKED


@pytest.mark.parametrize(("radius", "result"), [(1.118, REACHABLE), (1.1181, BLOCKED)])
def test_a_slanting_gap_passes_a_disc_along_its_bisector(radius, result):
    walls = np.zeros((22, 22), bool)
    walls[10, :10] = walls[13, 11:] = True  # corners (10, 11) and (11, 13): a gap of the root of 5
    world = World(
        walls, Pose(16.5, 5.5), Target(4.5, 17.5, 0.1), cell_size=1.0, robot_radius=radius
    )
    assert decided(world).result == result


def test_a_wall_one_cell_thick_stops_the_smallest_disc():
    decision = decided(drawn("...#...\nS..#..G\n...#...", radius=1e-6))
    assert decision.result == BLOCKED
    assert {3} >= set(decision.certificate.cells[decision.certificate.cells[:, 1] == 1, 0]) - {
        -1,
        7,
    }


def test_the_outside_of_the_grid_is_solid():
    assert decided(drawn("SG", radius=0.0501)).result == BLOCKED
    assert decided(drawn("SG", radius=0.05)).result == REACHABLE


@pytest.mark.parametrize("radius", [0.2, 0.7, 2000.0])
def test_a_robot_larger_than_the_world_is_blocked(radius):
    decision = decided(drawn("SG", radius=radius))
    assert decision.result == BLOCKED


def test_a_start_too_near_to_a_cell_is_blocked_by_that_cell():
    decision = decided(drawn("....\n#S.G\n....", radius=0.07))
    assert decision.result == BLOCKED
    assert decision.certificate.cells.tolist() == [[0, 1]]
    assert decision.certificate.clearance == 0.05


def test_a_target_whose_every_pose_is_covered_is_blocked_by_one_cell():
    decision = decided(
        drawn(BEND.replace("G", "#", 1).replace(".#.......", "G#......."), radius=0.07)
    )
    assert decision.result == BLOCKED
    assert len(decision.certificate.cells) == 1


def test_a_target_with_a_covered_centre_is_reached_at_its_clear_side():
    world = drawn("......\n.S..G#\n......", radius=0.07, target_radius=0.05)
    witness = decided(world).certificate
    assert 0.05 >= np.hypot(witness.x[-1] - 0.45, witness.y[-1] - 0.15) > 0.0


def test_a_target_that_reaches_through_a_gap_is_reached_from_the_other_side():
    walls = np.zeros((7, 7), bool)
    walls[3, :3] = walls[3, 4:] = True  # a door of one cell, too narrow for the disc
    world = World(walls, Pose(3.5, 1.0), Target(3.5, 4.2, 2.0), cell_size=1.0, robot_radius=0.6)
    assert decided(world).result == REACHABLE


def test_a_target_that_reaches_into_a_gap_but_not_through_is_blocked():
    walls = np.zeros((7, 7), bool)
    walls[3, :3] = walls[3, 4:] = True
    world = World(walls, Pose(3.5, 1.0), Target(3.5, 4.2, 1.0), cell_size=1.0, robot_radius=0.6)
    assert decided(world).result == BLOCKED


def test_another_radius_may_have_another_answer():
    world = drawn(STAIRCASE)
    assert decided(world).result == REACHABLE
    assert decided(world, radius=0.071).result == BLOCKED


@pytest.mark.parametrize("radius", [0.0, -1.0, float("nan"), float("inf")])
def test_a_radius_must_be_a_finite_number_above_zero(radius):
    with raises(InvalidParameter, "not-positive"):
        decide(drawn(CORRIDOR), radius=radius)


def test_a_witness_starts_at_the_start_even_off_the_lattice():
    world = dataclasses.replace(drawn(BEND), start=Pose(0.1234567, 0.1512345))
    witness = decided(world).certificate
    assert (witness.times[0], witness.x[0], witness.y[0]) == (0.0, 0.1234567, 0.1512345)


def test_a_witness_keeps_to_the_speed_and_has_short_decimals():
    witness = decided(drawn(BEND, robot_speed=0.3)).certificate
    speeds = np.hypot(np.diff(witness.x), np.diff(witness.y)) / np.diff(witness.times)
    assert 0.2999 < speeds.max() <= 0.3
    assert max(len(repr(float(value))) for value in (*witness.times, *witness.x, *witness.y)) <= 9


def test_a_witness_in_the_open_is_one_straight_line():
    witness = decided(drawn("......G\n.......\n.......\nS......", radius=0.05)).certificate
    assert len(witness.x) == 2


def test_a_small_world_is_decided_without_numba_scipy_and_shapely():
    code = (
        "import sys, numpy as np; from worldgen.world import *; from worldgen.reach import decide;"
        "print(decide(World(np.eye(60, k=9) > 0, Pose(.5, .5), Target(5.5, 5.5, .05))).result,"
        "{'numba', 'scipy', 'shapely'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split(maxsplit=1) == [REACHABLE, "set()\n"]


@pytest.mark.parametrize(("density", "result"), [(0.06, REACHABLE), (0.3, BLOCKED)])
def test_a_world_of_300_by_300_cells_is_decided(density, result):
    walls = np.random.default_rng(2).random((300, 300)) < density
    walls[:3, :3] = walls[-3:, -3:] = False
    assert decided(World(walls, Pose(0.15, 0.15), Target(29.85, 29.85, 0.05))).result == result


def test_a_disc_of_many_cells_is_decided():
    walls = np.zeros((120, 120), bool)
    walls[60, ::20] = True  # gaps of 19 cells
    world = World(
        walls, Pose(60.0, 20.0), Target(60.0, 100.0, 1.0), cell_size=1.0, robot_radius=9.5
    )
    assert decided(world).result == REACHABLE
    assert decided(world, radius=9.51).result == BLOCKED


def distances(world):
    """Distance, cells, from points at multiples of 1/8 cell to the nearest solid cell.

    Plain broadcasting.
    """
    solid = np.argwhere(np.pad(world.walls, 1, constant_values=True)) - 1
    y, x = np.mgrid[0 : 8 * world.height + 1, 0 : 8 * world.width + 1] / 8
    apart = [
        np.maximum(np.maximum(solid[:, k] - v[..., None], v[..., None] - solid[:, k] - 1), 0)
        for k, v in ((0, y), (1, x))
    ]
    return np.sqrt(apart[0] ** 2 + apart[1] ** 2).min(axis=-1), x, y


def joins(world, clear, neighbours, slack):
    """Return whether clear points connect the start to a point of the target's disc, enlarged by
    ``slack`` cells.
    """
    _, x, y = distances(world)
    parts, _ = ndimage.label(clear, neighbours)
    home = parts[round(8 * world.start.y), round(8 * world.start.x)]
    near = np.hypot(x - world.target.x, y - world.target.y) <= world.target.radius + slack
    return bool(home and (parts[near] == home).any())


@pytest.mark.gate
@given(still_worlds())
def test_what_a_wider_disc_reaches_on_a_fine_lattice_is_reachable(world):
    clear = (
        distances(world)[0] >= world.robot_radius + 1 / 16 + 1e-9
    )  # so no step of 1/8 comes too near
    assume(joins(world, clear, np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]]), 0.0))
    assert decided(world).result == REACHABLE


@given(still_worlds())
def test_what_a_narrower_disc_cannot_reach_on_a_fine_lattice_is_not_reachable(world):
    clear = (
        distances(world)[0] >= world.robot_radius - 0.0884 - 1e-9
    )  # any clear path, moved to lattice points
    if not joins(world, clear, np.ones((3, 3)), 0.0884):
        assert decided(world).result == BLOCKED


@given(still_worlds())
def test_every_still_world_is_decided_and_the_checker_agrees(world):
    assert decided(world).result in (REACHABLE, BLOCKED)


@given(tight_worlds())
def test_discs_a_hair_wider_or_narrower_than_a_gap_are_decided_too(world):
    assert decided(world).result in (REACHABLE, BLOCKED)


@pytest.mark.parametrize(("reach", "result"), [(1.415, REACHABLE), (1.414, BLOCKED)])
def test_a_target_that_only_just_touches_where_the_disc_may_be_is_reached_there(reach, result):
    world = World(
        np.zeros((9, 9), bool),
        Pose(4.5, 4.5),
        Target(0.0, 0.0, reach),
        cell_size=1.0,
        robot_radius=1.0,
    )
    assert decided(world).result == result  # the nearest pose is (1, 1), the root of 2 away


def test_a_start_that_touches_a_wall_between_lattice_points_is_decided():
    world = World(
        np.zeros((9, 9), bool),
        Pose(0.3333, 4.5),
        Target(4.5, 4.5, 0.1),
        cell_size=1.0,
        robot_radius=0.3333,
    )
    assert decided(world).result == REACHABLE


def test_a_target_in_a_wedge_between_a_side_and_a_corner_is_reached_along_the_side():
    text = "...#..#.... #......#... ..........# ......#.... .#......... ..#........"
    walls = np.array([[letter == "#" for letter in row] for row in text.split()[::-1]])
    world = World(
        walls, Pose(8.5, 2.5), Target(6.5, 0.5, 1.0), cell_size=1.0, robot_radius=1.0000001
    )
    decision = decide(
        world
    )  # the wedge begins at (7.0006, 1.0000001) and is too thin for nodes a sixteenth apart
    assert decision.result == REACHABLE
    assert check_certificate(world, decision.certificate).valid


@pytest.mark.parametrize("target", [(4.5, 4.1667), (4.5001, 4.1667), (4.501, 4.168)])
def test_a_pocket_between_three_corners_with_no_node_in_it_is_decided(target):
    walls = np.zeros((9, 9), bool)
    walls[[2, 2, 6], [2, 6, 3]] = (
        True  # corners at (3, 3), (6, 3) and (4, 6): their circle has a radius of 1.9003
    )
    world = World(walls, Pose(4.5, 4.1667), Target(*target, 1e-6), cell_size=1.0, robot_radius=1.89)
    decision = decide(world)
    assert decision.result == REACHABLE
    assert check_certificate(world, decision.certificate).valid


def test_one_ring_parts_the_start_from_a_target_that_has_poses_on_several_sides():
    walled = """
.........
.#######.
.#..G..#.
.#.....#.
.#.###.#.
.#.#S#.#.
.#.###.#.
.#.....#.
.#######.
.........
"""
    world = drawn(walled, radius=0.05, target_radius=0.25)
    assert decided(world).result == BLOCKED
    assert (
        not decided(world).certificate.cells.max() > 5
    )  # the inner ring, not one of those that separate only some poses


@given(still_worlds(), st.data())
def test_two_clear_poses_have_either_a_path_or_a_cut_and_never_both(world, data):
    clear = (
        distances(world)[0][4:-4:4, 4:-4:4] >= world.robot_radius
    )  # exact at multiples of half a cell
    poses = st.sampled_from([(float(x + 1) / 2, float(y + 1) / 2) for y, x in np.argwhere(clear)])
    assume(clear.any())
    start, target = data.draw(poses), data.draw(poses)
    world = dataclasses.replace(world, start=Pose(*start), target=Target(*target, 1e-6))
    points = [(round(1024 * x), round(1024 * y)) for x, y in (start, target)]
    parted = find_chain(world.walls, radius_in_cells(world), points[0], points[1:]) is not None
    assert decided(world).result == (BLOCKED if parted else REACHABLE)


@pytest.mark.gate
@given(worlds_with_everything())
def test_any_legal_world_gets_an_answer_and_any_certificate_a_report(world):
    decision = decide(world)
    assert decision.certificate is None or check_certificate(world, decision.certificate).valid
    assert check_certificate(world).reason


def test_links_are_the_gaps_below_the_discs_width():
    offsets = linked_offsets(radius_in_cells(drawn(CORRIDOR, radius=0.07)))
    assert set(offsets) == {
        (dx, dy)
        for dx, dy in itertools.product(range(-2, 3), repeat=2)
        if 0 < dx * dx + dy * dy < 8
    }
    assert all(
        (-dx, -dy) in offsets[len(offsets) // 2 :] for dx, dy in offsets[: len(offsets) // 2]
    )


def test_the_distance_of_a_slanting_segment_to_a_cell_is_exact():
    assert segment_box_sq((0, 2048), (2048, 0), (0, 0)) == (0, 1)
    distance, over = segment_box_sq((0, 3072), (3072, 0), (0, 0))
    assert distance / over == 1024**2 / 2


@pytest.mark.parametrize("x", [0.15, 0.1501234567], ids=["on the lattice", "beside it"])
def test_the_robot_drives_its_witness_at_top_speed(x):
    walls = np.zeros((9, 9), bool)
    walls[4, :7] = True
    world = World(walls, Pose(x, 0.15), Target(0.15, 0.75, 0.05), robot_speed=1.5)
    path = decide(world).certificate
    assert path.length > 1.0 and path.duration == pytest.approx(path.length / 1.5, rel=1e-4)
