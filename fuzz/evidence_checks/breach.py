"""Check that a walled-off target is reached by the run that ignores the wall it goes through."""

from __future__ import annotations

from fuzz.evidence_checks._plain import lattice_cell
from sim.evidence import WallEvidence
from sim.trace import Trace
from worldgen.world import World


def check_breach(world: World, trace: Trace, whole: Trace, evidence: WallEvidence) -> str:
    """Check that the run, continued past the wall, first enters the target in step ``reached``.

    The checker of the cut decides whether the target is walled off.

    Args:
        world: World of the run.
        trace: The run that ended in the wall.
        whole: The same run with walls that do not end it.
        evidence: ``step`` and ``reached``.
    """
    step = evidence.step
    reached = evidence.reached
    if reached is None or not step < reached <= whole.steps:
        return (
            f"the run does not include both the wall in step {step} and the target in step "
            f"{reached}"
        )
    # Up to the wall, both runs must be the same.
    if trace.steps != step or not (trace.states == whole.states[: step + 1]).all():
        return "the continued run differs before the wall"
    # The target counts as reached in its cell, as for the thesis's robot.
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
