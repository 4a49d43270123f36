"""Cars: witnesses that they can drive, and a checker that refuses those that they cannot."""

import math
from dataclasses import replace

import numpy as np
import pytest

from worldgen import (
    CellState,
    Drive,
    Event,
    Pose,
    Robot,
    Target,
    Timeline,
    Witness,
    World,
    check_certificate,
    decide,
    generate,
    read_world,
    write_world,
)
from worldgen.reach.verifying import verify_world

BEND_WIDTH, BEND_RADIUS = 1.2, 0.3
# The arc touches both outer walls, and the inner corner.
BEND_LIMIT = (math.sqrt(2) * (BEND_WIDTH - BEND_RADIUS) - BEND_RADIUS) / (math.sqrt(2) - 1)


def bend(turning_radius, *, mirrored=False, **drive):
    """Two aisles of 1.2 m that meet at a right angle, for a disc of 0.3 m."""
    free = np.zeros((60, 80), np.bool_)
    free[5:17, 2:72] = True
    free[5:58, 60:72] = True
    start, target = Pose(0.8, 1.1, 0.0), Target(6.6, 5.2, 0.3)
    if mirrored:
        free = free[::-1]
        start, target = Pose(0.8, 4.9, 0.0), Target(6.6, 0.8, 0.3)
    robot = Robot(start, target, BEND_RADIUS, 1.0, drive=Drive(turning_radius, **drive))
    return World(~free, robots=[robot])


def with_car(world, turning_radius, **drive):
    robot = replace(world.robots[0], drive=Drive(turning_radius, **drive))
    return replace(world, robots=[robot], certificate=None, provenance=None)


AHEAD = Target(2.0, 1.0, 0.1)


def open_floor(*, target=AHEAD, **drive):
    robot = Robot(Pose(0.5, 1.0, 0.0), target, 0.1, 1.0, drive=Drive(0.4, **drive))
    return World(np.zeros((20, 30), np.bool_), robots=[robot])


def path(*poses):
    """A witness through these poses, at 0.1 m/s or slower."""
    x, y, headings = (np.array(values, float) for values in zip(*poses, strict=True))
    return Witness(np.arange(len(x)) * 10.0, x, y, 0.1, headings)


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_forward_car_turns_through_a_bend_up_to_the_closed_form(mirrored):
    for share in (0.3, 0.9, 0.999):
        world = bend(share * BEND_LIMIT, mirrored=mirrored)
        decision = decide(world)
        assert decision.result == "reachable"
        assert check_certificate(world, decision.certificate).valid


@pytest.mark.gate
@pytest.mark.parametrize("mirrored", [False, True])
def test_a_forward_car_is_confined_in_a_bend_beyond_the_closed_form(mirrored):
    for share in (1.2, 1.5, 3.0):
        assert decide(bend(share * BEND_LIMIT, mirrored=mirrored)).result == "blocked"
    # Boxes cannot be as small as this takes, and the answer has to stay true.
    assert decide(bend(1.001 * BEND_LIMIT, mirrored=mirrored)).result == "undecided"


@pytest.mark.gate
def test_a_car_of_3_metres_is_confined_in_the_bend():
    answer = verify_world(bend(3.0))
    assert answer["result"] == "blocked" and answer["certificate_valid"]


def test_a_car_that_may_reverse_turns_through_a_bend_beyond_the_closed_form():
    world = bend(1.2 * BEND_LIMIT, reverse=True)
    decision = decide(world)
    assert decision.result == "reachable"
    assert check_certificate(world, decision.certificate).valid
    # The same path is none for a car that may not reverse.
    report = check_certificate(bend(1.2 * BEND_LIMIT), decision.certificate)
    assert not report.valid and "cannot drive" in report.reason


@pytest.mark.parametrize("family", ["cave", "forest", "maze", "trap"])
@pytest.mark.parametrize("reverse", [False, True])
def test_witnesses_in_families_are_valid_and_survive_a_file(tmp_path, family, reverse):
    for seed in range(3):
        world = with_car(generate(family, seed=seed), 0.1, reverse=reverse)
        decision = decide(world)
        if reverse:
            assert decision.result == "reachable"
        if decision.certificate is not None:
            proved = replace(world, certificate=decision.certificate)
            write_world(proved, tmp_path / "w.grid", force=True)
            assert read_world(tmp_path / "w.grid") == proved
            assert check_certificate(read_world(tmp_path / "w.grid")).valid


def test_equal_questions_have_equal_witnesses():
    first, second = (decide(bend(1.5, reverse=True)).certificate for _ in range(2))
    assert first == second


def test_what_stops_the_body_stops_the_car():
    walls = np.zeros((20, 30), np.bool_)
    walls[:, 15] = True
    decision = decide(replace(open_floor(reverse=True), walls=walls))
    assert decision.result == "blocked"
    assert check_certificate(
        replace(open_floor(reverse=True), walls=walls), decision.certificate
    ).valid


@pytest.mark.gate
def test_an_undecided_car_says_what_was_tried():
    reason = decide(bend(1.05 * BEND_LIMIT)).reason
    assert "turning radius" in reason and "forward only" in reason
    assert "boxes of poses down to" in reason


@pytest.mark.parametrize("heading", [0.0, math.pi / 2, math.pi, -2.0])
@pytest.mark.parametrize("reverse", [False, True])
def test_a_car_arrives_at_a_heading(heading, reverse):
    target = Target(1.8, 1.0, 0.05, heading, 0.02)
    world = open_floor(target=target, reverse=reverse)
    decision = decide(world)
    assert decision.result == "reachable"
    assert check_certificate(world, decision.certificate).valid
    off = math.remainder(decision.certificate.headings[-1] - heading, math.tau)
    assert abs(off) <= 0.02


def test_steering_that_takes_time_is_waited_for():
    at_once, slow = (decide(bend(1.0, steering_rate=rate)).certificate for rate in (0.0, 0.5))
    assert slow.duration > at_once.duration + 1.0
    assert check_certificate(bend(1.0, steering_rate=0.5), slow).valid
    # From straight to the left takes 2 s, and nothing moves meanwhile.
    stands = (np.diff(slow.x) == 0) & (np.diff(slow.y) == 0)
    assert min(np.diff(slow.times)[stands]) >= 2.0 and not np.diff(slow.headings)[stands].any()


def test_in_a_changing_world_the_path_avoids_all_that_is_ever_blocked():
    closes = Timeline.of([Event(5.0, 15, iy, CellState.SOLID) for iy in range(8, 20)])
    world = replace(open_floor(), timeline=closes)
    decision = decide(world)
    assert decision.result == "reachable"
    assert check_certificate(world, decision.certificate).valid


STRAIGHT = path((0.5, 1.0, 0.0), (2.0, 1.0, 0.0))
ARC = [(0.5 + 0.4 * math.sin(a), 1.4 - 0.4 * math.cos(a), a) for a in np.linspace(0, 1.0, 60)]


def arc_world():
    x, y, _ = ARC[-1]
    return open_floor(target=Target(x, y, 0.05))


def aisle_with_a_door(*, opens, closes=(), **parts):
    """An aisle with a door across it that opens, and may close again."""
    walls = np.ones((10, 60), np.bool_)
    walls[1:9, 1:59] = False
    events = [Event(opens, 30, iy, CellState.FREE) for iy in range(1, 9)]
    events += [Event(time, 30, iy, CellState.SOLID) for time in closes for iy in range(1, 9)]
    walls[1:9, 30] = True
    start = Pose(0.5, 0.5, parts.pop("heading", 0.0))
    robot = Robot(start, Target(5.0, 0.5, 0.1), **{"radius": 0.2, **parts})
    return World(walls, robots=[robot], timeline=Timeline.of(events))


@pytest.mark.parametrize(
    "parts",
    [
        {"drive": Drive(1.0)},
        pytest.param(
            {"drive": Drive(1.0, steering_rate=0.5), "heading": 0.3}, marks=pytest.mark.gate
        ),
        {"drive": Drive(1.0), "footprint": ((0.2, 0.1), (-0.2, 0.1), (-0.2, -0.1), (0.2, -0.1))},
    ],
    ids=["disc", "steers", "footprint"],
)
def test_a_car_waits_until_a_door_opens(parts):
    world = aisle_with_a_door(opens=20.0, **parts)
    decision = decide(world)
    assert decision.result == "reachable"
    assert check_certificate(world, decision.certificate).valid
    assert decision.certificate.duration > 20.0
    # It still steers while it stands.
    legs = (np.diff(getattr(decision.certificate, name)) for name in ("x", "y", "headings"))
    stands = ~np.any([leg != 0.0 for leg in legs], axis=0)
    rate = parts["drive"].steering_rate
    assert not rate or (np.diff(decision.certificate.times)[stands] >= 1.0 / rate).sum() > 1
    # The same path at other times leads through the door.
    early = replace(decision.certificate, times=decision.certificate.times / 2)
    assert not check_certificate(world, early).valid


@pytest.mark.gate
def test_a_car_does_not_wait_for_a_door_that_closes_too_soon():
    assert (
        decide(aisle_with_a_door(opens=20.0, closes=(20.1,), drive=Drive(1.0))).result
        != "reachable"
    )
    assert (
        decide(aisle_with_a_door(opens=20.0, closes=(28.0,), drive=Drive(1.0))).result
        == "reachable"
    )


def test_a_straight_line_and_an_arc_of_the_turning_circle_are_accepted():
    assert check_certificate(open_floor(), STRAIGHT).valid
    assert check_certificate(arc_world(), path(*ARC)).valid


@pytest.mark.parametrize(
    ("witness", "reason"),
    [
        (
            path((0.5, 1.0, 0.0), (1.0, 1.0, 0.0), (1.0, 1.02, 0.0), (2.0, 1.02, 0.0)),
            "cannot drive",
        ),
        (path((0.5, 1.0, 0.0), (0.4, 1.0, 0.0), (2.0, 1.0, 0.0)), "without reverse"),
        (path((0.5, 1.0, 0.0), (1.0, 1.0, 0.0), (1.0, 1.0, 0.1), (2.0, 1.1, 0.1)), "cannot drive"),
        (path((0.5, 1.0, 0.5), (2.0, 1.0, 0.5)), "start's heading"),
        (path((0.5, 1.0, 0.0), (1.0, 1.0, math.nan), (2.0, 1.0, 0.0)), "not finite"),
        (replace(STRAIGHT, headings=None), "needs headings"),
    ],
    ids=["slides", "reverses", "turns-on-the-spot", "starts-askew", "nan", "no-headings"],
)
def test_the_checker_refuses_what_a_car_cannot_drive(witness, reason):
    report = check_certificate(open_floor(), witness)
    assert not report.valid and reason in report.reason


def test_the_checker_refuses_an_arc_that_is_too_tight_or_too_coarse():
    tight = replace(arc_world(), robots=[replace(arc_world().robots[0], drive=Drive(0.42))])
    assert "cannot drive" in check_certificate(tight, path(*ARC)).reason
    coarse = path(*ARC[:1], *ARC[-1:])
    assert not check_certificate(arc_world(), coarse).valid


def test_many_small_cheats_add_up():
    # Each leg is moved sideways by less than the bound for one.
    x, y, headings = np.linspace(0.5, 2.0, 200), np.linspace(1.0, 1.02, 200), np.zeros(200)
    crab = Witness(np.arange(200.0), x, y, 0.1, headings)
    assert "cannot drive" in check_certificate(open_floor(), crab).reason


def with_footprint(world, length, width, ahead=0.0):
    corners = [
        (x * length / 2 + ahead, y * width / 2) for x, y in ((1, 1), (-1, 1), (-1, -1), (1, -1))
    ]
    robot = replace(world.robots[0], footprint=corners)
    return replace(world, robots=[robot], certificate=None, provenance=None)


def test_a_car_with_a_footprint_has_a_witness_that_survives_a_file(tmp_path):
    world = with_footprint(with_car(generate("cave", seed=0), 0.1, reverse=True), 0.2, 0.1)
    decision = decide(world)
    assert decision.result == "reachable"
    proved = replace(world, certificate=decision.certificate)
    write_world(proved, tmp_path / "w.grid", force=True)
    assert read_world(tmp_path / "w.grid") == proved
    assert check_certificate(read_world(tmp_path / "w.grid")).valid


def test_a_long_car_that_sweeps_a_corner_needs_the_room_that_its_footprint_takes():
    # The axle's path is that of a disc; the body around it is longer than the bend is wide.
    short, long = (with_footprint(bend(1.0), length, 0.4) for length in (0.6, 2.4))
    assert decide(short).result == "reachable"
    assert check_certificate(short, decide(short).certificate).valid
    assert decide(long).result != "reachable"
    # A proof about one body is none about a longer one.
    swapped = check_certificate(with_footprint(bend(1.0), 1.6, 0.4), decide(short).certificate)
    assert not swapped.valid


def test_a_long_car_turns_around_in_a_room_only_if_it_may_reverse():
    room = World(
        np.zeros((16, 16), np.bool_), Pose(0.8, 0.8, 0.0), Target(0.8, 0.8, 0.1, math.pi, 0.1)
    )
    forwards, both = (
        with_footprint(with_car(room, 0.7, reverse=reverse), 0.6, 0.3) for reverse in (False, True)
    )
    answer = verify_world(forwards)
    assert answer["result"] == "blocked" and answer["certificate_valid"]
    assert check_certificate(both, decide(both).certificate).valid
