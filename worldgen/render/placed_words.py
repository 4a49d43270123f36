"""Words in a picture, at the place where they hide the least, as in the pages' ``placed_words.js``."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from worldgen.render.content import Content
from worldgen.render.lettering import text_width
from worldgen.render.marks import MARKS, hue
from worldgen.render.primitives import DrawnLine, Paint, Primitive, Text
from worldgen.support.arrays import Bools, Floats

# Points of a path that are looked at.
_ROWS = 600
# Places across some words at which walls are looked for.
_SAMPLES = 5
# Share of the words' size by which they may be moved into the map and still be next to their place.
_ALONG = 0.6
# Cost of words that hide all of the robot, or of the target.
_BODY = 8.0
# Cost of a place that is less clear.
_FURTHER = 2.0
_BOX = np.array(((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)))


def size_of_words(words: str, unit: float) -> tuple[float, float]:
    """Return the width and the height of some words, px."""
    size = MARKS["since"].size * unit
    return text_width(words, size), 1.1 * size


def placed_words(
    content: Content,
    words: str,
    places: Sequence[Floats],
    colour: str,
    *,
    further: Sequence[Floats] = (),
    shunned: tuple[float, float] | None = None,
) -> list[Primitive]:
    """Return words at the place that hides the least: of the robot, its loop, target and walls.

    Args:
        content: The picture's content.
        words: The words.
        places: (2,) px: upper left corners; the first of equally good ones is taken.
        colour: ``#rrggbb``.
        further: The same, less clear: taken if all ``places`` hide more.
        shunned: Middle of a cell that must stay visible, px.
    """
    frame = content.frame
    size = np.array(size_of_words(words, frame.unit))
    low = np.array((frame.left, frame.top))
    beyond = np.array((frame.left + frame.width, frame.bottom)) - size
    best: tuple[float, Floats] | None = None
    for k, place in enumerate((*places, *further)):
        # Move it until the words are in the map.
        moved = np.maximum(low, np.minimum(place, beyond))
        is_far = bool((np.abs(moved - place) > _ALONG * size).any())
        if shunned is not None:
            near = np.abs(np.array(shunned) - moved - 0.5 * size) < 0.5 * size + 0.4 * frame.cell
            cost = 5.0 * bool(near.all())
        else:
            cost = 0.0
        cost += _hidden(content, moved, size) + 3.0 * is_far + 0.5 * bool((moved != place).any())
        cost += _FURTHER * (k >= len(places))
        if best is None or cost < best[0] - 1e-9:
            best = cost, moved
    assert best is not None
    content.words.append((best[1], best[1] + size))
    left, top = best[1].tolist()
    plate = best[1] + np.array((-1.0, 0.0)) + _BOX * (size + np.array((2.0, 0.0)))
    return [
        DrawnLine(plate, Paint(fill=hue("floor"), opacity=0.85), closed=True),
        Text(left, top + 0.8 * float(size[1]), MARKS["since"].size * frame.unit, words, colour),
    ]


def _hidden(content: Content, corner: Floats, size: Floats) -> float:
    """Return how much some words at a place would hide."""
    frame = content.frame

    def is_covered(points: Floats, margin: float = 0.0) -> Bools:
        inside = (points > corner - margin) & (points < corner + size + margin)
        return np.asarray(inside.all(axis=1))

    robot = content.robot(0)
    discs = [(robot.target.x, robot.target.y, robot.target.radius, MARKS["target"].size)]
    if content.trail is not None:
        row = -1 if content.shortfall is None else content.shortfall.row
        discs.append((*content.trail.points[row], robot.radius, MARKS["end"].size))
    cost = 0.0
    for x, y, radius, least in discs:
        reach = max(radius * frame.scale, least * frame.unit)
        middle = np.array(frame.to_pixels(x, y))
        overlap = np.minimum(corner + size, middle + reach) - np.maximum(corner, middle - reach)
        cost += _BODY * float(np.prod(np.maximum(overlap, 0.0))) / (2.0 * reach) ** 2
    cost += sum(
        4.0 for low, high in content.words if (corner < high).all() and (corner + size > low).all()
    )
    for trail in content.trails[:1]:
        path = trail.points[-_ROWS:] if trail.repeats_from is None else trail.loop
        points = frame.points(path[:: max(1, len(path) // _ROWS)])
        hidden = float(is_covered(points, 2.0).mean())
        cost += 2.0 + 4.0 * hidden if hidden else 0.0
        cost += float(is_covered(points, 0.5 * robot.radius * frame.scale).any())
    at = corner + size * np.column_stack(
        ((np.arange(_SAMPLES) + 0.5) / _SAMPLES, np.full(_SAMPLES, 0.5))
    )
    cells = (at - np.array((frame.left, frame.bottom))) * np.array((1.0, -1.0)) / frame.cell
    window = frame.window
    ix, iy = np.floor(cells).astype(int).T + np.array(((window.x,), (window.y,)))
    walls = content.world.walls
    inside = (ix >= 0) & (ix < walls.shape[1]) & (iy >= 0) & (iy < walls.shape[0])
    return cost + 0.5 * float(walls[iy[inside], ix[inside]].sum() + (~inside).sum())
