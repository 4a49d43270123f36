"""Random walk: legs of equal length in random directions; a wall ends a leg early.

It is a baseline that any other controller should beat, and a measure of how hard a world is for
pure chance. It arrives with probability one, but may exceed any time limit.

Source: Karl Pearson, "The problem of the random walk", Nature 72 (1905), p. 294.
"""

from __future__ import annotations

from sim.controllers.base import CompiledController
from sim.controllers.core_act import CoreAct

random_walk = CompiledController(
    "random-walk",
    CoreAct("random-walk"),
    (0.0,),
    about="Drive legs in random directions; a wall ends a leg.",
    randomised=True,
    senses=("bump", "random", "time_step", "top_speed"),
)
