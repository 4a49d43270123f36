"""Sort failures into buckets that do not change if a world is mirrored, rotated or shifted."""

from __future__ import annotations

import math
from enum import StrEnum

import numpy as np

from fuzz.facts.contacts import KINDS, Contact, contacts, enclosure, part_of, winding_number
from fuzz.facts.crash_bucket import crash_bucket
from sim.episode import Episode
from sim.evidence import (
    BudgetEvidence,
    BurnedEvidence,
    ContactEvidence,
    FaultEvidence,
    JointLoopEvidence,
    LoopEvidence,
    WallEvidence,
)
from sim.outcome import FleetEpisode
from sim.trace import Trace
from sim.verdict import Verdict
from worldgen.support.arrays import Floats
from worldgen.world import World

# Cells by which a limit may be exceeded, so that a mirrored run is on the same side of the limit.
_ROUNDING = 1e-6


def towards_its_goal(world: World, episode: Episode) -> World:
    """Return the world of a single robot's run with the goal that it never reached as the target."""
    reached = episode.goals_reached
    if reached is None:
        return world
    return world.for_goal(min(reached, len(world.robots[0].waypoints)))


def failure_class(world: World, episode: Episode) -> str:
    """Return a short name for the kind of failure, usable as a file name.

    docs/reference/verdicts.md explains its words.

    Args:
        world: World of the run.
        episode: The run, recorded.
    """
    verdict = episode.verdict
    trace = episode.trace
    evidence = episode.evidence
    # Several robots: how they block each other, or what the robot did that ended the run.
    if isinstance(evidence, JointLoopEvidence):
        # Without their number: otherwise shrinking could not drop robots that only wait as well.
        return _joined(verdict, standoff(evidence))
    if isinstance(episode, FleetEpisode):
        number = getattr(evidence, "robot", None)
        if number is not None:
            return failure_class(world.alone(number), episode.robots[number - 1])
    # Faults of the controller itself are described by what it did, not by where it was.
    if isinstance(evidence, FaultEvidence):
        if verdict == Verdict.CRASH:
            return _joined(verdict, crash_bucket(evidence))
        if verdict == Verdict.INVALID_COMMAND:
            return _joined(verdict, evidence.rule)
        return verdict
    if trace is None:
        return verdict
    world = towards_its_goal(world, episode)
    match evidence:
        case WallEvidence() as wall:
            what = verdict if wall.reached is None else "breach"
            return _joined(what, wall.cause, part_of(world, *wall.cell))
        case LoopEvidence(entry=entry, period=period):
            return _joined(verdict, *_of_loop(world, trace, entry, period))
        case BudgetEvidence(kind=kind):
            return _joined(verdict, kind, *_of_second_half(world, trace))
        case ContactEvidence(cell=cell):
            return _joined(verdict, part_of(world, *cell))
        case BurnedEvidence() as burned:
            return _joined(verdict, *_of_fire(world, trace, burned))
    return verdict


def _of_loop(world: World, trace: Trace, entry: int, period: int) -> tuple[str, ...]:
    """Return touches, their kind, the path's shape and extent, and whether it gets closer."""
    last = entry + period
    touched = contacts(world, trace, entry + 1, last)
    cells = {cell for contact in touched for cell in contact.cells}
    side = world.cell_size
    path = slice(entry, last + 1)
    rounds = winding_number(trace.x[path] / side, trace.y[path] / side, cells)
    shape = ("turn" if _turns(trace, entry, last) else "swing", "round", "rounds")[min(rounds, 2)]
    where = _where(world, trace, touched, entry, last)
    return (
        _touches(len(touched)),
        where,
        shape,
        _extent(world, trace, entry, last),
        _progress(world, trace, entry, last),
    )


def _of_second_half(world: World, trace: Trace) -> tuple[str, ...]:
    """Return the contact or the enclosure of the robot in the second half, and its extent."""
    half = trace.steps // 2
    last = trace.steps
    touched = contacts(world, trace, half + 1, last)
    free = "" if touched else "free"
    return free, _where(world, trace, touched, half, last), _extent(world, trace, half, last)


def _of_fire(world: World, trace: Trace, evidence: BurnedEvidence) -> tuple[str, ...]:
    """Return the cell's state, and whether the robot drove into it or was caught by the change."""
    return evidence.state, "entered" if is_entered(world, trace, evidence) else "caught"


def is_entered(world: World, trace: Trace, evidence: BurnedEvidence) -> bool:
    """Return True if the cell was already burning or solid when the robot drove into it."""
    begun = (evidence.step - 1) * trace.time_step + 1e-9
    changes = [*world.timeline.until(begun).in_cell(*evidence.cell)]
    return bool(changes) and changes[-1].state.word == evidence.state


def _joined(*words: object) -> str:
    return "-".join(str(word) for word in words if word)


def _touches(count: int) -> str:
    return ("free", "1bump", "2bump", "bumps")[min(count, 3)]


def _where(world: World, trace: Trace, touched: list[Contact], first: int, last: int) -> str:
    """Return the most specific kind of wall touched.

    If none is, describe how the place nearest to the target is enclosed.
    """
    if touched:
        return min((contact.kind for contact in touched), key=KINDS.index)
    apart = _apart(world, trace)[first : last + 1]
    nearest = first + np.flatnonzero(apart <= apart.min() + _ROUNDING)
    x = trace.x[nearest] / world.cell_size
    y = trace.y[nearest] / world.cell_size
    return enclosure(world, zip(x.tolist(), y.tolist(), strict=True))


def _turns(trace: Trace, first: int, last: int) -> int:
    """Return the whole turns of the heading, without sign, over a period.

    A change by exactly half a turn has no direction and counts as none.
    """
    change = np.diff(trace.heading[first : last + 1])
    wrapped = (change + math.pi) % (2 * math.pi) - math.pi
    wrapped[np.abs(wrapped) > math.pi - _ROUNDING] = 0.0
    return int(abs(float(np.sum(wrapped))) / (2 * math.pi) + _ROUNDING)


def _extent(world: World, trace: Trace, first: int, last: int) -> str:
    x = trace.x[first : last + 1]
    y = trace.y[first : last + 1]
    cells = max(float(np.ptp(x)), float(np.ptp(y))) / world.cell_size
    for name, limit in (("spot", 0.5), ("near", 4.0), ("wide", 16.0)):
        if cells <= limit + _ROUNDING:
            return name
    return "far"


def _progress(world: World, trace: Trace, first: int, last: int) -> str:
    """Return ``closer`` if these steps get nearer to the target than the start, else ``away``."""
    apart = _apart(world, trace)
    return (
        "closer" if float(apart[first : last + 1].min()) < float(apart[0]) - _ROUNDING else "away"
    )


def _apart(world: World, trace: Trace) -> Floats:
    """Return the distance of each state from the target, in cells."""
    dx = (trace.x - world.target.x) / world.cell_size
    dy = (trace.y - world.target.y) / world.cell_size
    apart: Floats = np.sqrt(dx * dx + dy * dy)
    return apart


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
