"""Bodies and cars under ``swept`` and ``endpoint``: turns, contacts, loops, and what is refused."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

from fuzz.evidence_checks import check_evidence
from sim import Command, RobotOptions, RunOptions, simulate
from sim.episode import prepare
from sim.motion import MOTIONS
from worldgen import World, generate
from worldgen.errors import InvalidParameter, InvalidWorld
from worldgen.robot import Drive, Pose, Robot, Target
from worldgen.timeline import CellState, Event, Timeline

SIDE = 0.1
STEP = 0.1
TURN = 2.0 * math.pi / 65_536


def box(length, width, ahead=0.0):
    """Return the corners of a rectangle whose middle is some way ahead of the axle."""
    signs = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    return tuple((ahead + sx * length / 2, sy * width / 2) for sx, sy in signs)


def hall(width, height, robot, start, events=()):
    """Return a hall without pillars, whose target is out of reach."""
    target = replace(robot.target, x=0.05, y=0.05, radius=1e-6)
    robot = replace(robot, start=start, target=target)
    timeline = Timeline.of(events)
    return World(
        np.zeros((height, width), bool), robots=(robot,), cell_size=SIDE, timeline=timeline
    )


ROBOT = Robot(Pose(0.0, 0.0), Target(0.0, 0.0, 0.1), speed=1.0)
BAR = replace(ROBOT, footprint=box(0.8, 0.1))


@dataclass(frozen=True)
class Commands:
    """Gives fixed commands, one after another, then stands; remembers the bumps."""

    commands: tuple[tuple[float, float], ...]
    senses = ("bump", "bump_bearing")

    def reset(self):
        return (0.0, 0.0, 0.0)

    def act(self, seen, memory):
        number = int(memory[0])
        speed, rate = self.commands[number] if number < len(self.commands) else (0.0, 0.0)
        bumps = memory[1] + 2.0**number * seen.bump
        bearing = seen.bump_bearing if seen.bump else memory[2]
        return Command(speed, rate), (memory[0] + 1.0, bumps, bearing)


def drive(world, *commands, motion="swept", steps=None, **robot):
    """Run commands, and return the recorded run."""
    options = RunOptions(
        motion, len(commands) + 2 if steps is None else steps, STEP, robot=RobotOptions(**robot)
    )
    return simulate(world, Commands(commands), options, record=True)


@pytest.mark.parametrize("motion", ["swept", "endpoint"])
def test_a_turn_that_is_cut_short_is_sensed_in_the_next_step_and_counted(motion):
    world = hall(20, 5, BAR, Pose(1.0, 0.25))
    run = drive(world, (0.0, 0.0), (0.0, math.pi / 2 / STEP), (0.0, 0.0), motion=motion)
    trace = run.trace
    assert trace.bump.tolist() == [False, False, False, True, False, False]
    assert run.collisions == 1
    assert trace.memory(3)[1] == 4.0  # the third step, and no other, felt it
    if motion == "swept":
        # sin(a) * 0.4 + cos(a) * 0.05 = 0.25, and the wall is to the left or behind on the right.
        angle = trace.heading[2]
        assert 0.4 * math.sin(angle) + 0.05 * math.cos(angle) == pytest.approx(0.25, abs=1e-4)
        assert abs(trace.memory(3)[2]) == pytest.approx(math.pi / 2 + angle, abs=1e-3) or abs(
            trace.memory(3)[2]
        ) == pytest.approx(math.pi / 2 - angle, abs=1e-3)
    else:
        assert trace.heading[2] == 0.0


def test_a_turn_of_half_a_circle_passes_every_heading_on_its_way():
    world = hall(20, 5, BAR, Pose(1.0, 0.25))
    run = drive(world, (0.0, math.pi / STEP))
    # The bar would be clear at the end, but not on the way.
    assert 0.5 < run.trace.heading[1] < 0.7
    jumps = drive(world, (0.0, math.pi / STEP), motion="endpoint")
    assert abs(jumps.trace.heading[1]) == pytest.approx(math.pi, abs=2 * TURN)


@pytest.mark.parametrize("motion", ["swept", "endpoint"])
@pytest.mark.parametrize(
    "commands", [((0.0, 4.0), (0.0, 4.0), (0.0, 4.0)), ((1.0, 0.0),) * 9], ids=["turn", "move"]
)
def test_contact_may_be_a_failure_with_evidence(commands, motion):
    forbidden = replace(BAR, target=replace(BAR.target, contact="fail"))
    world = hall(20, 5, forbidden, Pose(1.2, 0.25))
    run = drive(world, *commands, motion=motion)
    assert run.verdict == "contact" and run.trace.bump[-1]
    assert not check_evidence(run.verdict, world, run.trace, run.evidence, MOTIONS.get(motion))


def test_a_body_that_pushes_against_a_wall_slides_and_one_that_stops_does_not():
    start = Pose(1.0, 0.25, -0.3)
    for contact, moved in (("slide", 0.38), ("stop", 0.27)):
        robot = replace(BAR, target=replace(BAR.target, contact=contact))
        run = drive(hall(30, 9, robot, start), *((1.0, 0.0),) * 4)
        assert run.trace.x[5] - run.trace.x[0] == pytest.approx(moved, abs=0.01)
        assert run.trace.bump[4:6].all()
        # Its lower right corner is at the wall.
        low = run.trace.y[5] - 0.4 * math.sin(0.3) - 0.05 * math.cos(0.3)
        assert low == pytest.approx(0.0, abs=5e-4)


def test_a_body_that_is_stuck_for_good_is_a_proved_loop():
    world = hall(20, 5, BAR, Pose(1.0, 0.25))
    run = simulate(world, "turn-left", RunOptions("swept", 4_000, STEP))
    assert run.verdict == "loop"
    longer = run.evidence.entry + 2 * run.evidence.period
    prepared = prepare(world, "turn-left", RunOptions("swept", longer, STEP))
    run = replace(run, trace=prepared.run(longer, find_loop=False, record=True).trace)
    assert not check_evidence(run.verdict, world, run.trace, run.evidence, MOTIONS.get("swept"))


def test_a_start_at_which_only_another_heading_is_clear_names_the_heading():
    world = hall(20, 5, BAR, Pose(1.0, 0.25, 1.5))
    with pytest.raises(InvalidWorld, match=r"heading 1\.5 rad") as caught:
        drive(world, (0.0, 0.0))
    assert caught.value.code == "start-in-wall"
    assert drive(hall(20, 5, BAR, Pose(1.0, 0.25, 3.14)), (0.0, 0.0)).steps


def test_debris_and_fire_catch_a_body_by_its_corners_only():
    start = Pose(1.0, 0.45)
    for ix, iy, burned in ((13, 4, True), (10, 5, False), (10, 4, True)):
        for state in (CellState.SOLID, CellState.BURNING):
            world = hall(20, 9, BAR, start, [Event(0.15, ix, iy, state)])
            run = drive(world, *((0.0, 0.0),) * 4)
            assert (run.verdict == "burned") == burned
            if burned:
                motion = MOTIONS.get("swept")
                assert not check_evidence("burned", world, run.trace, run.evidence, motion)


def test_a_turn_through_fire_burns():
    world = hall(20, 20, BAR, Pose(1.0, 1.0), [Event(0.05, 13, 11, CellState.BURNING)])
    turns = ((0.0, 0.0), (0.0, math.pi / 2 / STEP))
    run = drive(world, *turns)
    assert run.verdict == "burned" and run.steps == 2
    assert not check_evidence("burned", world, run.trace, run.evidence, MOTIONS.get("swept"))
    far = hall(20, 20, BAR, Pose(1.0, 1.0), [Event(0.05, 17, 17, CellState.BURNING)])
    assert drive(far, *turns).verdict != "burned"


def test_a_push_turns_a_body_only_as_far_as_it_is_clear():
    world = hall(20, 5, BAR, Pose(1.0, 0.25))
    pushed = drive(world, *((0.0, 0.0),) * 3, pushes=(0.1, 0.2, 0.0, 1.5))
    assert 0.5 < pushed.trace.heading[1] < 0.7 and pushed.trace.x[1] == pytest.approx(1.2)
    assert pushed.trace.bump[1]


def test_a_body_under_endpoint_may_tunnel_and_overlap_with_evidence():
    cells = np.zeros((9, 40), bool)
    cells[:, 20] = True
    robot = replace(BAR, footprint=box(0.2, 0.1), start=Pose(1.5, 0.45), speed=8.0)
    world = World(cells, robots=(replace(robot, target=Target(0.05, 0.05, 1e-6)),), cell_size=SIDE)
    run = drive(world, (8.0, 0.0), motion="endpoint")
    assert run.verdict == "tunnel"
    assert not check_evidence("tunnel", world, run.trace, run.evidence, MOTIONS.get("endpoint"))
    assert drive(world, (8.0, 0.0)).trace.x[-1] == pytest.approx(1.9, abs=1e-3)


CAR = replace(ROBOT, drive=Drive(0.5))


def turns_of(trace):
    """Return the turn and the length of each step."""
    turn = np.remainder(np.diff(trace.heading) + math.pi, 2 * math.pi) - math.pi
    length = np.zeros(len(turn))
    ways = np.hypot(np.diff(trace.path_x), np.diff(trace.path_y))
    np.add.at(length, trace.path_step[1:] - 1, ways)
    return turn, length


def pillars(robot, start):
    """Return a hall with pillars."""
    world = hall(60, 60, robot, start)
    cells = np.zeros((60, 60), bool)
    cells[7::14, 7::14] = True
    return replace(world, walls=cells)


@pytest.mark.parametrize("motion", ["swept", "endpoint"])
@pytest.mark.parametrize("body", [(), box(0.3, 0.2, 0.1)], ids=["disc", "body"])
def test_a_car_never_turns_more_than_its_way_allows(body, motion):
    robot = Robot(
        ROBOT.start, ROBOT.target, 0.15, 2.0, footprint=body, drive=Drive(0.5, reverse=True)
    )
    numbers = np.random.default_rng(3).uniform(-1.0, 1.0, (60, 2)) * [2.0, 8.0]
    commands = np.repeat(numbers, 10, axis=0).tolist()
    for options in ({}, {"slip": 0.3, "acceleration": 1.0, "friction": 1.0}):
        run = drive(pillars(robot, Pose(3.0, 2.5)), *commands, motion=motion, **options)
        assert run.trace.bump.any()
        turn, length = turns_of(run.trace)
        assert (np.abs(turn) <= length / 0.5 + 2 * TURN + 0.02 * SIDE).all()
        assert np.abs(turn).max() > 0.2


def off_its_arcs(trace, radius):
    """Return by how much a car's exact place leaves an arc in each step, and how far it turns too much.

    Both are shares of what it drives, or of a lattice unit if that is more.
    """
    words = trace.states.astype(np.int64)
    place = words[:, :2] + words[:, -2:] / 256
    dx, dy = np.diff(place, axis=0).T
    turn = (np.diff(words[:, 2]) + 32768) % 65536 - 32768
    middle = (words[:-1, 2] + turn / 2) * TURN
    driven = np.maximum(np.hypot(dx, dy), 1.0)
    # The least chord of an arc with this turn.
    chord = 2.0 * radius * np.sin(np.maximum(np.abs(turn) - 2, 0) * TURN / 2.0)
    across = np.abs(dy * np.cos(middle) - dx * np.sin(middle))
    return across / driven, (chord - np.hypot(dx, dy)) / driven


@pytest.mark.parametrize("speed", [0.015, 2.0])
@pytest.mark.parametrize("body", [(), box(0.3, 0.2, 0.1)], ids=["disc", "body"])
def test_a_car_is_always_on_its_arcs_also_at_walls_and_where_it_is_slow(body, speed):
    robot = Robot(
        ROBOT.start, ROBOT.target, 0.15, speed, footprint=body, drive=Drive(0.5, reverse=True)
    )
    numbers = np.random.default_rng(4).uniform(-1.0, 1.0, (100, 2)) * [speed, 4.0 * speed]
    commands = np.repeat(numbers, 10, axis=0).tolist()
    trace = drive(pillars(robot, Pose(3.0, 2.5)), *commands).trace
    assert trace.bump.sum() > 100 or speed < 1.0
    across, turned = off_its_arcs(trace, 0.5 / SIDE * 1024)
    assert across.max() < 0.004 and turned.max() < 0.004


def test_a_car_with_full_lock_at_a_wall_stands_and_has_driven_nothing():
    # It used to creep along the wall, by a unit of rounding a step.
    for heading, rate in ((0.3, 9.0), (0.3, -9.0), (-0.9, 9.0), (0.01, -9.0)):
        run = drive(hall(40, 40, CAR, Pose(3.6, 2.0, heading)), *((1.0, rate),) * 1000)
        assert run.trace.bump[10:1000].all()
        assert (run.trace.states[8:, :3] == run.trace.states[8, :3]).all()
        assert run.path_length < 0.6


def test_a_car_does_not_turn_on_the_spot_nor_drive_backwards_unless_it_may():
    world = hall(40, 40, CAR, Pose(2.0, 2.0))
    run = drive(world, *((0.0, 5.0),) * 3, *((-1.0, 0.0),) * 3)
    assert np.ptp(run.trace.x) == np.ptp(run.trace.heading) == 0.0
    back = replace(CAR, drive=Drive(0.5, reverse=True))
    run = drive(hall(40, 40, back, Pose(2.0, 2.0)), *((-1.0, 0.0),) * 3)
    assert run.trace.x[-1] == pytest.approx(1.7, abs=1e-3)


def test_a_car_drives_a_circle_of_its_turning_radius():
    world = hall(40, 40, CAR, Pose(2.0, 1.2))
    run = drive(world, *((1.0, 9.0),) * 31)
    trace = run.trace
    steady = trace.path_step > 1
    x, y = trace.path_x[steady], trace.path_y[steady]
    centre_x, centre_y = (x.min() + x.max()) / 2, (y.min() + y.max()) / 2
    radii = np.hypot(x - centre_x, y - centre_y)
    # Corners are on a circle, and chords leave it by at most 1/64 of a cell.
    assert radii.min() > 0.5 - SIDE / 64 and radii.max() < 0.5 + SIDE / 16
    turn, _ = turns_of(trace)
    assert turn[2:-3] == pytest.approx(0.2, abs=2 * TURN)


def test_a_car_is_on_the_arc_that_begins_at_its_start_and_along_its_heading():
    for body in ((), box(0.3, 0.2, 0.1)):
        robot = replace(CAR, footprint=body)
        trace = drive(hall(40, 40, robot, Pose(2.0, 1.2)), *((1.0, 9.0),) * 32).trace
        driven = 0.1 * np.maximum(0, np.arange(trace.steps + 1) - 1)[:32] / 0.5
        x, y = 2.0 + 0.5 * np.sin(driven), 1.2 + 0.5 * (1.0 - np.cos(driven))
        apart = np.hypot(trace.x[:32] - x, trace.y[:32] - y)
        # A turn after the leg would leave it by 5 cm.
        assert apart.max() < SIDE / 64


def test_a_fast_car_keeps_to_the_arc_by_more_legs():
    fast = replace(CAR, speed=8.0)
    run = drive(hall(60, 60, fast, Pose(3.0, 2.0)), *((8.0, 99.0),) * 6)
    points = np.bincount(run.trace.path_step)
    assert points[3] > 5
    x, y = run.trace.path_x[run.trace.path_step > 1], run.trace.path_y[run.trace.path_step > 1]
    middle_x, middle_y = (x[:-1] + x[1:]) / 2, (y[:-1] + y[1:]) / 2
    # The circle through the corners, by least squares.
    rows = np.stack([x, y, np.ones_like(x)], axis=1)
    (a, b, c), *_ = np.linalg.lstsq(rows, x * x + y * y, rcond=None)
    radius = math.sqrt(c + a * a / 4 + b * b / 4)
    assert radius >= 0.5 - 1e-3
    sagitta = radius - np.hypot(middle_x - a / 2, middle_y - b / 2)
    assert np.median(sagitta) < SIDE / 64


def test_steering_takes_time_if_it_has_a_rate():
    slow = replace(CAR, drive=Drive(0.5, steering_rate=2.0))
    run = drive(hall(40, 40, slow, Pose(2.0, 1.2)), *((1.0, 9.0),) * 12)
    turn, _ = turns_of(run.trace)
    shares = turn[1:12] / 0.2
    assert shares == pytest.approx(np.minimum(0.2 * np.arange(1, 12), 1.0), abs=0.01)


def test_a_car_at_a_wall_stops_and_its_turn_with_it():
    world = hall(40, 40, CAR, Pose(3.85, 2.0, 0.3))
    run = drive(world, *((1.0, 2.0),) * 8)
    assert run.trace.bump[3:9].all()
    # It does not slide along the wall.
    assert np.ptp(run.trace.y[3:9]) < 2e-3 and np.ptp(run.trace.heading[3:9]) < 0.01


def _fleet(robot):
    world = generate("rooms", 3, robots=2)
    first = world.robots[0]
    own = replace(robot, start=first.start, target=first.target)
    return replace(world.bare, robots=(own, *world.robots[1:]))


def _alone(robot):
    world = generate("rooms", 3)
    return replace(world.bare, robots=(replace(robot, start=world.start, target=world.target),))


REFUSED = {
    "fleet": (_fleet, "orca", {}, "not-for-fleets"),
    "stepped": (_alone, "turn-left", {"motion": "stepped"}, "not-for-stepped"),
    "cover": (_alone, "random-walk", {"task": "cover"}, "nothing-to-cover"),
}


@pytest.mark.parametrize(
    "robot", [replace(ROBOT, footprint=box(0.1, 0.06)), CAR], ids=["body", "car"]
)
@pytest.mark.parametrize("who", REFUSED)
def test_what_is_only_for_discs_refuses_bodies_and_cars(who, robot):
    make, name, options, code = REFUSED[who]
    with pytest.raises(InvalidParameter) as caught:
        simulate(make(robot), name, steps=100, **options)
    assert caught.value.code == code


@pytest.mark.parametrize("is_fire", [False, True], ids=["wall", "fire"])
def test_a_turn_that_ends_the_run_is_not_an_arrival(is_fire):
    # The bar touches the cell from below, at its goal, and turns into it.
    walls = np.zeros((20, 20), bool)
    walls[13, 10] = not is_fire
    goal = Target(
        1.0, 1.25, 0.1, 0.3, 0.299, arrival="stop", contact="fail", arrival_turn_rate=100.0
    )
    if not is_fire:
        goal = replace(goal, heading=None)
    events = [Event(0.05, 10, 13, CellState.BURNING)] if is_fire else []
    robot = replace(BAR, start=Pose(1.0, 1.25), target=goal)
    world = World(walls, robots=(robot,), cell_size=SIDE, timeline=Timeline.of(events))
    run = drive(world, (0.0, 3.0))
    assert run.verdict == ("burned" if is_fire else "contact")


def test_a_recorded_car_has_the_heading_of_each_leg_of_its_path():
    robot = replace(BAR, drive=Drive(turning_radius=0.3, reverse=True), speed=2.0)
    world = hall(60, 60, robot, Pose(3.0, 3.0, 0.5))
    trace = drive(world, (2.0, 3.0), (-2.0, 4.0), (1.0, 0.0)).trace
    legs = np.diff(trace.path_x), np.diff(trace.path_y)
    moved = np.hypot(*legs) > 1e-3
    off = np.arctan2(legs[1], legs[0]) - trace.path_heading[1:]
    # Forwards or backwards, but never sideways.
    assert moved.sum() > 4
    assert np.abs(np.sin(off[moved])).max() < 0.05
