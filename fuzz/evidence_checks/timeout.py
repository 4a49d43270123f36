"""``timeout``: the budget is spent while the robot was still entering new cells."""

from __future__ import annotations

from fuzz.evidence_checks._plain import check_budget, first_new_cell_of_second_half
from sim.evidence import BudgetEvidence
from sim.motion import Motion
from sim.trace import Trace
from worldgen.world import World

__all__ = ["check_timeout"]


def check_timeout(world: World, trace: Trace, evidence: BudgetEvidence, motion: Motion) -> str:
    """Check that the second half has a new cell (else it is ``stalled``), and the budget."""
    if not first_new_cell_of_second_half(world, trace):
        return "the second half has no new cell"
    return check_budget(world, trace, evidence)
