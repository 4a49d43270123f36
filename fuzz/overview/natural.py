"""Run a controller in natural worlds, which nobody searched for, to find how often it arrives.

A search looks for failures, so its counts do not show how good a controller is. Natural worlds come
from families at default settings, with a seed that no search strategy uses. What happens in them
estimates a rate, with an interval.
"""

from __future__ import annotations

import bisect
import itertools
import math
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from fuzz.campaign.executors import Executor
from fuzz.cause import Cause
from fuzz.facts.changed_worlds import OtherWorlds
from fuzz.facts.hazards import could_not_know
from fuzz.facts.proofs import certified
from fuzz.layouts.variation import Variation, applied, generated
from fuzz.overview.result import NaturalResult, NaturalTally
from fuzz.simplicity import Case, simplicity
from fuzz.triage.diagnosis import cause_of_run
from fuzz.unit.deadline import Deadline
from sim.clock.controller_time import Effort, count_differences, count_lines, count_survivors
from sim.clock.stopping import OutOfTime, check_time, stopping_when
from sim.controllers.answers import leaving_proofs
from sim.controllers.catalogue.renewal import as_loaded
from sim.controllers.lines_run import report_lines, watch_lines
from sim.episode import Episode, simulate
from sim.scenario import Scenario
from sim.verdict import ARRIVALS
from worldgen.difficulty.bottleneck import bottleneck
from worldgen.errors import InvalidParameter, WorldgenError
from worldgen.family import FAMILIES
from worldgen.plugins.workers import LISTEN
from worldgen.random_streams import RandomStream
from worldgen.support.intervals import interval_95
from worldgen.world import Value, Witness, World

NATURAL = "natural"
"""The random stream of natural worlds, from which no unit of a search draws."""

CLEARANCES = ("less than 1.1", "1.1 to 1.5", "1.5 to 2", "2 to 3", "more than 3")
"""Radius of the largest disc that gets from start to target, divided by the robot's radius."""

_CLEARANCE_EDGES = (1.1, 1.5, 2.0, 3.0)

TURNS = ("no", "1 or 2", "3 to 5", "6 or more")
"""Quarter turns on the path that proves the target reachable."""

_TURN_EDGES = (0.5, 2.5, 5.5)

# Worlds that a worker gets at a time: as many as take it this long, s, up to a limit.
_BRIEF = 0.2
_MOST_AT_ONCE = 32
# Seconds after the end in which results may still arrive.
_GRACE = 1.0


class NaturalRun(NamedTuple):
    """One run in a natural world.

    Args:
        family: The family that made the world.
        verdict: Its verdict.
        cause: Why the robot does not arrive; ``None`` if it does.
        clearance: How wide the path is, in radii, or widths of a footprint; a name in
            :data:`CLEARANCES`, empty if no path is proved.
        turns: How winding it is, a name in :data:`TURNS`; as above.
    """

    family: str
    verdict: str
    cause: Cause | None = None
    clearance: str = ""
    turns: str = ""


class DrawnWorld(NamedTuple):
    """A natural world before it is made.

    Args:
        number: Its number.
        family: The family that makes it.
        seed: Seed of the family.
        values: What is drawn of the robot and the run.
    """

    number: int
    family: str
    seed: int
    values: Mapping[str, Value]


def natural_result(runs: Iterable[NaturalRun], *, is_complete: bool = True) -> NaturalResult:
    """Return the counts of natural runs.

    Args:
        runs: The runs.
        is_complete: False if time ran out before all worlds were run.
    """
    everything = list(runs)
    fair = [one for one in everything if one.cause != Cause.HARMED_UNSENSED]
    arrived = sum(one.cause is None for one in fair)
    low, high = interval_95(arrived, len(fair))
    return NaturalResult(
        worlds=len(fair),
        arrived=arrived,
        unsensed=len(everything) - len(fair),
        share=round(arrived / len(fair), 4) if fair else None,
        low=round(low, 4),
        high=round(high, 4),
        verdicts=dict(Counter(one.verdict for one in fair).most_common()),
        causes=dict(Counter(one.cause.value for one in fair if one.cause).most_common()),
        families=_tallies(fair, "family"),
        clearances=_tallies(fair, "clearance", CLEARANCES),
        turns=_tallies(fair, "turns", TURNS),
        complete=is_complete,
    )


def _tallies(
    runs: Sequence[NaturalRun], field: str, names: Iterable[str] = ()
) -> dict[str, NaturalTally]:
    """Return the counts by a field; given names that were never tried have zeros."""
    worlds = Counter(getattr(one, field) for one in runs)
    arrived = Counter(getattr(one, field) for one in runs if one.cause is None)
    return {name: NaturalTally(worlds[name], arrived[name]) for name in names or worlds}


def natural_families(chosen: Sequence[str]) -> list[str]:
    """Return the families whose worlds count as natural for a campaign.

    Args:
        chosen: Families and other strategies that the user requested; empty for all families.

    Returns:
        The chosen families, or all for one robot that come with worldgen or are installed. Empty
        if none of the chosen strategies draws from a family.
    """
    if not chosen:
        return [name for name in FAMILIES.names() if not FAMILIES.get(name).places_robots]
    names = set(FAMILIES.names())
    return [name for name in chosen if name in names or ":" in name]


@dataclass(frozen=True)
class NaturalTime:
    """The time for natural worlds, by :func:`fuzz.unit.deadline.now`.

    Args:
        early: When no more are run.
        end: When even the first few are not.
        needed: Number of these.
    """

    early: float = math.inf
    end: float = math.inf
    needed: int = 0

    def __call__(self, finished: int) -> bool:
        """Return True if no more should be run, given the number of those that are finished."""
        end = self.end if finished < self.needed else self.early
        return Deadline(end, end).to_begin_is_over()


_NO_LIMIT = NaturalTime()


def natural_runs(
    scenario: Scenario,
    families: Sequence[str],
    count: int,
    seed: int,
    is_over: Callable[[int], bool] = _NO_LIMIT,
    vary: Sequence[Variation] = (),
    executor: Executor | None = None,
) -> tuple[NaturalResult, dict[Cause, Case]]:
    """Run a scenario in natural worlds, each family in turn.

    Return the counts and, by cause, the simplest world in which it occurred. Without ``is_over``,
    they depend only on the other arguments but the last.

    Args:
        scenario: Controller and options.
        families: Names of families.
        count: Number of worlds.
        seed: Seed of the campaign.
        is_over: Returns True once no more worlds should be run, given the number of those that are
            finished.
        vary: Quantities of the robot and the run to draw from, as the search does.
        executor: Whose workers run the worlds, which then pickle ``is_over``; this process if
            omitted.
    """
    call = partial(_run_worlds, scenario, tuple(families), seed, is_over, tuple(vary))
    everything = range(count if families else 0)
    if executor is None:
        finished, _ = call(everything, 0)
    else:
        finished = _shared_out(executor, call, everything, is_over)
    runs: list[NaturalRun] = []
    examples: dict[Cause, Case] = {}
    # A world that takes long fails more often, so worlds after one that is not finished would make
    # the rate too good.
    whole = list(itertools.takewhile(finished.__contains__, everything))
    for number in whole:
        run, case = finished[number]
        if run is None:
            continue
        runs.append(run)
        cause = run.cause
        if case is not None and cause is not None:
            before = examples.get(cause, case)
            examples[cause] = case if simplicity(case) < simplicity(before) else before
    return natural_result(runs, is_complete=len(whole) == len(everything)), examples


class _Finished(NamedTuple):
    """A natural world that is done with.

    Args:
        run: Its run; ``None`` if there is no such world.
        case: The world and scenario, if the robot does not arrive and is to blame.
    """

    run: NaturalRun | None = None
    case: Case | None = None


def _shared_out(
    executor: Executor,
    call: Callable[[range, int], tuple[dict[int, _Finished], Effort]],
    everything: range,
    is_over: Callable[[int], bool],
) -> dict[int, _Finished]:
    """Let workers run all worlds, a few at a time, and return those that are finished.

    Raises:
        KeyboardInterrupt: After Ctrl-C.
    """
    executor.go_on()
    finished: dict[int, _Finished] = {}
    waiting: set[Future[tuple[dict[int, _Finished], Effort]]] = set()
    first = 0
    size = 1
    over_since = math.inf
    while True:
        # Give each free worker something to do.
        while len(waiting) < executor.room and first < len(everything):
            if is_over(len(finished)):
                break
            numbers = everything[first : first + size]
            first += size
            waiting.add(executor.submit(call, numbers, len(finished)))
        if not waiting:
            return finished
        # A worker that is stuck in a step is not waited for.
        executor.listen()
        if is_over(len(finished)):
            over_since = min(over_since, time.monotonic())
            if time.monotonic() - over_since > _GRACE:
                return finished
        for future in wait(waiting, LISTEN, FIRST_COMPLETED).done:
            waiting.remove(future)
            more, effort = future.result()
            finished |= more
            # What was noticed there counts here.
            count_survivors(effort.survivors)
            count_differences(effort.differences)
            count_lines(effort.lines)
            # Quick worlds are handed out by the dozen.
            if effort.seconds < _BRIEF:
                size = min(2 * size, _MOST_AT_ONCE)


def _run_worlds(
    scenario: Scenario,
    families: Sequence[str],
    seed: int,
    is_over: Callable[[int], bool],
    vary: Sequence[Variation],
    numbers: range,
    finished: int,
) -> tuple[dict[int, _Finished], Effort]:
    """Run some of the natural worlds, until the time is over.

    Args:
        scenario: As for :func:`natural_runs`, like the next four.
        families: Names of families.
        seed: Seed of the campaign.
        is_over: Returns True once no more worlds should be run.
        vary: Quantities to draw from.
        numbers: Numbers of the worlds.
        finished: Number of worlds that are finished elsewhere.

    Returns:
        The finished worlds by number, and what they took.
    """
    began = Effort.so_far()
    watch_lines(as_loaded(scenario.controller))
    done: dict[int, _Finished] = {}
    for drawn in drawn_worlds(families, seed, numbers.stop, vary):
        number = drawn.number
        if number < numbers.start:
            continue
        ran = finished + sum(one.run is not None for one in done.values())
        try:
            with stopping_when(partial(is_over, ran)):
                check_time()
                case = natural_case(drawn, scenario)
                with leaving_proofs():
                    done[number] = _Finished() if case is None else _finished(drawn.family, case)
        except OutOfTime:
            break
        except WorldgenError:
            # A world that cannot be made reveals nothing about the controller.
            done[number] = _Finished()
    report_lines()
    return done, began.since()


def _finished(family: str, case: Case) -> _Finished:
    """Run a natural world."""
    episode, cause = _run(case)
    if cause == Cause.HARMED_UNSENSED:
        return _Finished(NaturalRun(family, episode.verdict.value, cause))
    run = NaturalRun(family, episode.verdict.value, cause, *_path_in(case.world))
    return _Finished(run, None if cause is None else case)


def _path_in(world: World) -> tuple[str, str]:
    """Return how wide and how winding the path is, in the world's initial state."""
    witness = world.certificate
    if not isinstance(witness, Witness):
        return "", ""
    robot = world.robots[0]
    if robot.is_disc:
        share = bottleneck(world, world.walls) / robot.radius
    else:
        # As for a disc that is as wide as the footprint: what its path leaves to spare on both sides.
        share = 1.0 + witness.clearance / (0.5 * float(np.ptp(robot.footprint, axis=0).min()))
    turns = _quarter_turns(witness)
    return (
        CLEARANCES[bisect.bisect(_CLEARANCE_EDGES, share)],
        TURNS[bisect.bisect(_TURN_EDGES, turns)],
    )


def drawn_worlds(
    families: Sequence[str], seed: int, count: int, vary: Sequence[Variation] = ()
) -> Iterator[DrawnWorld]:
    """Yield natural worlds as they are drawn, the same for whoever makes them.

    Args:
        families: Names of families, which take turns.
        seed: Seed of the campaign.
        count: Number of worlds.
        vary: Quantities to draw from.
    """
    stream = RandomStream(seed).child(NATURAL)
    # Another stream, so that the worlds are the same whatever varies.
    values = RandomStream(seed).child(NATURAL, "vary")
    for number in range(count):
        world_seed = stream.next64()
        drawn = {one.name: values.choice(one.values) for one in vary}
        yield DrawnWorld(number, families[number % len(families)], world_seed, drawn)


def natural_case(drawn: DrawnWorld, scenario: Scenario) -> Case | None:
    """Return a natural world with its robot; ``None`` if it cannot arrive there, or starts there.

    Raises:
        WorldgenError: If there is no such world.
    """
    world = generated(drawn.family, drawn.seed, drawn.values)
    world, scenario = applied(drawn.values, world, scenario.with_run(seed=drawn.number))
    proved = world if world.certificate else certified(world)
    if proved is None or proved.robots[0].starts_in_target:
        return None
    return Case(proved, scenario)


def _run(case: Case) -> tuple[Episode, Cause | None]:
    """Run a scenario; return the run and, if the robot does not arrive, the cause."""
    world, scenario = case
    options = scenario.options(world)
    episode = simulate(world, scenario.controller, options)
    if episode.verdict in ARRIVALS:
        return episode, None
    # Only a recording shows the cause. Most runs arrive, so it is cheaper to run again.
    try:
        recorded = simulate(world, scenario.controller, options, record=True)
    except InvalidParameter:
        # The run is too long to be recorded, but it did not arrive, so it counts.
        return episode, Cause.UNKNOWN
    # A controller that is not repeatable may arrive this time. In that case its first run counts.
    if recorded.verdict in ARRIVALS:
        return episode, Cause.UNKNOWN
    episode = recorded
    if could_not_know(world, episode, scenario):
        return episode, Cause.HARMED_UNSENSED
    others = OtherWorlds(scenario.controller, options)
    return episode, cause_of_run(world, episode, others)


def describe_fall(now: NaturalResult | None, before: NaturalResult | None) -> str:
    """Return that a robot arrives in fewer natural worlds than before; empty unless it surely does.

    Args:
        now: The results now.
        before: The results before; both ``None`` if unknown.
    """
    if now is None or before is None or not now.worlds or not before.worlds:
        return ""
    if now.interval[1] >= before.low:
        return ""
    return (
        f"it arrives in {now.percent} % of natural worlds, and arrived in {before.percent} % before"
    )


def _quarter_turns(witness: Witness) -> float:
    """Return the total number of quarter turns by which a path changes its direction."""
    bearing = np.arctan2(np.diff(witness.y), np.diff(witness.x))
    moves = (np.diff(witness.x) != 0.0) | (np.diff(witness.y) != 0.0)
    change = (np.diff(bearing[moves]) + math.pi) % (2 * math.pi) - math.pi
    return float(np.abs(change).sum()) / (math.pi / 2)
