"""A robot's own estimate of its position is named where it departs from the true one."""

import math
from dataclasses import replace

import numpy as np
import pytest

from fuzz.facts.proofs import certified
from fuzz.triage.judging import failure_of
from fuzz.triage.pose_estimate import pose_estimate
from fuzz.triage.run_facts import run_facts
from sim import Command, simulate
from sim.scenario import Scenario
from tests.helpers.faulty_robots import hall
from tests.helpers.halls import cup
from worldgen import Pose, generate

HERE = "tests.fuzz.test_pose_estimate"
STEPS = 600


class Bounces:
    """Pushes against each wall for a while, turns by a right angle and a bit, and drives on."""

    speed = 0.0

    def reset(self, world):
        self.speed = 0.0
        self.begin(world)
        return (0.0,)

    def begin(self, world):
        """Start to keep track."""

    def keep(self, observation):
        """Keep track of a step."""

    def act(self, observation, memory):
        self.keep(observation)
        self.speed = observation.top_speed
        turn = 1.9 if observation.bump and memory[0] % 8.0 == 0.0 else 0.0
        turn += 0.1 * math.sin(0.3 * memory[0])
        return Command(self.speed, turn / observation.time_step), (memory[0] + 1.0,)


class Reckons(Bounces):
    """Adds up its commands, which walls cut short."""

    def begin(self, world):
        self.x = world.start.x
        self.y = world.start.y

    def keep(self, observation):
        self.x += self.speed * math.cos(observation.heading) * observation.time_step
        self.y += self.speed * math.sin(observation.heading) * observation.time_step


class ReckonsFromZero(Reckons):
    """Has its origin at the start, and a table for it."""

    def begin(self, world):
        self.pose = [0.0, 0.0]

    def keep(self, observation):
        self.pose[0] += self.speed * math.cos(observation.heading) * observation.time_step
        self.pose[1] += self.speed * math.sin(observation.heading) * observation.time_step


class Knows(Reckons):
    """Remembers where it was in the step before."""

    def keep(self, observation):
        self.x = observation.x
        self.y = observation.y


class KnowsFromTheFirstStep(Knows):
    """Begins at zero, until it senses where it is."""

    def begin(self, world):
        self.x = self.y = 0.0


class HeldFromTheStart(Reckons):
    """Pushes against what is ahead of it for a while before it turns."""

    def act(self, observation, memory):
        command, (count,) = super().act(observation, memory)
        return (Command(command.speed, 0.0) if count < 80.0 else command), (count,)


class RemembersTouches(Reckons):
    """Remembers where it last touched a wall."""

    def keep(self, observation):
        if observation.bump:
            self.x = observation.x
            self.y = observation.y


class RemembersTheNearest(Reckons):
    """Remembers where it was nearest to the target."""

    def begin(self, world):
        super().begin(world)
        self.least = math.inf

    def keep(self, observation):
        if observation.target_distance < self.least:
            self.least = observation.target_distance
            self.x = observation.x
            self.y = observation.y


class LooksAhead(Reckons):
    """Keeps a point ahead of it."""

    def keep(self, observation):
        self.x = observation.x + 0.5 * math.cos(observation.heading)
        self.y = observation.y + 0.5 * math.sin(observation.heading)


class Recorded:
    """Lets a robot act, and records the numbers of its state as they are watched."""

    def __init__(self, robot):
        self.robot = robot
        self.numbers = {}

    def reset(self, world):
        memory = self.robot.reset(world)
        self.numbers = {name: [value] for name, value in self.state().items()}
        return memory

    def act(self, observation, memory):
        answer = self.robot.act(observation, memory)
        for name, value in self.state().items():
            self.numbers[name].append(value)
        return answer

    def state(self):
        found = dict(vars(self.robot))
        for place, value in enumerate(found.pop("pose", ())):
            found[f"pose[{place}]"] = value
        return found


def ran(kind, seed):
    world = generate("rubble", seed)
    robot = Recorded(kind())
    return world, simulate(world, robot, steps=STEPS, record=True).trace, robot


def estimates(kind):
    found = []
    for seed in range(2):
        world, trace, robot = ran(kind, seed)
        numbers = {name: np.array(values) for name, values in robot.numbers.items()}
        found.append(pose_estimate(world, trace, numbers))
    return found


@pytest.mark.parametrize(
    ("kind", "names"), [(Reckons, ("x", "y")), (ReckonsFromZero, ("pose[0]", "pose[1]"))]
)
def test_dead_reckoning_that_walls_falsify_is_named_with_its_figures(kind, names):
    for found in estimates(kind):
        assert found.names == names and found.at_walls > 0.9
        assert 0 < found.since < STEPS and found.off > 0.1


@pytest.mark.parametrize(
    "kind",
    [Knows, KnowsFromTheFirstStep, RemembersTouches, RemembersTheNearest, LooksAhead, Bounces],
)
def test_a_place_that_is_only_remembered_is_no_estimate(kind):
    assert estimates(kind) == [None, None]


def test_dead_reckoning_is_named_although_a_wall_holds_the_robot_from_the_start():
    world = replace(hall(), start=Pose(2.9, 1.05, 0.0))
    robot = Recorded(HeldFromTheStart())
    trace = simulate(world, robot, steps=STEPS, record=True).trace
    numbers = {name: np.array(values) for name, values in robot.numbers.items()}
    found = pose_estimate(world, trace, numbers)
    assert found.names == ("x", "y") and found.since < 10 and found.at_walls > 0.9


def test_the_error_is_the_true_one():
    world, trace, recorded = ran(Reckons, 0)
    found = estimates(Reckons)[0]
    step = world.robot_speed * trace.time_step
    off = math.dist((recorded.robot.x, recorded.robot.y), (trace.x[-1], trace.y[-1]))
    assert found.off == pytest.approx(off, abs=2 * step)


class Homes(Reckons):
    """Drives to where it believes the target to be."""

    def begin(self, world):
        super().begin(world)
        self.goal = world.target.x, world.target.y

    def act(self, observation, memory):
        self.keep(observation)
        self.speed = observation.top_speed
        aim = math.atan2(self.goal[1] - self.y, self.goal[0] - self.x)
        turn = 1.9 if observation.bump and memory[0] % 7 else aim - observation.heading
        return Command(self.speed, turn / observation.time_step), (memory[0] + 1.0,)


@pytest.mark.gate
def test_what_a_robot_repeats_comes_with_where_it_believes_to_be():
    world = certified(cup())
    failure = failure_of(world, Scenario(f"{HERE}:Homes"))
    facts = run_facts(failure, failure.run())
    assert "self.x and self.y follow its position for " in facts.repeats
    assert facts.repeats.endswith("m off at the end, because of steps that touch a wall")
    assert "self.x" not in run_facts(failure, failure.run(), with_code=False).repeats
