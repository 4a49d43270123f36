"""What the controllers with range beams share: where a beam and the target are, and how to command a turn."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from sim.controllers.library._plane import wrap
from sim.kernels import layout
from sim.kernels._jit import kernel

__all__ = ["WHOLE_TURN", "bearing_of", "steer", "target_bearing"]

Floats = npt.NDArray[np.float64]

WHOLE_TURN = 2.0 * math.pi


@kernel
def bearing_of(beam: int, beams: int) -> float:
    """Direction of a range beam from the heading, rad, for beams all round, the first ahead."""
    return WHOLE_TURN * beam / beams


@kernel
def target_bearing(observation: Floats) -> float:
    """Direction of the target from the heading, rad in [-pi, pi)."""
    return wrap(observation[layout.OBS_TARGET_HEADING] - observation[layout.OBS_HEADING])


@kernel
def steer(observation: Floats, command: Floats, turn: float, speed: float) -> None:
    """Commands a turn, rad, within the next step, and a speed, m/s."""
    command[layout.CMD_TURN_RATE] = turn / observation[layout.OBS_TIME_STEP]
    command[layout.CMD_SPEED] = speed
