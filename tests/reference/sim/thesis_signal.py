"""The thesis's light: the map of its strength, the noise filter, and how the robot reads it.

The author's proposals for further work are here too: a sensor with a limited field or with errors;
walls that weaken or block the light behind them; a robot whose own map is coarser than the world.

Source: the thesis's listing, ``Grid.lightGridGenrtr``, ``simWorldCreator.noiseMapGen``,
``simGuiExp.scanMultipleCells``, ``calcHeading`` and ``robot.turnS``.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from tests.reference.sim.fdlibm import atan
from tests.reference.sim.random_draw import random_draw
from tests.reference.sim.thesis_layout import BLOCKED, CELL, OPEN, WALL, Setup

Cells = npt.NDArray[np.int32]

_TWO_PI = 2.0 * math.pi
_TURN_STEP = 0.08  # rad per tick
_TURN_SNAP = 0.2  # rad; nearer than this the robot takes the heading immediately
_DARK = 2.0**30  # reading where no light arrives: weaker than any signal
_MOST_HALVINGS = 30  # walls that weaken the light; more do not make it darker
_READINGS = 2**16  # random numbers per tick; the last one is for slip
_NOISE_REACH = 2  # cells around a wall whose signal the filter changes


def signal_map(width: int, height: int, target_x: int, target_y: int) -> Cells:
    """(width, height) int32: squared distance in cells to the target's cell.

    The border is ``WALL``.
    """
    light = np.full((width, height), WALL, np.int32)
    for y in range(1, height - 1):
        for x in range(1, width - 1):
            light[x, y] = (x - target_x) * (x - target_x) + (y - target_y) * (y - target_y)
    return light


def add_noise(cells: Cells, light: Cells) -> None:
    """Weakens or strengthens the signal of cells near inner walls, in place.

    The effect of the order is kept.

    Args:
        cells: The signal with every wall drawn.
        light: The undisturbed signal, :func:`signal_map`.
    """
    for wall_y in range(1, cells.shape[1] - 1):
        for wall_x in range(1, cells.shape[0] - 1):
            if cells[wall_x, wall_y] != WALL:
                continue
            for y in range(
                max(wall_y - _NOISE_REACH, 1), min(wall_y + _NOISE_REACH, cells.shape[1] - 2) + 1
            ):
                for x in range(
                    max(wall_x - _NOISE_REACH, 1),
                    min(wall_x + _NOISE_REACH, cells.shape[0] - 2) + 1,
                ):
                    if cells[x, y] <= 0:
                        continue
                    if cells[x, y] > light[wall_x, wall_y]:
                        cells[x, y] = int(1.5 * light[x, y])
                    elif int(0.9 * light[x, y]) != 0:
                        cells[x, y] = int(0.9 * light[x, y])


def bearing(dx: float, dy: float) -> float:
    """Heading of a vector, in the listing's four quadrants; can be -0.0, and 2 pi is 0."""
    heading = atan(dy / dx) if dx != 0.0 else (1.5 * math.pi if dy > 0.0 else math.pi / 2.0)
    if dx >= 0.0 and dy <= 0.0:
        return math.pi + heading if heading <= 0.0 else heading
    if dx <= 0.0 and dy <= 0.0:
        return heading
    if dx <= 0.0:
        return _TWO_PI + heading if heading <= 0.0 else heading
    return math.pi + heading if heading >= 0.0 else heading


def signal_direction(cells: Cells, x: float, y: float, sense: int) -> float:
    """Heading to the centre of the cell with the best signal within ``sense`` cells.

    Ties go to the first. In a wall the robot's own cell has the lowest value, so it then seeks the
    middle of that wall.
    """
    own_x, own_y = int(x / CELL), int(y / CELL)
    lowest, best_x, best_y = cells[own_x, own_y], own_x, own_y
    for cell_y in range(max(own_y - sense, 1), min(own_y + sense, cells.shape[1] - 2) + 1):
        for cell_x in range(max(own_x - sense, 1), min(own_x + sense, cells.shape[0] - 2) + 1):
            value = cells[cell_x, cell_y]
            if 0 <= value < lowest:
                lowest, best_x, best_y = value, cell_x, cell_y
    return bearing((best_x + 0.5) * CELL - x, (best_y + 0.5) * CELL - y)


def walls_between(cells: Cells, x: int, y: int, to_x: int, to_y: int) -> int:
    """Count walls that the straight line between two cells' centres crosses, except these two.

    A line exactly through a corner crosses neither of the two cells next to it.

    Source: John Amanatides and Andrew Woo, "A fast voxel traversal algorithm for ray tracing",
        Eurographics 1987;
    here in integers.
    """
    way_x, way_y = abs(to_x - x), abs(to_y - y)
    step_x, step_y = (1 if to_x > x else -1), (1 if to_y > y else -1)
    gone_x, gone_y, walls = 0, 0, 0
    while gone_x < way_x or gone_y < way_y:
        ahead = (1 + 2 * gone_x) * way_y - (
            1 + 2 * gone_y
        ) * way_x  # negative: the next edge crossed is vertical
        if ahead <= 0:
            gone_x += 1
        if ahead >= 0:
            gone_y += 1
        on_x, on_y = x + step_x * gone_x, y + step_y * gone_y
        if cells[on_x, on_y] == WALL and not (on_x == to_x and on_y == to_y):
            walls += 1
    return walls


def _reading(cells: Cells, x: int, y: int, setup: Setup) -> float:
    """Signal of a cell through the walls; negative if there is none."""
    value = float(cells[x, y])
    if value <= 0.0 or setup.signal == OPEN:
        return value
    walls = walls_between(cells, x, y, setup.target_x, setup.target_y)
    if walls == 0:
        return value
    return (
        _DARK
        if setup.signal == BLOCKED or walls > _MOST_HALVINGS
        else min(value * 2.0**walls, _DARK)
    )


def _block_reading(cells: Cells, block_x: int, block_y: int, setup: Setup) -> float:
    """Best signal in a block of the robot's map; -1 if it has none, as in a block of walls."""
    best = -1.0
    for y in range(
        block_y * setup.map_scale, min((block_y + 1) * setup.map_scale, cells.shape[1] - 1)
    ):
        for x in range(
            block_x * setup.map_scale, min((block_x + 1) * setup.map_scale, cells.shape[0] - 1)
        ):
            value = _reading(cells, x, y, setup)
            if value >= 0.0 and (best < 0.0 or value < best):
                best = value
    return best


def _noisy_reading(cells: Cells, x: int, y: int, setup: Setup, scale: int, draw: int) -> float:
    """The sensor's reading for a cell, or for a block of the robot's map."""
    value = _reading(cells, x, y, setup) if scale == 1 else _block_reading(cells, x, y, setup)
    if value > 0.0 and setup.sensor_noise > 0.0:
        value *= 1.0 + setup.sensor_noise * (2.0 * random_draw(setup.seed, draw) - 1.0)
    return value


def _in_field(x: float, y: float, to_x: float, to_y: float, heading: float, field: float) -> bool:
    """Return whether a place is in the sensor's field of view."""
    if field == 0.0:
        return True
    turn = np.fmod(bearing(to_x - x, to_y - y) - heading, _TWO_PI)
    off = abs(float(turn))
    return min(off, _TWO_PI - off) <= field / 2.0


def sensed_direction(
    cells: Cells, x: float, y: float, heading: float, setup: Setup, step: int
) -> float:
    """Heading to the best signal by the sensor that ``setup`` describes.

    The thesis's is :func:`signal_direction`. The robot reads its own cell, or block of its map,
    whatever its heading. In the best block it uses single cells.

    Args:
        cells: The signal with every wall drawn.
        x: Centre, px.
        y: Same as above.
        heading: The robot's heading, rad.
        setup: Its sensor.
        step: Number of the tick, which picks the sensor's errors.
    """
    if (
        setup.signal == OPEN
        and setup.sensor_field == 0.0
        and setup.sensor_noise == 0.0
        and setup.map_scale == 1
    ):
        return signal_direction(cells, x, y, setup.sense)
    if setup.map_scale > 1:
        best_x, best_y = _best_of(cells, x, y, heading, setup, step, setup.map_scale)
        side = CELL * setup.map_scale
        if best_x != int(x / side) or best_y != int(y / side):
            return bearing((best_x + 0.5) * side - x, (best_y + 0.5) * side - y)
    best_x, best_y = _best_of(cells, x, y, heading, setup, step, 1)
    return bearing((best_x + 0.5) * CELL - x, (best_y + 0.5) * CELL - y)


def _best_of(
    cells: Cells, x: float, y: float, heading: float, setup: Setup, step: int, scale: int
) -> tuple[int, int]:
    """Cell, or block of ``scale`` cells, with the best reading in reach.

    The first wins a tie, and the robot's own cell wins over all others.
    """
    side = CELL * scale
    own_x, own_y = int(x / side), int(y / side)
    last_x, last_y = (cells.shape[0] - 2) // scale, (cells.shape[1] - 2) // scale
    first = 1 if scale == 1 else 0
    best_x, best_y = own_x, own_y
    lowest = _noisy_reading(cells, own_x, own_y, setup, scale, step * _READINGS)
    count = 0
    for cell_y in range(max(own_y - setup.sense, first), min(own_y + setup.sense, last_y) + 1):
        for cell_x in range(max(own_x - setup.sense, first), min(own_x + setup.sense, last_x) + 1):
            count += 1
            middle_x, middle_y = (cell_x + 0.5) * side, (cell_y + 0.5) * side
            if not _in_field(x, y, middle_x, middle_y, heading, setup.sensor_field):
                continue
            value = _noisy_reading(
                cells, cell_x, cell_y, setup, scale, step * _READINGS + count % (_READINGS - 1)
            )
            if 0.0 <= value < lowest:
                lowest, best_x, best_y = value, cell_x, cell_y
    return best_x, best_y


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
