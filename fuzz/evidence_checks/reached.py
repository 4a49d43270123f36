"""``reached``: the robot arrived as its goal asks."""

from __future__ import annotations

import math

import numpy as np

from fuzz.evidence_checks._plain import (
    lattice_cell,
    off_goal,
    place_gaps,
    set_speed,
    step_path,
    target_gap,
)
from sim.evidence import ReachedEvidence
from sim.motion import Motion
from sim.trace import Trace
from worldgen.world import World

_HALF_UNIT = math.pi / 65536 + 1e-9  # rad by which the lattice rounds a heading
_ROUNDING = 1e-9


def check_reached(world: World, trace: Trace, evidence: ReachedEvidence, motion: Motion) -> str:
    """Check that the robot has arrived after the last step.

    It must be in the target's disc as the goal asks; the thesis's robot, in the target's cell.

    The tolerance is 1/1024 of a cell, because the pose lattice rounds both start and target.
    """
    side = world.cell_size
    if not motion.on_lattice:
        here, there = (
            (int(lattice_cell(x / side)), int(lattice_cell(y / side)))
            for x, y in ((trace.x[-1], trace.y[-1]), (world.target.x, world.target.y))
        )
        return "" if here == there else f"the run ends in cell {here}, the target is in {there}"
    # The place, and the heading: a run that arrives ends before the controller turns again.
    arrival = world.target.arrival
    if arrival == "touch":
        x, y = step_path(trace, trace.steps).xy
        gap = target_gap(world, np.array(x), np.array(y))
    else:
        gap = float(place_gaps(world, trace.x[-1:], trace.y[-1:])[0])
    if gap > side / 1024:
        return f"the last step ends {gap:g} m away from the target"
    off = float(off_goal(world, trace.heading[-1:])[0])
    if off > _HALF_UNIT:
        return f"the robot's heading exceeds the goal's tolerance by {off:g} rad"
    return _check_stop(world, trace) if arrival == "stop" else ""


def _check_stop(world: World, trace: Trace) -> str:
    """Check that the robot hardly moves or turns at the end."""
    goal = world.target
    speed = abs(set_speed(world, trace, trace.steps))
    if speed > goal.arrival_speed * (1.0 + _ROUNDING):
        return f"the robot drives at {speed:g} m/s at the end"
    # A push in that step may have turned the robot, too.
    if trace.robot is not None and (trace.robot.pushes or trace.robot.push_places):
        return ""
    turn = abs(
        float(np.remainder(trace.heading[-1] - trace.heading[-2] + np.pi, 2 * np.pi) - np.pi)
    )
    if turn > goal.arrival_turn_rate * trace.time_step + _ROUNDING:
        return f"the robot turns at {turn / trace.time_step:g} rad/s at the end"
    return ""
