"""A Q-learning robot that keeps learning while it drives.

It starts with the table of ``q-learning``. After each decision it moves the value of the turn that
it took by a quarter towards the result: a reward for coming nearer, a penalty for a wall, and the
value of the best turn in the resulting situation. A turn that fails often enough falls behind
another, so the robot tries something else by itself.

The memory is bounded: 768 situations times six values of 16 bits, in 1,536 numbers. All values are
integers that converge, so once nothing new is learned, the run repeats its complete state. A proved
``loop`` is therefore a statement about the learner, too: the table repeats as well, so it never
learns its way out.

``worldgen train`` lets it practise with some random decisions, and keeps its table.

Sources: Christopher J. C. H. Watkins, "Learning from delayed rewards", PhD thesis, King's College,
    Cambridge (1989); Christopher J. C. H. Watkins and Peter Dayan, "Q-learning", Machine Learning 8
    (1992). For rewarding a smaller distance as a potential: Andrew Y. Ng, Daishi Harada and Stuart
    Russell, "Policy invariance under reward transformations" (1999).
"""

from __future__ import annotations

from sim._core import ffi, lib
from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct, fields_of, size_of
from sim.controllers.learning import Learning
from sim.controllers.library.q_learning import NEEDS, SENSES
from sim.controllers.memory_view import MemoryField
from worldgen.support.arrays import Floats

AT = fields_of("WgQLearnerMemory")

# Reward for arriving, in thousandths; the same as in the training of its first table.
_ARRIVED = 30_000.0

_SIZE = size_of("WgQLearnerMemory")


def _at_reset() -> tuple[float, ...]:
    memory = ffi.new("double[]", _SIZE)
    lib.wg_q_learner_reset(memory)
    return tuple(memory)


def _arrives(memory: Floats) -> None:
    lib.wg_q_learner_arrives(ffi.from_buffer("double[]", memory, require_writable=True), _ARRIVED)


AT_RESET = _at_reset()
LEARNING = Learning(AT.values, _SIZE - AT.values, AT.explore, _arrives, whole=True)

q_learner = CompiledController(
    "q-learner",
    CoreAct("q-learner"),
    AT_RESET,
    about="Choose turns from a learned table, and keep learning.",
    senses=(*SENSES, "target_distance"),
    needs=NEEDS,
    memory_fields=(MemoryField("situation", AT.situation), MemoryField("turn", AT.choice)),
    learning=LEARNING,
)
