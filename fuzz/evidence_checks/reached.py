"""``reached``: the centre entered the target."""

from __future__ import annotations

import shapely

from fuzz.evidence_checks._plain import lattice_cell, step_path
from sim.evidence import ReachedEvidence
from sim.motion import Motion
from sim.trace import Trace
from worldgen.world import World


def check_reached(world: World, trace: Trace, evidence: ReachedEvidence, motion: Motion) -> str:
    """Check that the last step touches the target's disc or, for the thesis's robot, its cell.

    The tolerance is 1/1024 of a cell, because the pose lattice rounds both start and target.
    """
    side = world.cell_size
    if not motion.on_lattice:
        here, there = (
            (int(lattice_cell(x / side)), int(lattice_cell(y / side)))
            for x, y in ((trace.x[-1], trace.y[-1]), (world.target.x, world.target.y))
        )
        return "" if here == there else f"the run ends in cell {here}, the target is in {there}"
    last = step_path(trace, trace.steps)
    gap = float(last.distance(shapely.Point(world.target.x, world.target.y))) - world.target.radius
    return "" if gap <= side / 1024 else f"the last step ends {gap:g} m away from the target"
