"""The checker refuses certificates that prove nothing."""

import dataclasses
import math

import numpy as np
import pytest

from tests.helpers.drawn_worlds import drawn
from worldgen.reach import BLOCKED, UNDECIDED, check_certificate, decide, witness_margin
from worldgen.timeline import CellState, Event, Timeline
from worldgen.world import Cut, Pose, Target, Witness, World

ROOM = """
........
......G.
........
..####..
........
.S......
........
"""
WALLED = ROOM.replace("..####..", "########")
ACROSS = np.array([(ix, 3) for ix in range(-1, 9)] + [(8, iy) for iy in range(2, -2, -1)])
ROUND_START = np.concatenate(
    [ACROSS, [(ix, -1) for ix in range(7, -2, -1)], [(-1, iy) for iy in range(3)]]
)


def refusal(world, certificate, **options):
    report = check_certificate(world, certificate, **options)
    assert not report.valid
    return report.reason


def witness(times, points, clearance=0.07):
    x, y = np.array(points, float).T
    return Witness(np.array(times, float), x, y, clearance)


ROUND = [(0.15, 0.15), (0.1, 0.35), (0.15, 0.55), (0.65, 0.55)]
GOOD = witness([0, 1, 2, 3], ROUND)


def changed(*, times=None, points=None, clearance=0.07):
    return witness(
        [0, 1, 2, 3] if times is None else times, ROUND if points is None else points, clearance
    )


def moved(index, x, y):
    return changed(points=[(x, y) if i == index else point for i, point in enumerate(ROUND)])


def test_a_good_witness_is_accepted_and_measured():
    report = check_certificate(drawn(ROOM), GOOD)
    assert report.valid
    assert report.clearance == pytest.approx(0.1, abs=0.03)


@pytest.mark.parametrize(
    ("damaged", "why"),
    [
        (moved(0, 0.16, 0.15), "from the start"),
        (moved(3, 0.65, 0.5), "outside the target's disc"),
        (moved(1, 0.2, 0.35), "comes within"),
        (moved(1, 0.0699, 0.35), "the outside of the grid"),
        (moved(1, -0.1, 0.35), "leaves the grid at point 1"),
        (moved(1, 0.1, float("nan")), "not finite"),
        (changed(times=[1, 2, 3, 4]), "starts at 1.0 s"),
        (changed(times=[0, 2, 1, 3]), "back in time after point 1"),
        (changed(times=[0, 0.1, 2, 3]), "faster than 2.0 m/s after point 0"),
        (changed(clearance=0.2), "claims 0.2 m of clearance"),
        (witness([], np.zeros((0, 2))), "no points"),
    ],
)
def test_a_damaged_witness_is_refused(damaged, why):
    assert why in refusal(drawn(ROOM), damaged)


def test_a_witness_is_refused_for_a_disc_that_it_does_not_let_through():
    assert "the radius is 0.11 m" in refusal(drawn(ROOM), GOOD, radius=0.11)


def test_a_witness_through_a_wall_is_refused():
    assert "comes within 0 m of cells 0 to 7 of row 3" in refusal(drawn(WALLED), GOOD)


@pytest.mark.parametrize(
    "through",
    [(0.06, 0.35), (0.74, 0.35), (0.4, 0.06), (0.4, 0.64)],
    ids=["left", "right", "bottom", "top"],
)
def test_a_witness_too_near_to_the_outside_is_refused(through):
    world = World(np.zeros((7, 8), bool), Pose(0.15, 0.15), Target(0.65, 0.55, 0.05))
    path = witness([0, 1, 2], [(0.15, 0.15), through, (0.65, 0.55)])
    assert "the outside of the grid" in refusal(world, path)


def past_the_corner(right, up, gap, burning):
    """Return a world with a fire, and a witness that passes one of its corners after 2 s."""
    fire = [Event(burning, 4, 4, CellState.BURNING), Event(burning + 0.1, 4, 4, CellState.FREE)]
    # It passes the corner at right angles to the cell's diagonal.
    nearest = 0.45 + (0.05 + gap / np.sqrt(2)) * np.array([right, up])
    along = np.array([right, -up]) * 0.15
    start, end = nearest - along, nearest + along
    world = World(
        np.zeros((9, 9), bool), Pose(*start), Target(*end, 0.05), timeline=Timeline.of(fire)
    )
    return world, witness([0, 4], [start, end], clearance=0.05)


@pytest.mark.parametrize("up", [-1, 1], ids=["below", "above"])
@pytest.mark.parametrize("right", [-1, 1], ids=["left", "right"])
def test_a_witness_for_a_disc_of_7_cm_passes_the_corner_of_a_fire_at_7_cm(right, up):
    assert not check_certificate(*past_the_corner(right, up, 0.069, burning=1.95)).valid
    assert check_certificate(*past_the_corner(right, up, 0.071, burning=1.95)).valid
    # It meets a later fire if it begins later.
    assert 0.3 < witness_margin(*past_the_corner(right, up, 0.069, burning=2.5)) < 0.5
    assert witness_margin(*past_the_corner(right, up, 0.071, burning=2.5)) == math.inf


def test_a_world_without_a_certificate_proves_nothing():
    assert refusal(drawn(ROOM), None) == "the world has no certificate"


def test_a_good_cut_is_accepted_and_measured():
    for chain in (ROUND_START, ROUND_START[::-1], np.roll(ROUND_START, 5, axis=0)):
        report = check_certificate(drawn(WALLED), Cut(chain, 0.0))
        assert report.valid
        assert report.clearance == 0.0


@pytest.mark.parametrize(
    ("chain", "clearance", "why"),
    [
        (ROUND_START[:0], 0.0, "no cells"),
        (np.delete(ROUND_START, [3, 4], axis=0), 0.1, "stops discs above 0.1 m"),
        (np.delete(ROUND_START, [3, 4], axis=0), 0.0, "has a gap of twice 0.1 m"),
        (ROUND_START[:6], 0.06, "has a gap of twice"),
        (np.where(ROUND_START == [[3, 3]], [[3, 2]], ROUND_START), 0.0, "is free at some time"),
        (np.array([(-1, 7), (0, 7), (1, 7), (0, 7)]), 0.0, "does not separate"),
        (np.array([(3, 3), (4, 3), (5, 3)]), 0.05, "does not separate"),
        (np.array([(-2, 3), (-1, 3), (-2, 3)]), 0.0, "beyond the ring"),
    ],
)
def test_a_damaged_cut_is_refused(chain, clearance, why):
    assert why in refusal(drawn(WALLED), Cut(chain, clearance))


def test_a_cut_is_refused_for_a_disc_that_fits_its_gap_exactly():
    world = drawn(WALLED.replace("########", "#.#.#.#."), radius=0.05)
    chain = np.concatenate([ACROSS[1:9:2], ROUND_START[9:]])
    assert check_certificate(world, Cut(chain, 0.05), radius=0.0500001).valid
    assert "the radius is 0.05 m" in refusal(world, Cut(chain, 0.05))
    assert "gap of twice" in refusal(world, Cut(chain, 0.049))


def test_a_cut_of_a_wall_that_opens_is_refused():
    world = dataclasses.replace(drawn(WALLED), timeline=Timeline.of([(5.0, 2, 3, CellState.FREE)]))
    assert "(2, 3) of the cut is free at some time" in refusal(world, Cut(ROUND_START, 0.0))


def test_a_cut_that_leaves_part_of_the_target_on_the_near_side_is_refused():
    world = dataclasses.replace(drawn(WALLED), target=Target(0.65, 0.55, 0.42))
    assert "every clear pose" in refusal(world, Cut(ROUND_START, 0.0))


def test_a_cut_may_cross_the_part_of_the_target_where_no_disc_fits():
    world = dataclasses.replace(drawn(WALLED), target=Target(0.65, 0.55, 0.29))
    assert check_certificate(world, Cut(ROUND_START, 0.069)).valid


def test_a_target_that_misses_the_only_clear_pose_by_a_hair_of_1e_31_cell_is_proved_blocked():
    # The corner at (5 - r, r) is sqrt(r**2 + 6e-16**2) from the target, which is r wide.
    radius = 0.07500000000000001
    target = Target(0.17500000000000002, 0.0, radius)
    world = World(
        np.zeros((5, 5), bool), Pose(radius, radius), target, cell_size=0.05, robot_radius=radius
    )
    decision = decide(world)
    assert decision.result == BLOCKED
    assert check_certificate(world, decision.certificate).valid


def test_a_tie_in_lengths_that_are_too_long_to_multiply_is_undecided():
    # The target misses the nearest clear pose by 1e-18 cells.
    world = World(
        np.zeros((3, 3), bool), Pose(1e5, 1e5), Target(0.0, 0.0, 0.1414213562373), 1e5, 0.1
    )
    decision = decide(world)
    assert (decision.result, decision.certificate) == (UNDECIDED, None)
    assert "round the radius" in decision.reason


@pytest.mark.parametrize("cell", [1.0, 1e3])
def test_a_cut_round_a_target_in_a_corner_holds_for_a_robot_of_any_size_if_the_target_is_as_far_as_that(
    cell,
):
    beyond, nearer = (  # the nearest clear pose is the root of 2 radii away
        World(
            np.zeros((3, 3), bool),
            Pose(cell, cell),
            Target(0.0, 0.0, 0.1 * reach),
            cell_size=cell,
            robot_radius=0.1,
        )
        for reach in (1.414213562373, 1.414213562374)
    )
    cut = decide(beyond).certificate
    assert isinstance(cut, Cut) and check_certificate(beyond, cut).valid
    assert "every clear pose" in refusal(nearer, cut)


def test_one_cell_is_a_cut_where_it_covers_the_start():
    world = dataclasses.replace(drawn(WALLED), start=Pose(0.15, 0.25))
    assert check_certificate(world, Cut(np.array([(1, 3)]), 0.05)).valid
    assert not check_certificate(world, Cut(np.array([(3, 3)]), 0.05)).valid


GATE = "###########\nS....#....G\n###########"


def gate(opens):
    line = Timeline.of([(1.0, 5, 1, CellState.BURNING), (opens, 5, 1, CellState.FREE)])
    return drawn(GATE, radius=0.05, robot_speed=0.5, timeline=line)


def test_a_timed_witness_is_refused_where_it_meets_a_fire():
    made = decide(gate(4.0)).certificate
    early = dataclasses.replace(
        made,
        times=np.maximum(made.times - 0.01, 0.0) * (made.times > 3.0)
        + made.times * (made.times <= 3.0),
    )
    assert check_certificate(gate(4.0), made).valid
    assert "cell (5, 1), blocked at that time" in refusal(gate(4.0), early)
    assert "cell (5, 1), blocked at that time" in refusal(gate(4.01), made)


def test_a_witness_may_cross_a_burnt_cell_within_one_piece():
    straight = witness([0, 10], [(0.05, 0.15), (1.05, 0.15)], clearance=0.05)
    assert check_certificate(gate(3.9), straight).valid
    assert "blocked at that time" in refusal(gate(4.1), straight)


def test_a_big_world_is_checked():
    walls = np.random.default_rng(2).random((1000, 1000)) < 0.06
    walls[:3, :3] = walls[-3:, -3:] = False
    world = dataclasses.replace(
        drawn("S.G", radius=0.05),
        walls=walls,
        target=Target(99.85, 99.85, 0.05),
        start=Pose(0.15, 0.15),
    )
    assert check_certificate(world, decide(world).certificate).valid
