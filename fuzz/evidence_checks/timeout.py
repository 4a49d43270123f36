"""``timeout``: the budget is spent, and the robot was still getting to new cells."""

from __future__ import annotations

from fuzz.evidence_checks._plain import first_new_cell_of_second_half, object_to_budget
from sim.evidence import BudgetEvidence
from sim.motion import Motion
from sim.trace import Trace
from worldgen.world import World

__all__ = ["object_to_timeout"]


def object_to_timeout(world: World, trace: Trace, evidence: BudgetEvidence, motion: Motion) -> str:
    """Objects if the second half has no new cell, which would be ``stalled``, or to the budget's multiple."""
    if not first_new_cell_of_second_half(world, trace):
        return "the second half has no new cell"
    return object_to_budget(world, trace, evidence)
