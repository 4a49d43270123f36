"""Draw how near a robot that repeats itself gets to its target, and which wall is in between."""

from __future__ import annotations

import math

import numpy as np

from worldgen.render.content import Content
from worldgen.render.lettering import length_words
from worldgen.render.marks import MARKS, Mark, hue
from worldgen.render.placed_words import placed_words, size_of_words
from worldgen.render.primitives import DrawnLine, Paint, Primitive
from worldgen.render.trail_parts import arrow_head
from worldgen.support.arrays import Floats


def shortfall_parts(content: Content, mark: Mark) -> list[Primitive]:
    """Return an arrow up to the wall in between with a bar at that wall, or the distance in words."""
    shortfall = content.shortfall
    if shortfall is None:
        return []
    frame = content.frame
    start, end = frame.points(np.array((shortfall.place, shortfall.end)))
    if shortfall.contact is None:
        return _distance(content, start, end, shortfall.distance)
    unit = frame.unit
    robot = content.robot(0)
    reach = (robot.radius if robot.is_disc else robot.inner_radius) * frame.scale
    # The picture's y axis points down.
    ahead = shortfall.ahead * (1.0, -1.0)
    contact = frame.points(shortfall.contact[None])[0]
    tip = end + reach * ahead
    # The bar is on the wall's side that the robot's rim would touch.
    across = contact - end
    length = float(np.hypot(*across))
    across = (
        np.array((ahead[1], -ahead[0])) if length == 0.0 else across[::-1] * (1.0, -1.0) / length
    )
    bar = contact + 1.5 * mark.size * unit * np.outer((-1.0, 1.0), across)
    x, y = tip.tolist()
    angle = math.atan2(ahead[1], ahead[0])
    head = arrow_head(x, y, angle, 2.0 * mark.size * unit, hue(mark.colour), casing=unit)
    thick = Paint(stroke=hue(mark.colour), width=1.8 * mark.width * unit)
    casing = Paint(stroke=hue("floor"), width=1.8 * mark.width * unit + 3.0 * unit, opacity=0.8)
    return [
        *(DrawnLine(np.array((start, tip)), paint) for paint in mark.lines(unit)),
        DrawnLine(bar, casing),
        DrawnLine(bar, thick),
        head,
    ]


def _distance(content: Content, start: Floats, end: Floats, metres: float) -> list[Primitive]:
    """Return a line with a bar at either end, and its length."""
    mark = MARKS["short"]
    unit = content.frame.unit
    along = (end - start) / max(float(np.hypot(*(end - start))), 1e-9)
    across = np.array((along[1], -along[0]))
    bars = [at + mark.size * unit * np.outer((-1.0, 1.0), across) for at in (start, end)]
    lines = [np.array((start, end)), *bars]
    parts = [DrawnLine(line, paint) for paint in mark.lines(unit) for line in lines]
    # The words are next to the middle of the line, above it or on its right.
    words = length_words(metres)
    size = np.array(size_of_words(words, unit))
    if (across[0], -across[1]) < (-across[0], across[1]):
        across = -across
    away = 6.0 * unit + 0.5 * float(size @ np.abs(across))
    places = [0.5 * (start + end) + side * away * across - 0.5 * size for side in (1.0, -1.0)]
    return [*parts, *placed_words(content, words, places, hue(mark.colour))]
