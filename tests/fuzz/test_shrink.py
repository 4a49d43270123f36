"""Shrinking: what remains is small, still fails, still proved, and nothing more can go."""

import math
from dataclasses import replace

import numpy as np
import pytest

from fuzz.failure import certified, failure_of, replay
from fuzz.shrink import removable, shrink
from fuzz.shrink.edits import bare, drop_columns, drop_events, drop_rows, free_cells
from fuzz.shrink.predicate import StillFails
from sim.scenario import Scenario
from sim.thesis_options import ThesisOptions
from worldgen import CellState, Event, InvalidParameter, Pose, Target, Timeline, Witness, World, check_certificate


def cup_world():
    walls = np.zeros((20, 20), bool)
    walls[[0, -1], :] = walls[:, [0, -1]] = True
    walls[12, 5:15] = True
    walls[7:12, 5] = walls[7:12, 14] = True
    walls[3, 2:5] = walls[16, 15:17] = True
    return World(walls, Pose(1.05, 0.45, math.pi / 2), Target(1.05, 1.65, 0.05))


def failure(controller="turn-right", motion="swept", **scenario):
    return failure_of(certified(cup_world()), Scenario(controller, motion, **scenario), fewest_steps=20_000)


@pytest.fixture(scope="module")
def shrunk():
    return shrink(failure())


def test_a_trap_shrinks_to_a_few_cells(shrunk):
    assert shrunk.before > 80 and shrunk.after <= 8


def test_the_shrunk_world_fails_with_the_same_verdict_and_replays(shrunk):
    assert shrunk.world.failure.verdict == "loop" and replay(shrunk.world).confirmed


def test_the_shrunk_world_carries_a_witness_that_the_checker_accepts(shrunk):
    assert isinstance(shrunk.world.certificate, Witness) and check_certificate(shrunk.world).valid


def test_nothing_more_can_be_removed(shrunk):
    assert shrunk.left == () and shrunk.complete


def test_the_check_of_minimality_sees_a_cell_too_many():
    world = certified(cup_world())
    still_fails = StillFails(Scenario("turn-right"), "loop", 20_000)
    assert any(name.startswith("cell") for name in removable(world, still_fails))


def test_shrinking_twice_changes_nothing(shrunk):
    again = shrink(shrunk.world).world
    assert np.array_equal(again.walls, shrunk.world.walls) and again.start == shrunk.world.start


def test_out_of_time_the_best_so_far_comes_back():
    result = shrink(failure(), seconds=1e-9)
    assert not result.complete and replay(result.world).confirmed


def test_shrinking_keeps_the_thesis_robots_noise_and_sensor():
    made = failure("turn-right", "stepped", thesis=ThesisOptions(noise=True, sensor_range=50))
    result = shrink(made, seconds=5.0).world.failure
    assert (result.parameters["noise"], result.parameters["sensor_range"]) == (True, 50)


def test_a_world_without_failure_is_refused():
    with pytest.raises(InvalidParameter, match="holds no failure"):
        shrink(cup_world())


def test_a_failure_that_does_not_fail_is_refused():
    made = failure()
    fine = replace(made, failure=replace(made.failure, verdict="tunnel"))
    with pytest.raises(InvalidParameter, match="does not end as 'tunnel'"):
        shrink(fine)


def test_dropping_a_row_moves_what_lies_above():
    world = drop_rows(bare(cup_world()), 5, 1)
    assert (world.height, world.start.y, world.target.y) == (19, 0.45, 1.55)


def test_dropping_a_column_moves_what_lies_right_of_it():
    world = drop_columns(bare(cup_world()), 2, 2)
    assert (world.width, world.start.x, world.target.x) == (18, 0.85, 0.85)


def test_freeing_a_free_cell_is_no_edit():
    assert free_cells(cup_world(), [(1, 1)]) is None


def test_events_move_and_go_with_their_rows():
    timeline = Timeline.of([Event(1.0, 3, 4, CellState.SOLID), Event(2.0, 3, 9, CellState.BURNING)])
    world = drop_rows(replace(cup_world(), timeline=timeline), 4, 1)
    assert [(event.ix, event.iy) for event in world.timeline] == [(3, 8)]
    assert len(drop_events(world, 0, 1).timeline) == 0


def test_a_random_controllers_failure_says_for_how_many_seeds_it_fails():
    details = shrink(failure("turn-random", seed=3)).world.failure.details
    failing, count = details["failing_seeds"]
    assert count == 40 and 0 <= details["failing_share_at_least"] <= failing / count
