"""Directions and distances in the plane, places of a beam and the target, and commands to turn.

Only ``+ - * /``, ``sqrt`` and fdlibm's functions are used, so the bits are the same on every
machine.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from tests.reference.sim import layout
from tests.reference.sim.fdlibm import atan

Floats = npt.NDArray[np.float64]

WHOLE_TURN = 2.0 * math.pi


def wrap(angle: float) -> float:
    """The same angle in [-pi, pi), rad."""
    return angle - WHOLE_TURN * math.floor((angle + math.pi) / WHOLE_TURN)


def angle_of(dx: float, dy: float) -> float:
    """Direction of the vector (dx, dy), rad; 0 for the zero vector."""
    if dx == 0.0 and dy == 0.0:
        return 0.0
    if abs(dy) <= abs(dx):
        angle = atan(dy / dx)
        if dx > 0.0:
            return angle
        return angle + math.pi if dy >= 0.0 else angle - math.pi
    angle = atan(dx / dy)
    return math.pi / 2.0 - angle if dy > 0.0 else -math.pi / 2.0 - angle


def distance(x: float, y: float, to_x: float, to_y: float) -> float:
    """Distance between two points."""
    dx, dy = to_x - x, to_y - y
    return math.sqrt(dx * dx + dy * dy)


def distance_to_way(
    x: float, y: float, from_x: float, from_y: float, to_x: float, to_y: float
) -> float:
    """Distance of a point from a straight segment."""
    dx, dy = to_x - from_x, to_y - from_y
    length_sq = dx * dx + dy * dy
    share = 0.0
    if length_sq > 0.0:
        share = min(1.0, max(0.0, ((x - from_x) * dx + (y - from_y) * dy) / length_sq))
    return distance(x, y, from_x + share * dx, from_y + share * dy)


def bearing_of(beam: int, beams: int) -> float:
    """Direction of a range beam from the heading, rad, for beams all around, the first ahead."""
    return WHOLE_TURN * beam / beams


def target_bearing(observation: Floats) -> float:
    """Direction of the target from the heading, rad in [-pi, pi)."""
    return wrap(observation[layout.OBS_TARGET_HEADING] - observation[layout.OBS_HEADING])


def steer(observation: Floats, command: Floats, turn: float, speed: float) -> None:
    """Commands a turn, rad, within the next step, and a speed, m/s."""
    command[layout.CMD_TURN_RATE] = turn / observation[layout.OBS_TIME_STEP]
    command[layout.CMD_SPEED] = speed
