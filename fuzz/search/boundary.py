"""The boundary strategy: change one number of a scenario until the outcome changes.

Other strategies leave radius, speed and time step as they are; this one changes those that the user
has not fixed. Half of the scenarios here are known
failures, for which the search looks for the nearest value at which the robot arrives. The other
half are drawn, and the search looks for the nearest value at which the robot fails. Two
neighbouring values with different outcomes make a failure whose record states the boundary. A drawn
scenario that fails but has no boundary within reach is passed to triage unchanged.
"""

from __future__ import annotations

from collections.abc import Mapping

from fuzz.boundary import (
    AXES,
    Axis,
    BoundaryRun,
    BoundaryRuns,
    Subject,
    nearest_boundary,
    subject_of,
)
from fuzz.facts.proofs import certified
from fuzz.layouts.features import decode_world
from fuzz.layouts.layout_bytes import LAYOUT_BYTES
from fuzz.layouts.variation import applied, generated, layout_disc
from fuzz.search.task import SearchTask
from sim.clock.stopping import OutOfTime, check_time
from sim.episode import Episode
from sim.outcome import Outcome
from sim.scenario import Scenario
from worldgen.errors import GenerationFailed, InvalidParameter, InvalidWorld
from worldgen.random_streams import RandomStream
from worldgen.world import Value

BOUNDARY = "boundary"

# Even complete controllers fail in gaps as wide as the robot: mapper still does with 2 % to spare.
# With 5 % to spare, none of them does.
_SPARE = 0.05
# Number of feature layouts that take as long as one boundary, which takes about 20 runs but few
# proofs.
_DEARER = 16


def search(task: SearchTask) -> None:
    """Search for boundaries, and hand their failing sides to triage."""
    stream = task.stream
    failures = [subject_of(failure) for _, failure in sorted(task.memory.failures.items())]
    known = [subject for subject in failures if subject is not None]

    def count(look: BoundaryRun) -> None:
        task.triage.count(look.outcome.verdict, look.outcome.steps)
        check_time()

    # What the user fixed is not varied, or the failure would be another robot's.
    constraint = task.config.constraint
    fixed = {"robot_radius"} if constraint.fixes("robot_footprint") else set()
    free = [
        name
        for name, axis in AXES.items()
        if not (constraint.fixes(axis.quantity) or axis.quantity in fixed)
    ]
    # A boundary takes many runs, so only a fraction of the examples is spent here.
    for _ in range(max(task.config.examples // (_DEARER * task.config.pace.slower), 1)):
        axis = AXES[stream.choice(free)]
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


def _bring(task: SearchTask, looks: BoundaryRuns, start: int, *, is_known: bool) -> None:
    """Pass the failing side of the nearest boundary to triage, or a drawn scenario without one."""
    try:
        found = nearest_boundary(looks, start)
    except OutOfTime:
        if not is_known:
            _bring_whole(task, looks.seen_at(start))
        raise
    if found is not None:
        fails = found.fails.subject
        outcome = found.fails.outcome
        task.triage.enter(
            fails.world,
            fails.scenario,
            outcome.verdict,
            _cause(outcome),
            boundaries=[found.record()],
        )
    elif not is_known:
        _bring_whole(task, looks.seen_at(start))


def _bring_whole(task: SearchTask, look: BoundaryRun | None) -> None:
    """Hand in a run if it failed."""
    if look is not None and not look.arrives:
        subject = look.subject
        outcome = look.outcome
        task.triage.enter(subject.world, subject.scenario, outcome.verdict, _cause(outcome))


def _subject(
    task: SearchTask, stream: RandomStream, known: list[Subject], axis: Axis
) -> Subject | None:
    """Return a known failure or a drawn scenario; on a fixed map only a known failure."""
    if known and (stream.below(2) or task.config.fixed_map is not None):
        subject = stream.choice(known)
        if axis.index(subject) is not None:
            return subject
    if task.config.fixed_map is not None:
        return None
    scenario = task.scenario(stream.below(2**32), stream.choice(task.config.time_steps))
    values = {one.name: stream.choice(one.values) for one in task.config.vary}
    try:
        return _drawn(task, stream, axis, scenario, values)
    # The family makes no such world, or the robot does not fit at its start.
    except (GenerationFailed, InvalidParameter, InvalidWorld):
        return None


def _drawn(
    task: SearchTask,
    stream: RandomStream,
    axis: Axis,
    scenario: Scenario,
    values: Mapping[str, Value],
) -> Subject | None:
    """Return a world in which the robot can arrive, and the scenario, with the drawn values."""
    if axis.name != "depth":
        _, cell_size = layout_disc(values)
        data = stream.bits(LAYOUT_BYTES // 8).astype("<u8").tobytes()
        world = decode_world(data, cell_size=cell_size)
    else:
        world = generated("trap", stream.below(2**32), values)
    world, scenario = applied(values, world, scenario)
    proved = world if world.certificate else certified(world)
    return None if proved is None else Subject(proved, scenario)


def _cause(outcome: Outcome | Episode) -> str:
    """Return the cause of a verdict, which only the outcome of one robot names."""
    return outcome.cause if isinstance(outcome, Outcome) else ""
