"""Compose a picture: a world, a run in it, and the caption.

The result is a list of primitives in pixels. What is drawn, and in which order, is in
``marks.json``, which the pages' player reads too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import msgspec
import numpy as np

from worldgen.render.body_parts import witness_parts
from worldgen.render.caption import caption
from worldgen.render.certificate_parts import blocked_share, cut_chain
from worldgen.render.change_labels import change_labels
from worldgen.render.content import Changes, Content, View
from worldgen.render.disturbance_parts import above_the_trail, missed_cells, under_the_walls
from worldgen.render.frame import Frame
from worldgen.render.marks import MARKS, Mark, hue
from worldgen.render.memory_parts import floor_of_memory, lines_of_memory, plan_of_memory
from worldgen.render.named_parts import axis_numbers, named_cells, named_parts
from worldgen.render.overlay import Trail, Trails, each_trail
from worldgen.render.primitives import DrawnCells, DrawnCircle, DrawnLine, Glow, Paint, Primitive
from worldgen.render.robot_parts import (
    blocked_parts,
    end_number,
    start_dot,
    start_heading,
    start_number,
    start_parts,
    target_number,
    target_parts,
    waypoint_parts,
)
from worldgen.render.shortfall_parts import barred_parts, distance_parts
from worldgen.render.trail_parts import (
    approach_parts,
    band_parts,
    body_parts,
    breach_crosses,
    loop_parts,
    overlap_parts,
    pierced_parts,
    robot_at,
    run_parts,
    stay_parts,
    touched_parts,
)
from worldgen.support.arrays import Bools
from worldgen.world import Cut, JointWitness, Robot, Witness, World


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
    view = View(signal and not world.is_fleet, witness)
    content = Content(world, trails, view, title, frame, Changes.of(world), named)
    words, height = caption(content)
    paper = _box(0.0, 0.0, frame.picture_width, height, hue("paper"))
    numbers = axis_numbers(content) if named else []
    parts = (paper, *_map(content), *numbers, *words)
    return Picture(frame, frame.picture_width, height, title, parts)


def card_content(world: World, trails: Trails, frame: Frame, *, witness: bool = True) -> Content:
    """Return the content of a small picture, which has no signal."""
    view = View(False, witness, is_card=True)
    return Content(world, each_trail(trails), view, "", frame, Changes.of(world))


def card_parts(content: Content) -> list[Primitive]:
    """Return the map of a small picture, without caption, lowest layer first."""
    frame = content.frame
    paper = _box(0.0, 0.0, frame.picture_width, frame.bottom + frame.top, hue("paper"))
    return [paper, *_map(content)]


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
    fire = MARKS["fire"]
    parts: list[Primitive] = [
        _box(0.0, 0.0, frame.picture_width, height, hue("paper")),
        _band(frame),
        DrawnCells(np.ones_like(solid), hue("floor")),
        DrawnCells(solid, hue("wall")),
        DrawnCells(burning, hue(fire.colour), opacity=fire.fill),
    ]
    content = Content(world, (), View(False, True), "", frame, Changes.of(world))
    for name in ("witness", "start", "heading", "target", "waypoint", "number"):
        parts += _DRAWN[name](content, MARKS[name])
    return parts


def _map(content: Content) -> list[Primitive]:
    parts: list[Primitive] = [_band(content.frame)]
    for name, mark in MARKS.items():
        if name in _DRAWN and (mark.on_cards or not content.view.is_card):
            parts += _DRAWN[name](content, mark)
    return parts


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
        hue("wall"),
    )


def _floor(content: Content, mark: Mark) -> list[Primitive]:
    frame = content.frame
    fill = hue(mark.colour)
    return [_box(frame.left, frame.top, frame.left + frame.width, frame.bottom, fill)]


def _signal(content: Content, mark: Mark) -> list[Primitive]:
    if not content.view.signal:
        return []
    world = content.world
    frame = content.frame
    target = world.target
    x, y = frame.to_pixels(target.x, target.y)
    width = world.width * world.cell_size
    height = world.height * world.cell_size
    far = (
        math.hypot(max(target.x, width - target.x), max(target.y, height - target.y)) * frame.scale
    )
    near = max(target.radius * frame.scale, 2.0 * frame.unit)
    parts: list[Primitive] = [Glow(x, y, near, max(far, near * 1.01), mark.full_tint, hue("floor"))]
    ring = near
    gap = 12.0 * frame.unit
    while ring < far:
        # The signal halves here.
        ring *= math.sqrt(2.0)
        if ring * (1.0 - math.sqrt(0.5)) >= gap:
            parts.append(DrawnCircle(x, y, ring, mark.line(frame.unit), clipped=True))
    return parts


def _drift(content: Content, mark: Mark) -> list[Primitive]:
    trail = content.trail
    return under_the_walls(trail.disturbances, content.frame) if trail else []


def _missed(content: Content, mark: Mark) -> list[Primitive]:
    return missed_cells(content.trail.missed, content.frame) if content.trail else []


def _remembered(content: Content, mark: Mark) -> list[Primitive]:
    return floor_of_memory(content.trail.memory, content.frame) if content.trail else []


def _walls(content: Content, mark: Mark) -> list[Primitive]:
    return [DrawnCells(content.world.walls, hue(mark.colour))]


def _cells(mask: Bools, mark: Mark, frame: Frame) -> list[Primitive]:
    """Return cells with a tint and stripes; below some size the stripes would run together."""
    if not mask.any():
        return []
    colour = hue(mark.colour)
    parts: list[Primitive] = [DrawnCells(mask, colour, opacity=mark.fill)]
    if frame.cell >= 4.0 * frame.unit:
        stripes = mark.size * frame.unit
        parts.append(DrawnCells(mask, colour, opacity=mark.opacity, hatch=stripes))
    return parts


def _burns(content: Content, mark: Mark) -> list[Primitive]:
    return _cells(content.changes.burns, mark, content.frame)


def _closes(content: Content, mark: Mark) -> list[Primitive]:
    return _cells(content.changes.closes, mark, content.frame)


def _opens(content: Content, mark: Mark) -> list[Primitive]:
    opens = content.changes.opens
    if not opens.any():
        return []
    # Stripes stand out from a light ground, not from a wall.
    light = DrawnCells(opens, hue("floor"), opacity=mark.fill)
    return [light, *_cells(opens, msgspec.structs.replace(mark, fill=0.0), content.frame)]


def _touched(content: Content, mark: Mark) -> list[Primitive]:
    solid = content.world.walls | content.changes.closes
    robots = [content.robot(number) for number in range(len(content.trails))]
    return touched_parts(content.trails, solid, robots, content.frame)


def _cut(content: Content, mark: Mark) -> list[Primitive]:
    proof = content.world.certificate
    if not content.view.witness or not isinstance(proof, Cut) or not len(proof.cells):
        return []
    return cut_chain(proof, content.frame, mark)


def _cut_poses(content: Content, mark: Mark) -> list[Primitive]:
    proof = content.world.certificate
    if not content.view.witness or not isinstance(proof, Cut) or proof.boxes is None:
        return []
    shares = blocked_share(content.world, proof.boxes)
    colour = hue(mark.colour)
    some = (shares > 0.0) & (shares < 1.0)
    stripes = mark.size * content.frame.unit
    return [
        DrawnCells(some, colour, opacity=0.35 * mark.fill),
        DrawnCells(shares >= 1.0, colour, opacity=mark.fill),
        DrawnCells(shares >= 1.0, colour, opacity=mark.opacity, hatch=stripes),
    ]


def _witness(content: Content, mark: Mark) -> list[Primitive]:
    proof = content.world.certificate
    if not content.view.witness or not isinstance(proof, Witness | JointWitness):
        return []
    paths = proof.paths if isinstance(proof, JointWitness) else (proof,)
    world = content.world
    parts: list[Primitive] = []
    for number, (robot, path) in enumerate(zip(world.robots, paths, strict=False)):
        colour = content.colour("start", number)
        parts += witness_parts(world, robot, path, content.frame, colour)
    return parts


def _of_robots(
    draw: Callable[[Robot, Frame, str], Iterable[Primitive]], name: str
) -> Callable[[Content, Mark], list[Primitive]]:
    """Return a function that draws something of each robot in its colour."""

    def drawn(content: Content, mark: Mark) -> list[Primitive]:
        return [
            part
            for number, robot in enumerate(content.world.robots)
            for part in draw(robot, content.frame, content.colour(name, number))
        ]

    return drawn


def _of_trails(
    draw: Callable[[Trail, Frame, Robot, str], Iterable[Primitive]], name: str = "loop"
) -> Callable[[Content, Mark], list[Primitive]]:
    """Return a function that draws something of each trail in its robot's colour."""

    def drawn(content: Content, mark: Mark) -> list[Primitive]:
        return [
            part
            for number, trail in enumerate(content.trails)
            for part in draw(
                trail, content.frame, content.robot(number), content.colour(name, number)
            )
        ]

    return drawn


def _start(content: Content, mark: Mark) -> list[Primitive]:
    # A picture of a run shows the robot itself elsewhere.
    return [] if content.trails else _of_robots(start_parts, "start")(content, mark)


def _began(content: Content, mark: Mark) -> list[Primitive]:
    return _of_robots(start_dot, "start")(content, mark) if content.trails else []


def _heading(content: Content, mark: Mark) -> list[Primitive]:
    return [] if content.trails else _of_robots(start_heading, "start")(content, mark)


def _end(content: Content, mark: Mark) -> list[Primitive]:
    # What is repeated has no end; where several robots are at last shows how they stand.
    return [
        part
        for number, trail in enumerate(content.trails)
        if content.has_several or content.shortfall is None
        for part in robot_at(
            trail,
            len(trail.x) - 1,
            content.frame,
            content.robot(number),
            content.colour("end", number),
            "end",
        )
    ]


def _nearest(content: Content, mark: Mark) -> list[Primitive]:
    trail, short = content.trail, content.shortfall
    if trail is None or short is None:
        return []
    return robot_at(trail, short.row, content.frame, content.robot(0), hue(mark.colour), "nearest")


def _pierced(content: Content, mark: Mark) -> list[Primitive]:
    shape = content.world.walls.shape
    return [
        part
        for trail in content.trails
        for part in pierced_parts(trail.pierced, shape, content.frame)
    ]


def _breach(content: Content, mark: Mark) -> list[Primitive]:
    return [
        part for trail in content.trails for part in breach_crosses(trail.pierced, content.frame)
    ]


def _pushed(content: Content, mark: Mark) -> list[Primitive]:
    cell = content.world.cell_size
    return [
        part
        for trail in content.trails
        for part in above_the_trail(trail.disturbances, content.frame, cell)
    ]


def _memory(content: Content, mark: Mark) -> list[Primitive]:
    return lines_of_memory(content.trail.memory, content.frame) if content.trail else []


def _plan(content: Content, mark: Mark) -> list[Primitive]:
    return plan_of_memory(content.trail.memory, content.frame) if content.trail else []


def _blocked(content: Content, mark: Mark) -> list[Primitive]:
    trails = content.trails
    return [
        part
        for number, trail in enumerate(trails)
        for other in trail.blocked_by
        if 0 < other <= len(trails)
        for part in blocked_parts(content.robot(number), trail, trails[other - 1], content.frame)
    ]


def _numbers(content: Content, mark: Mark) -> list[Primitive]:
    # A small picture of a world without a run shows its walls.
    if content.view.is_card and not content.trails:
        return []
    if not content.has_several:
        return []
    parts: list[Primitive] = []
    for number, robot in enumerate(content.world.robots if content.world.is_fleet else ()):
        parts += target_number(robot, number, content.frame)
        if not content.trails:
            parts += start_number(robot, number, content.frame)
    for number, trail in enumerate(content.trails):
        parts += end_number(trail, number, content.frame)
    return parts


def _named(content: Content, mark: Mark) -> list[Primitive]:
    return named_parts(content.named, content.frame) if content.named else []


_DRAWN: Mapping[str, Callable[[Content, Mark], list[Primitive]]] = {
    "floor": _floor,
    "signal": _signal,
    "drift": _drift,
    "missed": _missed,
    "remembered": _remembered,
    "wall": _walls,
    "burns": _burns,
    "closes": _closes,
    "opens": _opens,
    "touched": _touched,
    "cut": _cut,
    "cut-poses": _cut_poses,
    "band": _of_trails(band_parts),
    "start": _start,
    "began": _began,
    "end": _end,
    "nearest": _nearest,
    "witness": _witness,
    "trail": _of_trails(run_parts),
    "approach": _of_trails(approach_parts),
    "body": _of_trails(body_parts),
    "loop": _of_trails(loop_parts),
    "stay": _of_trails(stay_parts),
    "heading": _heading,
    "pushed": _pushed,
    "memory": _memory,
    "plan": _plan,
    "pierced": _pierced,
    "overlap": _of_trails(overlap_parts),
    "breach": _breach,
    "barred": barred_parts,
    "short": distance_parts,
    "since": change_labels,
    "target": _of_robots(target_parts, "target"),
    "waypoint": _of_robots(waypoint_parts, "target"),
    "blocked": _blocked,
    "number": _numbers,
    "named": _named,
}
"""Draws a mark, by its name in ``marks.json``, which has their order."""
