"""``burned``: flames or falling debris hit the robot."""

from __future__ import annotations

from fuzz.evidence_checks._plain import step_gap
from sim.evidence import BurnedEvidence
from sim.motion import Motion
from sim.trace import Trace
from worldgen.timeline import CellState
from worldgen.world import World


def check_burned(world: World, trace: Trace, evidence: BurnedEvidence, motion: Motion) -> str:
    """Check that the named cell is in the named state and within the robot's radius."""
    step = evidence.step
    cell = evidence.cell
    state = evidence.state
    if not 1 <= step <= trace.steps:
        return f"the run has no step {step}"
    known = [*world.timeline.until(step * trace.time_step + 1e-9).in_cell(*cell)]
    if not known or known[-1].state.word != state or known[-1].state == CellState.FREE:
        return f"cell {cell} is not {state} in step {step}"
    # Some motion models move the robot exactly to the event; only the path after it counts.
    since = known[-1].time / trace.time_step - (step - 1) if motion.exact_events else 0.0
    gap = step_gap(world, trace, step, cell, max(since, 0.0))
    # The corners of a body are rounded to 1/1024 of a cell.
    is_disc = world.robots[0].is_disc
    slack = world.robot_radius * 1e-9 if is_disc else world.cell_size / 1024
    return f"the robot stays {gap:g} m away from cell {cell} in step {step}" if gap > slack else ""
