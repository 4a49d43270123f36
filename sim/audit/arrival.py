"""Find out when a recorded robot arrived, by the rules of the world's goals."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from sim.audit.path import AuditPath, shorter_turn
from worldgen.support.arrays import Bools, Indices
from worldgen.world import Target

# Share by which the target may be larger, and angle, rad, because recorded numbers are rounded.
_ROUNDING = 1e-9


def arrival_times(goals: Sequence[Target], way: AuditPath, *, is_plan: bool) -> list[float]:
    """Return the times when the robot first arrived at its goals, in order, s.

    A goal counts from the sample after the arrival at the one before. The list ends before the
    first goal that it never arrived at.
    """
    times: list[float] = []
    after = -1
    for number, goal in enumerate(goals):
        is_last = number == len(goals) - 1
        arrived = _arrival(goal, way, after, is_plan=is_plan, is_last=is_last)
        if arrived is None:
            break
        time, row = arrived
        times.append(time)
        # It is the next goal's turn from the next recorded sample on.
        after = int(way.samples[min(int(np.searchsorted(way.samples, row)), len(way.samples) - 1)])
    return times


def _arrival(
    target: Target, way: AuditPath, after: int, *, is_plan: bool, is_last: bool
) -> tuple[float, int] | None:
    """Return the time of the first arrival at one goal, s, and the row of the path that ends it.

    A robot that has to stand must be slow on the way to the next sample; after the last sample,
    nothing is known. A plan is assumed to stop at its last pose, and at waypoints that ask for it.

    Args:
        target: The goal.
        way: The path.
        after: Row of the path at which the goal before was reached; -1 if there is none.
        is_plan: Whether it is a plan, without times.
        is_last: Whether the goal is the last one.
    """
    if target.arrival == "touch":
        return _touch(target, way, max(after, 0))
    rows = way.samples
    there = _in_target(target, way, rows) & (rows > after)
    if target.arrival == "stop" and is_plan:
        there[:-1] &= not is_last
    elif target.arrival == "stop":
        there = there[:-1] & _stands(target, way)
    arrived = np.flatnonzero(there)
    if not len(arrived):
        return None
    row = int(rows[arrived[0]])
    return float(way.times[row]), row


def ends_in_target(target: Target, way: AuditPath) -> bool:
    """Return True if the last sample is in the target, at a heading that the goal allows."""
    return bool(_in_target(target, way, way.samples[-1:])[0])


def _in_target(target: Target, way: AuditPath, rows: Indices) -> Bools:
    gap = np.hypot(way.metres[0][rows] - target.x, way.metres[1][rows] - target.y)
    return (gap <= target.radius * (1.0 + _ROUNDING)) & _aims(target, way)[rows]


def _aims(target: Target, way: AuditPath) -> Bools:
    """Return where the heading is one that the goal allows; unknown headings are not."""
    if target.heading is None:
        return np.ones(len(way.times), np.bool_)
    if way.headings is None:
        return np.zeros(len(way.times), np.bool_)
    off = np.abs(shorter_turn(way.headings - target.heading))
    aims: Bools = off <= target.heading_tolerance + _ROUNDING
    return aims


def _stands(target: Target, way: AuditPath) -> Bools:
    """Return for each move between recorded samples if it is as slow as the goal asks."""
    lasts = np.diff(way.times[way.samples])
    slow = way.lengths <= target.arrival_speed * lasts + _ROUNDING
    if way.headings is not None:
        turn = np.abs(shorter_turn(np.diff(way.headings[way.samples])))
        slow &= turn <= target.arrival_turn_rate * lasts + _ROUNDING
    stands: Bools = slow & (lasts > 0.0)
    return stands


def _touch(target: Target, way: AuditPath, first: int) -> tuple[float, int] | None:
    """Return when the centre first is in the target's disc at an allowed heading.

    Args:
        target: The goal.
        way: The path.
        first: Row of the path from which on it counts.

    Returns:
        The time, s, and the row that ends the move.
    """
    # Find the first move that comes within the target's radius.
    x = way.metres[0] - target.x
    y = way.metres[1] - target.y
    ax = x[:-1]
    ay = y[:-1]
    dx = np.diff(x)
    dy = np.diff(y)
    square = dx * dx + dy * dy
    share = np.clip(-(ax * dx + ay * dy) / np.where(square > 0.0, square, 1.0), 0.0, 1.0)
    gap = np.hypot(ax + share * dx, ay + share * dy)
    aims = _aims(target, way)
    is_near = gap <= target.radius * (1.0 + _ROUNDING)
    is_near[:first] = False
    inside = np.flatnonzero(is_near & (aims[:-1] | aims[1:]))
    if not len(inside):
        return None

    # Solve for the fraction of that move at which the centre enters the disc.
    row = int(inside[0])
    enter = float(share[row])
    along = math.sqrt(square[row])
    if math.hypot(ax[row], ay[row]) <= target.radius:
        enter = 0.0
    elif along > 0.0:
        across = (ax[row] * dy[row] - ay[row] * dx[row]) / along
        half = math.sqrt(max(target.radius**2 - across * across, 0.0))
        enter = max(-(ax[row] * dx[row] + ay[row] * dy[row]) / along - half, 0.0) / along
    begin = float(way.times[row])
    end = float(way.times[row + 1])
    return begin + min(enter, 1.0) * (end - begin), row + 1
