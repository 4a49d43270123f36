"""Random walk: legs of equal length in random directions; a wall ends a leg early.

Any other controller should be quicker; it also shows how hard a world is by chance alone. It
arrives in the end, with probability one, but without any time limit.

Source: Karl Pearson, "The problem of the random walk", Nature 72 (1905), p. 294.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from tests.reference.sim import layout

Floats = npt.NDArray[np.float64]

LEG = (
    0.5  # m: length of a leg; shorter ones stay near the start for longer, longer ones follow walls
)
LEFT = 0  # layout of the memory: the remaining length of the leg, m


def _walk(observation: Floats, memory: Floats, command: Floats) -> None:
    if observation[layout.OBS_BUMP] != 0.0 or memory[LEFT] <= 0.0:
        memory[LEFT] = LEG
        command[layout.CMD_TURN_RATE] = 2.0 * math.pi * (observation[layout.OBS_RANDOM] - 0.5)
        command[layout.CMD_TURN_RATE] /= observation[layout.OBS_TIME_STEP]
        command[layout.CMD_DRAW] = 1.0
    length = min(
        memory[LEFT], observation[layout.OBS_TOP_SPEED] * observation[layout.OBS_TIME_STEP]
    )
    memory[LEFT] -= length
    command[layout.CMD_SPEED] = length / observation[layout.OBS_TIME_STEP]


def _act(observation: Floats, memory: Floats, command: Floats) -> None:
    _walk(observation, memory, command)
