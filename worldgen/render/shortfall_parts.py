"""Draw how near a robot that repeats itself gets to its target, and which wall is in between."""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np

from worldgen.render.content import Content
from worldgen.render.lettering import length_words
from worldgen.render.marks import MARKS, Mark, hue
from worldgen.render.placed_words import placed_words, size_of_words
from worldgen.render.primitives import DrawnLine, Paint, Primitive
from worldgen.render.trail_parts import arrow_head
from worldgen.support.arrays import Floats

Place: TypeAlias = Floats | tuple[float, float]


def barred_parts(content: Content, mark: Mark) -> list[Primitive]:
    """Return an arrow to the wall that stops the robot on the straight line to its target."""
    short = content.shortfall
    if short is None or short.contact is None:
        return []
    start, end, contact = content.frame.points(np.array((short.place, short.end, short.contact)))
    # The bar is on the wall's side that the robot's rim would touch.
    x, y = contact - end if (contact != end).any() else short.ahead * (1.0, -1.0)
    return barred_arrow(start, contact, np.array((y, -x)), content.frame.unit)


def barred_arrow(start: Place, tip: Place, along: Place, unit: float) -> list[Primitive]:
    """Return an arrow whose tip is in the middle of a bar.

    Args:
        start: px.
        tip: px.
        along: Direction of the bar, of any length.
        unit: Pixels of a unit.
    """
    mark = MARKS["barred"]
    colour = hue(mark.colour)
    line = np.array((start, tip), np.float64)
    angle = math.atan2(*(line[1] - line[0])[::-1])
    bar = line[1] + 1.5 * mark.size * unit / math.hypot(*along) * np.outer((-1.0, 1.0), along)
    thick = 1.8 * mark.width * unit
    # The head ends in the bar, and leaves some of a short line.
    size = min(2.0 * mark.size * unit, 0.7 * math.dist(start, tip))
    x, y = line[1] - 0.6 * size * np.array((math.cos(angle), math.sin(angle)))
    return [
        *(DrawnLine(line, paint) for paint in mark.lines(unit)),
        DrawnLine(bar, Paint(stroke=hue("floor"), width=thick + 3.0 * unit, opacity=0.8)),
        arrow_head(float(x), float(y), angle, size, colour, casing=unit),
        DrawnLine(bar, Paint(stroke=colour, width=thick)),
    ]


def distance_parts(content: Content, mark: Mark) -> list[Primitive]:
    """Return a line to the target with a bar at either end, and its length, if nothing is between."""
    short = content.shortfall
    if short is None or short.contact is not None:
        return []
    start, end = content.frame.points(np.array((short.place, short.end)))
    unit = content.frame.unit
    along = (end - start) / max(float(np.hypot(*(end - start))), 1e-9)
    across = np.array((along[1], -along[0]))
    bars = [at + mark.size * unit * np.outer((-1.0, 1.0), across) for at in (start, end)]
    lines = [np.array((start, end)), *bars]
    parts = [DrawnLine(line, paint) for paint in mark.lines(unit) for line in lines]
    # The words are next to the middle of the line, above it or on its right.
    words = length_words(short.distance)
    size = np.array(size_of_words(words, unit))
    if (across[0], -across[1]) < (-across[0], across[1]):
        across = -across
    away = 6.0 * unit + 0.5 * float(size @ np.abs(across))
    places = [0.5 * (start + end) + side * away * across - 0.5 * size for side in (1.0, -1.0)]
    # If it would hide one of them, the words are next to the robot and the target.
    robot = content.robot(0)
    radius = max(robot.radius, robot.target.radius) * content.frame.scale
    aside = max(radius, (MARKS["target"].size + 5.0) * unit)
    low = np.minimum(start, end) - aside - size
    beyond = np.maximum(start, end) + aside
    middle = 0.5 * (start + end - size)
    around = [np.array((x, middle[1])) for x in (low[0], beyond[0])]
    around += [np.array((middle[0], y)) for y in (low[1], beyond[1])]
    return [*parts, *placed_words(content, words, places, hue(mark.colour), further=around)]
