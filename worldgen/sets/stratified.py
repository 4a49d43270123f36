"""Sets of worlds that are spread evenly over a range of difficulty."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from importlib.metadata import version
from itertools import pairwise
from typing import cast

from worldgen.difficulty import measure
from worldgen.difficulty.search import TRIES
from worldgen.difficulty.strata import StrataSearch, edges_of
from worldgen.family import FAMILIES, Family
from worldgen.random_streams import MASK64
from worldgen.sets.making import Made
from worldgen.sets.manifest import Manifest, ManifestHeader
from worldgen.sets.plan import file_name
from worldgen.world import Provenance, Value

__all__ = ["StratifiedPlan", "StratumCount", "plan_stratified_set", "strata_of"]


@dataclass(frozen=True)
class StratifiedPlan:
    """A set with equally many worlds in each stratum of a range of difficulty, found by one search.

    Args:
        family: The family.
        header: The manifest's first line; its parameters are those that are fixed.
        where: What else is wished of each world.
        tries: Worlds made for a stratum in vain before it is given up.
    """

    family: Family
    header: ManifestHeader
    where: str | None
    tries: int

    def with_seed(self, seed: int) -> StratifiedPlan:
        """Return the same by a search with another seed."""
        return replace(self, header=replace(self.header, seed=seed))

    def made(self, first: int, workers: int) -> Iterator[Made]:
        """Yield the worlds from this one on.

        What the search found before it is found again, for the next depend on it.
        """
        header = self.header
        given = {
            name: value
            for name, value in header.params.items()
            if name not in self.family.constants
        }
        search = StrataSearch(
            self.family,
            header.strata,
            header.count,
            header.seed,
            given,
            where=self.where,
            tries=self.tries,
        )
        for k, one in enumerate(search.found()):
            if k >= first:
                params = cast(
                    "Provenance", one.world.provenance
                ).params  # generate() gives no world without one
                metrics = (
                    measure(one.world).as_dict()
                    if header.metrics
                    else {"difficulty": one.difficulty}
                )
                yield replace(Made.of(one.world, params, metrics), stratum=one.stratum)

    def file(self, k: int) -> str:
        """Return the name of the file of the world counted ``k`` from 0.

        Its number, for two may have one seed.
        """
        return file_name(self.header, k, f"{k + 1:0{len(str(self.header.count))}d}")


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
        seed: Of the search.
        count: How many.
        given: Parameters that keep their values; the others vary.
        difficulty: Lower and upper end of the range, inside 0 to 1.
        where: What else is wished of each world, like ``"detour > 3"``.
        tries: Worlds made for a stratum in vain before it is given up, and its worlds left to its
            neighbours.
        metrics: Whether every metric of each world is measured; its difficulty is in any case.

    Raises:
        InvalidParameter: If the range or the wish cannot be read, or a parameter is unknown.
    """
    made_by = family if isinstance(family, Family) else FAMILIES.get(family)
    made_by.complete(given)
    fixed = {**given, **made_by.constants}
    low, high = difficulty
    edges = edges_of(low, high, count)
    wish = f"{low:g} <= difficulty <= {high:g}" + (f" and ({where})" if where else "")
    header = ManifestHeader(
        made_by.name,
        made_by.version,
        fixed,
        seed & MASK64,
        count,
        metrics,
        version("worldgen"),
        wish,
        edges,
    )
    return StratifiedPlan(made_by, header, where, tries)


@dataclass(frozen=True)
class StratumCount:
    """How many worlds a stratum has, and how many its equal share is."""

    low: float
    high: float
    worlds: int
    share: int


def strata_of(manifest: Manifest) -> list[StratumCount]:
    """Return how the worlds of a set are spread over its strata; nothing if it has none."""
    edges = manifest.header.strata
    count = manifest.header.count
    strata = len(edges) - 1
    found = Counter(entry.stratum for entry in manifest.entries)
    return [
        StratumCount(low, high, found[low, high], count // strata + (k < count % strata))
        for k, (low, high) in enumerate(pairwise(edges))
    ]
