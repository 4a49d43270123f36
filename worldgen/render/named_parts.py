"""Mark the cells that the text next to a picture names, and number the columns and rows."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from worldgen.render.content import Content
from worldgen.render.frame import Frame
from worldgen.render.marks import MARKS, hue
from worldgen.render.overlay import Trail
from worldgen.render.primitives import DrawnLine, Paint, Primitive, Text

_SIZE = 9.0  # of the numbers, units
_DIGIT = 0.58  # width of a digit divided by its size
# Half the diagonal of a mark: a part of a cell, within limits in units.
_PART = 0.3
_LEAST = 5.0
_MOST = 20.0


def named_cells(trails: Iterable[Trail]) -> tuple[tuple[int, int], ...]:
    """Return the cells that the text about some trails names, each once."""
    return tuple(dict.fromkeys(cell for trail in trails for cell in trail.named))


def named_parts(cells: Sequence[tuple[int, int]], frame: Frame) -> list[Primitive]:
    """Return a mark for each named cell."""
    reach = min(max(_PART * frame.cell, _LEAST * frame.unit), _MOST * frame.unit)
    places = frame.corners(np.array(cells, np.float64).reshape(-1, 2) + 0.5)
    return [part for x, y in places for part in named_mark(x, y, reach, frame.unit)]


def named_mark(x: float, y: float, reach: float, unit: float) -> list[Primitive]:
    """Return the mark of a named cell, a diamond.

    It is hollow, so that the state of the cell stays visible, and has a dark edge against the floor.
    """
    corners = np.array(((0.0, -1.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0)))
    diamond = np.array((x, y)) + reach * corners
    mark = MARKS["named"]
    edge = Paint(stroke=hue("named-edge"), width=mark.casing * unit)
    return [DrawnLine(diamond, stroke, closed=True) for stroke in (edge, mark.line(unit))]


def axis_numbers(content: Content) -> list[Primitive]:
    """Return the numbers of columns, above the map, and of rows, to its left."""
    frame = content.frame
    size = _SIZE * frame.unit
    columns = content.world.width
    rows = content.world.height
    digits = len(str(max(columns, rows) - 1))
    step = _step((digits * _DIGIT + 0.6) * size / frame.cell)
    gap = frame.band + 3.0 * frame.unit
    parts: list[Primitive] = []
    for column in range(0, columns, step):
        text = str(column)
        x = frame.left + (column + 0.5) * frame.cell - 0.5 * _DIGIT * size * len(text)
        parts.append(Text(x, frame.top - gap, size, text, hue("quiet")))
    for row in range(0, rows, step):
        text = str(row)
        x = frame.left - gap - _DIGIT * size * len(text)
        y = frame.bottom - (row + 0.5) * frame.cell + 0.36 * size
        parts.append(Text(x, y, size, text, hue("quiet")))
    return parts


def _step(least: float) -> int:
    """Return the smallest of 1, 2, 5, 10, 20 ... that is not below a number of cells."""
    power = int(10 ** max(0, math.floor(math.log10(max(least, 1.0)))))
    return next(step for k in (1, 2, 5, 10) if (step := k * power) >= least)
