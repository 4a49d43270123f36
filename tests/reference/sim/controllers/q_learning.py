"""Q-learning: a table of the value of each turn in each situation, learned in the simulator.

Every fourth step the robot senses where the target is (to an eighth of a turn), which of five
directions are blocked, and which way it turned last; that makes 768 situations. For each, the table
has the value of six turns, and the robot takes the best. It was never told how to follow a wall.
It must treat situations alike that it cannot tell apart: in worlds where the table, right on
average, is wrong, it drives in circles forever.

The table is in ``_q_table.py``, which ``python -m benchmarks.train_q_learning`` wrote and can write
again, bit for bit.

Sources: Christopher J. C. H. Watkins, "Learning from delayed rewards", PhD thesis, King's College,
    Cambridge (1989);
Christopher J. C. H. Watkins and Peter Dayan, "Q-learning", Machine Learning 8 (1992).
"""

from __future__ import annotations

import math
import re

import numpy as np
import numpy.typing as npt

from benchmarks.train_q_learning import TABLE
from tests.reference.sim import layout
from tests.reference.sim.controllers._directions import WHOLE_TURN, steer, target_bearing

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

TURNS = (0, 1, 7, 2, 6, 4)  # eighths of a turn, counter-clockwise; ties go to the first
_LOOKS = (0, 1, 2, 6, 7)  # the beams that the robot uses, eighths of a turn apart
SITUATIONS = 3 * 8 * 32
_IN_THE_WAY = 0.09  # m: a smaller gap counts as blocked
DRIVEN = 4  # steps between two decisions, if no bump comes first

WAIT, TURNED = (
    0,
    1,
)  # memory: steps until the next decision; last turn: 0 none or back, 1 left, 2 right
AT_RESET = (0.0, 0.0)


def situation(observation: Floats, memory: Floats) -> int:
    """Number of the situation, below SITUATIONS."""
    eighth = math.floor(target_bearing(observation) / WHOLE_TURN * 8.0 + 0.5) % 8
    blocked, near = 0, observation[layout.OBS_RADIUS] + _IN_THE_WAY
    for k in range(len(_LOOKS)):
        if observation[layout.OBS_SIZE + _LOOKS[k]] < near:
            blocked |= 1 << k
    return (int(memory[TURNED]) * 8 + eighth) * 32 + blocked


def drive(observation: Floats, memory: Floats, command: Floats, best: Ints) -> None:
    """One step: decides if it is time to, and keeps driving.

    Args:
        observation: ``OBS_``.
        memory: Steps to wait and the last turn.
        command: ``CMD_``.
        best: (SITUATIONS,) the index in TURNS to take in each situation.
    """
    turn = 0
    if memory[WAIT] <= 0.0 or observation[layout.OBS_BUMP] != 0.0:
        turn = TURNS[best[situation(observation, memory)]]
        memory[WAIT], memory[TURNED] = float(DRIVEN), 0.0
        if turn % 4 != 0:
            memory[TURNED] = 1.0 if turn < 4 else 2.0
    memory[WAIT] -= 1.0
    steer(
        observation,
        command,
        (turn if turn <= 4 else turn - 8) * (WHOLE_TURN / 8.0),
        observation[layout.OBS_TOP_SPEED],
    )


def shipped() -> Ints:
    """Return (SITUATIONS,) the best turn of the shipped table in each situation.

    Ties go to the first.
    """
    text = TABLE.read_text(encoding="utf-8")
    worths = np.array(re.findall(r"-?\d+", text[text.index("{") :]), np.int64).reshape(
        SITUATIONS, len(TURNS)
    )
    return np.argmax(worths, axis=1)


_BEST = shipped()


def act(observation: Floats, memory: Floats, command: Floats) -> None:
    drive(observation, memory, command, _BEST)
