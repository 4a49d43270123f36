"""Load the modules that a search's first units need, in each of its processes.

These are the library and the controllers.
"""

from __future__ import annotations

from collections.abc import Sequence

from fuzz.triage.proofs import certified
from sim.runners.controller_time import Effort
from sim.runners.try_out import EMPTY_ARENA, try_out
from sim.scenario import Scenario

__all__ = ["load"]


def load(scenarios: Sequence[Scenario]) -> float:
    """Let each controller take two steps, and prove a world.

    Args:
        scenarios: The controllers, and how they run.

    Returns:
        Seconds of this spent in the controllers' own code.
    """
    began = Effort.so_far()
    for scenario in scenarios:
        try_out(scenario)
    certified(EMPTY_ARENA)
    return began.since().own
