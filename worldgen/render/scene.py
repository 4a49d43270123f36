"""Compose a picture: a world, a run in it, and the caption.

The result is a list of primitives in pixels.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from worldgen.render.body_parts import BodyPose, body_shapes, goal_wedge, solid_body, witness_parts
from worldgen.render.caption import caption
from worldgen.render.content import Changes, Content
from worldgen.render.disturbance_parts import above_the_trail, missed_cells, under_the_walls
from worldgen.render.fleet_parts import joint_witness_parts, robot_parts, waypoint_parts
from worldgen.render.frame import BAND, Frame
from worldgen.render.memory_parts import floor_of_memory, lines_of_memory
from worldgen.render.named_parts import axis_numbers, named_cells, named_parts
from worldgen.render.outline import corner_count, outlines
from worldgen.render.overlay import Trails, each_trail
from worldgen.render.palette import (
    FIRE,
    FLOOR,
    FULL_TINT,
    GREY,
    PAPER,
    START,
    TARGET,
    TUNNEL,
    WALL,
    mix,
)
from worldgen.render.primitives import DrawnCells, DrawnCircle, DrawnLine, Glow, Paint, Primitive
from worldgen.render.trail_parts import (
    breach_crosses,
    heading_tick,
    pierced_parts,
    ring_and_cross,
    robot_disc,
    swept_parts,
    trail_parts,
)
from worldgen.support.arrays import Bools, Floats
from worldgen.world import Cut, JointWitness, Witness, World

# A robot with a smaller radius, units, gets a ring of this radius.
HIDDEN = 6.0
FINDER = 11.0
# Limit on dotted outlines; more of them turn into a grey blur.
MOST_CORNERS = 4000


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture, ready for any backend; primitives are drawn in order.

    Args:
        frame: The map's place in the picture.
        width: px.
        height: px.
        title: Name of the picture; may be empty.
        primitives: Lowest first.
    """

    frame: Frame
    width: int
    height: int
    title: str
    primitives: tuple[Primitive, ...]


def compose(
    world: World, trail: Trails, *, signal: bool, witness: bool, title: str, pixels: int
) -> Picture:
    """Return a world's complete picture, lowest layer first.

    Args:
        world: What to draw.
        trail: A run in it; for several robots, one trail for each.
        signal: True to tint the floor by the target's signal.
        witness: True to draw the proof's path, or its cut.
        title: First line of the caption.
        pixels: Longer side of the map, px.

    Raises:
        InvalidParameter: If ``pixels`` is out of range.
    """
    trails = each_trail(trail)
    named = named_cells(trails)
    frame = Frame.of(world, pixels, is_numbered=bool(named))
    # The floor cannot show the signals of several targets.
    shown = signal and not world.is_fleet
    content = Content(world, trails, shown, witness, title, frame, Changes.of(world), named)
    words, height = caption(content)
    paper = _box(0.0, 0.0, frame.picture_width, height, PAPER)
    marked = [*named_parts(named, frame), *axis_numbers(content)] if named else []
    parts = (paper, *_map(content), *marked, *words)
    return Picture(frame, frame.picture_width, height, title, parts)


def map_parts(world: World, frame: Frame) -> list[Primitive]:
    """Return a world's map alone, without caption, signal or proof, lowest layer first."""
    paper = _box(0.0, 0.0, frame.picture_width, frame.bottom + frame.top, PAPER)
    return [paper, *_map(Content(world, (), False, False, "", frame, Changes.of(world)))]


def moment_parts(
    world: World, frame: Frame, solid: Bools, burning: Bools, height: int
) -> list[Primitive]:
    """Return a world's map at one moment, lowest layer first, with room for text below.

    Args:
        world: What to draw.
        frame: The map's place in the picture.
        solid: (height, width) bool: the cells that are solid at that moment.
        burning: (height, width) bool: the cells that burn.
        height: Height of the picture, px.
    """
    parts: list[Primitive] = [_box(0.0, 0.0, frame.picture_width, height, PAPER), _band(frame)]
    parts += [
        DrawnCells(np.ones_like(solid), FLOOR),
        DrawnCells(solid, WALL),
        DrawnCells(burning, FIRE),
    ]
    if world.is_fleet:
        return [*parts, *robot_parts(world, (), frame)]
    return [
        *parts,
        *_start_disc(world, frame),
        *_start_heading(world, frame),
        *_target(world, frame),
    ]


def _map(content: Content) -> list[Primitive]:
    world = content.world
    frame = content.frame
    parts: list[Primitive] = [_band(frame), *_floor(world, frame, signal=content.signal)]
    if content.trail:
        parts += under_the_walls(content.trail.disturbances, frame)
        parts += missed_cells(content.trail.missed, frame)
        parts += floor_of_memory(content.trail.memory, frame)
    parts += [DrawnCells(world.walls, WALL), *_changes(content.changes, frame)]
    if content.witness:
        parts += _certificate(world, frame)
    if world.is_fleet:
        return [*parts, *robot_parts(world, content.trails, frame)]
    trail = content.trail
    robot = world.robots[0]
    # The start's disc is drawn under the lines, because a cycle often leads through it; its heading
    # is drawn above.
    parts += [*(swept_parts(trail, frame, robot) if trail else ()), *_start_disc(world, frame)]
    parts += [*(trail_parts(trail, frame, robot) if trail else ()), *_start_heading(world, frame)]
    if trail:
        parts += above_the_trail(trail.disturbances, frame, world.cell_size)
        parts += lines_of_memory(trail.memory, frame)
        parts += [
            *pierced_parts(trail.pierced, world.walls.shape, frame),
            *breach_crosses(trail.pierced, frame),
        ]
    return [*parts, *_target(world, frame)]


def _box(left: float, top: float, right: float, bottom: float, fill: str) -> DrawnLine:
    points = np.array(((left, top), (right, top), (right, bottom), (left, bottom)), np.float64)
    return DrawnLine(points, Paint(fill=fill), closed=True)


def _band(frame: Frame) -> DrawnLine:
    """Return a wall around the map, because everything outside the grid is solid."""
    band = frame.band
    return _box(
        frame.left - band,
        frame.top - band,
        frame.left + frame.width + band,
        frame.bottom + band,
        WALL,
    )


def _floor(world: World, frame: Frame, *, signal: bool) -> list[Primitive]:
    if not signal:
        return [_box(frame.left, frame.top, frame.left + frame.width, frame.bottom, FLOOR)]
    target = world.target
    x, y = frame.to_pixels(target.x, target.y)
    width = world.width * world.cell_size
    height = world.height * world.cell_size
    far = (
        math.hypot(max(target.x, width - target.x), max(target.y, height - target.y)) * frame.scale
    )
    near = max(target.radius * frame.scale, 2.0 * frame.unit)
    parts: list[Primitive] = [Glow(x, y, near, max(far, near * 1.01), FULL_TINT, FLOOR)]
    ring = near
    gap = 12.0 * frame.unit
    line = Paint(stroke=TARGET, width=1.0 * frame.unit, opacity=0.22)
    while ring < far:
        # The signal halves here.
        ring *= math.sqrt(2.0)
        if ring * (1.0 - math.sqrt(0.5)) >= gap:
            parts.append(DrawnCircle(x, y, ring, line, clipped=True))
    return parts


def _changes(changes: Changes, frame: Frame) -> list[Primitive]:
    unit = frame.unit
    # Below this size the stripes of a cell would run together.
    stripes = 7.0 * unit if frame.cell >= 4.0 * unit else 0.0
    parts: list[Primitive] = []
    for mask, colour in ((changes.closes, GREY), (changes.burns, FIRE)):
        if mask.any():
            parts.append(DrawnCells(mask, colour, opacity=0.30))
            if stripes:
                parts.append(DrawnCells(mask, colour, opacity=0.85, hatch=stripes))
    # Dotted outlines of very many corners would only make the file large.
    if changes.opens.any() and corner_count(changes.opens) <= MOST_CORNERS:
        dotted = Paint(stroke=PAPER, width=1.8 * unit, dash=(1.8 * unit, 3.2 * unit))
        for line in outlines(changes.opens):
            parts.append(DrawnLine(frame.corners(line), dotted, closed=True))
    return parts


def _certificate(world: World, frame: Frame) -> list[Primitive]:
    unit = frame.unit
    proof = world.certificate
    if isinstance(proof, Witness) and len(proof.x) > 1:
        points = frame.points(np.column_stack((proof.x, proof.y)))
        return [
            DrawnLine(points, Paint(stroke=START, width=1.8 * unit, dash=(7.0 * unit, 5.0 * unit))),
            *witness_parts(world, proof, frame),
        ]
    if isinstance(proof, JointWitness):
        return joint_witness_parts(proof, frame)
    if isinstance(proof, Cut) and len(proof.cells):
        points = _onto_the_border(frame.corners(proof.cells + 0.5), frame)
        # The light casing makes the cut visible on both walls and floor.
        casing = DrawnLine(points, Paint(stroke=PAPER, width=5.0 * unit, opacity=0.8), closed=True)
        return [casing, DrawnLine(points, Paint(stroke=TUNNEL, width=3.0 * unit), closed=True)]
    return []


def _onto_the_border(points: Floats, frame: Frame) -> Floats:
    """Return the cut's cells outside the grid, drawn on the wall around it, off the caption."""
    beyond = BAND / 2 * frame.unit
    corner = np.array((frame.left, frame.top))
    ends = corner + np.array((frame.width, frame.height))
    clipped: Floats = np.clip(points, corner - beyond, ends + beyond)
    return clipped


def _target(world: World, frame: Frame) -> list[Primitive]:
    unit = frame.unit
    x, y = frame.to_pixels(world.target.x, world.target.y)
    radius = max(world.target.radius * frame.scale, 5.0 * unit)
    reach = radius + 6.0 * unit
    parts = waypoint_parts(world.robots[0], TARGET, frame)
    parts.append(DrawnCircle(x, y, radius, Paint(fill=PAPER, opacity=0.75)))
    strokes = (Paint(stroke=PAPER, width=5.0 * unit), Paint(stroke=TARGET, width=2.4 * unit))
    parts += ring_and_cross(x, y, radius, reach, strokes)
    return [*parts, *_goal(world, frame, reach)]


def _goal(world: World, frame: Frame, reach: float) -> list[Primitive]:
    """Return the goal's heading, and the outline of a body that stands there."""
    robot = world.robots[0]
    target = world.target
    if target.heading is None:
        return []
    parts: list[Primitive] = []
    if not robot.is_disc:
        dashed = Paint(stroke=TARGET, width=1.4 * frame.unit, dash=(4.0 * frame.unit,) * 2)
        parts += body_shapes(robot, BodyPose(target.x, target.y, target.heading), frame, (dashed,))
    return [*parts, *goal_wedge(target, frame, reach)]


def _start_disc(world: World, frame: Frame) -> list[Primitive]:
    """Return the robot's body, true to scale; if it is too small to see, a ring marks it."""
    unit = frame.unit
    robot = world.robots[0]
    if not robot.is_disc:
        pose = BodyPose(world.start.x, world.start.y, world.start.heading)
        return solid_body(robot, pose, frame, colour=START, tint=0.45, width=2.0)
    x, y = frame.to_pixels(world.start.x, world.start.y)
    radius = world.robot_radius * frame.scale
    shown = max(radius, 3.0 * unit)
    parts = robot_disc(x, y, shown, unit, colour=START, tint=0.45, width=2.0)
    if radius < HIDDEN * unit:
        parts.append(DrawnCircle(x, y, FINDER * unit, Paint(stroke=PAPER, width=4.5 * unit)))
        parts.append(DrawnCircle(x, y, FINDER * unit, Paint(stroke=START, width=2.2 * unit)))
    return parts


def _start_heading(world: World, frame: Frame) -> list[Primitive]:
    """Return a tick on the rim of the start's disc, or of its ring; a body has its own mark."""
    if not world.robots[0].is_disc:
        return []
    x, y = frame.to_pixels(world.start.x, world.start.y)
    rim = world.robot_radius * frame.scale
    if rim < HIDDEN * frame.unit:
        rim = FINDER * frame.unit
    paint = Paint(stroke=mix(START, "#000000", 0.45), width=3.6 * frame.unit)
    return [heading_tick(x, y, rim, world.start.heading, paint)]
