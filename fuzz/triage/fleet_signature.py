"""Describe how robots keep each other from arriving, from which robot drives into which."""

from __future__ import annotations

from enum import StrEnum

from sim.evidence import JointLoopEvidence

__all__ = ["Standoff", "standoff"]


class Standoff(StrEnum):
    """How robots that repeat themselves forever block each other."""

    FACE_TO_FACE = "face-to-face"
    CIRCULAR_WAIT = "circular-wait"
    BEHIND_PARKED = "behind-parked"
    QUEUE = "queue"
    OSCILLATION = "oscillation"
    APART = "apart"


def standoff(evidence: JointLoopEvidence) -> Standoff:
    """Return how the robots of a joint loop block each other.

    Two robots that drive into each other are *face to face*; three or more, each of which drives
    into the next, are in a *circular wait*. A robot can also be stopped by a robot that has
    *parked*, or *queue* behind one that walls hold back. Robots that move and never touch
    *oscillate*; those that stand or circle without touching anyone are *apart*.
    """
    drives_into: dict[int, set[int]] = {}
    for robot, other in evidence.blocked:
        drives_into.setdefault(robot, set()).add(other)
    if any(robot in drives_into.get(other, ()) for robot, other in evidence.blocked):
        return Standoff.FACE_TO_FACE
    if any(robot in _reached_from(robot, drives_into) for robot in drives_into):
        return Standoff.CIRCULAR_WAIT
    parked = {number for number, _ in evidence.parked}
    if any(others & parked for others in drives_into.values()):
        return Standoff.BEHIND_PARKED
    if drives_into:
        return Standoff.QUEUE
    if evidence.periods and len({period for _, period in evidence.periods}) == len(
        evidence.periods
    ):
        return Standoff.APART
    return Standoff.OSCILLATION if len(evidence.moving) > 1 else Standoff.APART


def _reached_from(robot: int, drives_into: dict[int, set[int]]) -> set[int]:
    """Return all robots that can be reached from one by following who drives into whom."""
    found: set[int] = set()
    waiting = [*drives_into.get(robot, ())]
    while waiting:
        other = waiting.pop()
        if other not in found:
            found.add(other)
            waiting += drives_into.get(other, ())
    return found
