"""Sets of worlds that are searched for by their metrics."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from importlib.metadata import version

from worldgen.difficulty import measure
from worldgen.difficulty.search import TRIES, Search, constraint_for, found
from worldgen.family import FAMILIES, Family
from worldgen.random_streams import MASK64
from worldgen.sets.making import Made
from worldgen.sets.manifest import ManifestHeader
from worldgen.sets.plan import file_name
from worldgen.world import Provenance, Value

__all__ = ["WantedPlan", "plan_wanted_set"]


@dataclass(frozen=True)
class WantedPlan:
    """A set whose worlds are searched for, one after another, by one search.

    Args:
        family: The family.
        header: The manifest's first line; its parameters are those that are fixed.
        tries: Worlds that the search makes at most for each that it finds.
        tell: Called after each try.
    """

    family: Family
    header: ManifestHeader
    tries: int
    tell: Callable[[Search], None] | None = None

    def with_seed(self, seed: int) -> WantedPlan:
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
        search = Search(self.family, constraint_for(header.wish), header.seed, given)
        for k, one in enumerate(found(search, header.count, self.tries, self.tell)):
            if k >= first and isinstance(provenance := one.world.provenance, Provenance):
                metrics = measure(one.world).as_dict() if header.metrics else {}
                yield Made.of(one.world, provenance.params, metrics)

    def file(self, k: int) -> str:
        """Return the name of the file of the world counted ``k`` from 0.

        Its number, for two may have one seed.
        """
        return file_name(self.header, k, f"{k + 1:0{len(str(self.header.count))}d}")


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
    """Return the plan of ``count`` different worlds whose metrics are as wished.

    Args:
        family: The family, or the name of a registered one.
        seed: Of the search.
        count: How many.
        given: Parameters that keep their values; the others vary.
        where: A wish, like ``"detour > 3"``.
        difficulty: The difficulty wanted, 0 to 1.
        tries: Worlds that the search makes at most for each that it finds.
        metrics: Whether every metric of each world is measured.
        tell: Called after each try.

    Raises:
        InvalidParameter: If the wish cannot be read, or a parameter is unknown.
    """
    made_by = family if isinstance(family, Family) else FAMILIES.get(family)
    made_by.complete(given)
    fixed = {**given, **made_by.constants}
    wish = constraint_for(where, difficulty).text
    header = ManifestHeader(
        made_by.name,
        made_by.version,
        fixed,
        seed & MASK64,
        count,
        metrics,
        version("worldgen"),
        wish,
    )
    return WantedPlan(made_by, header, tries, tell)
