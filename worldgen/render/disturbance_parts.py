"""Draw what disturbs a robot besides walls, on the map and in its key: pushes, drift, decoys.

Cells that a coverage task missed are drawn too.
"""

from __future__ import annotations

import math

import numpy as np

from worldgen.render.frame import Frame
from worldgen.render.marks import MARKS, hue, mix
from worldgen.render.overlay import Disturbances, Shove
from worldgen.render.primitives import DrawnCells, DrawnCircle, DrawnLine, Paint, Primitive
from worldgen.render.trail_parts import arrow, arrow_head
from worldgen.support.arrays import Bools

# Arrows of a drift along the longer side of the map.
_DRIFT_ARROWS = 6


def under_the_walls(disturbances: Disturbances, frame: Frame) -> list[Primitive]:
    """Draw a field of faint arrows where the floor carries the robot, hidden by walls."""
    if disturbances.drift_heading is None:
        return []
    pitch = max(frame.width, frame.height) / _DRIFT_ARROWS
    # The picture's y axis points down.
    along = np.array((math.cos(disturbances.drift_heading), -math.sin(disturbances.drift_heading)))
    paint = MARKS["drift"].line(frame.unit)
    parts: list[Primitive] = []
    for row in range(math.ceil(frame.height / pitch)):
        for column in range(math.ceil(frame.width / pitch)):
            middle = np.array((frame.left, frame.top)) + pitch * np.array((column + 0.5, row + 0.5))
            # The last row and column may be cut off by the border.
            if middle[0] > frame.left + frame.width or middle[1] > frame.top + frame.height:
                continue
            ends = np.array((middle - 0.22 * pitch * along, middle + 0.22 * pitch * along))
            parts.append(DrawnLine(ends, paint))
            angle = math.atan2(along[1], along[0])
            mark = MARKS["drift"]
            x, y = ends[1].tolist()
            tint = mix(hue("floor"), hue(mark.colour), mark.opacity)
            parts.append(arrow_head(x, y, angle, mark.size * frame.unit, tint))
    return parts


def missed_cells(missed: Bools | None, frame: Frame) -> list[Primitive]:
    """Draw stripes over the cells that the robot should have visited but did not."""
    if missed is None or not missed.any():
        return []
    mark = MARKS["missed"]
    stripes = 7.0 * frame.unit if frame.cell >= 4.0 * frame.unit else 0.0
    parts: list[Primitive] = [DrawnCells(missed, hue("missed"), opacity=mark.fill)]
    if stripes:
        parts.append(DrawnCells(missed, hue("missed"), opacity=mark.opacity, hatch=stripes))
    return parts


def above_the_trail(disturbances: Disturbances, frame: Frame, cell_size: float) -> list[Primitive]:
    """Draw places that push, with their arrows; pushes where they happened; and decoys.

    Args:
        disturbances: What to draw.
        frame: The map's place in the picture.
        cell_size: m.
    """
    parts: list[Primitive] = []
    for place in disturbances.places:
        parts += _place(place, frame, cell_size)
    for push in disturbances.pushes:
        start, end = frame.points(
            np.array(((push.x, push.y), (push.x + push.dx, push.y + push.dy)))
        ).tolist()
        parts += push_arrow((start[0], start[1]), (end[0], end[1]), frame.unit)
    for x, y in disturbances.decoys:
        parts += decoy_mark(*frame.to_pixels(x, y), frame.unit)
    return parts


def _place(place: Shove, frame: Frame, cell_size: float) -> list[Primitive]:
    """Draw the cell's frame, and an arrow from its middle in the direction of the push."""
    left = math.floor(place.x / cell_size + 1e-9) * cell_size
    low = math.floor(place.y / cell_size + 1e-9) * cell_size
    corners = np.array(((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))) * cell_size
    outline = frame.points(corners + np.array((left, low)))
    middle = frame.to_pixels(left + 0.5 * cell_size, low + 0.5 * cell_size)
    parts: list[Primitive] = [
        DrawnLine(outline, MARKS["pushes"].inside(), closed=True),
        DrawnLine(outline, MARKS["pushes"].line(frame.unit), closed=True),
    ]
    length = math.hypot(place.dx, place.dy)
    if length == 0.0:
        return parts
    # Short pushes get an arrow that is long enough to be visible.
    reach = max(length * frame.scale, 14.0 * frame.unit)
    tip = (middle[0] + reach * place.dx / length, middle[1] - reach * place.dy / length)
    return parts + push_arrow(middle, tip, frame.unit)


def push_arrow(
    start: tuple[float, float], end: tuple[float, float], unit: float
) -> list[Primitive]:
    """Draw an arrow in the colour of pushes, or a dot if a push only turns the robot."""
    if math.dist(start, end) < 1.0:
        return [DrawnCircle(*start, 8.0 * unit, MARKS["pushed"].line(unit))]
    return arrow(start, end, unit, "pushed")


def decoy_mark(x: float, y: float, unit: float) -> list[Primitive]:
    """Draw a dashed ring in the target's colour, without the cross that marks the target."""
    mark = MARKS["decoy"]
    return [
        DrawnCircle(x, y, mark.size * unit, Paint(fill=hue("floor"), opacity=0.75)),
        DrawnCircle(x, y, mark.size * unit, mark.line(unit)),
        DrawnCircle(x, y, 0.3 * mark.size * unit, Paint(fill=hue(mark.colour))),
    ]
