"""Causes that only a second run shows: the same scenario in another world.

A robot whose gap is too narrow often repeats the same moves as a robot behind a wall. A smaller
robot distinguishes the two: it arrives in the first case. A robot that comes back to a wall has
left it too early if it can get around walls, and bounces off it otherwise; a room with one wall
distinguishes these.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from fuzz.facts.contacts import nearest_walls, walls_at_the_end
from sim.controllers.answers import leaving_proofs
from sim.controllers.catalogue import CONTROLLERS
from sim.controllers.programs.process import is_process_name
from sim.episode import simulate
from sim.options.run import RunOptions
from sim.trace import Trace
from sim.verdict import ARRIVALS
from worldgen.difficulty.bottleneck import narrowest_gap_sq
from worldgen.errors import WorldgenError
from worldgen.lattice import UNIT
from worldgen.plugins.user_modules import sources_read
from worldgen.reach.still.disc import target_disc
from worldgen.reach.still.walls import Walls
from worldgen.render.body_parts import room_at, tight_poses
from worldgen.render.polyline import along, arc_length
from worldgen.timeline import Timeline
from worldgen.world import Pose, Robot, Target, Witness, World

# A place is a gap if two of the robots do not fit through it side by side, and at a wall if one of
# twice the radius does not fit there.
_GAP = 2.0

# Places along a witness among which the nearest one to a pose is found.
_SAMPLES = 500

# Radii of smaller robots, as shares of the robot's own, the smallest first: most robots that no gap
# holds back fail at the first radius, which saves the other runs.
_SMALLER = (0.5, 0.6, 0.7, 0.8, 0.9)

# The same of bodies that are not discs. Half of a rectangle may still be longer than a gap is wide,
# and a controller may take it for the disc around it.
SMALLER_BODIES = (0.3, 0.4, *_SMALLER)

# Number of smaller robots that must arrive. In a world that is hard for another reason, one or two
# robots may arrive by chance.
_FEWEST = 3

# A room with a wall in the middle, in cells: its length, its thickness, and the free space around
# it. The robot starts in front of the wall, a little off its middle.
_LONG = 16
_THICK = 2
_AROUND = 6
_OFF_MIDDLE = 0.3
_HEADINGS = (0.0, 2.0, -2.0, 3.0)  # rad; the wall is in direction 0

# Length of the path, in cells, that it has to drive along the wall. Straight ahead, it reaches the
# wall 7.7 cells from the nearer end.
_FOLLOWED = 6.5

# Cells that a robot at top speed can drive in that room, which gives slower ones time too; and the
# steps at most, however short they are.
_DRIVES = 300
_MOST_STEPS = 20_000

# Largest radius of the robot in that room, in cells: a larger robot gets larger cells.
_LARGEST = 0.35

# A wall is next to the robot if it is at most this many radii from the robot's centre, and the sine
# of the angle between its direction and the heading is larger than the second number.
_NEAR = 3.0
_SIDEWAYS = 0.34

# Radii that the robot may drive without a wall next to it and still follow that wall.
_INTERRUPTED = 1.0


@dataclass(frozen=True)
class OtherWorlds:
    """Runs a scenario in worlds other than its own.

    Args:
        controller: Name of the controller.
        options: Options of the run.
    """

    controller: str
    options: RunOptions

    def arrives(self, world: World) -> bool:
        """Return True if the robot arrives in a world."""
        try:
            with leaving_proofs():
                return simulate(world, self.controller, self.options).verdict in ARRIVALS
        except WorldgenError:
            # The changed robot does not fit at the start, or its wheels would not fit the robot.
            return False

    def gets_around_walls(self, world: World) -> bool:
        """Return True if the robot goes along a wall in its way until near the wall's end.

        Wall followers and planners do. It is tried in a room with one wall between start and
        target, from several start headings: a robot that bounces may stay near a wall by chance.

        Args:
            world: A world of the scenario; its robot and its cells decide the size of the room.
        """
        # The answer is about the controller, so the budget and the seed of a run don't matter.
        side = max(world.cell_size, world.robot_radius / _LARGEST)
        steps = math.ceil(_DRIVES * side / (world.robot_speed * self.options.time_step))
        robot = world.robots[0]
        robot = replace(
            robot,
            start=Pose(0.0, 0.0),
            target=Target(0.0, 0.0, robot.radius, contact=robot.target.contact),
        )
        options = replace(self.options, steps=min(steps, _MOST_STEPS), seed=0)
        run = _RunInRoom(self.controller, options, side, robot)
        # Nothing tells when a program is edited, so it is tried each time.
        if is_process_name(self.controller):
            return run.gets_around()
        file = CONTROLLERS.source(self.controller)
        edited = file.stat().st_mtime_ns if file is not None and file.is_file() else 0
        return _known_to_get_around(run, (edited, *sources_read().items()))


@dataclass(frozen=True)
class _RunInRoom:
    """A scenario in a room with one wall between start and target.

    Args:
        controller: Name of the controller.
        options: Options of the run.
        side: Side of a cell, m.
        robot: The robot; the room sets where it starts, and where its target is.
    """

    controller: str
    options: RunOptions
    side: float
    robot: Robot

    def gets_around(self) -> bool:
        for heading in _HEADINGS:
            room = self._room(heading)
            try:
                with leaving_proofs():
                    trace = simulate(room, self.controller, self.options, record=True).trace
            except WorldgenError:
                # Its options do not fit such a room.
                return False
            if trace is None or _longest_beside_a_wall(room, trace) < _FOLLOWED * self.side:
                return False
        return True

    def _room(self, heading: float) -> World:
        walls = np.zeros((_LONG + 2 * _AROUND, _THICK + 4 * _AROUND), np.bool_)
        walls[_AROUND:-_AROUND, 2 * _AROUND : -2 * _AROUND] = True
        height, width = walls.shape
        middle = height / 2 * self.side
        start = Pose(_AROUND * self.side, middle + _OFF_MIDDLE * self.side, heading)
        target = replace(self.robot.target, x=(width - _AROUND) * self.side, y=middle)
        robot = replace(self.robot, start=start, target=target)
        return World(walls, cell_size=self.side, robots=[robot])


@functools.lru_cache(maxsize=64)
def _known_to_get_around(run: _RunInRoom, code: tuple[object, ...]) -> bool:
    """Return whether a robot gets around a wall; computed again once the user's code has changed.

    Args:
        run: The scenario.
        code: Equal as long as the code is the same.
    """
    return run.gets_around()


def fails_by_timing(world: World, arrives: Callable[[World], bool]) -> bool:
    """Return True if the robot arrives once all changes have happened before it starts.

    Then neither the final walls nor the initial ones stop it. It fails because a cell changes while
    it drives.

    Args:
        world: The world.
        arrives: Returns True if the same robot arrives in another world.
    """
    if not world.timeline:
        return False
    return arrives(
        replace(
            world,
            walls=walls_at_the_end(world),
            timeline=Timeline(),
            certificate=None,
            failure=None,
        )
    )


def gap_that_stops(
    world: World, place: tuple[float, float], arrives: Callable[[World], bool], reached: int = 0
) -> float:
    """Return the width of a gap that the robot avoids although it fits through; 0 without one.

    A gap stops the robot if every path from the place that it reaches is narrow, and all robots
    below some smaller size arrive. Of a body that is not a disc, its witness's path is examined.

    Args:
        world: The world.
        place: x and y, cells.
        arrives: Returns True if the same robot arrives in another world.
        reached: Number of waypoints that it has arrived at; the path to the next goal counts.

    Returns:
        The width in radii of the robot.
    """
    robot = world.robots[0]
    ahead = world.for_goal(reached)
    leg = _leg_of(world, reached)
    gap = _narrow_way(ahead, place) if robot.is_disc else _narrow_path(ahead, place, leg)
    if not gap:
        return 0.0
    changed = replace(world, certificate=None, failure=None)
    # The first robot that does not arrive decides, so no larger one is tried.
    arrived = itertools.takewhile(
        lambda share: arrives(replace(changed, robots=(smaller(robot, share),))),
        _SMALLER if robot.is_disc else SMALLER_BODIES,
    )
    return gap if len(list(arrived)) >= _FEWEST else 0.0


def smaller(robot: Robot, share: float) -> Robot:
    """Return the robot with this share of its size."""
    footprint = tuple((share * x, share * y) for x, y in robot.footprint)
    return replace(robot, radius=share * robot.radius, footprint=footprint)


def _leg_of(world: World, reached: int) -> Witness | None:
    """Return the part of a witness from one goal, or the start, to the next; None without a witness."""
    proof = world.certificate
    if not isinstance(proof, Witness):
        return None
    first = last = 0
    # The witness has a point in each goal.
    for goal in world.robots[0].goals[: reached + 1]:
        first = last
        away = np.hypot(proof.x[first:] - goal.x, proof.y[first:] - goal.y)
        last = first + int(np.argmax(away <= goal.radius * (1.0 + 1e-9)))
    part = slice(first, last + 1)
    headings = None if proof.headings is None else proof.headings[part]
    return Witness(proof.times[part], proof.x[part], proof.y[part], proof.clearance, headings)


def _narrow_path(world: World, place: tuple[float, float], proof: Witness | None) -> float:
    """Return how wide a body's witness is at its tightest place, after a place; 0 if it is wide.

    Returns:
        The shorter side of the body and the room on both of its sides, in radii of the robot.
    """
    tight = tight_poses(world, proof) if proof is not None else []
    if not tight or proof is None or len(proof.x) < 2:
        return 0.0
    # A robot that has the tightest place behind it is held by another one, which this doesn't show.
    points = np.column_stack((proof.x, proof.y))
    samples = along(points, np.linspace(0.0, float(arc_length(points)[-1]), _SAMPLES))
    here = np.array(place) * world.cell_size
    reached, passed = (
        int(np.hypot(*(samples - point).T).argmin()) for point in (here, tight[-1][:2])
    )
    robot = world.robots[0]
    side = float(np.ptp(robot.footprint, axis=0).min())
    width = side + 2.0 * room_at(world, tight[0])
    return width / robot.radius if reached <= passed and width < _GAP * side else 0.0


def _narrow_way(world: World, place: tuple[float, float]) -> float:
    """Return how wide every path from a place to the target is at most; 0 if one is wide.

    The width is that of a gap on the way, or twice the distance of the target from a wall, in radii
    of the robot.
    """
    solid = walls_at_the_end(world)
    x, y = place
    height, width = solid.shape
    if not (0 <= x < width and 0 <= y < height) or solid[math.floor(y), math.floor(x)]:
        return 0.0
    # The place itself may be next to a wall: that does not keep the robot from leaving it.
    target = target_disc(world)
    centre = (target.x, target.y)
    radius = world.robot_radius / world.cell_size
    limit = math.ceil((2.0 * _GAP * radius) ** 2)
    gap_sq = narrowest_gap_sq(solid, (round(x * UNIT), round(y * UNIT)), centre, limit)
    gap = math.inf if gap_sq is None else math.sqrt(gap_sq) / radius
    to_wall = math.sqrt(Walls(solid, Fraction(1)).nearest(centre)[1]) + target.radius
    beside_target = 2.0 * to_wall / (radius * UNIT)
    return min(gap, beside_target) if min(gap, beside_target) < 2.0 * _GAP else 0.0


def _longest_beside_a_wall(world: World, trace: Trace) -> float:
    """Return the longest path on which a wall stays on the same side of the robot, m."""
    steps = np.arange(1, trace.steps + 1)
    stride = np.hypot(np.diff(trace.x), np.diff(trace.y))
    gap, direction = nearest_walls(world, trace, steps, _NEAR * world.robot_radius)
    # Positive with a wall on the left, 0 without one.
    side = np.where(np.isfinite(gap), np.sin(direction - trace.heading[1:]), 0.0)
    longest = 0.0
    for has_wall in (side > _SIDEWAYS, side < -_SIDEWAYS):
        path = without = 0.0
        for length, is_there in zip(stride.tolist(), has_wall.tolist(), strict=True):
            without = 0.0 if is_there else without + length
            path = path + length if without < _INTERRUPTED * world.robot_radius else 0.0
            longest = max(longest, path)
    return longest
