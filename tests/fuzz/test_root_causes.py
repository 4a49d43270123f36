"""Causes depend on the repeated part of a run, not on its place."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fuzz.cause import Circumstance, Diagnosis
from fuzz.facts.changed_worlds import OtherWorlds, gap_that_stops
from fuzz.facts.proofs import certified
from fuzz.failure import Failure
from fuzz.overview import Cause
from fuzz.triage.behaviour import behaviour_of
from fuzz.triage.diagnosis import CAUSE, cause_of, cause_of_run, diagnosis_of, diagnosis_of_run
from fuzz.triage.repeated_moves import describe_period
from sim import Command, simulate
from sim.options.run import options_from
from tests.helpers.faulty_robots import HERE, found_by, gap, hall
from worldgen import Pose, Robot, Target, World

SHIPPED = Path(__file__).parents[2] / "corpora/failures"


class Circles:
    """Drives in circles that never quite close, and counts its steps, so that no state recurs."""

    turn = 6.02  # degrees a step
    share_of_speed = 0.5

    def reset(self):
        return (0.0,)

    def act(self, seen, memory):
        rate = math.radians(self.turn) / seen.time_step
        return Command(self.share_of_speed * seen.top_speed, rate), (memory[0] + 1.0,)


class Backs(Circles):
    """Does so backwards."""

    share_of_speed = -0.5


class Turns(Circles):
    """Creeps while it turns: a circle of a hundredth of its radius."""

    share_of_speed = 0.005


class Moves(Circles):
    """Repeats a list of moves: steps, degrees of each, and share of the top speed."""

    moves = ()

    def act(self, seen, memory):
        each = [move[1:] for move in self.moves for _ in range(move[0])]
        turn, share = each[int(memory[0]) % len(each)]
        command = Command(share * seen.top_speed, math.radians(turn) / seen.time_step)
        return command, (memory[0] + 1.0,)


class DriftsAndWaits(Moves):
    """Drives a circle, then a little straight on, and waits: it gets farther each time."""

    moves = ((30, 12.0, 1.0), (10, 0.0, 0.1), (3, 0.0, 0.0))


class Scans(Moves):
    """Drives to and fro, and turns once on the spot at each end."""

    moves = ((20, 0.0, 1.0), (9, 60.0, 0.0)) * 2


class Ovals(Moves):
    """Drives long arcs that hardly bend, and turns sharply at their ends."""

    moves = ((90, 0.2, 1.0), (6, 27.0, 1.0))


def runs_to_the_limit(controller, steps, target=(5.5, 5.5), start=(1.2, 1.2)):
    world = certified(replace(hall(60, 60, start=start), target=Target(*target, 0.01)))
    run = simulate(world, controller, steps=steps, record=True)
    assert run.verdict in ("stalled", "timeout")
    return world, run


@pytest.mark.parametrize("steps", [600, 833, 4_000])
@pytest.mark.parametrize("near", [False, True], ids=["far from the target", "around the target"])
def test_circles_without_a_proved_loop_are_circles(steps, near):
    target = (1.2, 1.32) if near else (5.5, 5.5)
    world, run = runs_to_the_limit(Circles(), steps, target)
    assert cause_of_run(world, run) == Cause.DRIVES_IN_CIRCLES
    assert describe_period(world, run) == (
        "drives about the same circle again and again, with a radius of 0.14 m, turning left, in 60 "
        "steps (0.9 s)"
    )
    assert cause_of_run(*runs_to_the_limit(Turns(), steps)) == Cause.TURNS_ON_THE_SPOT


def test_a_circle_is_driven_backwards_on_its_own_side():
    assert "circle again and again, backwards, with a radius of 0.14 m, turning left" in (
        describe_period(*runs_to_the_limit(Backs(), 600))
    )


def test_a_robot_that_gets_farther_drives_in_no_circles():
    world, run = runs_to_the_limit(DriftsAndWaits(), 3_870)
    assert cause_of_run(world, run) == Cause.WANDERS


def test_turns_on_the_spot_at_the_ends_of_a_lane_are_no_laps():
    world, run = runs_to_the_limit(Scans(), 900, start=(1.25, 1.25))
    assert cause_of_run(world, run) == Cause.GOES_BACK_AND_FORTH


def test_a_path_that_is_no_circle_is_not_called_one():
    assert "circle" not in describe_period(*runs_to_the_limit(Ovals(), 900, start=(2.0, 3.0)))


@pytest.mark.parametrize(
    ("controller", "cause"),
    [
        ("Still", Cause.STANDS_STILL),
        ("Pushes", Cause.PUSHES_A_WALL),
        ("Dithers", Cause.TURNS_ON_THE_SPOT),
        ("Backs", Cause.DRIVES_IN_CIRCLES),
        ("Wavers", Cause.PUSHES_A_WALL),
    ],
)
def test_a_plain_fault_has_the_cause_that_its_run_shows(controller, cause):
    failure = found_by(controller)
    assert failure.record.details[CAUSE] == cause.value and cause_of(failure) == cause


def test_a_robot_that_a_gap_holds_back_needs_a_wider_one():
    failure = found_by("WantsRoom", gap())
    diagnosis = diagnosis_of(failure)
    assert diagnosis == (Cause.STANDS_STILL, Circumstance.AT_A_GAP, round(0.2 / 0.07, 4))
    assert diagnosis.sentence() == "It stops for good in front of a gap of 2.9 radii."
    # Only smaller robots show it.
    alone = diagnosis_of_run(failure.world, failure.run())
    assert alone == (Cause.STANDS_STILL, None, 0.0)


def wide_gap(length=1.2):
    """A body of 0.7 m width in front of a gap of 0.8 m."""
    walls = np.zeros((40, 60), np.bool_)
    walls[:, 30:32] = True
    walls[18:26, 30:32] = False
    half = length / 2
    corners = [(half, 0.35), (-half, 0.35), (-half, -0.35), (half, -0.35)]
    robot = Robot(Pose(1.0, 2.2), Target(5.0, 2.2, 0.1), speed=1.0, footprint=corners)
    return certified(World(walls, robots=[robot]))


def test_a_robot_that_takes_its_body_for_a_disc_is_held_by_a_gap_that_fits_its_body():
    world = wide_gap()
    run = simulate(world, "dynamic-window", record=True)
    others = OtherWorlds("dynamic-window", options_from(world, None, {}))
    diagnosis = diagnosis_of_run(world, run, others)
    assert diagnosis == (Cause.PUSHES_A_WALL, Circumstance.AT_A_GAP, 0.0)
    assert diagnosis.sentence(world) == (
        "It keeps driving into a wall in front of a gap (0.05 m to spare at heading 0 degrees; it "
        "fits there only at headings within 17 degrees of 0 or 180)."
    )
    # A body that is past the gap is not held by it.
    assert gap_that_stops(world, (45.0, 22.0), lambda _: True) == 0.0
    assert gap_that_stops(world, (25.0, 22.0), lambda _: True) == pytest.approx(1.15, abs=0.01)


def test_a_gap_on_the_way_to_a_waypoint_holds_a_robot_back_and_one_behind_it_does_not():
    # Between start and target there is none; the waypoint is behind the gap.
    world = wide_gap()
    there = world.target
    robot = replace(world.robots[0], target=Target(1.0, 1.0, 0.1), waypoints=(there,))
    tour = certified(replace(world, robots=[robot]))
    disc = replace(robot, footprint=(), radius=0.3)
    round_tour = certified(replace(world, robots=[disc]))
    for one, width in ((tour, 1.15), (round_tour, 0.8 / 0.3)):
        assert gap_that_stops(one, (25.0, 22.0), lambda _: True) == pytest.approx(width, abs=0.02)
    # Both have to come back through it.
    for one in (tour, round_tour):
        assert gap_that_stops(one, (45.0, 22.0), lambda _: True) == 0.0
        assert gap_that_stops(one, (45.0, 22.0), lambda _: True, reached=1) > 0.0


def test_a_gap_that_the_robot_has_passed_does_not_hold_it_back():
    failure = found_by("StopsBehind", gap())
    assert diagnosis_of(failure) == Diagnosis(Cause.STANDS_STILL)
    smaller = replace(failure.world, robot_radius=0.05, certificate=None)
    assert OtherWorlds(failure.record.controller, failure.options).arrives(smaller)


def test_no_wall_is_between_a_robot_and_a_target_whose_edge_it_can_reach():
    at_a_wall = Target(1.05, 0.45, 0.05)
    below = certified(replace(hall(12, 5, start=(1.05, 0.08)), target=at_a_wall))
    assert diagnosis_of(found_by("Still", below)) == Diagnosis(Cause.STANDS_STILL)


@pytest.mark.parametrize("wall", [False, True])
def test_a_robot_that_never_drives_misses_nothing_and_no_wall_traps_it(wall):
    world = hall(start=(0.45, 0.25))
    if wall:
        walls = world.walls.copy()
        walls[:5, 6] = True
        world = replace(hall(start=(0.8, 0.25)), walls=walls)
    for name, cause in (("Still", Cause.STANDS_STILL), ("Spins", Cause.TURNS_ON_THE_SPOT)):
        assert diagnosis_of(found_by(name, certified(world))) == Diagnosis(cause)


def test_a_wall_that_is_gone_confuses_a_robot_that_remembers_it():
    failure = found_by("Remembers", gap(opens_at=30.0))
    assert diagnosis_of(failure) == Diagnosis(Cause.STANDS_STILL, Circumstance.AMONG_CHANGES)
    arrives = OtherWorlds(failure.record.controller, failure.options).arrives
    assert arrives(gap()) and not arrives(failure.world)


def test_local_minima_hold_a_robot_of_any_size_and_gaps_only_a_large_one():
    def circumstances(name):
        files = sorted((SHIPPED / name).rglob("*.grid"))
        return [diagnosis_of(Failure.read(file)).circumstance for file in files]

    assert Circumstance.AT_A_GAP not in circumstances("potential-field")
    assert Circumstance.AT_A_GAP in circumstances("dynamic-window")


@pytest.mark.parametrize(
    ("name", "weakness"),
    [
        ("wall-left/swept", Diagnosis(Cause.CIRCLES_AN_OBSTACLE)),
        ("turn-right/swept", Diagnosis(Cause.RETURNS_TO_A_WALL, Circumstance.FOLLOWS_NO_WALL)),
        ("tangent-bug/swept", Diagnosis(Cause.RETURNS_TO_A_WALL)),
    ],
)
def test_most_loops_of_a_library_controller_have_its_known_weakness(name, weakness):
    files = sorted((SHIPPED / name).glob("*.grid"))
    loops = [failure for failure in map(Failure.read, files) if failure.verdict == "loop"]
    found = [diagnosis_of(failure) for failure in loops]
    assert loops and found.count(weakness) >= 0.6 * len(found)


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


def circling():
    """Return the simplest shipped failure of a wall follower that goes around an island."""
    failures = map(Failure.read, (SHIPPED / "wall-left/swept").glob("*.grid"))
    found = [one for one in failures if cause_of(one) == Cause.CIRCLES_AN_OBSTACLE]
    return min(found, key=lambda one: one.order)


def test_a_recorded_cause_needs_no_run_and_a_missing_one_is_found():
    shipped = circling().without(CAUSE)
    assert cause_of(shipped) == Cause.CIRCLES_AN_OBSTACLE
    unknown = replace(shipped.record, controller="./gone.py:Robot")
    assert cause_of(replace(shipped, record=unknown)) == Cause.UNKNOWN
    recorded = replace(shipped, record=unknown).noting(cause="pushes-a-wall")
    assert cause_of(recorded) == Cause.PUSHES_A_WALL


@pytest.mark.parametrize(
    ("evidence", "sentence"),
    [
        ({"error": "killed by SIGSEGV", "signal": "SIGSEGV"}, "Its code is killed by a signal."),
        ({"error": "exit code 3", "exit_code": 3}, "Its program exits in the middle of a run."),
        ({"error": "ValueError: no", "exception": "ValueError"}, "Its code raises an error."),
    ],
)
@pytest.mark.parametrize("recorded", [{}, {CAUSE: "crashes"}])
def test_a_crash_is_described_as_it_happened(evidence, sentence, recorded):
    found = found_by("Still").without(CAUSE).noting(**recorded)
    record = replace(found.record, verdict="crash", evidence=evidence)
    diagnosis = diagnosis_of(replace(found, record=record))
    assert diagnosis.sentence() == sentence and diagnosis.cause == Cause.CRASHES


def test_a_path_around_an_island_goes_around_what_touches_it_at_a_corner():
    failure = circling()
    seen = behaviour_of(failure.world, failure.run())
    assert seen.around_island + seen.around_target >= 1 and seen.off_wall <= 1.0


MOVES = ("stays there", "pushes against it", "turns", "drives")


@pytest.mark.gate
@pytest.mark.parametrize("folder", ["failures", "thesis-faults"])
def test_a_cause_never_contradicts_the_moves_that_repeat(folder):
    """What a cause says the robot does is what one period of its run shows."""
    for file in sorted((SHIPPED.parent / folder).rglob("*.grid")):
        failure = Failure.read(file)
        if failure.verdict not in ("loop", "stalled") or failure.world.is_fleet:
            continue
        words = describe_period(failure.world, failure.run())
        moves = {move for move in MOVES if move in words}
        match cause_of(failure):
            case Cause.STANDS_STILL:
                assert moves == {"stays there"}, file
            case Cause.PUSHES_A_WALL:
                assert "wall" in words and moves <= {"pushes against it", "turns"}, file
            case Cause.TURNS_ON_THE_SPOT:
                assert "turns" in moves, file
            case Cause.RETURNS_TO_A_WALL:
                assert "wall" in words and "no wall" not in words, file
            case cause:
                assert "drives" in moves or "turns" in moves, (file, cause)
