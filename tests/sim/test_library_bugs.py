"""Wall followers and bug algorithms.

They arrive, both compiled and interpreted, and the fuzzer finds no failures.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from sim import simulate
from sim.controllers.library.bug1 import bug1
from sim.controllers.library.bug2 import bug2
from sim.controllers.library.tangent_bug import tangent_bug
from sim.controllers.library.wall import wall_left, wall_right
from tests.helpers.command_line import worldgen
from tests.helpers.drawn_worlds import drawn
from tests.helpers.interpreted import Interpreted
from worldgen import Pose, Target, World, generate
from worldgen.timeline import CellState, Event, Timeline

BUGS = [bug1, bug2]
FOLLOWERS = [wall_left, wall_right]
CUP = """
.............
.....G.......
.............
.............
..########...
..#......#...
..#......#...
..#......#...
..#..S...#...
.............
.............
"""
DIAGONAL_GAP = """
...........
.S.........
...........
####.......
...........
.....######
...........
.G.........
...........
"""  # the gap between the two corners is 0.014 cells wider than the robot
ISLAND = """
...........
.........G.
...........
...........
....###....
....###....
....###....
...........
.S.........
...........
"""


def name(controller):
    return controller.name


@pytest.mark.parametrize("controller", BUGS, ids=name)
@pytest.mark.parametrize("family", ["maze", "trap", "corridor"])
@pytest.mark.parametrize("time_step", [0.015, 0.15])
def test_a_bug_reaches_every_target(controller, family, time_step):
    for seed in range(8):
        world = generate(family, seed, size=20)
        assert (
            simulate(world, controller, time_step=time_step, steps=60_000).verdict == "reached"
        ), seed


@pytest.mark.parametrize("controller", BUGS, ids=name)
def test_a_bug_gets_out_of_a_cup(controller):
    assert simulate(drawn(CUP), controller).verdict == "reached"


@pytest.mark.parametrize("controller", BUGS, ids=name)
def test_a_bug_finds_a_gap_hardly_wider_than_the_robot(controller):
    episode = simulate(drawn(DIAGONAL_GAP), controller)
    assert episode.verdict == "reached"


@pytest.mark.parametrize("controller", BUGS, ids=name)
def test_a_corner_that_a_bug_slides_round_in_a_narrow_gap_is_no_hit(controller):
    walls = np.zeros((24, 18), bool)
    for ix, iy in ((14, 21), (12, 19), (16, 19)):
        walls[iy, ix] = True
    world = World(walls, Pose(1.7, 2.3, -math.pi / 2), Target(0.1, 0.1, 0.05))
    assert simulate(world, controller, steps=2200).verdict == "reached"


@pytest.mark.parametrize("controller", BUGS, ids=name)
def test_a_bug_whose_target_is_walled_off_goes_round_for_ever(controller):
    world = drawn("S......\n.......\n..####.\n..#..#.\n..#.G#.\n..####.\n.......", radius=0.03)
    assert simulate(world, controller).verdict == "loop"


def test_bug1_goes_all_the_way_round_an_island_and_bug2_does_not():
    ways = [simulate(drawn(ISLAND), controller).path_length for controller in BUGS]
    around = 0.1 * (4 * 3 + 2 * np.pi * 0.7)
    assert ways[0] - ways[1] > 0.6 * around


@pytest.mark.parametrize("follower", FOLLOWERS, ids=name)
def test_a_wall_follower_goes_round_an_island_for_ever(follower):
    assert simulate(drawn(ISLAND), follower).verdict == "loop"


@pytest.mark.parametrize("follower", FOLLOWERS, ids=name)
def test_a_wall_follower_gets_through_corridors(follower):
    assert all(
        simulate(generate("corridor", seed, size=20), follower).verdict == "reached"
        for seed in range(8)
    )


def test_the_two_wall_followers_keep_the_wall_on_opposite_sides():
    def turning(follower):
        trace = simulate(drawn(ISLAND), follower, steps=60, record=True).trace
        x, y = trace.x[30:] - 0.55, trace.y[30:] - 0.45  # from the middle of the island
        return np.unwrap(np.arctan2(y, x))[-1] - np.unwrap(np.arctan2(y, x))[0]

    assert turning(wall_left) > 1.0 and turning(wall_right) < -1.0


@pytest.mark.gate
@pytest.mark.parametrize("controller", [*BUGS, *FOLLOWERS, tangent_bug], ids=name)
def test_who_follows_a_wall_that_goes_away_drives_on_to_the_target(controller):
    world = drawn(
        "...........\n.........G.\n...........\n" + 3 * "....#......\n" + ".S.........\n..........."
    )
    gone = Timeline.of([Event(0.3, 4, row, CellState.FREE) for row in (2, 3, 4)])
    assert simulate(replace(world, timeline=gone), controller).verdict == "reached"


@pytest.mark.parametrize("controller", BUGS + FOLLOWERS, ids=name)
def test_a_run_is_the_same_compiled_and_interpreted(controller):
    world = generate("maze", 3, size=20)
    runs = [simulate(world, one, steps=700) for one in (controller, Interpreted(controller))]
    assert runs[0].trace_digest == runs[1].trace_digest and runs[0].steps > 50


@pytest.mark.nightly
@pytest.mark.parametrize("controller", ["bug1", "bug2"])
@pytest.mark.parametrize("time_step", [0.015, 0.06])
def test_a_campaign_finds_nothing_against_a_bug(controller, time_step, tmp_path):
    done = worldgen(
        "fuzz", "--controller", f"sim.controllers.library.{controller}:{controller}", "--units", 4, "--seed", 1,
        "--family", "features", "--family", "maze", "--family", "trap", "--family", "corridor",
        "--time-step", time_step, "--workers", 1, "--no-shrink", "--out", tmp_path / "found",
    )  # fmt: skip
    assert done.code == 0, done.out
