"""A short run before long work, so that what can never work is said at once."""

from __future__ import annotations

import numpy as np

from sim.controllers.contract import check_contract
from sim.episode import prepare
from sim.outcome import Outcome
from sim.scenario import Scenario
from worldgen.world import Pose, Target, World

__all__ = ["EMPTY_ARENA", "try_out"]

EMPTY_ARENA = World(np.zeros((8, 8), bool), Pose(0.35, 0.35, 0.0), Target(0.6, 0.6, 0.05))
"""A world without walls."""

_STEPS = 2


def try_out(scenario: Scenario) -> Outcome:
    """Run two steps in an empty arena.

    Returns:
        How the run ended.

    Raises:
        InvalidParameter: If the controller does not compile, does not fit the motion model, or returns what the
            contract does not allow.
    """
    options = scenario.options(EMPTY_ARENA, _STEPS)
    outcome = prepare(EMPTY_ARENA, scenario.controller, options).run(
        _STEPS, find_loop=False, record=False, digest=False
    )
    check_contract(scenario.controller, outcome.fault, outcome.steps)
    return outcome
