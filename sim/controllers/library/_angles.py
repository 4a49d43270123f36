"""Angles for the controllers of the library: from ``+ - * /``, square roots and fdlibm alone, the same everywhere."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from sim.kernels import layout
from sim.kernels._jit import kernel
from sim.kernels.fdlibm import atan

__all__ = ["WHOLE_TURN", "bearing_of", "direction", "steer", "target_bearing", "wrapped"]

Floats = npt.NDArray[np.float64]

WHOLE_TURN = 2.0 * math.pi


@kernel
def wrapped(angle: float) -> float:
    """The same angle in (-pi, pi], for one within a few turns."""
    while angle > math.pi:
        angle -= WHOLE_TURN
    while angle <= -math.pi:
        angle += WHOLE_TURN
    return angle


@kernel
def direction(x: float, y: float) -> float:
    """Direction of the vector (x, y), rad in (-pi, pi]; 0 for the zero vector."""
    if x == 0.0 and y == 0.0:
        return 0.0
    if abs(y) > abs(x):
        return (0.5 * math.pi if y > 0.0 else -0.5 * math.pi) - atan(x / y)
    angle = atan(y / x)
    if x > 0.0:
        return angle
    return angle + math.pi if y >= 0.0 else angle - math.pi


@kernel
def bearing_of(beam: int, beams: int) -> float:
    """Direction of a range beam from the heading, rad, for beams all round, the first ahead."""
    return WHOLE_TURN * beam / beams


@kernel
def target_bearing(observation: Floats) -> float:
    """Direction of the target from the heading, rad in (-pi, pi]."""
    return wrapped(observation[layout.OBS_TARGET_HEADING] - observation[layout.OBS_HEADING])


@kernel
def steer(observation: Floats, command: Floats, turn: float, speed: float) -> None:
    """Commands a turn, rad, within the next step, and a speed, m/s."""
    command[layout.CMD_TURN_RATE] = turn / observation[layout.OBS_TIME_STEP]
    command[layout.CMD_SPEED] = speed
