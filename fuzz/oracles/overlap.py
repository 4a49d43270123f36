"""``overlap``: the disc cut a wall by more than the motion model's stated tolerance."""

from __future__ import annotations

from collections.abc import Mapping

from fuzz.oracles._cause import object_to_cause
from fuzz.oracles._plain import cell_box, cell_of, integer, is_solid_at, step_path
from sim.motion import Motion
from sim.trace import Trace
from worldgen.world import Value, World

__all__ = ["object_to_overlap"]


def object_to_overlap(world: World, trace: Trace, evidence: Mapping[str, Value], motion: Motion) -> str:
    """Objects unless the disc, along the path of the named step, cuts the named solid cell deeply enough.

    Where the evidence names the move that let the robot into the wall, that is judged too.
    """
    step, cell = integer(evidence, "step"), cell_of(evidence)
    if not 1 <= step <= trace.steps or cell is None:
        return "the evidence names no step and cell of this run"
    if not is_solid_at(world, *cell, (step - 1) * trace.time_step, step * trace.time_step):
        return f"cell {cell} is not solid in step {step}"
    depth = world.robot_radius - float(step_path(trace, step).distance(cell_box(world, *cell)))
    allowed = motion.overlap_tolerance * world.cell_size
    if depth <= allowed - 1e-9:
        return f"the disc cuts cell {cell} by {depth:g} m, allowed are {allowed:g} m"
    return object_to_cause(world, trace, evidence)
