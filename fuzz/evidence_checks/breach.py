"""A walled-off target that is reached.

The run that went through the wall, had nobody stopped it.
"""

from __future__ import annotations

from fuzz.evidence_checks._plain import lattice_cell
from sim.evidence import WallEvidence
from sim.trace import Trace
from worldgen.world import World

__all__ = ["check_breach"]


def check_breach(world: World, trace: Trace, whole: Trace, evidence: WallEvidence) -> str:
    """Check that the run, going on past the wall, enters the target's cell in step ``reached``, not before.

    That the target is walled off is for the checker of the cut to say.

    Args:
        world: Where the run was.
        trace: The run that ended in the wall.
        whole: The same run where walls end nothing.
        evidence: ``step`` and ``reached``.
    """
    step = evidence.step
    reached = evidence.reached
    if reached is None or not step < reached <= whole.steps:
        return (
            f"the target is said to be reached in step {reached}, the wall entered in step {step}"
        )
    if trace.steps != step or not (trace.states == whole.states[: step + 1]).all():
        return "the run that goes on is another one before the wall"
    columns = lattice_cell(whole.x / world.cell_size)
    rows = lattice_cell(whole.y / world.cell_size)
    there = (
        lattice_cell(world.target.x / world.cell_size),
        lattice_cell(world.target.y / world.cell_size),
    )
    inside = (columns == there[0]) & (rows == there[1])
    if not inside[reached]:
        return f"step {reached} does not end in the target's cell"
    return f"the target is reached before step {reached}" if inside[:reached].any() else ""
