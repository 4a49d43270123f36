"""A controller that numba compiles: millions of steps a second. Try it, change it, try it again:

worldgen run w.grid --controller ./example.py:example --trail run.png
"""  # noqa: D415 - a command has no full stop

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from sim import CompiledController
from sim.kernels import layout

Floats = npt.NDArray[np.float64]

TURN = 1.5  # rad, counter-clockwise, after each bump
PATIENCE = 20.0  # steps for which it drives on before it looks at the target again
WAITING = 0  # what stands where in the memory: the steps still to drive on


def act(observation: Floats, memory: Floats, command: Floats) -> None:
    """One step: drives to the target; after a bump turns away and drives straight on for a while.

    Numbers, arrays, math and other compiled functions only. All state is in the memory; a global
    that changes would be frozen at its first value. The command is all zero when this is called.
    """
    if observation[layout.OBS_BUMP] != 0.0:
        turn = TURN
        memory[WAITING] = PATIENCE
    elif memory[WAITING] > 0.0:
        turn = 0.0
        memory[WAITING] -= 1.0
    else:
        turn = observation[layout.OBS_TARGET_HEADING] - observation[layout.OBS_HEADING]
        turn = (turn + math.pi) % (2 * math.pi) - math.pi
    command[layout.CMD_SPEED] = observation[layout.OBS_TOP_SPEED]
    command[layout.CMD_TURN_RATE] = turn / observation[layout.OBS_TIME_STEP]


example = CompiledController(
    "example",
    act,
    memory=(0.0,),  # at the start of a run
    senses=(
        "bump",
        "heading",
        "target_heading",
        "time_step",
        "top_speed",
    ),  # all others are nan, and cost no time
)
