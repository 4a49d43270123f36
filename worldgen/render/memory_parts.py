"""Draw what a robot remembers after a run: tinted floor below the path, lines above it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from worldgen.render.frame import Frame
from worldgen.render.marks import MARKS, hue
from worldgen.render.overlay import Remembered
from worldgen.render.primitives import DrawnCircle, DrawnLine, Paint, Primitive, Text
from worldgen.support.arrays import Floats

# More shapes than this are left out: they would only make a file large.
_MOST_SHAPES = 20_000


def floor_of_memory(memory: Remembered | None, frame: Frame) -> list[Primitive]:
    """Return the rectangles that a robot remembers, tinted by their strength."""
    if memory is None:
        return []
    parts: list[Primitive] = []
    for x0, y0, x1, y1, strength in memory.fills[:_MOST_SHAPES].tolist():
        corners = np.array(((x0, y0), (x1, y0), (x1, y1), (x0, y1)))
        paint = Paint(
            fill=hue("memory"), opacity=MARKS["remembered"].fill * min(max(strength, 0.0), 1.0)
        )
        parts.append(DrawnLine(frame.points(corners), paint, closed=True))
    return parts


def lines_of_memory(memory: Remembered | None, frame: Frame) -> list[Primitive]:
    """Return the lines and the places that a robot remembers."""
    if memory is None:
        return []
    unit = frame.unit
    # A grid of blocked lines is dense, so it must not hide the path below it.
    mark = MARKS["memory"]
    edge = mark.line(unit)
    faint = replace(edge, width=0.6 * edge.width, opacity=0.45)
    parts: list[Primitive] = [
        DrawnLine(frame.points(ends.reshape(2, 2)), paint)
        for lines, paint in ((memory.blocked, faint), (memory.edges, edge))
        for ends in lines[:_MOST_SHAPES]
    ]
    for x, y in _drawn(memory.nodes, frame):
        parts.append(DrawnCircle(x, y, (mark.size + 1.0) * unit, Paint(fill=hue("floor"))))
        parts.append(DrawnCircle(x, y, mark.size * unit, Paint(fill=hue(mark.colour))))
    for name, place in memory.places.items():
        x, y = frame.to_pixels(*place)
        parts.append(DrawnCircle(x, y, 5.0 * unit, Paint(stroke=hue("memory"), width=2.2 * unit)))
        parts.append(Text(x + 8.0 * unit, y + 4.0 * unit, 11.0 * unit, name, hue("memory")))
    return parts


def plan_of_memory(memory: Remembered | None, frame: Frame) -> list[Primitive]:
    """Return the path that a robot was about to drive."""
    if memory is None or len(memory.plan) < 2:
        return []
    return [DrawnLine(frame.points(memory.plan), MARKS["plan"].line(frame.unit))]


def _drawn(points: Floats, frame: Frame) -> list[list[float]]:
    return frame.points(points[:_MOST_SHAPES]).tolist() if len(points) else []
