"""Waypoints of a run: the robot arrived at each that it claims, in order."""

from __future__ import annotations

import numpy as np

from fuzz.evidence_checks._plain import off_goal, place_gaps, set_speed, step_path, target_gap
from sim.trace import Trace
from worldgen.support.arrays import Floats
from worldgen.world import World

_HALF_UNIT = np.pi / 65536 + 1e-9  # rad by which the lattice rounds a heading
_ROUNDING = 1e-9


def check_waypoints(world: World, trace: Trace) -> str:
    """Check that the robot arrived at each waypoint that the trace counts, and at one a step.

    The tolerance of a place is 1/1024 of a cell, as for the target.
    """
    passed = trace.passed
    counts = np.diff(passed)
    if len(passed) != trace.steps + 1 or passed[0] != 0 or not np.isin(counts, (0, 1)).all():
        return "the waypoints are not counted one by one"
    for number, step in enumerate((np.flatnonzero(counts) + 1).tolist()):
        fault = _arrival_fault(world.for_goal(number), trace, step)
        if fault:
            return f"waypoint {number + 1} is counted in step {step}, but {fault}"
    return ""


def _arrival_fault(world: World, trace: Trace, step: int) -> str:
    """Return why the robot did not arrive at the target in a step; empty if it did."""
    goal = world.target
    if goal.arrival == "touch":
        x, y = step_path(trace, step).xy
        gap = target_gap(world, np.array(x), np.array(y))
    else:
        gap = float(place_gaps(world, trace.x[step : step + 1], trace.y[step : step + 1])[0])
    if gap > world.cell_size / 1024:
        return f"the robot is {gap:g} m away from it"
    # A push turns the robot in the middle of what is recorded.
    is_pushed = trace.robot is not None and bool(trace.robot.pushes or trace.robot.push_places)
    if not is_pushed and float(off_goal(world, _headings(world, trace, step)).min()) > _HALF_UNIT:
        return "the robot has another heading"
    if goal.arrival != "stop":
        return ""
    if abs(set_speed(world, trace, step)) > goal.arrival_speed * (1.0 + _ROUNDING):
        return "the robot does not stand"
    turn = float(np.remainder(np.diff(trace.heading[step - 1 : step + 1])[0] + np.pi, 2 * np.pi))
    most = goal.arrival_turn_rate * trace.time_step + _ROUNDING
    return "" if is_pushed or abs(turn - np.pi) <= most else "the robot turns"


def _headings(world: World, trace: Trace, step: int) -> Floats:
    """Return the headings that count in a step: on the way, at its end, or once it has acted."""
    arrival = world.target.arrival
    # A car turns while it drives, any other robot when its controller has acted.
    if arrival == "stop" or (arrival == "step" and world.robots[0].drive.is_car):
        return trace.heading[step : step + 1]
    before = trace.heading[step - 1 : step]
    if arrival == "step" or not len(trace.path_heading):
        return before
    first, last = np.searchsorted(trace.path_step, [step, step + 1])
    return np.concatenate([before, trace.path_heading[first:last]])
