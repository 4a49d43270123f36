"""Simulated cars stay where a proof confines them, whatever their controllers do."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

from sim import Command, simulate
from tests.worldgen.test_car_confinement import Straight, alley, dead_end
from worldgen import Drive, Robot, Target, World, generate
from worldgen.reach import BLOCKED, decide
from worldgen.reach.car import confine
from worldgen.reach.car.confine import confine_car
from worldgen.reach.car.search import EFFORTS, find_path, witness_of
from worldgen.reach.check.car_confinement import check_car_confinement
from worldgen.robot import Pose

TURN = math.tau / 65_536
BOX = ((0.3, 0.22), (-0.25, 0.22), (-0.25, -0.2), (0.3, -0.2))


@dataclass(frozen=True)
class Wilful:
    """Drives forwards with speeds and locks that it draws, or with full lock towards its target.

    Args:
        speeds: (n,) m/s, one after another.
        locks: (n,) from -1 to 1; above 1, it steers towards the target as far as it can.
        hold: Steps for which it keeps one of them.
        target: Its target, m.
        flips: True to turn the other way in the step after a bump.
    """

    speeds: tuple[float, ...]
    locks: tuple[float, ...]
    hold: int
    target: tuple[float, float]
    flips: bool
    senses = ("bump", "x", "y", "heading")

    def reset(self):
        return (0.0,)

    def act(self, seen, memory):
        number = int(memory[0]) // self.hold % len(self.speeds)
        lock = self.locks[number]
        if lock > 1.0:
            bearing = math.atan2(self.target[1] - seen.y, self.target[0] - seen.x)
            lock = math.copysign(1.0, math.remainder(bearing - seen.heading, math.tau))
        if self.flips and seen.bump:
            lock = -lock
        return Command(self.speeds[number], 20.0 * lock), (memory[0] + 1.0,)


def wilful(rng, world, time_step):
    """Draw a controller, and sometimes one that moves by a few lattice units a step only."""
    unit = world.cell_size / 1024 / time_step
    paces = ((1.0,), (1.0, 0.1), (60 * unit,), (7.3 * unit, 1.2 * unit), (1.0, 3 * unit))
    pace = paces[rng.integers(len(paces))]
    locks = rng.choice([-1.0, 1.0, 2.0, 0.0, *rng.uniform(-1.0, 1.0, 2)], 60)
    return Wilful(
        tuple(rng.choice(pace, 60).tolist()),
        tuple(locks.tolist()),
        int(rng.choice([1, 3, 20, 200])),
        (world.target.x, world.target.y),
        bool(rng.integers(2)),
    )


def poses_after(trace, step, side):
    """Return the exact poses (n, 3) of a car each time that it has driven `step` m: m, m, rad."""
    words = trace.states.astype(np.int64)
    places = (words[:, :2] + words[:, -2:] / 256) / 1024 * side
    turns = ((np.diff(words[:, 2]) + 32768) % 65536 - 32768) * TURN
    chords = np.hypot(*np.diff(places, axis=0).T)
    lengths = chords / np.sinc(turns / 2.0 / math.pi)
    ends = np.cumsum(lengths)
    found = []
    for k in range(1, int(ends[-1] / step) + 1):
        at = int(np.searchsorted(ends, k * step))
        share = 1.0 - (ends[at] - k * step) / lengths[at]
        # The part of the arc up to there.
        turn = share * turns[at]
        chord = share * lengths[at] * np.sinc(turn / 2.0 / math.pi)
        heading = words[at, 2] * TURN
        way = heading + turn / 2.0
        x, y = places[at] + chord * np.array([math.cos(way), math.sin(way)])
        found.append((x, y, heading + turn))
    return np.array(found).reshape(-1, 3)


def boxes_of(proof, poses):
    """Return whether poses are in boxes of a proof."""
    row = np.floor(poses[:, 1] / proof.side).astype(int)
    column = np.floor(poses[:, 0] / proof.side).astype(int)
    heading = np.rint(poses[:, 2] / (math.tau / proof.headings)).astype(int) % proof.headings
    boxes = np.zeros((proof.headings, *(proof.boxes.max(axis=0)[1::2] + 1)), bool)
    for layer, line, left, right in proof.boxes:
        boxes[layer, line, left : right + 1] = True
    inside = (row < boxes.shape[1]) & (column < boxes.shape[2])
    return inside & boxes[heading * inside, row * inside, column * inside]


def of_family(name, seed, turning_radius):
    world = generate(name, seed)
    robot = replace(world.robots[0], drive=Drive(turning_radius))
    return replace(world, robots=[robot], certificate=None, provenance=None)


def askew(width, heading, **robot):
    """A dead end in which the car starts at an angle."""
    world = dead_end(width, 0.5, **robot)
    start = world.start
    return replace(world, start=Pose(start.x, start.y - 0.07, heading))


WORLDS = {
    "narrow": lambda: dead_end(0.8, 0.5),
    "wide": lambda: dead_end(1.2, 0.5, heading=0.4),
    "askew": lambda: askew(1.1, -0.5),
    "footprint": lambda: dead_end(1.2, 0.5, footprint=BOX),
    "maze": lambda: of_family("maze", 1, 0.3),
    "rooms": lambda: of_family("rooms", 0, 0.3),
    "cave": lambda: of_family("cave", 1, 0.6),
    "forest": lambda: of_family("forest", 2, 0.6),
}


def assert_confined(world, seeds):
    """Drive many cars, and return by how many m they move and how often they touch a wall."""
    decision = decide(world)
    assert decision.result == BLOCKED
    proof = decision.confinement
    moved = touched = 0.0
    for seed in seeds:
        rng = np.random.default_rng(seed)
        time_step = float(rng.choice([0.1, 0.02, 0.5]))
        run = simulate(
            world, wilful(rng, world, time_step), steps=600, time_step=time_step, record=True
        )
        assert run.verdict != "reached"
        assert boxes_of(proof, poses_after(run.trace, proof.step, world.cell_size)).all()
        moved += run.path_length
        touched += run.collisions
    return moved, touched


@pytest.mark.gate
@pytest.mark.parametrize("name", WORLDS)
def test_no_car_leaves_the_boxes_that_confine_it(name):
    moved, touched = assert_confined(WORLDS[name](), range(60))
    assert moved > 5.0 and touched > 40


def test_a_few_cars_stay_in_the_boxes_that_confine_them():
    assert_confined(dead_end(1.2), range(3))


@pytest.mark.gate
def test_the_same_cars_arrive_where_they_are_not_confined():
    world = dead_end(2.2, 0.5, heading=-1.2)
    assert confine_car(world).proof is None
    runs = []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        runs.append(simulate(world, wilful(rng, world, 0.1), steps=3000, time_step=0.1))
    assert any(run.verdict == "reached" for run in runs)


@pytest.mark.gate
def test_cars_that_turn_on_smaller_circles_leave_the_boxes():
    proof = decide(dead_end(1.2, 0.9)).confinement
    world = dead_end(1.2, 0.3)
    left = 0
    for seed in range(20):
        rng = np.random.default_rng(seed)
        run = simulate(world, wilful(rng, world, 0.1), steps=600, time_step=0.1, record=True)
        left += not boxes_of(proof, poses_after(run.trace, proof.step, world.cell_size)).all()
    assert left > 3


def small_world(seed):
    """Draw a small world for a car that never reverses; None if its body alone cannot arrive."""
    rng = np.random.default_rng(seed)
    height, width = rng.integers(8, 22, 2)
    walls = np.zeros((height, width), bool)
    kind = rng.integers(3)
    if kind == 0:
        walls = rng.random((height, width)) < rng.choice([0.02, 0.05, 0.1])
    elif kind == 1:
        walls[:] = True
        x, y = rng.integers(width), rng.integers(height)
        for _ in range(rng.integers(2, 7)):
            aisle = rng.integers(2, 5)
            to_x, to_y = (
                (rng.integers(width), y) if rng.random() < 0.5 else (x, rng.integers(height))
            )
            walls[min(y, to_y) : max(y, to_y) + aisle, min(x, to_x) : max(x, to_x) + aisle] = False
            x, y = to_x, to_y
    else:
        for _ in range(rng.integers(2, 6)):
            a, b = rng.integers(1, 9, 2)
            row, column = rng.integers(height), rng.integers(width)
            walls[row : row + a, column : column + b] = True
    free = np.argwhere(~walls)
    if len(free) < 2:
        return None
    (start_y, start_x), (target_y, target_x) = free[rng.integers(len(free), size=2)] + 0.5
    heading = rng.choice([0.0, math.pi / 2, math.pi, -math.pi / 2, rng.uniform(-3.0, 3.0)])
    off_x, off_y = rng.uniform(-0.2, 0.2, 2)
    start = Pose((start_x + off_x) * 0.1, (start_y + off_y) * 0.1, float(heading))
    wanted = (rng.uniform(-3.0, 3.0), rng.choice([0.02, 0.2, 0.6])) if rng.random() < 0.3 else ()
    target = Target(
        target_x * 0.1, target_y * 0.1, float(rng.choice([0.02, 0.05, 0.1])), *map(float, wanted)
    )
    body = {"radius": float(rng.choice([0.03, 0.05, 0.07, 0.1, 0.14]))}
    if rng.random() < 0.3:
        length, wide = rng.uniform(0.1, 0.5), rng.uniform(0.06, 0.25)
        middle = rng.uniform(-0.3, 0.5) * length
        front, rear = middle + length / 2, middle - length / 2
        corners = ((front, wide / 2), (rear, wide / 2), (rear, -wide / 2), (front, -wide / 2))
        body = {"footprint": corners}
    drive = Drive(float(rng.choice([0.05, 0.1, 0.2, 0.3, 0.5, 1.0])))
    world = World(walls, robots=[Robot(start, target, drive=drive, **body)])
    free_body = replace(world, robots=[replace(world.robots[0], drive=Drive())])
    return None if decide(free_body, certificate=False).result == BLOCKED else world


def assert_proofs_are_true(seeds):
    """Confine cars in small worlds; return how many have a path, and how many a proof of none."""
    paths = proofs = 0
    for world in filter(None, map(small_world, seeds)):
        poses = find_path(world, EFFORTS[:1]).poses
        has_path = len(poses) > 0 and witness_of(world, poses) is not None
        proof = confine_car(world).proof
        paths += has_path
        proofs += proof is not None
        if proof is None:
            continue
        assert not has_path
        assert check_car_confinement(world, proof).valid
        for seed in range(3):
            rng = np.random.default_rng(seed)
            time_step = float(rng.choice([0.1, 0.02, 0.5]))
            driver = wilful(rng, world, time_step)
            run = simulate(world, driver, steps=200, time_step=time_step, record=True)
            assert run.verdict != "reached"
            assert boxes_of(proof, poses_after(run.trace, proof.step, world.cell_size)).all()
    return paths, proofs


@pytest.mark.gate
def test_no_small_world_is_blocked_that_has_a_path(monkeypatch):
    # The smallest boxes take the most time, and are the least wrong.
    monkeypatch.setattr(confine, "GRAINS", confine.GRAINS[:2])
    paths, proofs = assert_proofs_are_true(range(80))
    assert paths > 10 and proofs > 5


@pytest.mark.nightly
def test_no_small_world_of_many_is_blocked_that_has_a_path():
    paths, proofs = assert_proofs_are_true(range(1000, 2500))
    assert paths > 200 and proofs > 200


def with_target_where_it_got(seed):
    """Drive a car in a small world; return that world with a target where it was, and the driver.

    That is at a wall that it ran into, or anywhere on its way; None if it hardly moves.
    """
    world = small_world(seed)
    if world is None:
        return None
    rng = np.random.default_rng([seed, 1])
    # A step is as long as the world is wide, or much shorter.
    drive = Drive(float(rng.choice([0.1, 0.3, 1.0, 3.0, 10.0])))
    world = replace(world, robots=[replace(world.robots[0], drive=drive)])
    time_step = float(rng.choice([0.1, 0.02]))
    driver = wilful(rng, world, time_step)
    run = simulate(world, driver, steps=120, time_step=time_step, record=True)
    states = run.trace.states.astype(np.int64)
    stops = np.flatnonzero(
        (np.diff(states[:, :2], axis=0) == 0).all(axis=1) & (states[1:, 0] != states[0, 0])
    )
    at = stops[0] if len(stops) and rng.random() < 0.7 else rng.integers(len(states))
    x, y = states[at, :2] / 1024 * world.cell_size
    if math.hypot(x - world.start.x, y - world.start.y) < 0.05:
        return None
    wanted = (float(states[at, 2] * TURN), 0.02) if rng.random() < 0.5 else ()
    target = Target(x, y, 0.02, *wanted)
    there = replace(world, robots=[replace(world.robots[0], target=target)])
    return there, driver, time_step


def assert_what_is_reached_is_not_confined(monkeypatch, seeds):
    """Return at how many targets cars arrived, and how many proofs that ignore them were refused."""
    # Steps are longest in the largest boxes, which take the least time, too.
    monkeypatch.setattr(confine, "GRAINS", confine.GRAINS[:1])
    arrived = refused = 0
    for world, driver, time_step in filter(None, map(with_target_where_it_got, seeds)):
        if simulate(world, driver, steps=120, time_step=time_step).verdict != "reached":
            continue
        arrived += 1
        assert confine_car(world).proof is None
        with monkeypatch.context() as blind:
            blind.setattr(
                confine._Flood, "_is_goal", lambda flood, heading, off: 0 * np.uint8(heading > off)
            )
            proof = confine_car(world).proof
        if proof is not None:
            report = check_car_confinement(world, proof)
            assert not report.valid and "may arrive" in report.reason
            refused += 1
    return arrived, refused


@pytest.mark.gate
def test_no_car_is_confined_from_where_it_got(monkeypatch):
    arrived, refused = assert_what_is_reached_is_not_confined(monkeypatch, range(120))
    assert arrived > 15 and refused > 15


@pytest.mark.nightly
def test_no_car_of_many_is_confined_from_where_it_got(monkeypatch):
    arrived, refused = assert_what_is_reached_is_not_confined(monkeypatch, range(1000, 2000))
    assert arrived > 100 and refused > 100


@pytest.mark.gate
@pytest.mark.parametrize("turning_radius", [1.0, 2.0, 5.0, 10.0])
def test_no_car_is_confined_from_the_end_of_an_alley(turning_radius):
    # The wall is anywhere in a step, and the target is where it stops the car, or a bit before.
    for share in np.linspace(0.05, 0.55, 11):
        end = round(turning_radius * float(share), 2)
        for before in (0.0, 0.4 * end):
            world = alley(turning_radius, end - before, end)
            if math.dist((world.start.x, world.start.y), (world.target.x, world.target.y)) < 0.05:
                continue
            assert simulate(world, Straight(), steps=800, time_step=0.1).verdict == "reached"
            assert confine_car(world).proof is None
