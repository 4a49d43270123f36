"""The part of a world that a small picture shows: all of it, or what happens at a visible size."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from worldgen.render.frame import Window
from worldgen.render.marks import SPECIFICATION
from worldgen.render.overlay import Trail
from worldgen.render.polyline import arc_length
from worldgen.support.arrays import Floats
from worldgen.world import World

# Radii of the robot: the last part of a path without a period that is part of the event.
_LAST = 12.0


def event_window(world: World, trails: Sequence[Trail], pixels: float) -> Window:
    """Return the cells to show in a small picture, as the pages' ``view.js`` does.

    Args:
        world: The world.
        trails: What its robots did; empty for the whole world.
        pixels: Longer side of the map, px.
    """
    card = SPECIFICATION.card
    longest = max(world.width, world.height)
    radius = max(robot.radius for robot in world.robots) / world.cell_size
    # The side of the view, in cells, in which the robot has its least visible size.
    visible = 2.0 * radius * pixels / card.robot
    whole = Window(0, 0, world.width, world.height)
    if not trails:
        return whole
    points = np.concatenate([_event(trail, world) for trail in _in_the_event(trails)])
    low = points.min(axis=0) - card.around * radius
    high = points.max(axis=0) + card.around * radius
    # With the target, unless the robot would be too small to see.
    has_target = False
    if not world.is_fleet:
        target = world.target
        middle = np.array((target.x, target.y)) / world.cell_size
        room = target.radius / world.cell_size + 1.0
        lower = np.minimum(low, middle - room)
        upper = np.maximum(high, middle + room)
        has_target = float(max(upper - lower)) <= min(visible, longest)
        if has_target:
            low, high = lower, upper
    needed = float(max(high - low))
    # Where everything is visible, only what is small enough is worth losing sight of the rest.
    if longest <= visible and not (has_target and needed <= card.small * longest):
        return whole
    side = math.ceil(needed)
    sizes = [min(side, world.width), min(side, world.height)]
    middle = 0.5 * (low + high)
    # Within the world, so that no space is lost on what is outside.
    x, y = (
        min(max(0, math.floor(middle[axis] - 0.5 * size)), cells - size)
        for axis, (size, cells) in enumerate(zip(sizes, (world.width, world.height), strict=True))
    )
    return Window(x, y, *sizes)


def _in_the_event(trails: Sequence[Trail]) -> Sequence[Trail]:
    """Return the trails of the robots that block each other, or of all."""
    named = {other - 1 for trail in trails for other in trail.blocked_by}
    found = [trail for number, trail in enumerate(trails) if trail.blocked_by or number in named]
    return found or trails


def _event(trail: Trail, world: World) -> Floats:
    """Return the places, in cells, at which something happens: the period, or the last part."""
    points = trail.points if trail.repeats_from is None else trail.loop
    if trail.repeats_from is None:
        lengths = arc_length(points)
        radius = max(robot.radius for robot in world.robots)
        points = points[lengths >= lengths[-1] - _LAST * radius]
    cells: Floats = points / world.cell_size
    return cells
