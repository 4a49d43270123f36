"""Find robots that repeat themselves, each with its own period, and never meet.

The joint state of such robots returns only after the least common multiple of their periods, which
soon exceeds any budget: two loops of 515 and 689 steps take 354,835 steps. But if a robot is never
near enough to another one to touch or sense it, that robot has no effect on it. So each loop
continues forever independently, and the joint state provably returns, although no run is that long.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from sim.outcome import LIMIT, Outcome
from sim.trace import Trace
from sim.verdict import Verdict
from worldgen.support.arrays import Ints, Words

# Number of places of one robot to compare with all places of another at a time.
_PART = 256


@dataclass(frozen=True)
class Loops:
    """The loops of robots that repeat themselves.

    Args:
        entry: Step after which all of them are in their loops.
        periods: Each waiting robot's period, steps, by its index. Robots that come near each other
            have the same period, after which their joint state returns for the first time.
        are_shown: Whether the recording shows that, so that the loops are proved. If not, robots
            with different periods come near each other, and only simulating the joint period can
            decide.
    """

    entry: int
    periods: Mapping[int, int]
    are_shown: bool

    @property
    def joint_period(self) -> int:
        """Steps after which the joint state returns."""
        return math.lcm(*self.periods.values())


def separate_loops(
    members: Sequence[Outcome],
    reaches: Mapping[tuple[int, int], float],
    quiet: int,
    *,
    repeats: int,
) -> Loops | None:
    """Return the loops in which the robots of a recorded run end.

    Args:
        members: Each robot's recorded outcome, except for robots that have parked.
        reaches: Distance, m, beyond which two robots have no effect on each other, by their
            indices, the smaller first.
        quiet: Step of the world's last change; states before it prove nothing.
        repeats: How many periods the recording must show: 1, or 2 if a controller may hide memory.

    Returns:
        The loops; ``None`` if a robot does not repeat itself at the end of its recording.
    """
    # Robots that have parked never change again, so only the others have periods.
    traces = {
        number: one.trace
        for number, one in enumerate(members)
        if one.ending == LIMIT and one.trace is not None
    }
    if not traces:
        return None
    parked = max([quiet, *(one.steps for one in members if one.ending == Verdict.REACHED)])
    # Robots that may influence each other are a group, and only its joint state decides its future:
    # one robot's own state may recur earlier by chance.
    groups = [_Cluster((number,), _labels(trace.states)) for number, trace in traces.items()]
    alone: Loops | None = None
    while True:
        periods = [_period(group.labels, repeats) for group in groups]
        if not all(periods):
            # A group that does not return within the recording may do so later.
            return alone
        of_robot = {
            number: period
            for group, period in zip(groups, periods, strict=True)
            for number in group.numbers
        }
        begins = map(_entry, (group.labels for group in groups), periods)
        entry = max([parked, *begins])
        alone = alone or Loops(entry, of_robot, are_shown=False)

        # Robots that come near each other at any time repeat themselves together, or not at all.
        near = next(
            (
                (one, other)
                for one, other in itertools.combinations(traces, 2)
                if of_robot[one] != of_robot[other]
                and _come_near(traces[one], traces[other], entry, reaches[one, other])
            ),
            None,
        )
        if near is None:
            last = len(groups[0].labels) - 1
            return Loops(entry, of_robot, are_shown=last >= entry + repeats * max(periods))
        groups = _joined(groups, *near)


@dataclass(frozen=True, eq=False)
class _Cluster:
    """Robots that may influence each other.

    Args:
        numbers: Their indices.
        labels: (n + 1,) int64, a number for each of their joint states; equal for equal states.
    """

    numbers: tuple[int, ...]
    labels: Ints


def _joined(groups: Sequence[_Cluster], one: int, other: int) -> list[_Cluster]:
    """Return the groups, with those of two robots made one."""
    both = [group for group in groups if one in group.numbers or other in group.numbers]
    rest = [group for group in groups if group not in both]
    pairs = np.stack([group.labels for group in both], axis=1)
    numbers = tuple(sorted(number for group in both for number in group.numbers))
    return [*rest, _Cluster(numbers, _labels(pairs))]


def _labels(states: Words | Ints) -> Ints:
    """Return a number for each row, (n + 1,), such that equal rows have equal ones."""
    rows = np.ascontiguousarray(states)
    whole = rows.view(np.dtype((np.void, rows.dtype.itemsize * rows.shape[1]))).ravel()
    return np.unique(whole, return_inverse=True)[1].astype(np.int64)


def _period(labels: Ints, repeats: int) -> int:
    """Return the least period that fills the end of a run this many times; 0 if there is none."""
    last = len(labels) - 1
    for step in np.flatnonzero(labels[:-1] == labels[-1])[::-1].tolist():
        period: int = last - step
        first = last - repeats * period
        if first < 0:
            return 0
        if np.array_equal(labels[first : step + 1], labels[first + period :]):
            return period
    return 0


def _entry(labels: Ints, period: int) -> int:
    """Return the first step from which a run repeats itself with a period."""
    differ = np.flatnonzero(labels[:-period] != labels[period:])
    return int(differ[-1]) + 1 if len(differ) else 0


def _come_near(one: Trace, other: Trace, entry: int, reach: float) -> bool:
    """Return True if two robots are never farther apart than ``reach``.

    They count as near even if they are there at different times, because their periods differ.
    """
    first = np.unique(np.stack([one.x[entry:], one.y[entry:]], axis=1), axis=0)
    second = np.unique(np.stack([other.x[entry:], other.y[entry:]], axis=1), axis=0)
    # For most robots that are apart, the boxes around their paths show it.
    gaps = np.maximum(
        first.min(axis=0) - second.max(axis=0), second.min(axis=0) - first.max(axis=0)
    )
    if float(np.hypot(*np.maximum(gaps, 0.0))) > reach:
        return False
    # Compare a part of the places at a time, so that memory stays small.
    for begin in range(0, len(first), _PART):
        apart = first[begin : begin + _PART, np.newaxis] - second
        if bool((np.hypot(apart[..., 0], apart[..., 1]) <= reach).any()):
            return True
    return False
