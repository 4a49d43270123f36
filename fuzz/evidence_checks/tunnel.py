"""``tunnel``: the centre entered a solid cell, or crossed one between two states."""

from __future__ import annotations

from fuzz.evidence_checks._cause import check_cause
from fuzz.evidence_checks._plain import cell_box, is_solid_at, step_path
from sim.evidence import WallEvidence
from sim.motion import Motion
from sim.trace import Trace
from worldgen.world import World

__all__ = ["check_tunnel"]


def check_tunnel(world: World, trace: Trace, evidence: WallEvidence, motion: Motion) -> str:
    """Check that the path of the named step enters the named cell while that is solid.

    If the evidence names the move that let the robot into the wall, check that too.
    """
    step = evidence.step
    cell = evidence.cell
    if not 1 <= step <= trace.steps:
        return f"the run has no step {step}"
    if not is_solid_at(world, *cell, (step - 1) * trace.time_step, step * trace.time_step):
        return f"cell {cell} is not solid in step {step}"
    inside = cell_box(world, *cell).buffer(-1e-9 * world.cell_size)
    if not step_path(trace, step).intersects(inside):
        return f"the path of step {step} does not meet cell {cell}"
    return check_cause(world, trace, evidence)
