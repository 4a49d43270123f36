"""Controllers with one plain fault each, and worlds that show it."""

import math

import numpy as np

from fuzz.facts.proofs import certified
from fuzz.triage.judging import failure_of
from sim import Command
from sim.scenario import Scenario
from worldgen import Pose, Target, World
from worldgen.timeline import CellState, Timeline

HERE = __name__


class Still:
    """Never moves."""

    def reset(self):
        return ()

    def act(self, observation, memory):
        return Command(0.0, 0.0), memory


class Pushes(Still):
    """Drives straight ahead, whatever it touches."""

    def act(self, observation, memory):
        return Command(observation.top_speed, 0.0), memory


class Dithers(Still):
    """Turns around in every step."""

    def act(self, observation, memory):
        return Command(0.0, math.pi / observation.time_step), memory


class Spins(Still):
    """Turns by 3 degrees per step, and never drives."""

    def act(self, observation, memory):
        return Command(0.0, math.radians(3) / observation.time_step), memory


class Backs(Still):
    """Drives a square of one cell, away from all walls."""

    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        turn = math.pi / 2 if memory[0] == 9.0 else 0.0
        return Command(0.5, turn / observation.time_step), ((memory[0] + 1.0) % 10.0,)


class WantsRoom(Still):
    """Drives to the target, but stops in front of the gap of `gap` unless it is 60 % wider than
    needed.
    """

    def act(self, observation, memory):
        refuses = observation.x > 0.8 and 1.6 * observation.radius > 0.1
        return heading_for_the_target(observation, 0.0 if refuses else 1.0), memory


class StopsBehind(WantsRoom):
    """Does the same behind the gap, where there is enough room."""

    def act(self, observation, memory):
        refuses = observation.x > 1.2 and 1.6 * observation.radius > 0.1
        return heading_for_the_target(observation, 0.0 if refuses else 1.0), memory


class Wavers(Still):
    """Turns left and right by more than 70 degrees while it drives, and ends up in a corner."""

    def reset(self):
        return (0.21,)

    def act(self, observation, memory):
        turn = memory[0] * math.tau / observation.time_step
        return Command(observation.top_speed, turn), (-memory[0],)


class Remembers(Still):
    """Drives to the target until it bumps, and remembers that wall forever."""

    def reset(self):
        return (0.0,)

    def act(self, observation, memory):
        blocked = float(observation.bump or memory[0] == 1.0)
        return heading_for_the_target(observation, 1.0 - blocked), (blocked,)


def heading_for_the_target(observation, share_of_speed):
    turn = math.remainder(observation.target_heading - observation.heading, math.tau)
    return Command(share_of_speed * observation.top_speed, turn / observation.time_step)


def gap(opens_at=None):
    """Two rooms and a gap of 0.2 m between them; it is closed until it opens."""
    walls = np.zeros((9, 20), bool)
    walls[:, 10] = True
    walls[4:6, 10] = opens_at is not None
    events = [] if opens_at is None else [(opens_at, 10, iy, CellState.FREE) for iy in (4, 5)]
    world = World(
        walls,
        start=Pose(0.25, 0.5, 0.0),
        target=Target(1.75, 0.5, 0.05),
        cell_size=0.1,
        robot_radius=0.07,
        timeline=Timeline.of(events),
    )
    return certified(world)


def hall(width=30, height=20, start=(1.55, 1.05)):
    """An empty hall in which the robot faces right, away from its target."""
    return World(
        np.zeros((height, width), bool),
        start=Pose(*start, 0.0),
        target=Target(0.25, 0.25, 0.05),
        cell_size=0.1,
        robot_radius=0.07,
    )


def found_by(name, world=None):
    failure = failure_of(world or certified_hall(), Scenario(f"{HERE}:{name}"))
    assert failure is not None
    return failure


def certified_hall():
    return certified(hall())
