"""Say next to cells that change what they become, and when."""

from __future__ import annotations

import math

import numpy as np

from worldgen.render.content import Content
from worldgen.render.lettering import two_digits
from worldgen.render.marks import Mark, hue
from worldgen.render.placed_words import placed_words, size_of_words
from worldgen.render.primitives import Primitive
from worldgen.timeline import CellState

# Labels of a picture. Fires change hundreds of cells, and the first one says enough.
_MOST = 3
# Cells between two labelled ones.
_APART = 3
_WORDS = {CellState.SOLID: "wall", CellState.BURNING: "fire", CellState.FREE: "free"}


def change_labels(content: Content, mark: Mark) -> list[Primitive]:
    """Return what the cells that change first become, and when, next to each: ``wall at 1.2 s``."""
    changes = content.changes
    marked = {
        CellState.SOLID: changes.closes,
        CellState.BURNING: changes.burns,
        CellState.FREE: changes.opens,
    }
    frame = content.frame
    window = frame.window
    away = 3.0 * frame.unit
    parts: list[Primitive] = []
    labelled: list[tuple[int, int]] = []
    columns = (column.tolist() for column in content.world.timeline.columns)
    for time, ix, iy, state in zip(*columns, strict=True):
        if len(labelled) == _MOST:
            break
        if not marked[CellState(state)][iy, ix]:
            continue
        if any(max(abs(ix - x), abs(iy - y)) < _APART for x, y in labelled):
            continue
        if not (0 <= ix - window.x < window.width and 0 <= iy - window.y < window.height):
            continue
        labelled.append((ix, iy))
        words = f"{_WORDS[CellState(state)]} at {_rounded(time)} s"
        width, height = size_of_words(words, frame.unit)
        (left, bottom), (right, top) = frame.corners(
            np.array(((ix, iy), (ix + 1, iy + 1)))
        ).tolist()
        middle = 0.5 * (left + right), 0.5 * (top + bottom)
        across = middle[0] - 0.5 * width
        down = middle[1] - 0.5 * height
        left, right = left - away - width, right + away
        top, bottom = top - away - height, bottom + away
        sides = ((right, down), (left, down), (across, top), (across, bottom))
        corners = ((right, top), (right, bottom), (left, top), (left, bottom))
        parts += placed_words(
            content,
            words,
            [np.array(place) for place in sides],
            hue(mark.colour),
            further=[np.array(place) for place in corners],
            shunned=middle,
        )
    return parts


def _rounded(seconds: float) -> str:
    """Return a time with two digits, or in whole seconds if it is longer."""
    return two_digits(seconds) if seconds < 100.0 else str(math.floor(seconds + 0.5))
