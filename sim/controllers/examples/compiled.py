"""A controller that numba compiles, for millions of steps a second. Edit it and try it with:

worldgen run w.grid --controller ./example.py:example --picture run.png
"""  # noqa: D415 - a command has no full stop

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from sim import CompiledController
from sim.kernels import layout

Floats = npt.NDArray[np.float64]

# How far to turn after a bump, rad, counter-clockwise.
TURN = 1.5

# Steps to drive straight on after a turn, before heading for the target again.
PATIENCE = 20.0

# Index in the memory: how many of those steps are left.
WAITING = 0


def act(observation: Floats, memory: Floats, command: Floats) -> None:
    """Drive one step: head for the target, and after a bump turn away for a while.

    Use only numbers, arrays, math and other compiled functions. Keep all state in the memory; numba
    freezes global variables at their first value. The command is all zeros at the start.
    """
    # After a bump, turn away, and then drive straight on for some steps.
    if observation[layout.OBS_BUMP] != 0.0:
        turn = TURN
        memory[WAITING] = PATIENCE
    elif memory[WAITING] > 0.0:
        turn = 0.0
        memory[WAITING] -= 1.0
    else:
        # Turn towards the target, the shorter way around.
        turn = observation[layout.OBS_TARGET_HEADING] - observation[layout.OBS_HEADING]
        turn = (turn + math.pi) % (2 * math.pi) - math.pi

    # A turn rate of turn / time_step completes the turn within this step.
    command[layout.CMD_SPEED] = observation[layout.OBS_TOP_SPEED]
    command[layout.CMD_TURN_RATE] = turn / observation[layout.OBS_TIME_STEP]


example = CompiledController(
    "example",
    act,
    # The memory at the start of a run; its length stays the same.
    memory=(0.0,),
    # The observations that act() reads. The others are nan, and cost no time.
    senses=("bump", "heading", "target_heading", "time_step", "top_speed"),
)
