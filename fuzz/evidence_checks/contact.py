"""``contact``: a wall cut a move short, which the goal forbids."""

from __future__ import annotations

import math

import shapely

from fuzz.evidence_checks._plain import cell_box, is_solid_at, set_speed
from sim.evidence import ContactEvidence
from sim.motion import Motion
from sim.trace import Trace
from worldgen.world import World

_NEAR = 0.02  # cells that a robot may stop before a wall, because its places are rounded
_ROUNDING = 0.002  # the same for the end of the move that was wanted


def check_contact(world: World, trace: Trace, evidence: ContactEvidence, motion: Motion) -> str:
    """Check that the last step ends at the named solid cell, and was to lead into it.

    What slip, a drift or a push did to the move is not recorded; then only the place is checked.
    """
    step = evidence.step
    cell = evidence.cell
    side = world.cell_size
    if world.robots[0].contact != "fail":
        return "the goal does not forbid contact"
    if not 1 <= step == trace.steps:
        return f"the run does not end in step {step}"
    if not trace.bump[step]:
        return f"nothing stopped the robot in step {step}"
    if not is_solid_at(world, *cell, (step - 1) * trace.time_step, step * trace.time_step):
        return f"cell {cell} is not solid in step {step}"
    wall = cell_box(world, *cell)
    gap = float(wall.distance(shapely.Point(trace.x[step], trace.y[step]))) - world.robot_radius
    if motion.name == "swept" and not -1e-9 <= gap <= _NEAR * side:
        return f"the robot stops {gap:g} m away from cell {cell} in step {step}"
    robot = trace.robot
    if robot is not None and (robot.moved or robot.slip > 0.0):
        return ""

    # Where the step was to lead: along the heading before it, at the speed that was set before it.
    x = float(trace.x[step - 1])
    y = float(trace.y[step - 1])
    length = set_speed(world, trace, step - 1) * trace.time_step
    heading = float(trace.heading[step - 1])
    end = (x + length * math.cos(heading), y + length * math.sin(heading))
    wanted = shapely.Point(end) if motion.name != "swept" else shapely.LineString([(x, y), end])
    missed = float(wall.distance(wanted)) - world.robot_radius
    return (
        f"step {step} was to pass cell {cell} by {missed:g} m" if missed > _ROUNDING * side else ""
    )
