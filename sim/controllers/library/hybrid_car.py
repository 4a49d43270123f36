"""Hybrid A*: plan a path that a car can drive on a map that is known, and keep to it.

At the start, the prover's search (``worldgen/reach/car``) finds a path of arcs and lines for the
robot's turning radius, at first with some room to walls and to full lock, then with less. In each
step, the controller turns to the heading that the path will have, and a little towards the path if
the robot is off to its side. Where the path changes gear, it stops exactly there. If no path is
found, the robot stays where it is.

It plans once. It does not look for changes of the world, and what pushes the robot away from its
path by more than its steering can correct is not noticed.

Source: D. Dolgov, S. Thrun, M. Montemerlo and J. Diebel, "Path planning for autonomous vehicles in
    unknown semi-structured environments", The International Journal of Robotics Research 29 (2010).
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from sim.controllers.base import Command, Memory, Observation
from sim.controllers.memory_view import MemoryField
from worldgen.errors import InvalidWorld
from worldgen.lattice import heading_from_lattice, lattice_to_metres
from worldgen.reach.car.search import EFFORTS, find_path
from worldgen.reach.car.stretches import Stretch, stretches_of
from worldgen.support.arrays import Ints
from worldgen.world import Pose, Robot, World

# Places in the memory: the stretch that is being driven, steps for which the wheels still turn, the
# largest curvature, rad/m, the share of it that the wheels turn in a second, and the distance from
# the end of a stretch, m, at which the robot is there; then the stretches.
_STRETCH, _WAIT, _LOCK, _RATE, _NEAR = range(5)
_STRETCHES = 5
_NUMBERS = len(Stretch._fields)

# Cells; a simulated robot stands on multiples of half of it.
_THERE = 1 / 512
# Margins of driving in which an error to the side decays, and the largest angle, rad, between the
# robot and the path meanwhile.
_SETTLING = 5.0
_MOST_BACK = 0.2


@dataclass(frozen=True)
class HybridCar:
    """Plans a car's path with hybrid A*, and keeps to it.

    Args:
        margin: m; distance from walls with which it plans at first.
        spare_lock: Share of the largest curvature that it keeps for corrections, at first.
    """

    margin: float = 0.02
    spare_lock: float = 0.05

    about = "Know the map, plan a path that a car can drive, and keep to it."
    senses = ("heading", "x", "y", "time_step", "top_speed")
    memory_fields = (MemoryField("stretch", _STRETCH), MemoryField("wait", _WAIT))

    def reset(self, world: World) -> Memory:
        """Return the memory: the plan, and nothing done of it."""
        robot = world.robots[0]
        # A robot that turns on the spot drives small arcs instead.
        radius = robot.drive.turning_radius or robot.radius
        stretches: list[Stretch] = []
        for wary in self._wary(world, radius):
            poses = _plan(wary)
            if len(poses):
                arcs = wary.robots[0].drive.turning_radius
                stretches = stretches_of(poses, arcs, world.cell_size)
                break
        numbers = [float(value) for stretch in stretches for value in stretch]
        near = _THERE * world.cell_size
        return (0.0, 0.0, 1.0 / radius, robot.drive.steering_rate, near, *numbers)

    def _wary(self, world: World, radius: float) -> Iterator[World]:
        """Yield the world with less and less room kept from walls, target's rim and full lock."""
        robot = world.robots[0]
        for share in (1.0, 0.25, 0.0):
            drive = replace(robot.drive, turning_radius=radius * (1.0 + share * self.spare_lock))
            target, *waypoints = (
                replace(goal, radius=goal.radius * (1.0 - 0.5 * share))
                for goal in (robot.target, *robot.waypoints)
            )
            goals = replace(robot, drive=drive, target=target, waypoints=tuple(waypoints))
            wide = _padded(goals, share * self.margin)
            # The margin may be more than a robot of such a small world can have.
            with contextlib.suppress(InvalidWorld):
                yield replace(world, robots=(wide,), certificate=None)

    def act(self, observation: Observation, memory: Memory) -> tuple[Command, Memory]:
        """Return the command for the next step, and the new memory."""
        index, wait = int(memory[_STRETCH]), memory[_WAIT]
        stretch = _stretch(memory, index)
        if stretch is None:
            return Command(), memory
        reach = observation.top_speed * observation.time_step
        driven = _driven(stretch, observation)
        # Where the robot has to stop, it drives on until it is there.
        while stretch.length - driven < (memory[_NEAR] if _stops_after(memory, index) else 0.0):
            index += 1
            before, stretch = stretch, _stretch(memory, index)
            if stretch is None:
                return Command(), (float(index), 0.0, *memory[_LOCK:])
            driven = _driven(stretch, observation)
            if memory[_RATE]:
                change = abs(before.curvature * before.gear - stretch.curvature * stretch.gear)
                seconds = change / memory[_LOCK] / memory[_RATE]
                wait = math.ceil(seconds / observation.time_step)
        kept = (float(index), max(0.0, wait - 1.0), *memory[_LOCK:])
        if wait > 0:
            # The wheels of a car that stands turn as far as they go, or straight ahead.
            return Command(0.0, stretch.curvature * stretch.gear), kept
        if stretch.curvature:
            # A step is straight, and the turn follows it, so long steps would leave the arc.
            reach = min(reach, self.margin / 2)
        if _stops_after(memory, index):
            reach = min(reach, stretch.length - driven)
        # Take the heading that the path has after this step, and go back towards the path.
        back = _off(stretch, observation) / max(_SETTLING * self.margin, 3.0 * reach)
        heading = _heading(memory, index, driven + reach) - max(-_MOST_BACK, min(_MOST_BACK, back))
        turn = math.remainder(heading - observation.heading, math.tau)
        most = memory[_LOCK] * reach
        turn = max(-most, min(most, turn))
        speed = stretch.gear * reach / observation.time_step
        return Command(speed, turn / observation.time_step), kept


hybrid_car = HybridCar()


def _plan(world: World) -> Ints:
    """Return the poses of a path through all goals, as :func:`find_path` does; none if a leg has none.

    Each leg begins where the one before ends.
    """
    robot = world.robots[0]
    start = robot.start
    poses: list[Ints] = []
    for goal in robot.goals:
        one = replace(robot, start=start, target=goal, waypoints=())
        leg = find_path(replace(world, robots=(one,)), EFFORTS[:2]).poses
        if not len(leg):
            return leg
        x, y, heading = leg[-1].tolist()
        size = world.cell_size
        start = Pose(
            lattice_to_metres(x, size), lattice_to_metres(y, size), heading_from_lattice(heading)
        )
        poses.append(leg[1:] if poses else leg)
    return np.concatenate(poses)


def _padded(robot: Robot, margin: float) -> Robot:
    """Return a robot whose body is wider by a margin, m."""
    if robot.is_disc:
        return replace(robot, radius=robot.radius + margin)
    share = 1.0 + margin / robot.radius
    return replace(robot, footprint=tuple((x * share, y * share) for x, y in robot.footprint))


def _stretch(memory: Memory, index: int) -> Stretch | None:
    """Return a stretch of the plan; None after the last one."""
    begin = _STRETCHES + _NUMBERS * index
    if begin >= len(memory):
        return None
    x, y, heading, curvature, length, gear = memory[begin : begin + _NUMBERS]
    return Stretch(x, y, heading, curvature, length, int(gear))


def _stops_after(memory: Memory, index: int) -> bool:
    """Return True if the robot has to stop at the end of a stretch."""
    after = _stretch(memory, index + 1)
    before = _stretch(memory, index)
    return after is None or before is None or after.gear != before.gear or bool(memory[_RATE])


def _driven(stretch: Stretch, observation: Observation) -> float:
    """Return the length, m, of a stretch up to the point next to the robot."""
    ahead, left = _relative(stretch, observation)
    if not stretch.curvature:
        return stretch.gear * ahead
    # The angle around the centre of the arc, which is to the left by a signed radius.
    side = stretch.gear * stretch.curvature
    radius = 1.0 / abs(side)
    angle = math.atan2(stretch.gear * ahead, radius - left * math.copysign(1.0, side))
    if angle < -math.pi / 2:
        angle += math.tau
    return angle * radius


def _relative(stretch: Stretch, observation: Observation) -> tuple[float, float]:
    """Return where the robot is, seen from the start of a stretch: ahead and to the left, m."""
    cosine, sine = math.cos(stretch.heading), math.sin(stretch.heading)
    dx, dy = observation.x - stretch.x, observation.y - stretch.y
    return dx * cosine + dy * sine, dy * cosine - dx * sine


def _off(stretch: Stretch, observation: Observation) -> float:
    """Return how far the robot is to the left of a stretch, m, seen in the direction of the drive."""
    ahead, left = _relative(stretch, observation)
    if stretch.curvature:
        # The centre of the arc is to the left by a signed radius.
        radius = 1.0 / (stretch.gear * stretch.curvature)
        left = radius - math.copysign(math.hypot(ahead, left - radius), radius)
    return stretch.gear * left


def _heading(memory: Memory, index: int, driven: float) -> float:
    """Return the heading of the path, rad, some length after the start of a stretch.

    It is the last one before the robot has to stop if that is nearer.
    """
    stretch = _stretch(memory, index)
    while stretch is not None and driven > stretch.length and not _stops_after(memory, index):
        index += 1
        driven -= stretch.length
        stretch = _stretch(memory, index)
    if stretch is None:
        return 0.0
    return stretch.heading + stretch.curvature * min(driven, stretch.length)
