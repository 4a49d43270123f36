"""``loop``: the complete state recurred, so the run repeats forever."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from fuzz.evidence_checks._plain import places_gap, target_gap
from sim.evidence import LoopEvidence
from sim.motion import Motion
from sim.trace import Trace
from worldgen.world import World


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


def _decimal(value: float) -> Fraction:
    """Return the number that the shortest decimal notation of a float denotes."""
    return Fraction(repr(value))


def _digest(words: list[int]) -> str:
    value = 1469598103934665603
    for word in words:
        value = (value ^ word) * 1099511628211 % 2**64
    return f"{value:016x}"
