"""The boundary lane: from a scenario along one axis to where the controller begins, or ceases, to fail.

Other lanes leave radius, speed and time step as they are. Here half of the scenarios are failures
that the campaign knows, in which the nearest values are looked for at which the robot arrives; half
are drawn, for the nearest at which it does not. Two neighbouring values with different outcomes
bring one failure, and its record says where it begins. A drawn scenario that fails and of which no
such values are found brings the failure that it is.
"""

from __future__ import annotations

from fuzz.boundary import (
    AXES,
    Axis,
    BoundaryRun,
    BoundaryRuns,
    Subject,
    nearest_boundary,
    subject_of,
)
from fuzz.search.features import LAYOUT_BYTES, decode_world
from fuzz.search.task import Task
from fuzz.triage.proofs import certified
from sim.runners.stopping import OutOfTime, check_time
from worldgen.errors import GenerationFailed
from worldgen.generation import generate
from worldgen.random_streams import RandomStream

__all__ = ["BOUNDARY", "search"]

BOUNDARY = "boundary"

# Complete controllers, too, fail in gaps as wide as the robot, mapper with 2 % to spare; with 5 %
# none.
_SPARE = 0.05
# How many feature layouts are drawn in the time of one boundary: about 20 runs, few of them with a
# proof.
_DEARER = 16


def search(task: Task) -> None:
    """Looks for boundaries, and hands in their failing ends."""
    stream = task.stream
    failures = [subject_of(failure) for _, failure in sorted(task.memory.failures.items())]
    known = [subject for subject in failures if subject is not None]

    def count(look: BoundaryRun) -> None:
        task.door.count(look.outcome.verdict, look.outcome.steps)
        check_time()

    for _ in range(max(task.config.examples // (_DEARER * task.config.slower), 1)):
        axis = AXES[stream.choice(tuple(AXES))]
        subject = _subject(task, stream, known, axis)
        start = None if subject is None else axis.index(subject)
        if subject is None or start is None:
            continue
        _bring(
            task,
            BoundaryRuns(subject, axis, count, _SPARE),
            start,
            is_known=any(subject is one for one in known),
        )


def _bring(task: Task, looks: BoundaryRuns, start: int, *, is_known: bool) -> None:
    """Hand in the failing end of the nearest boundary, or what fails at all values that were tried."""
    try:
        found = nearest_boundary(looks, start)
    except OutOfTime:
        if not is_known:
            _bring_whole(task, looks.seen_at(start))
        raise
    if found is not None:
        fails = found.fails.subject
        outcome = found.fails.outcome
        task.door.enter(
            fails.world, fails.scenario, outcome.verdict, outcome.cause, boundaries=[found.record()]
        )
    elif not is_known:
        _bring_whole(task, looks.seen_at(start))


def _bring_whole(task: Task, look: BoundaryRun | None) -> None:
    """Hand in a run if it failed."""
    if look is not None and not look.arrives:
        subject = look.subject
        outcome = look.outcome
        task.door.enter(subject.world, subject.scenario, outcome.verdict, outcome.cause)


def _subject(task: Task, stream: RandomStream, known: list[Subject], axis: Axis) -> Subject | None:
    """A failure that is known, or a scenario that is drawn; on a fixed map only what is known."""
    if known and (stream.below(2) or task.config.fixed_map is not None):
        subject = stream.choice(known)
        if axis.index(subject) is not None:
            return subject
    if task.config.fixed_map is not None:
        return None
    scenario = task.scenario(stream.below(2**32), stream.choice(task.config.time_steps))
    if axis.name != "depth":
        world = certified(decode_world(stream.bits(LAYOUT_BYTES // 8).astype("<u8").tobytes()))
        return None if world is None else Subject(world, scenario)
    try:
        return Subject(generate("trap", stream.below(2**32)), scenario)
    except GenerationFailed:
        return None
