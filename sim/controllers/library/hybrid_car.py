"""Hybrid A*: plan a path that a car can drive on a map that is known, and keep to it.

At the start, the prover's search (``worldgen/reach/car``) finds a path of arcs and lines for the
robot's turning radius, at first with some room to walls and to full lock, then with less. In each
step, the controller takes the curvature of the path at the robot's place, and corrects it by how far
the robot is off to the side and off in its heading. Where the path changes gear, it stops exactly
there. If no path is found, the robot stays where it is.

It plans once. It does not look for changes of the world, and what pushes the robot away from its
path by more than its steering can correct is not noticed.

Sources: D. Dolgov, S. Thrun, M. Montemerlo and J. Diebel, "Path planning for autonomous vehicles in
    unknown semi-structured environments", The International Journal of Robotics Research 29 (2010).
    For the law that keeps to the path: C. Samson, "Control of chained systems: application to path
    following and time-varying point-stabilization of mobile robots", IEEE Transactions on Automatic
    Control 40 (1995).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from sim.controllers.base import Command, Memory, Observation
from sim.controllers.memory_view import MemoryField
from worldgen.reach.car.search import EFFORTS, find_path
from worldgen.reach.car.stretches import Stretch, stretches_of
from worldgen.world import Robot, World

# Places in the memory: the stretch that is being driven, steps for which the wheels still turn, the
# largest curvature, rad/m, and the share of it that the wheels turn in a second; then the stretches.
_STRETCH, _WAIT, _LOCK, _RATE = range(4)
_STRETCHES = 4
_NUMBERS = len(Stretch._fields)

# Share of a step, and m: nearer to the end of a stretch than this, the robot is there.
_NEAR = 1e-3
# Steps of driving in which an error of the pose decays.
_SETTLING = 3.0


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
            poses = find_path(wary, EFFORTS[:2]).poses
            if len(poses):
                arcs = wary.robots[0].drive.turning_radius
                stretches = stretches_of(poses, arcs, world.cell_size)
                break
        numbers = [float(value) for stretch in stretches for value in stretch]
        return (0.0, 0.0, 1.0 / radius, robot.drive.steering_rate, *numbers)

    def _wary(self, world: World, radius: float) -> Iterator[World]:
        """Yield the world with less and less room kept from walls, target's rim and full lock."""
        robot = world.robots[0]
        for share in (1.0, 0.25, 0.0):
            drive = replace(robot.drive, turning_radius=radius * (1.0 + share * self.spare_lock))
            target = replace(robot.target, radius=robot.target.radius * (1.0 - 0.5 * share))
            wide = _padded(replace(robot, drive=drive, target=target), share * self.margin)
            yield replace(world, robots=(wide,), certificate=None)

    def act(self, observation: Observation, memory: Memory) -> tuple[Command, Memory]:
        """Return the command for the next step, and the new memory."""
        index, wait = int(memory[_STRETCH]), memory[_WAIT]
        reach = observation.top_speed * observation.time_step
        near = _NEAR * reach
        stretch = _stretch(memory, index)
        if stretch is None:
            return Command(), memory
        left = stretch.length - _driven(stretch, observation)
        # The next stretch begins in the middle of a step, unless the robot has to stop first.
        while left < (near if _stops_after(memory, index) else reach / 2):
            index += 1
            before, stretch = stretch, _stretch(memory, index)
            if stretch is None:
                return Command(), (float(index), 0.0, *memory[_LOCK:])
            if memory[_RATE] and before.gear * before.curvature != stretch.gear * stretch.curvature:
                change = abs(before.gear * before.curvature - stretch.gear * stretch.curvature)
                seconds = change / memory[_LOCK] / memory[_RATE]
                wait = math.ceil(seconds / observation.time_step)
            left = stretch.length - _driven(stretch, observation)
        kept = (float(index), max(0.0, wait - 1.0), *memory[_LOCK:])
        if wait > 0:
            # The wheels of a car that stands turn as far as they go, or straight ahead.
            return Command(0.0, stretch.curvature * stretch.gear), kept
        speed = observation.top_speed
        if _stops_after(memory, index):
            speed = min(speed, left / observation.time_step)
        curvature = _curvature(stretch, observation, _SETTLING * reach)
        curvature = max(-memory[_LOCK], min(memory[_LOCK], curvature))
        return Command(stretch.gear * speed, curvature * speed), kept


hybrid_car = HybridCar()


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
    cosine, sine = math.cos(stretch.heading), math.sin(stretch.heading)
    ahead, left = _relative(stretch, observation, cosine, sine)
    if not stretch.curvature:
        return stretch.gear * ahead
    # The angle around the centre of the arc, which is to the left by a signed radius.
    side = stretch.gear * stretch.curvature
    radius = 1.0 / abs(side)
    angle = math.atan2(stretch.gear * ahead, radius - left * math.copysign(1.0, side))
    if angle < -math.pi / 2:
        angle += math.tau
    return angle * radius


def _relative(
    stretch: Stretch, observation: Observation, cosine: float, sine: float
) -> tuple[float, float]:
    """Return where the robot is, seen from the start of a stretch: ahead and to the left, m."""
    dx, dy = observation.x - stretch.x, observation.y - stretch.y
    return dx * cosine + dy * sine, dy * cosine - dx * sine


def _curvature(stretch: Stretch, observation: Observation, settling: float) -> float:
    """Return the turn per length, rad/m, that leads back to a stretch and along it.

    Args:
        stretch: A line or an arc.
        observation: The robot's pose.
        settling: Length in which errors decay, m.
    """
    driven = _driven(stretch, observation)
    heading = stretch.heading + stretch.curvature * driven
    cosine, sine = math.cos(stretch.heading), math.sin(stretch.heading)
    ahead, left = _relative(stretch, observation, cosine, sine)
    off = left
    if stretch.curvature:
        # The centre is to the left by the radius if the curvature and the gear agree.
        radius = 1.0 / (stretch.gear * stretch.curvature)
        off = radius - math.copysign(math.hypot(ahead, left - radius), radius)
    # Seen in the direction of the drive, which is back to front in reverse.
    off *= stretch.gear
    askew = math.remainder(observation.heading - heading, math.tau)
    return stretch.curvature - 2.0 * askew / settling - off / settling**2
