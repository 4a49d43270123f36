"""``loop``: the complete state recurred, so the run repeats forever."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from fuzz.evidence_checks._plain import (
    off_goal,
    place_gaps,
    places_gap,
    set_speed,
    step_path,
    target_gap,
)
from sim.evidence import LoopEvidence
from sim.motion import Motion
from sim.trace import Trace
from worldgen.world import World

_HALF_UNIT = 2 * np.pi / 65536  # rad by which the lattice may round a heading and a tolerance
_ROUNDING = 1e-9


def check_loop(world: World, trace: Trace, evidence: LoopEvidence, motion: Motion) -> str:
    """Check that two whole periods are equal, after the last event and away from the target.

    Args:
        world: World of the run.
        trace: A recording up to ``entry + 2 * period`` steps.
        evidence: ``entry``, ``period``, ``state_digest``.
        motion: The motion model.
    """
    entry = evidence.entry
    period = evidence.period
    if entry < 0 or period < 1:
        return f"a loop does not begin after step {entry} with a period of {period} steps"
    if not trace.complete:
        return "the controller has memory that it does not declare, so equal states prove nothing"
    if trace.steps < entry + 2 * period:
        return f"the trace ends at step {trace.steps}, before the second period is complete"
    if entry * _decimal(trace.time_step) < _decimal(world.timeline.last_time):
        return "the world still changes after the loop's entry"
    pushes = trace.robot.pushes[::4] if trace.robot is not None else ()
    if any(entry * _decimal(trace.time_step) < _decimal(time) for time in pushes):
        return "the robot is still pushed after the loop's entry"
    # Equal complete states, step by step, in both periods.
    one = trace.states[entry : entry + period + 1]
    two = trace.states[entry + period : entry + 2 * period + 1]
    if not np.array_equal(one, two):
        return "the second period differs from the first"
    if evidence.state_digest != _digest(trace.states[entry].tolist()):
        return "the state at the entry differs from the evidence"

    # A robot with a coverage task may cross the target any number of times.
    if trace.task == "cover":
        return ""
    if world.target.arrival != "touch" or world.target.heading is not None:
        arrives = _arrives(world, trace, entry, entry + period, motion)
        return "the robot arrives within the loop" if arrives else ""
    # `swept` checks for the target along the path; other models check only the end of a step.
    x = trace.x[entry : entry + period + 1]
    y = trace.y[entry : entry + period + 1]
    gap = places_gap(world, x, y)
    if motion.name == "swept":
        first, last = np.searchsorted(trace.path_step, [entry + 1, entry + period + 1])
        # A robot that stands still has no path, so begin with its place.
        x = np.concatenate([x[:1], trace.path_x[first:last]])
        y = np.concatenate([y[:1], trace.path_y[first:last]])
        gap = target_gap(world, x, y)
    return "the loop passes through the target" if gap < -world.cell_size / 1024 else ""


def _arrives(world: World, trace: Trace, first: int, last: int, motion: Motion) -> bool:
    """Return True if the robot clearly arrives in one of the steps after ``first`` up to ``last``.

    Clearly means that no rounding to the lattice can explain it.
    """
    goal = world.target
    steps = np.arange(first + 1, last + 1)
    inside = place_gaps(world, trace.x[steps], trace.y[steps]) < -world.cell_size / 1024
    before = off_goal(world, trace.heading[steps - 1]) < -_HALF_UNIT
    # A push turns the robot at the end of a step; the heading between both turns is not recorded.
    pushed = trace.robot is not None and bool(trace.robot.push_places)
    if goal.arrival == "stop":
        speeds = np.array([abs(set_speed(world, trace, int(step))) for step in steps[inside]])
        turns = np.diff(trace.heading[first : last + 1])[inside]
        turns = np.abs((turns + np.pi) % (2 * np.pi) - np.pi)
        stands = (speeds < goal.arrival_speed * (1 - _ROUNDING)) & (
            turns < goal.arrival_turn_rate * trace.time_step - _ROUNDING
        )
        after = off_goal(world, trace.heading[steps[inside]]) < -_HALF_UNIT
        return not pushed and bool((stands & after).any())
    if pushed and goal.heading is not None:
        return False
    if goal.arrival == "step" or motion.name != "swept":
        return bool((inside & before).any())
    # Only the paths of steps with the right heading count.
    paths = (step_path(trace, int(step)).xy for step in steps[before])
    gaps = [target_gap(world, np.array(x), np.array(y)) for x, y in paths]
    return min(gaps, default=0.0) < -world.cell_size / 1024


def _decimal(value: float) -> Fraction:
    """Return the number that the shortest decimal notation of a float denotes."""
    return Fraction(repr(value))


def _digest(words: list[int]) -> str:
    value = 1469598103934665603
    for word in words:
        value = (value ^ word) * 1099511628211 % 2**64
    return f"{value:016x}"
