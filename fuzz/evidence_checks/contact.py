"""``contact``: a wall cut a move short, which the goal forbids."""

from __future__ import annotations

import math

import numpy as np
import shapely

from fuzz.evidence_checks._plain import cell_box, convex_gap, corners_at, is_solid_at, set_speed
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
    if not world.robots[0].is_disc:
        return _check_body(world, trace, step, cell, motion)
    gap = float(wall.distance(shapely.Point(trace.x[step], trace.y[step]))) - world.robot_radius
    if motion.name == "swept" and not -1e-9 <= gap <= _NEAR * side:
        return f"the robot stops {gap:g} m away from cell {cell} in step {step}"
    robot = trace.robot
    is_car = world.robots[0].drive.is_car  # its arc is not recorded, only what it drove of it
    if is_car or (robot is not None and (robot.moved or robot.slip > 0.0)):
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


def _check_body(
    world: World, trace: Trace, step: int, cell: tuple[int, int], motion: Motion
) -> str:
    """Check the place where a body stops, and that its move or its turn was to lead into the cell."""
    side = world.cell_size
    wall = cell_box(world, *cell)
    here = (float(trace.x[step]), float(trace.y[step]), float(trace.heading[step]))
    # Corners are rounded to 1/1024 of a cell, and a turn stops at a heading of the simulator.
    slack = side / 1024
    least_turn = 2.0 * math.pi / 65_536
    near = _NEAR * side + slack + world.robot_radius * least_turn
    gap = convex_gap(corners_at(world, *here), wall)
    if motion.name == "swept" and not -slack <= gap <= near:
        return f"the body stops {gap:g} m away from cell {cell} in step {step}"
    robot = trace.robot
    if world.robots[0].drive.is_car or (robot is not None and (robot.moved or robot.slip > 0.0)):
        return ""

    # A turn that is refused under `endpoint` is not recorded, nor how far it was to go.
    before = (float(trace.x[step - 1]), float(trace.y[step - 1]), float(trace.heading[step - 1]))
    length = set_speed(world, trace, step - 1) * trace.time_step
    end = (
        before[0] + length * math.cos(before[2]),
        before[1] + length * math.sin(before[2]),
        before[2],
    )
    if motion.name != "swept":
        is_moved = math.hypot(here[0] - before[0], here[1] - before[1]) > 0.5 * abs(length)
        missed = -math.inf if is_moved else convex_gap(corners_at(world, *end), wall)
        is_turn = is_moved or abs(length) < slack
        return "" if is_turn or missed <= slack else f"step {step} was to pass cell {cell}"
    swept = np.concatenate([corners_at(world, *before), corners_at(world, *end)])
    turned = [corners_at(world, *here[:2], here[2] + k * least_turn) for k in (-2, 2)]
    missed = min(convex_gap(points, wall) for points in (swept, *turned))
    return f"step {step} was to pass cell {cell} by {missed:g} m" if missed > slack else ""
