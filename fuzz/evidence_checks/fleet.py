"""Check the evidence of a run of several robots, with each robot's recording."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np
import shapely

from fuzz.evidence_checks._plain import (
    check_budget,
    first_new_cell_of_second_half,
    places_gap,
    step_path,
    target_gap,
)
from fuzz.evidence_checks.burned import check_burned
from fuzz.evidence_checks.walls import check_overlap, check_tunnel
from sim.evidence import (
    BudgetEvidence,
    BurnedEvidence,
    CollisionEvidence,
    Evidence,
    JointLoopEvidence,
    WallEvidence,
)
from sim.motion import Motion
from sim.trace import Trace
from sim.verdict import Verdict
from worldgen.support.arrays import Floats
from worldgen.world import Robot, World

# Cells: start and target are rounded to the pose lattice, 1/1024 of a cell each.
_LATTICE = 2 / 1024


def check_fleet(
    world: World, traces: Sequence[Trace], verdict: Verdict, evidence: Evidence, motion: Motion
) -> str:
    """Return the reason why a verdict on several robots does not hold; empty if it holds.

    Args:
        world: World of the run.
        traces: Each robot's recording; for a joint loop they include a second period.
        verdict: The claim.
        evidence: Its evidence.
        motion: The motion model, which states how much overlap is tolerated.
    """
    if motion.name == "swept" and (wrong := _check_apart(world, traces)):
        return wrong
    match evidence:
        case JointLoopEvidence():
            return _check_joint_loop(world, traces, evidence, verdict, motion)
        case CollisionEvidence():
            return _check_collision(world, traces, evidence)
        case BudgetEvidence():
            return _check_fleet_budget(world, traces, evidence, verdict)
        case WallEvidence(robot=int(number)):
            check = check_tunnel if verdict == Verdict.TUNNEL else check_overlap
            return check(world.alone(number), traces[number - 1], evidence, motion)
        case BurnedEvidence(robot=int(number)):
            return check_burned(world.alone(number), traces[number - 1], evidence, motion)
    return ""


def _check_joint_loop(
    world: World,
    traces: Sequence[Trace],
    evidence: JointLoopEvidence,
    verdict: Verdict,
    motion: Motion,
) -> str:
    """Check that all robots that wait repeat themselves in step, and that the others have parked.

    Args:
        world: World of the run.
        traces: Each robot's recording; for a waiting robot, until two of its periods have passed.
        evidence: The claim.
        verdict: ``deadlock``, ``livelock`` or ``starved``.
        motion: The motion model.
    """
    entry = evidence.entry
    period = evidence.period
    robots = world.robots
    if entry < 0 or period < 1:
        return f"a loop does not begin after step {entry} with a period of {period} steps"
    parked = dict(evidence.parked)
    if sorted([*evidence.waiting, *parked]) != list(range(1, len(robots) + 1)):
        return "some robot is neither waiting nor arrived"
    time_step = Fraction(repr(traces[0].time_step))
    if entry * time_step < Fraction(repr(world.timeline.last_time)):
        return "the world still changes after the loop's entry"

    # Robots with different periods never come near each other, and return together.
    own = dict(evidence.periods or [(number, period) for number in evidence.waiting])
    if evidence.periods and (wrong := _check_separate(world, traces, evidence, own)):
        return wrong

    # Robots that have arrived stay where they are, in their targets.
    for number, step in parked.items():
        trace = traces[number - 1]
        if step > entry or trace.steps != step:
            return f"robot {number} arrives in step {trace.steps}, not in step {step}"
        if _gap(robots[number - 1], trace, step) > _LATTICE * world.cell_size:
            return f"robot {number} has not arrived in step {step}"

    # A robot that is claimed to block another must come as near to it as their last steps could
    # bring them.
    for one, other in evidence.blocked:
        if one not in evidence.waiting or not 1 <= other <= len(robots) or one == other:
            return f"robot {one} cannot be blocked by robot {other}"
        last = entry + max(own.values())
        apart = _least_apart(traces[one - 1], traces[other - 1], entry, last)
        first = robots[one - 1]
        second = robots[other - 1]
        reach = first.radius + second.radius + (first.speed + second.speed) * float(time_step)
        if apart > reach + _LATTICE * world.cell_size:
            return f"robots {one} and {other} stay {apart:g} m apart and cannot block each other"

    # All others must do the same in two periods, at the same times.
    moving = []
    for number in evidence.waiting:
        wrong = _check_period(world.alone(number), traces[number - 1], entry, own[number], motion)
        if wrong:
            return f"robot {number}: {wrong}"
        trace = traces[number - 1]
        first, last = np.searchsorted(trace.path_step, [entry + 1, entry + own[number] + 1])
        places = np.stack([trace.path_x[first:last], trace.path_y[first:last]], axis=1)
        if len(places) and (places != [trace.x[entry], trace.y[entry]]).any():
            moving.append(number)
    if wrong := _check_first_return(traces, entry, own):
        return wrong
    if tuple(moving) != evidence.moving:
        return f"robots {moving} move within the period, not {list(evidence.moving)}"
    wanted = Verdict.LIVELOCK if moving else Verdict.DEADLOCK
    if len(evidence.waiting) == 1:
        wanted = Verdict.STARVED
    return "" if verdict == wanted else f"this is {wanted}, not {verdict}"


def _check_separate(
    world: World, traces: Sequence[Trace], evidence: JointLoopEvidence, own: dict[int, int]
) -> str:
    """Check that the robots whose periods differ can neither touch nor sense each other."""
    if sorted(own) != sorted(evidence.waiting) or min(own.values()) < 1:
        return "the robots with a period are not the waiting ones"
    if math.lcm(*own.values()) != evidence.period:
        return f"the robots do not all return to their states after {evidence.period} steps"
    for one, other in itertools.combinations(own, 2):
        if own[one] == own[other]:
            continue
        # Compare all places of one robot with all places of the other, at any time.
        first = traces[one - 1]
        second = traces[other - 1]
        apart = _places_of(first, evidence.entry).distance(_places_of(second, evidence.entry))
        radii = world.robots[one - 1].radius + world.robots[other - 1].radius
        speeds = world.robots[one - 1].speed + world.robots[other - 1].speed
        reach = radii + speeds * first.time_step
        for number, trace in ((one, first), (other, second)):
            sensed = max(_ranges_of(trace)) + world.robots[number - 1].radius
            reach = max(reach, sensed)
        if apart <= reach:
            return f"robots {one} and {other} come within {apart:g} m, and have different periods"
    return ""


def _check_first_return(traces: Sequence[Trace], entry: int, own: dict[int, int]) -> str:
    """Check that the robots of each period do not return together before its end."""
    for period in sorted({*own.values()}):
        numbers = [number for number in own if own[number] == period]
        returned = np.ones(period - 1, np.bool_)
        for number in numbers:
            states = traces[number - 1].states
            returned &= (states[entry + 1 : entry + period] == states[entry]).all(axis=1)
        if returned.any():
            steps = int(np.argmax(returned)) + 1
            return f"robots {numbers} return to their states after {steps} steps, not {period}"
    return ""


def _places_of(trace: Trace, entry: int) -> shapely.MultiPoint:
    """Return where a robot's steps end, beginning with a step."""
    return shapely.MultiPoint(np.stack([trace.x[entry:], trace.y[entry:]], axis=1))


def _ranges_of(trace: Trace) -> tuple[float, float]:
    """Return the ranges at which a robot senses others, m: as neighbours, and by beams."""
    robot = trace.robot
    if robot is None:
        return (0.0, 0.0)
    return (robot.neighbour_range, robot.beam_range if robot.beams else 0.0)


def _check_period(world: World, trace: Trace, entry: int, period: int, motion: Motion) -> str:
    """Check that two whole periods of one robot are equal, and that it never arrives in them."""
    if not trace.complete:
        return "the controller has memory that it does not declare, so equal states prove nothing"
    if trace.steps < entry + 2 * period:
        return f"the trace ends at step {trace.steps}, before the second period is complete"
    one = trace.states[entry : entry + period + 1]
    two = trace.states[entry + period : entry + 2 * period + 1]
    if not np.array_equal(one, two):
        return "the second period differs from the first"
    # `swept` checks for the target along the path; other models check only the end of a step.
    gap = places_gap(
        world, trace.x[entry : entry + period + 1], trace.y[entry : entry + period + 1]
    )
    if motion.name == "swept":
        first, last = np.searchsorted(trace.path_step, [entry + 1, entry + period + 1])
        x = np.concatenate([trace.x[entry : entry + 1], trace.path_x[first:last]])
        y = np.concatenate([trace.y[entry : entry + 1], trace.path_y[first:last]])
        gap = target_gap(world, x, y)
    return "the loop passes through the target" if gap < -_LATTICE * world.cell_size else ""


def _check_collision(world: World, traces: Sequence[Trace], evidence: CollisionEvidence) -> str:
    """Check that two robots come closer in a step than their radii allow."""
    one, other = evidence.robots
    first = traces[one - 1]
    second = traces[other - 1]
    robots = world.robots
    together = robots[one - 1].radius + robots[other - 1].radius
    nearest = _nearest(first, second, evidence.step)
    if nearest < together:
        return ""
    return f"robots {one} and {other} stay {nearest:g} m apart in step {evidence.step}"


def _check_fleet_budget(
    world: World, traces: Sequence[Trace], evidence: BudgetEvidence, verdict: Verdict
) -> str:
    """Check the budget, and whether a robot enters a new cell in its second half."""
    longest = max(traces, key=lambda trace: trace.steps)
    half = longest.steps // 2
    fresh = [
        number
        for number, trace in enumerate(traces, start=1)
        if first_new_cell_of_second_half(world.alone(number), trace, half)
    ]
    if verdict == Verdict.STALLED and fresh:
        return f"robot {fresh[0]} still enters new cells in the second half"
    if verdict == Verdict.TIMEOUT and not fresh:
        return "the second half has no new cell"
    return check_budget(world, longest, evidence)


def _check_apart(world: World, traces: Sequence[Trace]) -> str:
    """Check that no two robots overlap at the end of a step; one that has arrived stays there."""
    robots = world.robots
    steps = max(trace.steps for trace in traces)
    for one, other in itertools.combinations(range(len(robots)), 2):
        dx = _held(traces[one].x, steps) - _held(traces[other].x, steps)
        dy = _held(traces[one].y, steps) - _held(traces[other].y, steps)
        gap = np.hypot(dx, dy) - robots[one].radius - robots[other].radius
        step = int(np.argmin(gap))
        if gap[step] < -_LATTICE * world.cell_size:
            return f"robots {one + 1} and {other + 1} overlap by {-gap[step]:g} m in step {step}"
    return ""


def _least_apart(first: Trace, second: Trace, begin: int, end: int) -> float:
    """Return the smallest distance, m, of two robots at the ends of a range of steps."""
    dx = _held(first.x, end)[begin : end + 1] - _held(second.x, end)[begin : end + 1]
    dy = _held(first.y, end)[begin : end + 1] - _held(second.y, end)[begin : end + 1]
    return float(np.hypot(dx, dy).min())


def _held(places: Floats, steps: int) -> Floats:
    """Return places for this many steps; the last one is repeated."""
    missing = max(steps + 1 - len(places), 0)
    return np.concatenate([places, np.repeat(places[-1:], missing)])


def _gap(robot: Robot, trace: Trace, step: int) -> float:
    """Return the distance, m, from the path of a step to a robot's target; negative inside."""
    target = shapely.Point(robot.target.x, robot.target.y)
    return float(step_path(trace, step).distance(target)) - robot.target.radius


def _nearest(first: Trace, second: Trace, step: int) -> float:
    """Return the smallest distance, m, of two robots in a step in which each drives straight."""
    ends = []
    for trace in (first, second):
        begin = min(step - 1, trace.steps)
        end = min(step, trace.steps)
        ends.append((trace.x[begin], trace.y[begin], trace.x[end], trace.y[end]))
    (ax, ay, bx, by), (cx, cy, dx, dy) = ends
    relative = shapely.LineString([(cx - ax, cy - ay), (dx - bx, dy - by)])
    return float(relative.distance(shapely.Point(0.0, 0.0)))
