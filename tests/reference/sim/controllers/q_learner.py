"""A Q-learning robot that learns while it drives, in plain Python.

Memory: steps to wait, the last turn; situation, choice and distance in mm of the last decision;
share of random decisions, in thousandths; then three values of 16 bits in each number.

Sources: Christopher J. C. H. Watkins and Peter Dayan, "Q-learning", Machine Learning 8 (1992).
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from tests.reference.sim import layout
from tests.reference.sim.controllers._directions import WHOLE_TURN, steer
from tests.reference.sim.controllers.q_learning import DRIVEN, TURNED, TURNS, WAIT, situation

Floats = npt.NDArray[np.float64]

SITUATION, CHOICE, FAR, EXPLORE, VALUES = 2, 3, 4, 5, 6
_ZERO = 1 << 15


def _values(memory: Floats, now: int) -> list[int]:
    found = []
    for number in memory[VALUES + 2 * now : VALUES + 2 * now + 2]:
        packed = int(number)
        found += [(packed >> shift & 0xFFFF) - _ZERO for shift in (0, 16, 32)]
    return found


def _learn(memory: Floats, worth: int) -> None:
    now = int(memory[SITUATION])
    choice = int(memory[CHOICE])
    values = _values(memory, now)
    values[choice] += (worth - values[choice]) // 4
    values[choice] = min(max(values[choice], -_ZERO), _ZERO - 1)
    for half in range(2):
        three = [value + _ZERO for value in values[3 * half : 3 * half + 3]]
        memory[VALUES + 2 * now + half] = three[0] + (three[1] << 16) + (three[2] << 32)


def act(observation: Floats, memory: Floats, command: Floats) -> None:
    """One step."""
    turn = 0
    bump = observation[layout.OBS_BUMP] != 0.0
    if memory[WAIT] <= 0.0 or bump:
        now = situation(observation, memory)
        far = math.floor(observation[layout.OBS_TARGET_DISTANCE] * 1000.0 + 0.5)
        if memory[SITUATION] >= 0.0:
            reward = -200 + 5 * (int(memory[FAR]) - far) - 1000 * bool(bump)
            _learn(memory, reward + 98 * max(_values(memory, now)) // 100)
        values = _values(memory, now)
        choice = values.index(max(values))
        if memory[EXPLORE] > 0.0:
            command[layout.CMD_DRAW] = 1.0
            drawn = observation[layout.OBS_RANDOM] * 1000.0
            if drawn < memory[EXPLORE]:
                choice = min(math.floor(drawn / memory[EXPLORE] * 6.0), 5)
        memory[SITUATION : FAR + 1] = (now, choice, far)
        turn = TURNS[choice]
        memory[WAIT] = float(DRIVEN)
        memory[TURNED] = 0.0 if turn % 4 == 0 else 1.0 if turn < 4 else 2.0
    memory[WAIT] -= 1.0
    angle = (turn if turn <= 4 else turn - 8) * (WHOLE_TURN / 8.0)
    steer(observation, command, angle, observation[layout.OBS_TOP_SPEED])
