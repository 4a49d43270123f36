"""Draw a robot's start and target, and what only several robots have: numbers, and who blocks whom."""

from __future__ import annotations

import math

import numpy as np

from worldgen.render.body_parts import BodyPose, body_shapes, goal_wedge, solid_body
from worldgen.render.frame import Frame
from worldgen.render.marks import MARKS, hue, robot_colours
from worldgen.render.overlay import Trail
from worldgen.render.primitives import DrawnCircle, DrawnLine, Paint, Primitive, Text
from worldgen.render.trail_parts import arrow, heading_tick
from worldgen.support.arrays import Floats
from worldgen.world import Robot, Target

# A robot with a smaller radius, units, gets a ring of this radius.
_HIDDEN = 6.0
_FINDER = 11.0

# Arrows from a robot to the one that blocks it, in radii: how far to the right of the line between
# their middles, and how far from the middles they begin and end.
_ASIDE = 0.55
_INSET = 0.3


def colour_of(robot: int) -> str:
    """Return the colour of one of several robots, given its index."""
    colours = robot_colours()
    return colours[robot % len(colours)]


def start_parts(robot: Robot, frame: Frame, colour: str) -> list[Primitive]:
    """Return the robot's body, true to scale; if it is too small to see, a ring marks it."""
    mark = MARKS["start"]
    unit = frame.unit
    if not robot.is_disc:
        pose = BodyPose(robot.start.x, robot.start.y, robot.start.heading)
        return solid_body(robot, pose, frame, colour=colour, mark=mark)
    x, y = frame.to_pixels(robot.start.x, robot.start.y)
    radius = max(robot.radius * frame.scale, 3.0 * unit)
    parts = start_disc(x, y, radius, unit, colour)
    if radius < _HIDDEN * unit:
        for width, stroke in ((4.5, hue("floor")), (2.2, colour)):
            parts.append(
                DrawnCircle(x, y, _FINDER * unit, Paint(stroke=stroke, width=width * unit))
            )
    return parts


def start_dot(robot: Robot, frame: Frame, colour: str) -> list[Primitive]:
    """Return the start in a picture of a run, which shows the robot itself elsewhere: a dot."""
    return dot(*frame.to_pixels(robot.start.x, robot.start.y), frame.unit, colour)


def dot(x: float, y: float, unit: float, colour: str) -> list[Primitive]:
    """Return the mark of a start in a picture of a run, visible on walls and floor."""
    radius = MARKS["began"].size * unit
    ring = Paint(fill=hue("floor"), opacity=0.8)
    return [
        DrawnCircle(x, y, radius + 1.5 * unit, ring),
        DrawnCircle(x, y, radius, Paint(fill=colour)),
    ]


def start_disc(x: float, y: float, radius: float, unit: float, colour: str) -> list[Primitive]:
    """Return the mark of a start without its heading, visible on walls and floor."""
    mark = MARKS["start"]
    return [
        DrawnCircle(x, y, radius + 1.5 * unit, Paint(fill=hue("floor"), opacity=0.8)),
        DrawnCircle(x, y, radius, mark.inside(colour)),
        DrawnCircle(x, y, radius, mark.line(unit, colour)),
    ]


def start_heading(robot: Robot, frame: Frame, colour: str) -> list[Primitive]:
    """Return a tick on the rim of the start's disc, or of its ring; a body has its own mark."""
    if not robot.is_disc:
        return []
    x, y = frame.to_pixels(robot.start.x, robot.start.y)
    rim = robot.radius * frame.scale
    if rim < _HIDDEN * frame.unit:
        rim = _FINDER * frame.unit
    return [heading_tick(x, y, rim, robot.start.heading, MARKS["heading"].line(frame.unit, colour))]


def target_parts(robot: Robot, frame: Frame, colour: str) -> list[Primitive]:
    """Return the target's ring with a cross over it, its heading, and a body that stands there."""
    goal = robot.target
    x, y = frame.to_pixels(goal.x, goal.y)
    radius = max(goal.radius * frame.scale, MARKS["target"].size * frame.unit)
    parts = target_mark(x, y, radius, frame.unit, colour)
    return [*parts, *goal_parts(robot, goal, frame, colour)]


def waypoint_parts(robot: Robot, frame: Frame, colour: str) -> list[Primitive]:
    """Return each waypoint's ring with its number in it, its heading, and a body that stands there."""
    parts: list[Primitive] = []
    for number, goal in enumerate(robot.waypoints):
        x, y = frame.to_pixels(goal.x, goal.y)
        radius = max(goal.radius * frame.scale, MARKS["waypoint"].size * frame.unit)
        parts += waypoint_mark(x, y, radius, frame.unit, colour)
        parts += _number((x, y), number, frame, colour)
        parts += goal_parts(robot, goal, frame, colour)
    return parts


def waypoint_mark(x: float, y: float, radius: float, unit: float, colour: str) -> list[Primitive]:
    """Return the ring of a waypoint, with a light casing."""
    mark = MARKS["waypoint"]
    rings = [DrawnCircle(x, y, radius, paint) for paint in mark.lines(unit, colour)]
    return [DrawnCircle(x, y, radius, mark.inside(colour)), *rings]


def target_mark(x: float, y: float, radius: float, unit: float, colour: str) -> list[Primitive]:
    """Return the mark of a target: a ring and a cross over it, with a light casing."""
    mark = MARKS["target"]
    reach = radius + 5.0 * unit
    parts: list[Primitive] = [DrawnCircle(x, y, radius, mark.inside(colour))]
    for paint in mark.lines(unit, colour):
        parts.append(DrawnCircle(x, y, radius, paint))
        for dx, dy in ((reach, 0.0), (0.0, reach)):
            parts.append(DrawnLine(np.array(((x - dx, y - dy), (x + dx, y + dy))), paint))
    return parts


def goal_parts(robot: Robot, target: Target, frame: Frame, colour: str) -> list[Primitive]:
    """Return the heading that a goal asks for, and the outline of a body that stands there."""
    if target.heading is None:
        return []
    parts: list[Primitive] = []
    if not robot.is_disc:
        pose = BodyPose(target.x, target.y, target.heading)
        parts += body_shapes(robot, pose, frame, (MARKS["goal"].line(frame.unit, colour),))
    least = MARKS["target" if target is robot.target else "waypoint"].size * frame.unit
    radius = max(target.radius * frame.scale, least)
    return [*parts, *goal_wedge(target, frame, radius + 5.0 * frame.unit, colour)]


def blocked_parts(robot: Robot, trail: Trail, other: Trail, frame: Frame) -> list[Primitive]:
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
    return arrow((tail[0], tail[1]), (tip[0], tip[1]), frame.unit, "blocked")


def end_number(trail: Trail, number: int, frame: Frame) -> list[Primitive]:
    """Return a robot's number where its run ended."""
    return _number(frame.to_pixels(float(trail.x[-1]), float(trail.y[-1])), number, frame)


def start_number(robot: Robot, number: int, frame: Frame) -> list[Primitive]:
    """Return a robot's number at its start."""
    return _number(frame.to_pixels(robot.start.x, robot.start.y), number, frame)


def target_number(robot: Robot, number: int, frame: Frame) -> list[Primitive]:
    """Return a robot's number next to its target."""
    x, y = frame.to_pixels(robot.target.x, robot.target.y)
    away = max(robot.target.radius * frame.scale, MARKS["target"].size * frame.unit)
    away += 10.0 * frame.unit
    return _number((x + away, y - away), number, frame)


def _number(
    at: tuple[float, float], number: int, frame: Frame, colour: str = ""
) -> list[Primitive]:
    """Return a number around a point, on a light ground; a robot's in its colour."""
    size = MARKS["number"].size * frame.unit
    text = str(number + 1)
    place: Floats = np.array(at) + np.array((-0.29 * size * len(text), 0.36 * size))
    return [
        DrawnCircle(at[0], at[1], 0.62 * size, Paint(fill=hue("floor"), opacity=0.8)),
        Text(float(place[0]), float(place[1]), size, text, colour or colour_of(number)),
    ]
