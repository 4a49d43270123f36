"""Causes depend on the repeated part of a run, not on its place."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fuzz.facts.changed_worlds import OtherWorlds
from fuzz.facts.proofs import certified
from fuzz.failure import Failure
from fuzz.overview import Cause
from fuzz.triage.behaviour import behaviour_of
from fuzz.triage.diagnosis import CAUSE, cause_of, cause_of_run
from sim import simulate
from tests.helpers.faulty_robots import HERE, found_by, gap, hall
from worldgen import Pose, Target, World

SHIPPED = Path(__file__).parents[2] / "corpora/failures"


@pytest.mark.parametrize(
    ("controller", "cause"),
    [
        ("Still", Cause.STANDS_STILL),
        ("Pushes", Cause.PUSHES_A_WALL),
        ("Dithers", Cause.TURNS_BACK_AND_FORTH),
        ("Backs", Cause.DRIVES_IN_CIRCLES),
        ("Wavers", Cause.PUSHES_A_WALL),
    ],
)
def test_a_plain_fault_has_the_cause_that_its_run_shows(controller, cause):
    failure = found_by(controller)
    assert failure.record.details[CAUSE] == cause.value and cause_of(failure) == cause


def test_a_robot_that_a_gap_holds_back_needs_a_wider_one():
    failure = found_by("WantsRoom", gap())
    assert failure.record.details[CAUSE] == Cause.NEEDS_A_WIDER_GAP.value
    assert cause_of_run(failure.world, failure.run()) == Cause.STANDS_STILL


def test_a_gap_that_the_robot_has_passed_does_not_hold_it_back():
    failure = found_by("StopsBehind", gap())
    assert failure.record.details[CAUSE] == Cause.STANDS_STILL.value
    smaller = replace(failure.world, robot_radius=0.05, certificate=None)
    assert OtherWorlds(failure.record.controller, failure.options).arrives(smaller)


def test_no_wall_is_between_a_robot_and_a_target_whose_edge_it_can_reach():
    at_a_wall = Target(1.05, 0.45, 0.05)
    below = certified(replace(hall(12, 5, start=(1.05, 0.08)), target=at_a_wall))
    assert found_by("Still", below).record.details[CAUSE] == Cause.STANDS_STILL.value


@pytest.mark.parametrize("wall", [False, True])
def test_a_robot_that_never_drives_misses_nothing_and_no_wall_traps_it(wall):
    world = hall(start=(0.45, 0.25))
    if wall:
        walls = world.walls.copy()
        walls[:5, 6] = True
        world = replace(hall(start=(0.8, 0.25)), walls=walls)
    for name, cause in (("Still", Cause.STANDS_STILL), ("Spins", Cause.TURNS_BACK_AND_FORTH)):
        assert found_by(name, certified(world)).record.details[CAUSE] == cause.value


def test_a_wall_that_is_gone_confuses_a_robot_that_remembers_it():
    failure = found_by("Remembers", gap(opens_at=30.0))
    assert failure.record.details[CAUSE] == Cause.CONFUSED_BY_CHANGES.value
    assert cause_of(failure) == Cause.CONFUSED_BY_CHANGES
    arrives = OtherWorlds(failure.record.controller, failure.options).arrives
    assert arrives(gap()) and not arrives(failure.world)


def test_local_minima_hold_a_robot_of_any_size_and_gaps_only_a_large_one():
    def causes(name):
        files = sorted((SHIPPED / name).rglob("*.grid"))
        return [cause_of(one) for one in map(Failure.read, files) if one.verdict != "timeout"]

    assert Cause.NEEDS_A_WIDER_GAP not in causes("potential-field")
    assert Cause.NEEDS_A_WIDER_GAP in causes("dynamic-window")


@pytest.mark.parametrize(
    ("name", "cause"),
    [
        ("wall-left/swept", Cause.CIRCLES_A_WALL),
        ("turn-right/swept", Cause.BOUNCES_BETWEEN_WALLS),
        ("tangent-bug/swept", Cause.RETURNS_TO_THE_WALL),
    ],
)
def test_most_loops_of_a_library_controller_have_its_known_weakness(name, cause):
    loops = [Failure.read(path) for path in sorted((SHIPPED / name).glob("loop-*.grid"))]
    causes = [cause_of(failure) for failure in loops]
    assert loops and causes.count(cause) >= 0.6 * len(causes)


def test_a_cause_is_the_same_in_a_world_that_is_turned_by_a_quarter():
    failure = found_by("Pushes")
    world = failure.world
    turned = World(
        np.rot90(world.walls).copy(),
        start=Pose(
            world.height * world.cell_size - world.start.y,
            world.start.x,
            world.start.heading + math.pi / 2,
        ),
        target=Target(
            world.height * world.cell_size - world.target.y, world.target.x, world.target.radius
        ),
        cell_size=world.cell_size,
        robot_radius=world.robot_radius,
    )
    episode = simulate(turned, f"{HERE}:Pushes", record=True)
    assert cause_of_run(turned, episode) == cause_of(failure)


def test_a_recorded_cause_needs_no_run_and_a_missing_one_is_found():
    shipped = Failure.read(next((SHIPPED / "wall-left/swept").glob("loop-*round*.grid")))
    assert CAUSE not in shipped.record.details and cause_of(shipped) == Cause.CIRCLES_A_WALL
    unknown = replace(shipped.record, controller="./gone.py:Robot")
    assert cause_of(replace(shipped, record=unknown)) == Cause.UNKNOWN
    recorded = replace(shipped, record=unknown).noting(cause="pushes-a-wall")
    assert cause_of(recorded) == Cause.PUSHES_A_WALL


def test_a_path_around_an_island_goes_around_what_touches_it_at_a_corner():
    path = next((SHIPPED / "wall-left/swept").glob("loop-*round*.grid"))
    failure = Failure.read(path)
    seen = behaviour_of(failure.world, failure.run())
    assert seen.around_island + seen.around_target >= 1 and seen.off_wall <= 1.0
