"""Q-learning: a table of what each turn is worth in each situation, learnt by driving in the simulator.

Every fourth step the robot looks where the target is (an eighth of a turn), which of five
directions are blocked, and which way it turned last; that makes 768 situations. For each the table
has the worth of six turns, and the robot takes the best. Nobody has told it how to follow a wall.
    What it cannot tell apart it must treat alike: in worlds where
the table, right on average, is wrong, it drives round for ever.

The table is in ``sim/core/controllers/q_table.c``, which ``python -m benchmarks.train_q_learning``
has written and writes again, bit for bit.

Sources: Christopher J. C. H. Watkins, "Learning from delayed rewards", PhD thesis, King's College,
    Cambridge (1989);
Christopher J. C. H. Watkins and Peter Dayan, "Q-learning", Machine Learning 8 (1992).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from sim import _core
from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct, memory_at_reset, size_of
from sim.options.robot import RobotOptions

__all__ = [
    "AT_RESET",
    "NEEDS",
    "SENSES",
    "SITUATIONS",
    "TURNS",
    "best_turns",
    "q_learning",
    "q_learning_robot",
]

Ints = npt.NDArray[np.int64]

_lib: Any = _core.lib

SITUATIONS = int(_lib.WG_Q_SITUATIONS)
TURNS = tuple(_lib.wg_q_turn_of)
"""Eighths of a turn, counter-clockwise; of equals the first is taken."""
DRIVEN = int(_lib.WG_Q_DRIVEN)
"""Steps between two decisions, if no bump comes first."""

AT_RESET = memory_at_reset(size_of("WgQMemory"), {})
SENSES = ("bump", "heading", "target_heading", "time_step", "top_speed", "radius", "beams")
NEEDS = RobotOptions(beams=8, beam_range=2.0)


def best_turns(table: Ints) -> Ints:
    """Return (SITUATIONS,) the index of the best turn in each situation; the first of equals."""
    best: Ints = np.argmax(table, axis=1).astype(np.int64)
    return best


def q_learning_robot(table: Ints, name: str = "q-learning") -> CompiledController:
    """Return a robot that drives by a table.

    Args:
        table: (SITUATIONS, turns) worths.
        name: For messages and files.
    """
    memory = AT_RESET + tuple(map(float, best_turns(table)))
    return CompiledController(name, CoreAct("q-learning-tuned"), memory, senses=SENSES, needs=NEEDS)


q_learning = CompiledController(
    "q-learning", CoreAct("q-learning"), AT_RESET, senses=SENSES, needs=NEEDS
)
