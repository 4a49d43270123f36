"""Decide a failure's cause from its run.

The rules are a list, and the first that applies decides. Each examines the repeated part, or the
move that ended the run, but never its place in the world. ``python -m benchmarks.causes`` measures
how well they distinguish seeded faults.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fuzz.facts.changed_worlds import OtherWorlds, fails_by_timing, needs_a_wider_gap
from fuzz.facts.hazards import Hazard, hazard_in
from fuzz.facts.signature import Standoff, is_entered, standoff
from fuzz.failure import Failure
from fuzz.triage.behaviour import RepeatedPart, behaviour_of
from fuzz.triage.cause import Cause
from sim.episode import Episode
from sim.evidence import (
    BudgetEvidence,
    BurnedEvidence,
    JointLoopEvidence,
    LoopEvidence,
    WallEvidence,
)
from sim.fleet import FleetEpisode
from sim.runners.stopping import OutOfTime
from sim.verdict import OUT_OF_BUDGET, Verdict
from worldgen.errors import WorldgenError
from worldgen.world import World

CAUSE = "cause"
"""Name of the detail of a failure's record that holds its cause."""

# Cells. A robot that stays within half a cell counts as standing at one place, however it moves
# there.
_ONE_PLACE = 0.5

# Turns per step, on average. A controller that turns by more than 70 degrees in nearly every step
# follows nothing; wall followers stay below 0.15 even around posts.
_RESTLESS = 0.2

# Turns per step, on average, above which a robot that never drives does not stand still either.
_TURNS_AT_ALL = 0.001

# Share of steps that turn the robot around. One that reverses at the ends of a longer path stays
# below it.
_OFTEN_AROUND = 0.1

# Cells between two touches. A wall follower touches its wall at least once per cell,
# even at corners.
_ALONG = 1.0

# Cells from the edges of robot and target: the closest it gets, and the farthest away it ever is.
_CLOSE = 1.0
_NEARBY = 3.0

# Share of steps that touch a wall below which walls are not what holds the robot back.
_RARELY = 0.02

# Share of steps above which a wall holds the robot: neither the target nor its own turns do.
_MOSTLY = 0.5

_BY_VERDICT: dict[str, Cause] = {
    Verdict.COLLISION: Cause.COLLIDES,
    Verdict.CRASH: Cause.CRASHES,
    Verdict.HANG: Cause.GIVES_NO_ANSWER,
    Verdict.INVALID_COMMAND: Cause.INVALID_COMMAND,
    Verdict.TIMEOUT: Cause.WANDERS,
}

CAUSE_OF_HAZARD = {Hazard.UNSENSED: Cause.HARMED_UNSENSED, Hazard.DISTURBED: Cause.PUSHED_TOO_HARD}
"""The causes of failures that are not the controller's fault."""

_BY_STANDOFF = {
    Standoff.FACE_TO_FACE: Cause.FACE_TO_FACE,
    Standoff.CIRCULAR_WAIT: Cause.WAITS_IN_A_CIRCLE,
    Standoff.BEHIND_PARKED: Cause.BLOCKED_BY_PARKED,
    Standoff.QUEUE: Cause.WAITS_IN_A_QUEUE,
    Standoff.OSCILLATION: Cause.GIVES_WAY_FOREVER,
}


def cause_of(failure: Failure) -> Cause:
    """Return a failure's cause: the recorded one, or else the run's.

    Returns:
        The cause; :attr:`Cause.UNKNOWN` if its controller cannot be run here, or not in time.
    """
    recorded = failure.record.details.get(CAUSE)
    if isinstance(recorded, str) and recorded in set(Cause):
        return Cause(recorded)
    # These need no run: the record is enough.
    if failure.oracle is not None:
        return Cause.BREAKS_A_RULE
    if (hazard := hazard_in(failure.record.details)) is not None:
        return CAUSE_OF_HAZARD[hazard]
    if (known := _BY_VERDICT.get(failure.verdict)) is not None:
        return known
    try:
        others = OtherWorlds(failure.record.controller, failure.options)
        return cause_of_run(failure.world, failure.run(), others)
    except (WorldgenError, OutOfTime):
        return Cause.UNKNOWN


def cause_of_run(world: World, episode: Episode, others: OtherWorlds | None = None) -> Cause:
    """Return the cause of a recorded run that did not arrive.

    Args:
        world: World of the run.
        episode: The run, recorded.
        others: Runs the same scenario in other worlds. If omitted, the causes that need such a run
            are not considered.
    """
    evidence = episode.evidence
    if (known := _BY_VERDICT.get(episode.verdict)) is not None:
        return known
    if isinstance(episode, FleetEpisode):
        return _of_fleet(world, episode, others)
    if episode.trace is None:
        return Cause.UNKNOWN
    if isinstance(evidence, BurnedEvidence):
        entered = is_entered(world, episode.trace, evidence)
        return Cause.DRIVES_INTO_A_HAZARD if entered else Cause.CAUGHT_BY_A_CHANGE
    if isinstance(evidence, WallEvidence):
        return _of_wall(evidence)
    behaviour = behaviour_of(world, episode)
    is_stuck = episode.verdict == Verdict.LOOP or episode.verdict in OUT_OF_BUDGET
    if behaviour is None or not is_stuck:
        return Cause.UNKNOWN
    return _of_other_worlds(world, behaviour, others) or _of_behaviour(world, behaviour, others)


def _of_fleet(world: World, episode: FleetEpisode, others: OtherWorlds | None) -> Cause:
    """Return the cause that keeps several robots from arriving, or the fault of one of them."""
    evidence = episode.evidence
    if isinstance(evidence, JointLoopEvidence):
        kind = standoff(evidence)
        # Robots that keep moving may not even meet. One that fails alone has its own reason.
        fail_alone: list[int] = []
        if kind == Standoff.OSCILLATION and others is not None:
            fail_alone = [n for n in evidence.waiting if not others.arrives(world.alone(n))]
        if (known := _BY_STANDOFF.get(kind)) is not None and not fail_alone:
            return known
        # No robot drives into another one, but robots may wait for each other at a distance.
        held = _held_by_others(world, episode, evidence.waiting, evidence.entry, others)
        if held is not None:
            return held
        # The robots do not affect each other, so the first one's own reason decides.
        number = (fail_alone or evidence.waiting)[0]
        # If nobody moves, only the robots' contacts explain why.
        trace = episode.robots[number - 1].trace
        if episode.verdict == Verdict.DEADLOCK and trace is not None:
            return Cause.PUSHES_A_WALL if trace.bump[-1] else Cause.STANDS_STILL
        period = dict(evidence.periods or ()).get(number, evidence.period)
        loop = LoopEvidence(entry=evidence.entry, period=period, state_digest=evidence.state_digest)
        own = replace(episode.robots[number - 1], verdict=Verdict.LOOP, evidence=loop)
        return cause_of_run(world.alone(number), own, others)
    late = [
        number
        for number, one in enumerate(episode.robots, start=1)
        if one.verdict != Verdict.REACHED
    ]
    # Without a proof, it is unknown which robot drives into which.
    if isinstance(evidence, BudgetEvidence):
        held = _held_by_others(world, episode, late, episode.steps // 2, others)
        if held is not None:
            return held
    number = getattr(evidence, "robot", None) or late[0]
    return cause_of_run(world.alone(number), episode.robots[number - 1], others)


def _held_by_others(
    world: World,
    episode: FleetEpisode,
    waiting: Sequence[int],
    since: int,
    others: OtherWorlds | None,
) -> Cause | None:
    """Return the cause if each robot that waits is near another one and would arrive alone.

    Near means that no other robot of its size would fit in between.

    Args:
        world: World of the run.
        episode: The run, recorded.
        waiting: Numbers of the robots that never arrive; the others have parked.
        since: Step from which they wait.
        others: Runs the same scenario in other worlds.
    """
    traces = [one.trace for one in episode.robots]
    parked = {k for k in range(len(traces)) if k + 1 not in waiting}
    only_parked = True
    for number in waiting:
        own = traces[number - 1]
        if own is None:
            return None
        radius = world.robots[number - 1].radius
        near = {
            k
            for k, other in enumerate(traces)
            if other is not None
            and other is not own
            and np.hypot(own.x[since:] - other.x[-1], own.y[since:] - other.y[-1]).min()
            < 3.0 * radius + world.robots[k].radius
        }
        if not near:
            return None
        only_parked &= near <= parked
    if others is None or not all(others.arrives(world.alone(number)) for number in waiting):
        return None
    return Cause.BLOCKED_BY_PARKED if only_parked else Cause.WAITS_FOR_OTHERS


def _of_wall(evidence: WallEvidence) -> Cause:
    # The thesis's motion names its own faulty moves. The other models have only one reason: they
    # check only where a step ends, and the step was too long for that.
    match evidence.cause:
        case None:
            return Cause.STEPS_OVER_A_WALL
        case "corner":
            return Cause.CUTS_A_CORNER
        case _:
            return Cause.SLIDES_INTO_A_WALL


def _of_other_worlds(world: World, seen: RepeatedPart, others: OtherWorlds | None) -> Cause | None:
    """Return the cause, if it is one of those that only runs in changed worlds show."""
    if others is None:
        return None
    try:
        if fails_by_timing(world, others.arrives):
            return Cause.CONFUSED_BY_CHANGES
        # The walls that a robot touches reveal more about it than gaps that it keeps away from.
        if seen.touching < _RARELY and needs_a_wider_gap(world, seen.closest, others.arrives):
            return Cause.NEEDS_A_WIDER_GAP
    except OutOfTime:
        # Without time for these runs, the robot's behaviour is the best evidence.
        return None
    return None


def _of_behaviour(world: World, seen: RepeatedPart, others: OtherWorlds | None) -> Cause:
    at_one_place = seen.extent <= _ONE_PLACE
    turns_around = seen.about_faces > 0.0

    # At one place, or turning all the time: it follows nothing and aims at nothing. At a wall,
    # every robot turns, so there only a turn around counts.
    if at_one_place and seen.touching == 1.0 and not turns_around:
        return Cause.PUSHES_A_WALL
    # A robot that never drove passes nothing and was held by nothing on its way.
    if seen.is_parked:
        turns = seen.turning >= _TURNS_AT_ALL
        return Cause.TURNS_BACK_AND_FORTH if turns else Cause.STANDS_STILL
    restless = seen.turning >= _RESTLESS and (turns_around or seen.touching < _MOSTLY)
    if restless or (at_one_place and turns_around):
        return Cause.TURNS_BACK_AND_FORTH

    # The robot is next to the target with nothing in between and hardly touches walls, so they are
    # not the reason.
    near = seen.nearest <= seen.reach + _CLOSE and seen.farthest <= seen.reach + _NEARBY
    if near and not seen.is_blocked and seen.touching < _RARELY:
        return Cause.MISSES_THE_TARGET

    # Along walls. A robot that follows an entire wall goes around an island, or around the target,
    # which is inside the outer wall; a robot that does neither has left the wall in between.
    if seen.off_wall <= _ALONG and (seen.around_island or seen.around_target):
        return Cause.CIRCLES_A_WALL
    if seen.touching >= _RARELY:
        if others is None:
            return Cause.UNKNOWN
        gets_around = others.gets_around_walls(world)
        return Cause.RETURNS_TO_THE_WALL if gets_around else Cause.BOUNCES_BETWEEN_WALLS

    # Away from walls. A robot that stays near the place where it is nearest is held there.
    if seen.is_blocked and seen.farthest <= seen.nearest + _NEARBY:
        return Cause.TRAPPED_BEHIND_A_WALL
    if seen.about_faces >= _OFTEN_AROUND:
        return Cause.TURNS_BACK_AND_FORTH
    return Cause.STANDS_STILL if at_one_place else Cause.DRIVES_IN_CIRCLES
