"""GESTALT in plain Python: a grid of goodness around the robot, arcs scored by it, the best one
driven.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from tests.reference.sim import layout
from tests.reference.sim.controllers._directions import (
    WHOLE_TURN,
    bearing_of,
    distance,
    steer,
    wrap,
)
from tests.reference.sim.fdlibm import cos, sin

Floats = npt.NDArray[np.float64]

# Memory: cells along a side of the window and a cell's side, m; the window's lowest column and row;
# the arc's direction, curvature and remaining length, m; then twelve degrees of 4 bits in each
# number.
SIDE, PITCH, WINDOW_X, WINDOW_Y, HEADING, BEND, LEFT, CELLS = range(8)

_A_WORD = 12
_BEST, _BAD, _UNKNOWN, _FIRST, _HIT, _PASS, _HEADINGS = 15, 4, 6, 8, 8, 1, 16
_ARC, _CELL, _FOOT, _BEND = 5.0, 0.5, 0.75, 0.78539816339744830962
_TO_GOOD, _TO_TARGET = 1.0, 0.4


class _Grid:
    """The window in a memory: the degree of each cell, by its column and row in the world."""

    def __init__(self, memory: Floats) -> None:
        self.memory = memory
        self.side = int(memory[SIDE])

    def has(self, column: int, row: int) -> bool:
        low_x, low_y = int(self.memory[WINDOW_X]), int(self.memory[WINDOW_Y])
        return low_x <= column < low_x + self.side and low_y <= row < low_y + self.side

    def _bits(self, column: int, row: int) -> tuple[int, int]:
        number = row % self.side * self.side + column % self.side
        return CELLS + number // _A_WORD, 4 * (number % _A_WORD)

    def degree(self, column: int, row: int) -> int:
        at, shift = self._bits(column, row)
        return (int(self.memory[at]) >> shift) & 15

    def put(self, column: int, row: int, degree: int) -> None:
        at, shift = self._bits(column, row)
        self.memory[at] = float((int(self.memory[at]) & ~(15 << shift)) | (degree << shift))

    def judge(self, x: float, y: float, change: int) -> None:
        column, row = math.floor(x / self.memory[PITCH]), math.floor(y / self.memory[PITCH])
        if self.has(column, row):
            degree = (self.degree(column, row) or _FIRST) + change
            self.put(column, row, min(max(degree, 1), _BEST))

    def move(self, axis: int, low: int) -> None:
        at = WINDOW_X + axis
        before = int(self.memory[at])
        lines = range(low, before) if low < before else range(before, low)
        # Beyond the window's size, the lines repeat.
        for line in list(lines)[-self.side :]:
            for k in range(self.side):
                self.put(*((line, k) if axis == 0 else (k, line)), 0)
        self.memory[at] = float(low)

    def degree_under(self, x: float, y: float, reach: float) -> int:
        pitch = self.memory[PITCH]
        least = _BEST
        for row in range(math.floor((y - reach) / pitch), math.floor((y + reach) / pitch) + 1):
            for column in range(
                math.floor((x - reach) / pitch), math.floor((x + reach) / pitch) + 1
            ):
                near = distance(x, y, (column + 0.5) * pitch, (row + 0.5) * pitch) < reach
                if near and self.has(column, row):
                    least = min(least, self.degree(column, row) or _UNKNOWN)
        return least


def _move_window(seen: Floats, memory: Floats, grid: _Grid) -> None:
    begins = memory[PITCH] == 0.0
    if begins:
        memory[PITCH] = _CELL * seen[layout.OBS_RADIUS]
    for axis, at in enumerate((layout.OBS_X, layout.OBS_Y)):
        low = math.floor(seen[at] / memory[PITCH]) - grid.side // 2
        if begins:
            memory[WINDOW_X + axis] = float(low)
        grid.move(axis, low)


def _look(seen: Floats, memory: Floats, grid: _Grid) -> None:
    x, y = seen[layout.OBS_X], seen[layout.OBS_Y]
    window = 0.5 * memory[SIDE] * memory[PITCH]
    beams = seen.size - layout.OBS_SIZE
    for beam in range(beams):
        angle = seen[layout.OBS_HEADING] + bearing_of(beam, beams)
        along_x, along_y = cos(angle), sin(angle)
        ends = seen[layout.OBS_SIZE + beam]
        at = 0.0
        while at < min(ends - memory[PITCH], window):
            grid.judge(x + at * along_x, y + at * along_y, _PASS)
            at += memory[PITCH]
        if ends < window:
            grid.judge(x + ends * along_x, y + ends * along_y, -_HIT)


def _score(
    seen: Floats, memory: Floats, grid: _Grid, heading: float, bend: float, length: float
) -> tuple[float, float]:
    """Return how good an arc is, and how much of it is usable: up to the first bad cell."""
    x, y = seen[layout.OBS_X], seen[layout.OBS_Y]
    far, towards = seen[layout.OBS_TARGET_DISTANCE], seen[layout.OBS_TARGET_HEADING]
    target_x, target_y = x + far * cos(towards), y + far * sin(towards)
    radius = seen[layout.OBS_RADIUS]
    driven = total = 0.0
    while driven < length:
        piece = min(memory[PITCH], length - driven)
        next_x, next_y = x + piece * cos(heading), y + piece * sin(heading)
        degree = grid.degree_under(next_x, next_y, _FOOT * radius)
        if degree <= _BAD:
            break
        x, y = next_x, next_y
        heading += bend * piece
        driven += piece
        total += piece * float(degree)
    if driven < memory[PITCH] and driven < length:
        return -math.inf, length
    whole = _ARC * radius
    progress = far - distance(x, y, target_x, target_y)
    return _TO_GOOD * total / float(_BEST) / whole + _TO_TARGET * progress / whole, driven


def _choose(seen: Floats, memory: Floats, grid: _Grid) -> None:
    whole = _ARC * seen[layout.OBS_RADIUS]
    best = -math.inf
    headings = [wrap(WHOLE_TURN * k / _HEADINGS) for k in range(_HEADINGS)]
    for heading in (seen[layout.OBS_TARGET_HEADING], *headings):
        for turn in (0.0, _BEND, -_BEND):
            length = min(whole, seen[layout.OBS_TARGET_DISTANCE])
            bend = turn / whole
            found, length = _score(seen, memory, grid, heading, bend, length)
            if found > best:
                best = found
                memory[HEADING], memory[BEND], memory[LEFT] = heading, bend, length
    if best == -math.inf:
        memory[CELLS:] = 0.0
        memory[HEADING] = wrap(memory[HEADING] + WHOLE_TURN / _HEADINGS)
        memory[BEND], memory[LEFT] = 0.0, memory[PITCH]


def act(seen: Floats, memory: Floats, command: Floats) -> None:
    """One step: looks and chooses an arc if the last has ended, and drives the next piece of it."""
    grid = _Grid(memory)
    _move_window(seen, memory, grid)
    touches = seen[layout.OBS_BUMP] != 0.0
    if touches or memory[LEFT] <= 0.0:
        _look(seen, memory, grid)
        if touches:
            angle = seen[layout.OBS_HEADING] + seen[layout.OBS_BUMP_BEARING]
            at = _FOOT * seen[layout.OBS_RADIUS]
            x, y = seen[layout.OBS_X] + at * cos(angle), seen[layout.OBS_Y] + at * sin(angle)
            grid.judge(x, y, -_BEST)
        _choose(seen, memory, grid)
    step = seen[layout.OBS_TIME_STEP]
    length = min(seen[layout.OBS_TOP_SPEED] * step, memory[LEFT])
    steer(seen, command, wrap(memory[HEADING] - seen[layout.OBS_HEADING]), length / step)
    memory[HEADING] = wrap(memory[HEADING] + memory[BEND] * length)
    memory[LEFT] -= length
