"""What a robot repeats is told by its own moves: turns, touches and their sides."""

import itertools
import math

import numpy as np
import pytest

from fuzz.facts import contacts
from fuzz.facts.contacts import WallBearings
from fuzz.triage import repeated_moves
from fuzz.triage.repeated_moves import describe_period
from sim import Command, simulate
from sim.clock.stopping import OutOfTime, stopping_when
from worldgen import Pose, Target, World, generate

HERE = "tests.fuzz.test_repeated_moves"


class Repeats:
    """In each step, turns by the next angle of a list, in degrees, and may also drive."""

    turns = (0.0,)
    share_of_speed = 0.0

    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        number = int(memory[0])
        turn = math.radians(self.turns[number]) / observation.time_step
        speed = self.share_of_speed * observation.top_speed
        return Command(speed, turn), (float((number + 1) % len(self.turns)),)


class Stays(Repeats):
    """Never moves."""


class Spins(Repeats):
    """Turns to the right all the time, in steps of two sizes."""

    turns = (-50.0, -130.0)


class Reverses(Repeats):
    """Turns around in every second step."""

    turns = (180.0, 0.0)


class Pushes(Repeats):
    """Pushes whatever it touches."""

    share_of_speed = 1.0


class Shuttles:
    """Drives forwards and backwards, two steps each."""

    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        speed = observation.top_speed if memory[0] < 2.0 else -observation.top_speed
        return Command(speed, 0.0), ((memory[0] + 1.0) % 4.0,)


class Wags(Repeats):
    """Turns left and right, by a little more each time."""

    turns = tuple(angle * sign for angle in (10, 20, 30, 40, 50) for sign in (1, -1))


class Grinds(Repeats):
    """Stays at a wall, and turns back and forth for a thousand steps."""

    # Binary fractions of a whole turn are exact.
    turns = (22.5, -22.5, -45.0, 45.0) * 250
    share_of_speed = 1.0


class SquareAtOnce:
    """Turns left by a right angle in the step in which it touches a wall."""

    def reset(self):
        return ()

    def act(self, observation, memory):
        turn = math.pi / 2 if observation.bump else 0.0
        return Command(observation.top_speed, turn / observation.time_step), ()


class SquareNextStep:
    """Does the same one step later."""

    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        turn = math.pi / 2 if memory[0] else 0.0
        command = Command(observation.top_speed, turn / observation.time_step)
        return command, (float(observation.bump and not memory[0]),)


class HidesItsState:
    """Turns left and right in turn, by a count outside its memory, so that no loop is proved."""

    def reset(self):
        self.count = 0
        return ()

    def act(self, observation, memory):
        self.count += 1
        turn = math.radians(20) if self.count % 2 else math.radians(-20)
        return Command(0.0, turn / observation.time_step), ()


class NeverTheSame(HidesItsState):
    """Turns by more in each step."""

    def act(self, observation, memory):
        self.count += 1
        return Command(0.0, math.radians(3 + self.count % 97) / observation.time_step), ()


def told(name, heading=0.0):
    world, episode = run(name, heading)
    return describe_period(world, episode)


def run(name, heading=0.0):
    world = World(
        np.zeros((6, 6), bool),
        start=Pose(0.3, 0.3, heading),
        target=Target(0.5, 0.5, 0.03),
        cell_size=0.1,
        robot_radius=0.07,
    )
    return world, simulate(world, f"{HERE}:{name}", record=True)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("Stays", "repeats 1 step (0.015 s, 0 m): it stays there"),
        ("Spins", "repeats 4 steps (0.06 s, 0 m): it turns 360 degrees right in 4 steps"),
        ("Reverses", "it turns around; it stays there; all of this 2 times"),
        ("Pushes", "repeats 1 step (0.015 s, 0 m): with a wall ahead, it pushes against it"),
        (
            "HidesItsState",
            "ends by repeating about the same 2 steps (0.03 s, 0 m): it turns 20 degrees left; it "
            "turns 20 degrees right",
        ),
        ("Shuttles", "it drives 0.06 m straight on; it drives 0.06 m backwards"),
        (
            "Wags",
            "repeats 10 steps (0.15 s, 0 m): it turns 150 degrees left and 150 degrees right in "
            "all, and touches no wall",
        ),
    ],
)
def test_a_period_is_told_by_its_moves_or_in_total_if_it_is_long(name, words):
    assert told(name).endswith(words)


@pytest.mark.parametrize("name", ["SquareAtOnce", "SquareNextStep"])
def test_a_turn_follows_the_touch_that_it_reacts_to(name):
    walls = np.zeros((9, 9), bool)
    world = World(walls, Pose(0.45, 0.2, 0.0), Target(0.45, 0.45, 0.03), cell_size=0.1)
    words = describe_period(world, simulate(world, f"{HERE}:{name}", record=True))
    assert "with a wall ahead, it" in words and "turns 90 degrees left" in words
    assert "wall on its" not in words and "wall behind" not in words


def test_a_run_that_only_runs_out_of_time_is_not_said_to_repeat(monkeypatch):
    monkeypatch.setattr(repeated_moves, "_MOST_SEARCHED", 150)
    words = told("NeverTheSame")
    assert words.startswith("does not repeat itself; in its last ")
    # Nothing is said about the side to which it does not turn.
    assert " left in all, and touches no wall" in words and "right" not in words


def test_a_wall_that_stops_the_robot_is_ahead_whatever_its_heading():
    slid = told("Pushes", heading=math.radians(-50.0))
    assert "with a wall ahead" in slid
    assert told("Pushes", heading=math.pi) == told("Pushes")


def test_a_long_period_examines_few_moves_and_the_grid_once(monkeypatch):
    """A period of 100,000 moves took minutes."""
    world, episode = run("Grinds", math.pi)
    assert episode.evidence.period >= 1000
    grids = []
    looks = []
    monkeypatch.setattr(
        World,
        "cells_at",
        lambda self, time, whole=World.cells_at: grids.append(1) or whole(self, time),
    )
    monkeypatch.setattr(
        WallBearings,
        "__call__",
        lambda self, steps, whole=WallBearings.__call__: (
            looks.append(len(steps)) or whole(self, steps)
        ),
    )
    assert "of its steps" in describe_period(world, episode)
    assert len(grids) == 1
    assert len(looks) <= 12


def test_a_description_ends_when_its_time_is_up(monkeypatch):
    monkeypatch.setattr(contacts, "_AT_ONCE", 10)
    world, episode = run("Grinds", math.pi)
    looks = itertools.count()
    with pytest.raises(OutOfTime), stopping_when(lambda: next(looks) >= 50, clock=lambda: 0.0):
        describe_period(world, episode)


def test_walls_are_where_a_search_cell_by_cell_finds_them():
    world = generate("cave", 3)
    trace = simulate(world, "wall-left", record=True).trace
    steps = np.flatnonzero(trace.bump)[:300]
    assert len(steps) > 20
    reach = world.robot_radius / world.cell_size + 0.02
    for step, found in zip(steps, WallBearings(world, trace)(steps), strict=True):
        x, y = trace.x[step] / world.cell_size, trace.y[step] / world.cell_size
        bearings = [0.0] if found == 0.0 else []
        for iy, ix in np.argwhere(np.pad(world.walls, 1, constant_values=True)) - 1:
            dx = min(max(x, ix), ix + 1) - x
            dy = min(max(y, iy), iy + 1) - y
            if math.hypot(dx, dy) <= reach:
                bearings.append(math.remainder(math.atan2(dy, dx) - trace.heading[step], math.tau))
        assert abs(found) == pytest.approx(min(map(abs, bearings)), abs=1e-9)


def test_a_run_that_does_not_repeat_has_no_period():
    world = World(
        np.zeros((6, 9), bool),
        start=Pose(0.3, 0.3, 0.0),
        target=Target(0.8, 0.3, 0.03),
        cell_size=0.1,
        robot_radius=0.07,
    )
    assert describe_period(world, simulate(world, f"{HERE}:Pushes", record=True)) == ""
