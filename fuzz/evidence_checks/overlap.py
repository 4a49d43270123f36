"""``overlap``: the disc cut a wall by more than the motion model's stated tolerance."""

from __future__ import annotations

from fuzz.evidence_checks._cause import check_cause
from fuzz.evidence_checks._plain import cell_box, is_solid_at, step_path
from sim.evidence import WallEvidence
from sim.motion import Motion
from sim.trace import Trace
from worldgen.world import World

__all__ = ["check_overlap"]


def check_overlap(world: World, trace: Trace, evidence: WallEvidence, motion: Motion) -> str:
    """Check that the disc, on the path of the named step, cuts the named solid cell deeply enough.

    If the evidence names the move that let the robot into the wall, check that too.
    """
    step = evidence.step
    cell = evidence.cell
    if not 1 <= step <= trace.steps:
        return f"the run has no step {step}"
    if not is_solid_at(world, *cell, (step - 1) * trace.time_step, step * trace.time_step):
        return f"cell {cell} is not solid in step {step}"
    # The deepest cut along the path, measured with shapely.
    depth = world.robot_radius - float(step_path(trace, step).distance(cell_box(world, *cell)))
    allowed = motion.overlap_tolerance * world.cell_size
    if depth <= allowed - 1e-9:
        return f"the disc cuts cell {cell} by {depth:g} m, but up to {allowed:g} m is allowed"
    return check_cause(world, trace, evidence)
