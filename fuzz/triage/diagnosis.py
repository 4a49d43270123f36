"""Decide a failure's cause from its run.

The rules are a list, and the first that applies decides. Each examines the repeated part, or the
move that ended the run, but never its place in the world. ``python -m benchmarks.causes`` measures
how well they distinguish seeded faults.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fuzz.cause import CAUSE, CIRCUMSTANCE, GAP, Cause, Circumstance, Diagnosis
from fuzz.facts.changed_worlds import OtherWorlds, fails_by_timing, gap_that_stops
from fuzz.facts.hazards import Hazard, hazard_in
from fuzz.facts.signature import Standoff, is_entered, standoff, towards_its_goal
from fuzz.failure import Failure
from fuzz.triage.behaviour import RepeatedPart, behaviour_of, passes_target
from fuzz.triage.repeated_moves import RARELY, TIGHTEST_CIRCLE
from sim.clock.stopping import OutOfTime
from sim.episode import Episode
from sim.evidence import (
    BudgetEvidence,
    BurnedEvidence,
    FaultEvidence,
    JointLoopEvidence,
    LoopEvidence,
    WallEvidence,
)
from sim.options.run import TARGET
from sim.outcome import FleetEpisode
from sim.trace import Trace
from sim.verdict import OUT_OF_BUDGET, Verdict
from worldgen.errors import WorldgenError
from worldgen.world import Value, World

# Robot radii. A robot that stays within this distance counts as standing at one place, however it
# moves there.
_ONE_PLACE = 1.0

# Robot radii per step, and turns per step, on average, below which a robot does not move at all.
_MOVES_AT_ALL = 1e-4
_TURNS_AT_ALL = 0.001

# Turns per step, on average. A controller that turns by more than 70 degrees in nearly every step
# follows nothing; wall followers stay below 0.15 even around posts.
_RESTLESS = 0.2

# Share of steps that turn the robot around, or change between forwards and backwards. One that
# reverses at the ends of a longer path stays below it.
_OFTEN_AROUND = 0.1

# Cells between two touches. A wall follower touches its wall at least once per cell,
# even at corners.
_ALONG = 1.0

# Cells that a robot stays near the place where it is nearest to its target.
_NEARBY = 3.0

# Share of steps above which a wall holds the robot: neither the target nor its own turns do.
_MOSTLY = 0.5

_BY_VERDICT: dict[str, Cause] = {
    Verdict.COLLISION: Cause.COLLIDES,
    Verdict.CONTACT: Cause.TOUCHES_A_WALL,
    Verdict.CRASH: Cause.CRASHES,
    Verdict.HANG: Cause.GIVES_NO_ANSWER,
    Verdict.INVALID_COMMAND: Cause.INVALID_COMMAND,
}

CAUSE_OF_HAZARD = {Hazard.UNSENSED: Cause.HARMED_UNSENSED, Hazard.DISTURBED: Cause.PUSHED_TOO_HARD}
"""The causes of failures that are not the controller's fault."""

_BY_STANDOFF = {
    Standoff.FACE_TO_FACE: Circumstance.FACE_TO_FACE,
    Standoff.CIRCULAR_WAIT: Circumstance.CIRCULAR_WAIT,
    Standoff.BEHIND_PARKED: Circumstance.PARKED_ROBOT,
    Standoff.QUEUE: Circumstance.QUEUE,
    Standoff.OSCILLATION: Circumstance.GIVING_WAY,
}


def cause_of(failure: Failure) -> Cause:
    """Return a failure's cause: the recorded one, or else the run's.

    Returns:
        The cause; :attr:`Cause.UNKNOWN` if its controller cannot be run here, or not in time.
    """
    return diagnosis_of(failure).cause


def diagnosis_of(failure: Failure) -> Diagnosis:
    """Return a failure's cause and its circumstance: the recorded ones, or else the run's."""
    details = failure.record.details
    if failure.recorded_cause is not None:
        circumstance = details.get(CIRCUMSTANCE)
        gap = details.get(GAP, 0.0)
        return Diagnosis(
            failure.recorded_cause,
            Circumstance(circumstance)
            if isinstance(circumstance, str) and circumstance in set(Circumstance)
            else _how_it_ends(failure),
            float(gap) if isinstance(gap, int | float) else 0.0,
        )
    # These need no run: the record is enough.
    if failure.oracle is not None:
        return Diagnosis(Cause.BREAKS_A_RULE)
    if (hazard := hazard_in(details)) is not None:
        return Diagnosis(CAUSE_OF_HAZARD[hazard])
    if (known := _BY_VERDICT.get(failure.verdict)) is not None:
        return Diagnosis(known, _how_it_ends(failure))
    try:
        others = OtherWorlds(failure.record.controller, failure.options)
        return diagnosis_of_run(failure.world, failure.run(), others)
    except (WorldgenError, OutOfTime):
        return Diagnosis(Cause.UNKNOWN)


def _how_it_ends(failure: Failure) -> Circumstance | None:
    """Return how a controller ends that raises no error; ``None`` for any other failure."""
    evidence = failure.evidence
    if failure.verdict != Verdict.CRASH or not isinstance(evidence, FaultEvidence):
        return None
    if evidence.signal is not None:
        return Circumstance.KILLED
    return None if evidence.exit_code is None else Circumstance.EXITS


def details_of(diagnosis: Diagnosis) -> dict[str, Value]:
    """Return the details that a failure's record keeps of its diagnosis."""
    details: dict[str, Value] = {CAUSE: diagnosis.cause.value}
    if diagnosis.circumstance is not None:
        details[CIRCUMSTANCE] = diagnosis.circumstance.value
    if diagnosis.gap:
        details[GAP] = round(diagnosis.gap, 4)
    return details


def cause_of_run(world: World, episode: Episode, others: OtherWorlds | None = None) -> Cause:
    """Return the cause of a recorded run that did not arrive.

    Args:
        world: World of the run.
        episode: The run, recorded.
        others: Runs the same scenario in other worlds; only several robots need them.
    """
    if isinstance(episode, FleetEpisode):
        return _of_fleet(world, episode, others).cause
    return _of_robot(world, episode)[0]


def _of_robot(world: World, episode: Episode) -> tuple[Cause, RepeatedPart | None]:
    """Return the cause of a single robot's run and, if it names a motion, the part that repeats."""
    evidence = episode.evidence
    world = towards_its_goal(world, episode)
    known = _BY_VERDICT.get(episode.verdict, Cause.UNKNOWN)
    if episode.trace is None:
        return Cause.WANDERS if episode.verdict == Verdict.TIMEOUT else known, None
    if isinstance(evidence, BurnedEvidence):
        entered = is_entered(world, episode.trace, evidence)
        return Cause.DRIVES_INTO_A_HAZARD if entered else Cause.CAUGHT_BY_A_CHANGE, None
    if isinstance(evidence, WallEvidence):
        return Cause.GOES_THROUGH_A_WALL, None
    is_stuck = episode.verdict == Verdict.LOOP or episode.verdict in OUT_OF_BUDGET
    seen = behaviour_of(world, episode) if is_stuck else None
    if seen is None:
        return known, None
    at_goal = _at_goal(world, episode.trace, seen)
    if at_goal is not None:
        return at_goal, None
    # A robot that only now and then reaches a new place may still end up repeating itself.
    if episode.verdict == Verdict.TIMEOUT and not seen.recurs:
        return Cause.WANDERS, None
    return _of_behaviour(seen), seen


def diagnosis_of_run(
    world: World, episode: Episode, others: OtherWorlds | None = None
) -> Diagnosis:
    """Return the cause of a recorded run that did not arrive, and its circumstance.

    Args:
        world: World of the run.
        episode: The run, recorded.
        others: Runs the same scenario in other worlds. If omitted, the circumstances that need such
            a run are not considered.
    """
    if isinstance(episode, FleetEpisode):
        return _of_fleet(world, episode, others)
    cause, seen = _of_robot(world, episode)
    if isinstance(episode.evidence, WallEvidence):
        return Diagnosis(cause, _how_through(episode.evidence))
    if seen is None:
        return Diagnosis(cause)
    return _with_circumstance(world, cause, seen, others, episode.goals_reached or 0)


def _of_fleet(world: World, episode: FleetEpisode, others: OtherWorlds | None) -> Diagnosis:
    """Return the cause that keeps several robots from arriving, or the fault of one of them."""
    if episode.verdict == Verdict.TIMEOUT:
        return Diagnosis(Cause.WANDERS)
    if (cause := _BY_VERDICT.get(episode.verdict)) is not None:
        return Diagnosis(cause)
    evidence = episode.evidence
    if isinstance(evidence, JointLoopEvidence):
        kind = standoff(evidence)
        # Robots that keep moving may not even meet. One that fails alone has its own reason.
        fail_alone: list[int] = []
        if kind == Standoff.OSCILLATION and others is not None:
            fail_alone = [n for n in evidence.waiting if not others.arrives(world.alone(n))]
        if (known := _BY_STANDOFF.get(kind)) is not None and not fail_alone:
            return Diagnosis(Cause.HELD_UP_BY_ROBOTS, known)
        # No robot drives into another one, but robots may wait for each other at a distance.
        held = _held_by_others(world, episode, evidence.waiting, evidence.entry, others)
        if held is not None:
            return held
        # The robots do not affect each other, so the first one's own reason decides.
        number = (fail_alone or evidence.waiting)[0]
        # If nobody moves, only the robots' contacts explain why.
        trace = episode.robots[number - 1].trace
        if episode.verdict == Verdict.DEADLOCK and trace is not None:
            return Diagnosis(Cause.PUSHES_A_WALL if trace.bump[-1] else Cause.STANDS_STILL)
        period = dict(evidence.periods or ()).get(number, evidence.period)
        loop = LoopEvidence(entry=evidence.entry, period=period, state_digest=evidence.state_digest)
        own = replace(episode.robots[number - 1], verdict=Verdict.LOOP, evidence=loop)
        return diagnosis_of_run(world.alone(number), own, others)
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
    return diagnosis_of_run(world.alone(number), episode.robots[number - 1], others)


def _held_by_others(
    world: World,
    episode: FleetEpisode,
    waiting: Sequence[int],
    since: int,
    others: OtherWorlds | None,
) -> Diagnosis | None:
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
    return Diagnosis(Cause.HELD_UP_BY_ROBOTS, Circumstance.PARKED_ROBOT if only_parked else None)


def _how_through(evidence: WallEvidence) -> Circumstance:
    # The thesis's motion names its own faulty moves. The other models have only one reason: they
    # check only where a step ends, and the step was too long for that.
    match evidence.cause:
        case None:
            return Circumstance.LONG_STEP
        case "corner":
            return Circumstance.CORNER
        case _:
            return Circumstance.SLIDING


def _of_behaviour(seen: RepeatedPart) -> Cause:
    """Return the motion that a run repeats."""
    at_one_place = seen.extent <= _ONE_PLACE * seen.radius
    turns = seen.turning >= _TURNS_AT_ALL

    # At one place. At a wall, every robot turns, so there only a turn around counts.
    if at_one_place and seen.touching == 1.0 and not seen.about_faces:
        return Cause.PUSHES_A_WALL
    if seen.length <= _MOVES_AT_ALL * seen.radius * seen.steps:
        return Cause.TURNS_ON_THE_SPOT if turns else Cause.STANDS_STILL
    if at_one_place:
        if seen.about_faces or seen.reversals:
            return Cause.GOES_BACK_AND_FORTH
        is_wide = seen.extent >= 2.0 * TIGHTEST_CIRCLE * seen.radius
        if turns and not seen.is_retraced and is_wide and seen.touching < RARELY:
            return Cause.DRIVES_IN_CIRCLES
        return Cause.TURNS_ON_THE_SPOT if turns else Cause.STANDS_STILL
    # Turning all the time, it follows nothing and aims at nothing.
    if seen.turning >= _RESTLESS and (seen.about_faces or seen.touching < _MOSTLY):
        return Cause.GOES_BACK_AND_FORTH

    # Along walls. A robot that follows an entire wall goes around an island, or around the target,
    # which is inside the outer wall; a robot that does neither has left the wall in between.
    if seen.off_wall <= _ALONG and (seen.around_island or seen.around_target):
        return Cause.CIRCLES_AN_OBSTACLE
    if seen.touching >= RARELY:
        return Cause.RETURNS_TO_A_WALL

    # Away from walls.
    if seen.around_island:
        return Cause.CIRCLES_AN_OBSTACLE
    if seen.about_faces + seen.reversals >= _OFTEN_AROUND or seen.is_retraced:
        return Cause.GOES_BACK_AND_FORTH
    return Cause.DRIVES_IN_CIRCLES


def _at_goal(world: World, trace: Trace, seen: RepeatedPart) -> Cause | None:
    """Return what keeps a robot from arriving that gets to its target; None for any other robot."""
    goal = world.target
    if trace.task != TARGET or (goal.arrival == "touch" and goal.heading is None):
        return None
    if goal.arrival != "touch" and passes_target(world, trace):
        return Cause.PASSES_ITS_GOAL
    if seen.touching >= RARELY:
        return None
    # A robot that turns next to its target tries to take up the heading.
    turns = seen.extent <= _ONE_PLACE * seen.radius and seen.turning >= _TURNS_AT_ALL
    aligns = goal.heading is not None and turns and seen.is_near
    return Cause.NEVER_SETTLES if seen.ends_in_target or aligns else None


def _with_circumstance(
    world: World, cause: Cause, seen: RepeatedPart, others: OtherWorlds | None, reached: int
) -> Diagnosis:
    """Return a motion with the circumstance in which the robot repeats it, on the way to a goal."""
    hardly_touches = seen.touching < RARELY
    # Runs in other worlds show most. Without time for them, the robot's own run is the best
    # evidence.
    if others is not None:
        try:
            if fails_by_timing(world, others.arrives):
                return Diagnosis(cause, Circumstance.AMONG_CHANGES)
            # The walls that a disc touches reveal more about it than gaps that it keeps away from.
            # A body touches walls because it has the wrong heading for a gap.
            may_be_held = hardly_touches or not world.robots[0].is_disc
            gap = 0.0
            if may_be_held:
                gap = gap_that_stops(world, seen.closest, others.arrives, reached)
            if gap:
                # A robot can reach a target in a gap that is too narrow to drive through.
                return Diagnosis(cause, Circumstance.AT_A_GAP, gap if gap >= 2.0 else 0.0)
            if cause == Cause.RETURNS_TO_A_WALL and not others.gets_around_walls(world):
                return Diagnosis(cause, Circumstance.FOLLOWS_NO_WALL)
        except OutOfTime:
            pass
    # A robot that never drove passes nothing, and nothing on its way held it back.
    if seen.is_parked or not hardly_touches:
        return Diagnosis(cause)
    if seen.is_near:
        return Diagnosis(cause, Circumstance.AT_THE_TARGET)
    # A robot that stays near the place where it is nearest to its target is held there.
    if seen.is_blocked and seen.farthest <= seen.nearest + _NEARBY:
        return Diagnosis(cause, Circumstance.BEHIND_A_WALL)
    return Diagnosis(cause)
