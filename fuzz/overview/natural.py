"""Run a controller in natural worlds, which nobody searched for, to find how often it arrives.

A search looks for failures, so its counts do not show how good a controller is. Natural worlds come
from families at default settings, with a seed that no search strategy uses. What happens in them
estimates a rate, with an interval.
"""

from __future__ import annotations

import bisect
import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from fuzz.cause import Cause
from fuzz.facts.changed_worlds import OtherWorlds
from fuzz.facts.hazards import could_not_know
from fuzz.facts.proofs import certified
from fuzz.layouts.variation import Variation, applied, generated
from fuzz.overview.table import NaturalRow, NaturalTally
from fuzz.simplicity import Case, simplicity
from fuzz.triage.diagnosis import cause_of_run
from sim.clock.stopping import OutOfTime, stopping_when
from sim.episode import Episode, simulate
from sim.scenario import Scenario
from sim.verdict import ARRIVALS
from worldgen.difficulty.bottleneck import bottleneck
from worldgen.errors import InvalidParameter, WorldgenError
from worldgen.family import FAMILIES
from worldgen.random_streams import RandomStream
from worldgen.support.intervals import interval_95
from worldgen.world import Value, Witness

NATURAL = "natural"
"""The random stream of natural worlds, from which no unit of a search draws."""

CLEARANCES = ("less than 1.1", "1.1 to 1.5", "1.5 to 2", "2 to 3", "more than 3")
"""Radius of the largest disc that gets from start to target, divided by the robot's radius."""

_CLEARANCE_EDGES = (1.1, 1.5, 2.0, 3.0)

TURNS = ("no", "1 or 2", "3 to 5", "6 or more")
"""Quarter turns on the path that proves the target reachable."""

_TURN_EDGES = (0.5, 2.5, 5.5)


@dataclass
class NaturalRuns:
    """A controller's results in natural worlds.

    Args:
        worlds: Number of worlds run, except those in which a hazard that the controller cannot
            sense harmed the robot, because it could not have avoided it.
        arrived: Number of these in which the robot arrived.
        unsensed: Number of worlds in which such a hazard harmed it.
        verdicts: Counts of each verdict.
        causes: Counts of each cause.
        examples: By cause, the simplest world in which it occurred, and the scenario.
        families: By family, the worlds run and those in which the robot arrived.
        clearances: By name in :data:`CLEARANCES`, the same.
        turns: By name in :data:`TURNS`, the same.
        is_complete: False if time ran out before all worlds were run.
    """

    worlds: int = 0
    arrived: int = 0
    unsensed: int = 0
    verdicts: Counter[str] = field(default_factory=Counter)
    causes: Counter[Cause] = field(default_factory=Counter)
    examples: dict[Cause, Case] = field(default_factory=dict)
    families: dict[str, tuple[int, int]] = field(default_factory=dict)
    clearances: dict[str, tuple[int, int]] = field(default_factory=dict)
    turns: dict[str, tuple[int, int]] = field(default_factory=dict)
    is_complete: bool = True

    @property
    def finished(self) -> int:
        """Number of worlds run, with those in which such a hazard harmed the robot."""
        return self.worlds + self.unsensed

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % interval of the share of natural worlds in which the robot arrives."""
        return interval_95(self.arrived, self.worlds)

    @property
    def percent(self) -> int:
        """Share of worlds where the robot arrives, as ``whole_percent`` gives it."""
        return whole_percent(self.arrived, self.worlds)

    def count(self, case: Case, family: str, episode: Episode, cause: Cause | None) -> None:
        """Add one run.

        Args:
            case: Its world, and the scenario.
            family: The family that made the world.
            episode: The run.
            cause: Why the robot does not arrive; ``None`` if it does.
        """
        if cause == Cause.HARMED_UNSENSED:
            self.unsensed += 1
            return
        arrived = cause is None
        self.worlds += 1
        self.arrived += arrived
        self.verdicts[episode.verdict.value] += 1
        if cause is not None:
            self.causes[cause] += 1
            before = self.examples.get(cause)
            if before is None or simplicity(case) < simplicity(before):
                self.examples[cause] = case
        _count(self.families, family, arrived)
        # Find how wide and how winding the path is, in the world's initial state.
        world = case.world
        witness = world.certificate
        if isinstance(witness, Witness):
            share = bottleneck(world, world.walls) / world.robot_radius
            _count(self.clearances, CLEARANCES[bisect.bisect(_CLEARANCE_EDGES, share)], arrived)
            _count(self.turns, TURNS[bisect.bisect(_TURN_EDGES, _quarter_turns(witness))], arrived)

    def table(self) -> NaturalRow:
        """Return the form of this record in JSON."""
        low, high = self.interval if self.worlds else (0.0, 1.0)
        return NaturalRow(
            worlds=self.worlds,
            arrived=self.arrived,
            unsensed=self.unsensed,
            share=round(self.arrived / self.worlds, 4) if self.worlds else None,
            low=round(low, 4),
            high=round(high, 4),
            verdicts=dict(self.verdicts.most_common()),
            causes={cause.value: count for cause, count in self.causes.most_common()},
            families=_rows(self.families, tuple(self.families)),
            clearances=_rows(self.clearances, CLEARANCES),
            turns=_rows(self.turns, TURNS),
            complete=self.is_complete,
        )


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
) -> NaturalRuns:
    """Run a scenario in natural worlds, each family in turn.

    Without ``is_over``, the result depends only on the other arguments.

    Args:
        scenario: Controller and options.
        families: Names of families.
        count: Number of worlds.
        seed: Seed of the campaign.
        is_over: Returns True once no more worlds should be run, given the number of those that are
            finished.
        vary: Quantities of the robot and the run to draw from, as the search does.
    """
    runs = NaturalRuns()
    stream = RandomStream(seed).child(NATURAL)
    # Another stream, so that the worlds are the same whatever varies.
    values = RandomStream(seed).child(NATURAL, "vary")
    for number in range(count if families else 0):
        world_seed = stream.next64()
        family = families[number % len(families)]
        try:
            with stopping_when(lambda: is_over(runs.finished)):
                if is_over(runs.finished):
                    raise OutOfTime
                drawn = {one.name: values.choice(one.values) for one in vary}
                case = _natural_case(family, world_seed, scenario.with_run(seed=number), drawn)
                if case is None:
                    continue
                episode, cause = _run(case)
        except OutOfTime:
            runs.is_complete = False
            break
        except WorldgenError:
            # A world that cannot be made reveals nothing about the controller.
            continue
        runs.count(case, family, episode, cause)
    return runs


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


def describe_fall(now: NaturalRuns | None, before: NaturalRow | None) -> str:
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
        f"it arrives in {now.percent} % of natural worlds, and arrived in "
        f"{whole_percent(before.arrived, before.worlds)} % before"
    )


def _quarter_turns(witness: Witness) -> float:
    """Return the total number of quarter turns by which a path changes its direction."""
    bearing = np.arctan2(np.diff(witness.y), np.diff(witness.x))
    moves = (np.diff(witness.x) != 0.0) | (np.diff(witness.y) != 0.0)
    change = (np.diff(bearing[moves]) + math.pi) % (2 * math.pi) - math.pi
    return float(np.abs(change).sum()) / (math.pi / 2)


def _count(table: dict[str, tuple[int, int]], name: str, arrived: bool) -> None:
    worlds, before = table.get(name, (0, 0))
    table[name] = (worlds + 1, before + arrived)


def _rows(table: Mapping[str, tuple[int, int]], names: Sequence[str]) -> dict[str, NaturalTally]:
    """Return the counts of each name; those that were never tried have zeros."""
    return {name: NaturalTally(*table.get(name, (0, 0))) for name in names}


def whole_percent(arrived: int, worlds: int) -> int:
    """Return the share of worlds where the robot arrives, percent; 100 only for all of them."""
    return min(round(100 * arrived / worlds), 99 + (arrived == worlds))
