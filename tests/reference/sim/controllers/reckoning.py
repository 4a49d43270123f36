"""Controllers that estimate where they are, or where the target is, in plain Python.

Memory: whether the position is known; x, y; the target's x, y; the previous odometry (or the place
of a measured distance); that distance; the length at which the signal halves; directions searched.
The memory of the controller that drives follows.

Source: Johann Borenstein, H. R. Everett and Liqiang Feng, "Where am I?" (1996), chapters 1 and 6.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from tests.reference.sim import layout
from tests.reference.sim.controllers import bug2, mapper, three_layer
from tests.reference.sim.controllers._directions import WHOLE_TURN, angle_of, distance, wrap
from tests.reference.sim.fdlibm import cos, sin

Floats = npt.NDArray[np.float64]

KNOWN, X, Y, TARGET_X, TARGET_Y, BEFORE_X, BEFORE_Y, FAR, CELL, SEARCH, TURNED = range(11)
SIZE = 11
# Index in the memory of three-layer.
_LAID, _CORNER_X, _CORNER_Y, _PITCH, _CELL_X, _CELL_Y = 0, 1, 2, 3, 12, 13


def _by_signal(signal: float, cell: float) -> float:
    return cell * math.sqrt(max(0.0, 1.0 / signal - 1.0))


def _show_target(seen: Floats, memory: Floats) -> None:
    dx = memory[TARGET_X] - seen[layout.OBS_X]
    dy = memory[TARGET_Y] - seen[layout.OBS_Y]
    seen[layout.OBS_TARGET_HEADING] = angle_of(dx, dy)
    seen[layout.OBS_TARGET_DISTANCE] = math.sqrt(dx * dx + dy * dy)


def _by_odometry(seen: Floats, memory: Floats) -> Floats:
    x = seen[layout.OBS_ODOMETRY_X]
    y = seen[layout.OBS_ODOMETRY_Y]
    if memory[KNOWN] == 0.0:
        far = seen[layout.OBS_TARGET_DISTANCE]
        heading = seen[layout.OBS_TARGET_HEADING]
        memory[KNOWN : TARGET_Y + 1] = (1.0, x, y, x + far * cos(heading), y + far * sin(heading))
        signal = seen[layout.OBS_SIGNAL]
        cells = _by_signal(signal, 1.0) if signal > 0.0 else 0.0
        memory[CELL] = far / cells if cells > 0.0 else 0.0
    else:
        dx = x - memory[BEFORE_X]
        dy = y - memory[BEFORE_Y]
        memory[X] += cos(memory[TURNED]) * dx - sin(memory[TURNED]) * dy
        memory[Y] += sin(memory[TURNED]) * dx + cos(memory[TURNED]) * dy
    memory[BEFORE_X] = x
    memory[BEFORE_Y] = y
    estimated = seen.copy()
    estimated[layout.OBS_X] = memory[X]
    estimated[layout.OBS_Y] = memory[Y]
    estimated[layout.OBS_HEADING] = wrap(seen[layout.OBS_ODOMETRY_HEADING] + memory[TURNED])
    return estimated


def act_bug(seen: Floats, memory: Floats, command: Floats) -> None:
    """One step of ``odometry-bug``."""
    estimated = _by_odometry(seen, memory)
    _show_target(estimated, memory)
    bug2._act(estimated, memory[SIZE:], command)


def act_mapper(seen: Floats, memory: Floats, command: Floats) -> None:
    """One step of ``signal-mapper``."""
    estimated = _by_odometry(seen, memory)
    memory[TURNED] = wrap(seen[layout.OBS_HEADING] - seen[layout.OBS_ODOMETRY_HEADING])
    estimated[layout.OBS_HEADING] = seen[layout.OBS_HEADING]
    dx = memory[TARGET_X] - memory[X]
    dy = memory[TARGET_Y] - memory[Y]
    far = math.sqrt(dx * dx + dy * dy)
    signal = seen[layout.OBS_SIGNAL]
    if signal > 0.0 and memory[CELL] > 0.0 and far > 0.0:
        wrong = _by_signal(signal, memory[CELL]) - far
        if not abs(wrong) > 0.3:
            memory[X] -= 0.2 * wrong * dx / far
            memory[Y] -= 0.2 * wrong * dy / far
    estimated[layout.OBS_X] = memory[X]
    estimated[layout.OBS_Y] = memory[Y]
    _show_target(estimated, memory)
    mapper._act(estimated, memory[SIZE:], command)


def _cross(seen: Floats, memory: Floats, far: float) -> None:
    x = seen[layout.OBS_X]
    y = seen[layout.OBS_Y]
    dx = x - memory[BEFORE_X]
    dy = y - memory[BEFORE_Y]
    base = math.sqrt(dx * dx + dy * dy)
    before = memory[FAR]
    along = (before * before - far * far + base * base) / (2.0 * base)
    across = math.sqrt(max(0.0, before * before - along * along))
    places = []
    for side in (-1.0, 1.0):
        at_x = memory[BEFORE_X] + (along * dx - side * across * dy) / base
        at_y = memory[BEFORE_Y] + (along * dy + side * across * dx) / base
        off = abs(wrap(angle_of(at_x - x, at_y - y) - seen[layout.OBS_SIGNAL_HEADING]))
        places.append((off, at_x, at_y))
    _, memory[TARGET_X], memory[TARGET_Y] = min(places, key=lambda one: one[0])


def _locate(seen: Floats, memory: Floats) -> None:
    x = seen[layout.OBS_X]
    y = seen[layout.OBS_Y]
    signal = seen[layout.OBS_SIGNAL]
    if signal <= 0.0:
        left = distance(x, y, memory[TARGET_X], memory[TARGET_Y])
        if memory[KNOWN] == 0.0 and (memory[SEARCH] == 0.0 or not left > 0.15):
            direction = 0.375 * WHOLE_TURN * memory[SEARCH]
            memory[SEARCH] = 1.0 if memory[SEARCH] >= 8 else memory[SEARCH] + 1.0
            memory[TARGET_X] = x + 3.0 * cos(direction)
            memory[TARGET_Y] = y + 3.0 * sin(direction)
        return
    far = _by_signal(signal, memory[CELL])
    if memory[KNOWN] == 0.0:
        heading = seen[layout.OBS_SIGNAL_HEADING]
        memory[KNOWN] = 1.0
        memory[TARGET_X] = x + far * cos(heading)
        memory[TARGET_Y] = y + far * sin(heading)
    elif distance(x, y, memory[BEFORE_X], memory[BEFORE_Y]) > 0.25:
        _cross(seen, memory, far)
    else:
        return
    memory[BEFORE_X : FAR + 1] = (x, y, far)


def act_layers(seen: Floats, memory: Floats, command: Floats) -> None:
    """One step of ``signal-three-layer``."""
    _locate(seen, memory)
    estimated = seen.copy()
    _show_target(estimated, memory)
    own = memory[SIZE:]
    if own[_LAID] != 0.0:
        for cell, place, corner in ((_CELL_X, TARGET_X, _CORNER_X), (_CELL_Y, TARGET_Y, _CORNER_Y)):
            at = math.floor((memory[place] - own[corner]) / own[_PITCH])
            own[cell] = min(max(at, 0), 47)
    three_layer.act(estimated, own, command)
