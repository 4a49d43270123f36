"""Shrinking: the result is small, still fails, is still proved, and nothing more can be removed."""

import functools
import math
from dataclasses import replace

import numpy as np
import pytest

from fuzz.campaign.unit import run_unit
from fuzz.facts.proofs import certified
from fuzz.failure import Failure
from fuzz.shrink import removable, shrink
from fuzz.shrink.edits import drop_lines, free_cells
from fuzz.shrink.minimal import removed
from fuzz.shrink.predicate import StillFails
from fuzz.simplicity import Case, number_cost, rounder, simplicity
from fuzz.triage.judging import failure_of
from fuzz.triage.replaying import replay
from fuzz.unit.config import CampaignConfig
from sim.options.run import RunOptions
from sim.options.thesis import ThesisOptions
from sim.runners.edited import has_sure_path
from sim.scenario import Scenario
from tests.helpers.raising import raises
from worldgen import (
    CellState,
    Event,
    InvalidParameter,
    Pose,
    Target,
    Timeline,
    Witness,
    World,
    WorldgenError,
    check_certificate,
    generate,
)


def cup_world():
    walls = np.zeros((20, 20), bool)
    walls[[0, -1], :] = walls[:, [0, -1]] = True
    walls[12, 5:15] = True
    walls[7:12, 5] = walls[7:12, 14] = True
    walls[3, 2:5] = walls[16, 15:17] = True
    return World(walls, Pose(1.05, 0.45, math.pi / 2), Target(1.05, 1.65, 0.05))


def failure(controller="turn-right", motion="swept", **scenario):
    return failure_of(
        certified(cup_world()),
        Scenario(controller, RunOptions(motion, **scenario)),
        fewest_steps=20_000,
    )


@pytest.fixture(scope="module")
def shrunk():
    return shrink(failure())


def test_a_trap_shrinks_to_a_few_cells(shrunk):
    assert shrunk.before > 80 and shrunk.after <= 8


def test_the_shrunk_world_fails_with_the_same_verdict_and_replays(shrunk):
    assert shrunk.failure.record.verdict == "loop" and replay(shrunk.failure).confirmed


def test_the_shrunk_world_carries_a_witness_that_the_checker_accepts(shrunk):
    assert (
        isinstance(shrunk.failure.world.certificate, Witness)
        and check_certificate(shrunk.failure.world).valid
    )


def test_nothing_more_can_be_removed(shrunk):
    assert shrunk.left == () and shrunk.complete


def test_the_check_of_minimality_sees_a_cell_too_many():
    world = certified(cup_world())
    still_fails = StillFails(Scenario("turn-right"), "loop", 20_000)
    assert any(name.startswith("cell") for name in removable(world, still_fails))


@pytest.mark.parametrize("family", ["trap", "fire", "doorway"])
def test_the_check_of_minimality_and_the_shrinker_cut_a_world_alike(family):
    world = generate(family, seed=0).bare
    left = dict(removed(world, lambda candidate: candidate))
    for row in range(world.height):
        assert left.get(f"row {row}") == drop_lines(world, row, 1, 0)
    for column in range(world.width):
        assert left.get(f"column {column}") == drop_lines(world, column, 1, 1)
    for iy, ix in np.argwhere(world.walls).tolist():
        assert left[f"cell ({ix}, {iy})"] == free_cells(world, [(ix, iy)])


def test_shrinking_twice_changes_nothing(shrunk):
    again = shrink(shrunk.failure).failure
    assert (
        np.array_equal(again.world.walls, shrunk.failure.world.walls)
        and again.world.start == shrunk.failure.world.start
    )


def test_out_of_time_the_best_so_far_comes_back():
    result = shrink(failure(), seconds=1e-9)
    assert not result.complete and replay(result.failure).confirmed


@pytest.mark.gate
def test_shrinking_keeps_the_thesis_robots_noise_and_sensor():
    made = failure("turn-right", "stepped", thesis=ThesisOptions(noise=True, sensor_range=50))
    result = shrink(made, seconds=5.0).failure.record
    assert (result.parameters["noise"], result.parameters["sensor_range"]) == (True, 50)


def test_a_world_without_failure_is_refused():
    with raises(InvalidParameter, "no-failure"):
        shrink(Failure.of(cup_world()))


def test_a_failure_that_does_not_fail_is_refused():
    made = failure()
    fine = replace(made, record=replace(made.record, verdict="tunnel"))
    with raises(InvalidParameter, "does-not-fail-so", verdict="tunnel"):
        shrink(fine)


def test_dropping_a_row_moves_what_lies_above():
    world = drop_lines(cup_world().bare, 5, 1, axis=0)
    assert (world.height, world.start.y, world.target.y) == (19, 0.45, 1.55)


def test_dropping_a_column_moves_what_lies_right_of_it():
    world = drop_lines(cup_world().bare, 2, 2, axis=1)
    assert (world.width, world.start.x, world.target.x) == (18, 0.85, 0.85)


@pytest.mark.parametrize("axis", [0, 1], ids=["rows", "columns"])
def test_all_rows_and_columns_but_one_can_be_dropped(axis):
    world = World(np.zeros((3, 3), bool), Pose(0.05, 0.05), Target(0.05, 0.05, 0.05))
    left = drop_lines(world, 1, 2, axis)
    assert left.walls.shape == ((1, 3) if axis == 0 else (3, 1))
    assert drop_lines(left, 0, 1, axis) is None


def test_freeing_a_free_cell_is_no_edit():
    assert free_cells(cup_world(), [(1, 1)]) is None


def test_events_move_and_go_with_their_rows():
    timeline = Timeline.of([Event(1.0, 3, 4, CellState.SOLID), Event(2.0, 3, 9, CellState.BURNING)])
    world = drop_lines(replace(cup_world(), timeline=timeline), 4, 1, axis=0)
    assert [(event.ix, event.iy) for event in world.timeline] == [(3, 8)]


def test_a_random_controllers_failure_says_for_how_many_seeds_it_fails():
    details = shrink(failure("turn-random", seed=3)).failure.record.details
    failing, count = details["failing_seeds"]
    assert count == 40 and 0 <= details["failing_share_at_least"] <= failing / count


SCENARIOS = [
    ("turn-right", "swept"),
    ("turn-left", "endpoint"),
    ("turn-right", "stepped"),
    ("vfh", "swept"),
]


@functools.cache
def found(controller, motion, family="features"):
    scenario = Scenario.parse(controller, motion=motion)
    config = CampaignConfig(
        scenario, seed=5, families=(family,), time_steps=(scenario.run.time_step,), examples=100
    )
    return [world for _, world in sorted(run_unit(config, 0).failures.items())][:4]


@functools.cache
def shrunk_found(controller, motion, family="features"):
    return [shrink(world) for world in found(controller, motion, family)]


def plain_neighbours(world):
    """Yield every world with one solid cell, row or column removed, using plain NumPy."""
    for iy, ix in np.argwhere(world.walls):
        walls = world.walls.copy()
        walls[iy, ix] = False
        yield replace(world, walls=walls)
    for axis, lines in enumerate(world.walls.shape):
        for line in range(lines if lines > 1 else 0):
            yield drop_lines(world, line, 1, axis)


def fails_alike(world, failure):
    """Take the steps that a user would take: prove, run, compare."""
    record, options = failure.record, failure.options
    proved = None if world is None else certified(world.bare)
    if proved is None:
        return False
    try:
        made = failure_of(proved, Scenario(record.controller, options), steps=options.steps)
    except WorldgenError:
        return False
    mine, theirs = (made.record if made else None), failure.record
    return mine is not None and (mine.verdict, mine.evidence.get("cause")) == (
        theirs.verdict, theirs.evidence.get("cause"),
    )  # fmt: skip


@pytest.mark.gate
@pytest.mark.parametrize(("controller", "motion", "family"), [*((*one, "features") for one in SCENARIOS),
                                                               ("turn-right", "swept", "fire")])  # fmt: skip
def test_results_are_one_minimal_by_brute_force(controller, motion, family):
    results = shrunk_found(controller, motion, family)
    assert results and all(result.failure.record.details["one_minimal"] for result in results)
    for result in results:
        assert not any(
            fails_alike(near, result.failure) for near in plain_neighbours(result.failure.world)
        )


@pytest.mark.gate
@pytest.mark.parametrize(("controller", "motion"), SCENARIOS)
def test_what_is_shrunk_keeps_verdict_and_cause_and_replays(controller, motion):
    for before, after in zip(
        found(controller, motion), shrunk_found(controller, motion), strict=True
    ):
        old, new = before.record, after.failure.record
        assert (new.verdict, new.evidence.get("cause")) == (old.verdict, old.evidence.get("cause"))
        assert new.details["cause"] == old.details["cause"]
        assert removable(after.failure.world, StillFails.of(after.failure)) == []
        assert replay(after.failure).confirmed


@pytest.mark.gate
def test_each_edit_that_is_taken_makes_the_failure_simpler():
    for before in found("turn-right", "swept"):
        seen = [before.world]
        shrink(before, progress=seen.append)
        scenario = before.scenario
        order = [simplicity(Case(world, scenario))[:6] for world in seen]
        assert len(order) > 3 and order == sorted(order, reverse=True)


def test_a_shrunk_failure_names_the_one_that_it_came_from():
    before = failure()
    once = shrink(before).failure
    assert once.record.details["original"] == before.id
    assert shrink(once).failure.record.details["original"] == before.id


def test_odd_numbers_of_the_world_and_the_run_become_simple():
    world = replace(
        cup_world(),
        start=Pose(1.06, 0.44, 1.5),
        target=Target(1.05, 1.64, 0.0613),
        robot_radius=0.0687,
    )
    made = failure_of(
        certified(world), Scenario("turn-right", RunOptions(time_step=0.0173)), fewest_steps=20_000
    )
    small = shrink(made).failure
    assert (
        small.world.robot_radius,
        small.world.target.radius,
        small.record.parameters["time_step"],
    ) == (0.07, 0.05, 0.015)
    assert small.world.start.heading % (math.pi / 2) == 0.0


@pytest.mark.parametrize(
    ("value", "usual", "simplest"), [(0.0687, 0.07, 0.07), (0.0687, 0.0, 0.0), (3.7, 2.0, 2.0)]
)
def test_rounder_numbers_come_simplest_first(value, usual, simplest):
    numbers = list(rounder(value, usual))
    costs = [number_cost(number, usual) for number in numbers]
    assert (
        numbers[0] == simplest and costs == sorted(costs) and max(costs) < number_cost(value, usual)
    )


def test_the_quick_look_at_the_way_never_sees_one_that_is_not_there():
    walls = np.zeros((6, 6), bool)
    walls[:, 3] = True
    shut = World(walls, Pose(0.05, 0.05, 0.0), Target(0.55, 0.55, 0.05), robot_radius=0.03)
    gap = walls.copy()
    gap[2, 3] = False
    assert not has_sure_path(shut) and has_sure_path(replace(shut, walls=gap))
    assert not has_sure_path(replace(shut, walls=gap, robot_radius=0.051))


@pytest.mark.parametrize(("radius", "seen"), [(0.07, True), (0.0708, False)])
def test_the_quick_look_goes_through_a_diagonal_gap_that_is_just_wide_enough(radius, seen):
    walls = np.zeros((8, 8), bool)
    walls[4:, :4] = walls[:3, 5:] = True  # their corners are the square root of two cells apart
    assert (
        has_sure_path(
            World(walls, Pose(0.15, 0.15, 0.0), Target(0.65, 0.65, 0.05), robot_radius=radius)
        )
        is seen
    )


def test_a_world_too_large_for_a_quick_look_is_shrunk_by_the_exact_judge(monkeypatch):
    monkeypatch.setattr("fuzz.shrink.trying._MOST_CELLS", 60)
    small = shrink(failure())
    assert small.left == () and replay(small.failure).confirmed
