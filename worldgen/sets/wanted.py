"""Sets of worlds found by searching for their metrics."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

from msgspec.structs import replace

from worldgen.difficulty import measure
from worldgen.difficulty.search import TRIES, Search, constraint_for, found
from worldgen.family import FAMILIES, Family
from worldgen.sets.making import Made
from worldgen.sets.plan import SearchedPlan, header_of
from worldgen.world import Provenance, Value

__all__ = ["WantedPlan", "plan_wanted_set"]


@dataclass(frozen=True, kw_only=True)
class WantedPlan(SearchedPlan):
    """A set whose worlds are found one after another by one search.

    Args:
        tell: Called after each try.
    """

    tell: Callable[[Search], None] | None = None

    def made(self, first: int, workers: int) -> Iterator[Made]:
        """Make the worlds from this one on.

        The search repeats what it found before, because later finds depend on it.
        """
        header = self.header
        search = Search(self.family, constraint_for(header.constraint), header.seed, self.given)
        for k, one in enumerate(found(search, header.count, self.tries, self.tell)):
            if k >= first and isinstance(provenance := one.world.provenance, Provenance):
                metrics = measure(one.world).as_dict() if header.metrics else {}
                yield Made.of(one.world, provenance.params, metrics)


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
    made_by = family if isinstance(family, Family) else FAMILIES.get(family)
    made_by.complete(given)
    fixed = {**given, **made_by.constants}
    constraint = constraint_for(where, difficulty).text
    header = replace(header_of(made_by, fixed, seed, count, metrics=metrics), constraint=constraint)
    return WantedPlan(family=made_by, header=header, tries=tries, tell=tell)
