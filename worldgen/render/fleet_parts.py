"""Draw several robots of one world, each in its own colour and with its number."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from worldgen.render.body_parts import BodyPose, goal_wedge, solid_body
from worldgen.render.frame import Frame
from worldgen.render.overlay import Trail
from worldgen.render.palette import INK, PAPER, mix
from worldgen.render.polyline import simplified
from worldgen.render.primitives import DrawnCircle, DrawnLine, Paint, Primitive, Text
from worldgen.render.trail_parts import arrow, heading_tick, ring_and_cross, robot_disc
from worldgen.support.arrays import Floats
from worldgen.world import JointWitness, Robot, Target, World

COLOURS = ("#C85400", "#0072B2", "#A8447F", "#00825F", "#7A6200", "#4F5BB8")
"""Colours of the robots, as in the player; a seventh robot has the first one's."""

# A robot with a smaller radius, units, gets a ring of this radius.
_HIDDEN = 6.0
_NUMBER_SIZE = 12.0

# Arrows from a robot to the one that blocks it, in radii: how far to the right of the line between
# their middles, and how far from the middles they begin and end.
_ASIDE = 0.55
_INSET = 0.3


def colour_of(robot: int) -> str:
    """Return the colour of a robot, given its index."""
    return COLOURS[robot % len(COLOURS)]


def joint_witness_parts(joint: JointWitness, frame: Frame) -> list[Primitive]:
    """Return the path that each robot could take, dashed in its colour."""
    unit = frame.unit
    parts: list[Primitive] = []
    for number, path in enumerate(joint.paths):
        if len(path.x) > 1:
            points = frame.points(np.column_stack((path.x, path.y)))
            paint = Paint(
                stroke=mix(PAPER, colour_of(number), 0.7),
                width=1.4 * unit,
                dash=(5.0 * unit, 5.0 * unit),
            )
            parts.append(DrawnLine(points, paint))
    return parts


def robot_parts(world: World, trails: Sequence[Trail], frame: Frame) -> list[Primitive]:
    """Return the starts, paths, targets and numbers of all robots, lowest layer first.

    Args:
        world: The world of the robots.
        trails: A path for each robot, in order; empty if there is no run.
        frame: The map's place in the picture.
    """
    robots = world.robots
    parts: list[Primitive] = []
    # Starts are drawn below paths, targets and ends above them.
    for number, robot in enumerate(robots):
        parts += _start(robot, colour_of(number), frame)
    for number, trail in enumerate(trails):
        parts += _path(trail, colour_of(number), frame)
    for number, robot in enumerate(robots):
        parts += _target(robot, number, frame)
    for number, trail in enumerate(trails):
        parts += _end(robots[number], trail, number, frame)
    for number, trail in enumerate(trails):
        for other in trail.blocked_by:
            if 0 < other <= len(trails):
                parts += _blocked(robots[number], trail, trails[other - 1], frame)
    if not trails:
        for number, robot in enumerate(robots):
            parts.append(_number(robot.start.x, robot.start.y, number, frame))
    return parts


def _start(robot: Robot, colour: str, frame: Frame) -> list[Primitive]:
    """Return a robot's body at its start, and a tick for its heading."""
    unit = frame.unit
    if not robot.is_disc:
        pose = BodyPose(robot.start.x, robot.start.y, robot.start.heading)
        return solid_body(robot, pose, frame, colour=colour, tint=0.25, width=1.6)
    x, y = frame.to_pixels(robot.start.x, robot.start.y)
    shown = max(robot.radius * frame.scale, _HIDDEN * unit)
    paint = Paint(stroke=mix(colour, "#000000", 0.3), width=3.0 * unit)
    return [
        *robot_disc(x, y, shown, unit, colour=colour, tint=0.25, width=1.6),
        heading_tick(x, y, shown, robot.start.heading, paint),
    ]


def _path(trail: Trail, colour: str, frame: Frame) -> list[Primitive]:
    """Return a robot's path; the part that repeats endlessly is drawn stronger."""
    unit = frame.unit
    points = frame.points(np.column_stack((trail.x, trail.y)))
    pieces = [(points, 1.8)]
    if trail.loop_from is not None:
        # The loop is drawn wider than the approach, because that is the point of the picture.
        pieces = [(points[: trail.loop_from + 1], 1.4), (points[trail.loop_from :], 3.0)]
    parts: list[Primitive] = []
    for piece, width in pieces:
        line = simplified(piece, 0.3)
        if len(line) > 1:
            # A light casing keeps the line visible on walls and on other lines.
            parts.append(
                DrawnLine(line, Paint(stroke=PAPER, width=(width + 1.6) * unit, opacity=0.7))
            )
            parts.append(DrawnLine(line, Paint(stroke=colour, width=width * unit)))
    return parts


def waypoint_parts(robot: Robot, colour: str, frame: Frame) -> list[Primitive]:
    """Return the goals before a robot's target, each as a ring with a cross and its number."""
    parts: list[Primitive] = []
    for number, goal in enumerate(robot.waypoints):
        parts += _goal(goal, number, colour, frame)
    return parts


def _target(robot: Robot, number: int, frame: Frame) -> list[Primitive]:
    """Return a robot's target as a ring with a cross, and its number next to it."""
    return _goal(robot.target, number, colour_of(number), frame)


def _goal(goal: Target, number: int, colour: str, frame: Frame) -> list[Primitive]:
    unit = frame.unit
    x, y = frame.to_pixels(goal.x, goal.y)
    # A target smaller than a few pixels would not be visible.
    radius = max(goal.radius * frame.scale, 5.0 * unit)
    reach = radius + 4.0 * unit
    parts: list[Primitive] = [DrawnCircle(x, y, radius, Paint(fill=PAPER, opacity=0.6))]
    strokes = (Paint(stroke=PAPER, width=4.4 * unit), Paint(stroke=colour, width=2.0 * unit))
    parts += ring_and_cross(x, y, radius, reach, strokes)
    parts += goal_wedge(goal, frame, reach, colour)
    parts += _label(np.array((x + reach + 4.0 * unit, y - reach)), number, colour, frame)
    return parts


def _end(robot: Robot, trail: Trail, number: int, frame: Frame) -> list[Primitive]:
    """Return a robot's disc where its run ended, with its number."""
    unit = frame.unit
    colour = colour_of(number)
    x, y = frame.to_pixels(float(trail.x[-1]), float(trail.y[-1]))
    shown = max(robot.radius * frame.scale, _HIDDEN * unit)
    return [
        DrawnCircle(x, y, shown + 1.5 * unit, Paint(fill=PAPER)),
        DrawnCircle(x, y, shown, Paint(fill=mix(PAPER, colour, 0.6))),
        DrawnCircle(x, y, shown, Paint(stroke=mix(colour, "#000000", 0.3), width=2.0 * unit)),
        _number(float(trail.x[-1]), float(trail.y[-1]), number, frame),
    ]


def _blocked(robot: Robot, trail: Trail, other: Trail, frame: Frame) -> list[Primitive]:
    """Return an arrow from where a robot ended to the one that blocks it."""
    start = np.array(frame.to_pixels(float(trail.x[-1]), float(trail.y[-1])))
    end = np.array(frame.to_pixels(float(other.x[-1]), float(other.y[-1])))
    radius = max(robot.radius * frame.scale, _HIDDEN * frame.unit)
    length = math.dist(start, end)
    if length == 0.0:
        return []
    # Keep to the right and away from the centres, so that two robots that block each other have
    # separate arrows and their numbers stay readable.
    ahead = (end - start) / length
    aside = _ASIDE * radius * np.array((-ahead[1], ahead[0]))
    inset = min(_INSET * radius, 0.25 * length) * ahead
    tail = start + inset + aside
    tip = end - inset + aside
    return arrow((tail[0], tail[1]), (tip[0], tip[1]), frame.unit, INK, INK)


def _number(x: float, y: float, number: int, frame: Frame) -> Primitive:
    """Return a robot's number in the middle of its disc."""
    size = _NUMBER_SIZE * frame.unit
    text = str(number + 1)
    at = np.array(frame.to_pixels(x, y)) + np.array((-0.29 * size * len(text), 0.36 * size))
    return Text(float(at[0]), float(at[1]), size, text, INK)


def _label(at: Floats, number: int, colour: str, frame: Frame) -> list[Primitive]:
    """Return a robot's or a waypoint's number next to its goal, on a light ground."""
    size = _NUMBER_SIZE * frame.unit
    text = str(number + 1)
    ground = Paint(fill=PAPER, opacity=0.8)
    middle = at + np.array((0.29 * size * len(text), -0.36 * size))
    dark = mix(colour, "#000000", 0.3)
    return [
        DrawnCircle(float(middle[0]), float(middle[1]), 0.62 * size, ground),
        Text(float(at[0]), float(at[1]), size, text, dark),
    ]
