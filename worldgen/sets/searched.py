"""Sets of worlds found by searching for their metrics, or spread over a range of difficulty."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import cast

import msgspec

from worldgen.difficulty import measure
from worldgen.difficulty.search import TRIES, Search, constraint_for, found
from worldgen.difficulty.strata import StrataSearch, edges_of
from worldgen.family import FAMILIES, Family
from worldgen.plugins.trust import admit_argument
from worldgen.sets.making import Made
from worldgen.sets.manifest import Manifest
from worldgen.sets.plan import SearchedPlan, header_of
from worldgen.world import Provenance, Value, World


@dataclass(frozen=True, kw_only=True)
class WantedPlan(SearchedPlan):
    """A set whose worlds are found one after another by one search.

    Args:
        tell: Called after each try.
    """

    tell: Callable[[Search], None] | None = None

    def made(self, first: int, workers: int) -> Iterator[Made]:
        """Make the worlds, starting with this one.

        The search repeats what it found before, because later finds depend on it.
        """
        header = self.header
        search = Search(
            self.family, constraint_for(header.constraint), header.seed, self.header.params
        )
        for k, one in enumerate(found(search, header.count, self.tries, self.tell)):
            if k >= first:
                metrics = measure(one.world).as_dict() if header.metrics else {}
                yield Made.of(one.world, _params_of(one.world), metrics)


def plan_wanted_set(
    family: Family | str,
    seed: int,
    count: int,
    given: Mapping[str, Value],
    *,
    where: str | None = None,
    difficulty: float | None = None,
    tries: int = TRIES,
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
        difficulty: The difficulty to aim for, 0 to 1.
        tries: Limit on the worlds made per world found.
        metrics: True to measure every metric of each world.
        tell: Called after each try.

    Raises:
        InvalidParameter: If the constraint cannot be parsed, or a parameter is unknown.
    """
    admit_argument(family)
    made_by = family if isinstance(family, Family) else FAMILIES.get(family)
    made_by.complete(given)
    constraint = constraint_for(where, difficulty).text
    header = msgspec.structs.replace(
        header_of(made_by, given, seed, count, metrics=metrics), constraint=constraint
    )
    return WantedPlan(family=made_by, header=header, tries=tries, tell=tell)


@dataclass(frozen=True, kw_only=True)
class StratifiedPlan(SearchedPlan):
    """A set with equally many worlds in each stratum of a range of difficulty, found by one search.

    Args:
        where: Further constraint on each world.
    """

    where: str | None

    def made(self, first: int, workers: int) -> Iterator[Made]:
        """Make the worlds, starting with this one.

        The search repeats its earlier finds, because later ones depend on them.
        """
        header = self.header
        search = StrataSearch(
            self.family,
            header.strata,
            header.count,
            header.seed,
            self.header.params,
            where=self.where,
            tries=self.tries,
        )
        for k, one in enumerate(search.found()):
            if k >= first:
                metrics = (
                    measure(one.world).as_dict()
                    if header.metrics
                    else {"difficulty": one.difficulty}
                )
                yield replace(
                    Made.of(one.world, _params_of(one.world), metrics), stratum=one.stratum
                )


def plan_stratified_set(
    family: Family | str,
    seed: int,
    count: int,
    given: Mapping[str, Value],
    *,
    difficulty: tuple[float, float],
    where: str | None = None,
    tries: int = TRIES,
    metrics: bool = True,
) -> StratifiedPlan:
    """Return the plan of ``count`` different worlds, spread evenly over a range of difficulty.

    Args:
        family: The family, or the name of a registered one.
        seed: Seed of the search.
        count: Number of worlds.
        given: Parameters that keep their values; the others vary.
        difficulty: Lower and upper end of the range, inside 0 to 1.
        where: Further constraint on each world, such as ``"detour > 3"``.
        tries: Worlds made without success for a stratum before it is abandoned and its neighbours
            get its share.
        metrics: True to measure every metric of each world; its difficulty is measured in any case.

    Raises:
        InvalidParameter: If the range or the constraint cannot be parsed, or a parameter is
            unknown.
    """
    admit_argument(family)
    made_by = family if isinstance(family, Family) else FAMILIES.get(family)
    made_by.complete(given)
    low, high = difficulty
    edges = edges_of(low, high, count)
    constraint = f"{low:g} <= difficulty <= {high:g}" + (f" and ({where})" if where else "")
    header = msgspec.structs.replace(
        header_of(made_by, given, seed, count, metrics=metrics), constraint=constraint, strata=edges
    )
    return StratifiedPlan(family=made_by, header=header, where=where, tries=tries)


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
