"""Q-learning: a table of the value of each turn in each situation, learned in simulation.

Every fourth step the robot observes the direction of the target (in eighths of a turn), which of
five directions are blocked, and to which side it last turned, which makes 768 situations. For each
situation the table holds the values of six turns, and the robot takes the best. It was never told
how to follow a wall. It must treat situations that it cannot distinguish alike, so in worlds where
the table is right on average but wrong locally, it drives in circles forever.

``python -m benchmarks.train_q_learning`` writes the table to
``sim/core/controllers/shared/q_table.c``, and gives the same bits every time.

Sources: Christopher J. C. H. Watkins, "Learning from delayed rewards", PhD thesis, King's College,
    Cambridge (1989); Christopher J. C. H. Watkins and Peter Dayan, "Q-learning", Machine Learning 8
    (1992).
"""

from __future__ import annotations

import numpy as np

from sim._core import lib
from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct, memory_at_reset, size_of
from sim.options.robot import RobotOptions
from worldgen.support.arrays import Ints

SITUATIONS = int(lib.WG_Q_SITUATIONS)
TURNS = tuple(lib.wg_q_turn_of)
"""Turns to choose from, in eighths of a turn, counter-clockwise; the first wins a tie."""
DRIVEN = int(lib.WG_Q_DRIVEN)
"""Steps between two decisions, if no bump occurs."""

AT_RESET = memory_at_reset(size_of("WgQMemory"), {})
SENSES = ("bump", "heading", "target_heading", "time_step", "top_speed", "radius", "beams")
NEEDS = RobotOptions(beams=8, beam_range=2.0)


def best_turns(table: Ints) -> Ints:
    """Return (SITUATIONS,) the index of the best turn in each situation; the first wins a tie."""
    best: Ints = np.argmax(table, axis=1).astype(np.int64)
    return best


_ABOUT = "Choose each turn from a table that was learned by simulation."


def q_learning_robot(table: Ints, name: str = "q-learning") -> CompiledController:
    """Return a controller that looks up its turns in a table.

    Args:
        table: (SITUATIONS, turns) value of each turn.
        name: Name in messages and files.
    """
    memory = AT_RESET + tuple(map(float, best_turns(table)))
    return CompiledController(
        name, CoreAct("q-learning-tuned"), memory, senses=SENSES, needs=NEEDS, about=_ABOUT
    )


q_learning = CompiledController(
    "q-learning", CoreAct("q-learning"), AT_RESET, senses=SENSES, needs=NEEDS, about=_ABOUT
)
