"""Sets of worlds found by searching for their metrics, or spread over a range of difficulty."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import cast

import msgspec

from worldgen.difficulty import measure, parse
from worldgen.difficulty.search import (
    TRIES,
    Search,
    constraint_for,
    strata_constraints,
    strata_edges,
)
from worldgen.family import FAMILIES, Family
from worldgen.plugins.trust import admit_argument
from worldgen.sets.making import Made
from worldgen.sets.manifest import Manifest
from worldgen.sets.plan import SetPlan, header_of
from worldgen.world import Provenance, Value, World


@dataclass(frozen=True, kw_only=True)
class WantedPlan(SetPlan):
    """A set whose worlds are found one after another by one search.

    Args:
        family: The family.
        tries: Limit on the worlds made without success for each world found.
        tell: Called after each try.
    """

    family: Family
    tries: int
    tell: Callable[[Search], None] | None = None

    def made(self, first: int, workers: int) -> Iterator[Made]:
        """Make the worlds, starting with this one.

        The search repeats what it found before, because later finds depend on it.
        """
        header = self.header
        edges = header.strata
        search = Search(
            self.family,
            parse(header.constraint),
            header.seed,
            header.params,
            strata_constraints(header.constraint, edges),
        )
        for k, one in enumerate(search.found(header.count, self.tries, self.tell)):
            if k < first:
                continue
            metrics: Mapping[str, float] = {}
            if header.metrics:
                metrics = measure(one.world).as_dict()
            elif edges:
                metrics = {"difficulty": one.metrics["difficulty"]}
            made = Made.of(one.world, _params_of(one.world), metrics)
            yield replace(made, stratum=edges[one.part : one.part + 2])


def plan_wanted_set(
    family: Family | str,
    seed: int,
    count: int,
    given: Mapping[str, Value],
    *,
    where: str | None = None,
    difficulty: float | tuple[float, float] | None = None,
    tries: int | None = None,
    metrics: bool = True,
    tell: Callable[[Search], None] | None = None,
) -> WantedPlan:
    """Return the plan of ``count`` different worlds whose metrics satisfy a constraint.

    Args:
        family: The family, or the name of a registered one.
        seed: Seed of the search.
        count: Number of worlds.
        given: Parameters that keep their values; the others vary.
        where: A constraint, such as ``"detour > 3"``.
        difficulty: The difficulty to aim for, 0 to 1; or a range, over which the worlds are spread
            evenly.
        tries: Limit on the worlds made per world found; 500 if omitted.
        metrics: True to measure every metric of each world. The difficulty of worlds that are
            spread over a range is measured in any case.
        tell: Called after each try.

    Raises:
        InvalidParameter: If the constraint cannot be parsed, or a parameter is unknown.
    """
    admit_argument(family)
    made_by = family if isinstance(family, Family) else FAMILIES.get(family)
    made_by.complete(given)
    constraint = constraint_for(where, difficulty).text
    edges = strata_edges(*difficulty, count) if isinstance(difficulty, tuple) else ()
    header = msgspec.structs.replace(
        header_of(made_by, given, seed, count, metrics=metrics), constraint=constraint, strata=edges
    )
    return WantedPlan(family=made_by, header=header, tries=tries or TRIES, tell=tell)


@dataclass(frozen=True)
class StratumCount:
    """The number of worlds in a stratum, and its equal share."""

    low: float
    high: float
    worlds: int
    share: int


def strata_of(manifest: Manifest) -> list[StratumCount]:
    """Return the number of worlds in each stratum of a set; empty if it has no strata."""
    edges = manifest.header.strata
    count = manifest.header.count
    strata = len(edges) - 1
    totals = Counter(entry.stratum for entry in manifest.entries)
    return [
        StratumCount(low, high, totals[low, high], count // strata + (k < count % strata))
        for k, (low, high) in enumerate(pairwise(edges))
    ]


def _params_of(world: World) -> Mapping[str, Value]:
    # generate() gives no world without a provenance.
    return cast("Provenance", world.provenance).params
