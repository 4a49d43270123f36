"""Run a controller in natural worlds, which nobody searched for, to find how often it arrives.

A search looks for failures, so its counts do not show how good a controller is. Natural worlds come
from families at default settings, with a seed that no search strategy uses. What happens in them
estimates a rate, with an interval.
"""

from __future__ import annotations

import bisect
import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from fuzz.cause import Cause
from fuzz.facts.changed_worlds import OtherWorlds
from fuzz.facts.hazards import could_not_know
from fuzz.facts.proofs import certified
from fuzz.layouts.variation import Variation, applied, generated
from fuzz.overview.result import NaturalResult, NaturalTally
from fuzz.simplicity import Case, simplicity
from fuzz.triage.diagnosis import cause_of_run
from sim.clock.stopping import OutOfTime, stopping_when
from sim.controllers.answers import leaving_proofs
from sim.episode import Episode, simulate
from sim.scenario import Scenario
from sim.verdict import ARRIVALS
from worldgen.difficulty.bottleneck import bottleneck
from worldgen.errors import InvalidParameter, WorldgenError
from worldgen.family import FAMILIES
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


class NaturalRun(NamedTuple):
    """One run in a natural world.

    Args:
        family: The family that made the world.
        verdict: Its verdict.
        cause: Why the robot does not arrive; ``None`` if it does.
        clearance: How wide the path is, a name in :data:`CLEARANCES`; empty if no path is proved.
        turns: How winding it is, a name in :data:`TURNS`; as above.
    """

    family: str
    verdict: str
    cause: Cause | None = None
    clearance: str = ""
    turns: str = ""


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


def natural_runs(
    scenario: Scenario,
    families: Sequence[str],
    count: int,
    seed: int,
    is_over: Callable[[int], bool] = lambda _: False,
    vary: Sequence[Variation] = (),
) -> tuple[NaturalResult, dict[Cause, Case]]:
    """Run a scenario in natural worlds, each family in turn.

    Return the counts and, by cause, the simplest world in which it occurred. Without ``is_over``,
    they depend only on the other arguments.

    Args:
        scenario: Controller and options.
        families: Names of families.
        count: Number of worlds.
        seed: Seed of the campaign.
        is_over: Returns True once no more worlds should be run, given the number of those that are
            finished.
        vary: Quantities of the robot and the run to draw from, as the search does.
    """
    runs: list[NaturalRun] = []
    examples: dict[Cause, Case] = {}
    is_complete = True
    stream = RandomStream(seed).child(NATURAL)
    # Another stream, so that the worlds are the same whatever varies.
    values = RandomStream(seed).child(NATURAL, "vary")
    for number in range(count if families else 0):
        world_seed = stream.next64()
        family = families[number % len(families)]
        try:
            with stopping_when(lambda: is_over(len(runs))):
                if is_over(len(runs)):
                    raise OutOfTime
                drawn = {one.name: values.choice(one.values) for one in vary}
                case = _natural_case(family, world_seed, scenario.with_run(seed=number), drawn)
                if case is None:
                    continue
                with leaving_proofs():
                    episode, cause = _run(case)
        except OutOfTime:
            is_complete = False
            break
        except WorldgenError:
            # A world that cannot be made reveals nothing about the controller.
            continue
        if cause == Cause.HARMED_UNSENSED:
            runs.append(NaturalRun(family, episode.verdict.value, cause))
            continue
        runs.append(NaturalRun(family, episode.verdict.value, cause, *_path_in(case.world)))
        if cause is not None:
            before = examples.get(cause, case)
            examples[cause] = case if simplicity(case) < simplicity(before) else before
    return natural_result(runs, is_complete=is_complete), examples


def _path_in(world: World) -> tuple[str, str]:
    """Return how wide and how winding the path is, in the world's initial state."""
    witness = world.certificate
    if not isinstance(witness, Witness):
        return "", ""
    share = bottleneck(world, world.walls) / world.robot_radius
    turns = _quarter_turns(witness)
    return (
        CLEARANCES[bisect.bisect(_CLEARANCE_EDGES, share)],
        TURNS[bisect.bisect(_TURN_EDGES, turns)],
    )


def _natural_case(
    family: str, seed: int, scenario: Scenario, values: Mapping[str, Value]
) -> Case | None:
    """Return a family's world with the drawn robot; ``None`` if it cannot arrive there."""
    world, scenario = applied(values, generated(family, seed, values), scenario)
    proved = world if world.certificate else certified(world)
    return None if proved is None else Case(proved, scenario)


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
