"""The thesis's light: the map of its strength, the noise filter, and how the robot reads and follows it.

Source: the thesis's listing, ``Grid.lightGridGenrtr``, ``simWorldCreator.noiseMapGen``,
``simGuiExp.scanMultipleCells``, ``calcHeading`` and ``robot.turnS``.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from sim.kernels._jit import allocating_kernel, kernel
from sim.kernels.fdlibm import atan
from sim.kernels.thesis_layout import CELL, WALL

__all__ = ["add_noise", "bearing", "signal_direction", "signal_map", "turn_towards"]

Cells = npt.NDArray[np.int32]

_TWO_PI = 2.0 * math.pi
_TURN_STEP = 0.08  # rad per tick
_TURN_SNAP = 0.2  # rad; nearer than this the robot takes the heading at once
_NOISE_REACH = 2  # cells round a wall whose signal the filter changes


@allocating_kernel
def signal_map(width: int, height: int, target_x: int, target_y: int) -> Cells:
    """(width, height) int32: squared distance in cells to the target's cell; the border is ``WALL``."""
    light = np.full((width, height), WALL, np.int32)
    for y in range(1, height - 1):
        for x in range(1, width - 1):
            light[x, y] = (x - target_x) * (x - target_x) + (y - target_y) * (y - target_y)
    return light


@kernel
def add_noise(cells: Cells, light: Cells) -> None:
    """Weakens or strengthens the signal of cells near inner walls, in place; what the order does stays.

    Args:
        cells: The signal with every wall drawn.
        light: The undisturbed signal, :func:`signal_map`.
    """
    for wall_y in range(1, cells.shape[1] - 1):
        for wall_x in range(1, cells.shape[0] - 1):
            if cells[wall_x, wall_y] != WALL:
                continue
            for y in range(max(wall_y - _NOISE_REACH, 1), min(wall_y + _NOISE_REACH, cells.shape[1] - 2) + 1):
                for x in range(max(wall_x - _NOISE_REACH, 1), min(wall_x + _NOISE_REACH, cells.shape[0] - 2) + 1):
                    if cells[x, y] <= 0:
                        continue
                    if cells[x, y] > light[wall_x, wall_y]:
                        cells[x, y] = int(1.5 * light[x, y])
                    elif int(0.9 * light[x, y]) != 0:
                        cells[x, y] = int(0.9 * light[x, y])


@kernel
def bearing(dx: float, dy: float) -> float:
    """Heading of a vector, in the listing's own four quadrants; can be -0.0, and 2 pi is 0."""
    heading = atan(dy / dx) if dx != 0.0 else (1.5 * math.pi if dy > 0.0 else math.pi / 2.0)
    if dx >= 0.0 and dy <= 0.0:
        return math.pi + heading if heading <= 0.0 else heading
    if dx <= 0.0 and dy <= 0.0:
        return heading
    if dx <= 0.0:
        return _TWO_PI + heading if heading <= 0.0 else heading
    return math.pi + heading if heading >= 0.0 else heading


@kernel
def signal_direction(cells: Cells, x: float, y: float, sense: int) -> float:
    """Heading to the centre of the cell with the best signal within ``sense`` cells; the first of equals.

    In a wall the own value is the lowest, so the robot then seeks the middle of that wall.
    """
    own_x, own_y = int(x / CELL), int(y / CELL)
    lowest, best_x, best_y = cells[own_x, own_y], own_x, own_y
    for cell_y in range(max(own_y - sense, 1), min(own_y + sense, cells.shape[1] - 2) + 1):
        for cell_x in range(max(own_x - sense, 1), min(own_x + sense, cells.shape[0] - 2) + 1):
            value = cells[cell_x, cell_y]
            if 0 <= value < lowest:
                lowest, best_x, best_y = value, cell_x, cell_y
    return bearing((best_x + 0.5) * CELL - x, (best_y + 0.5) * CELL - y)


@kernel
def turn_towards(heading: float, target: float) -> float:
    """Heading after one tick of turning; ``fmod`` as in Java, so headings may be negative."""
    if not abs(target - heading) > _TURN_SNAP:
        return target
    if target < heading:
        if target + math.pi > heading:
            return float(np.fmod(heading - _TURN_STEP, _TWO_PI))
        return float(np.fmod(heading + _TURN_STEP, _TWO_PI))
    if heading + math.pi > target:
        return float(np.fmod(heading + _TURN_STEP, _TWO_PI))
    return float(np.fmod(_TWO_PI + heading - _TURN_STEP, _TWO_PI))
