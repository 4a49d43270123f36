"""What a set is to hold, before any of it is made."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from importlib.metadata import version

from worldgen.errors import InvalidParameter
from worldgen.family import FAMILIES, Family
from worldgen.random_streams import MASK64
from worldgen.sets.making import Job, Made, make_all
from worldgen.sets.manifest import ManifestHeader
from worldgen.world import Value

__all__ = ["SetPlan", "file_name", "plan_set"]

_FLAT = 10_000  # worlds at most in one folder
_SHARD = 1_000  # worlds in each subfolder where there are more
_ODD = re.compile(r"[^A-Za-z0-9._-]+")


@dataclass(frozen=True)
class SetPlan:
    """A set that is wanted.

    Args:
        family: The family as the registry finds it: its name, or ``./file.py:name``.
        header: The manifest's first line.
    """

    family: str
    header: ManifestHeader

    def jobs(self, first: int = 0) -> Iterator[Job]:
        """Yield the worlds from this one on, counted from 0."""
        for k in range(first, self.header.count):
            yield Job(
                self.family, self.seed(k), self.header.params, None if self.header.metrics else {}
            )

    def made(self, first: int, workers: int) -> Iterator[Made]:
        """Make the worlds from this one on, in so many processes."""
        return make_all(self.jobs(first), workers)

    def seed(self, k: int) -> int:
        """Return the seed of the world counted ``k`` from 0."""
        return (self.header.seed + k) & MASK64

    def with_seed(self, seed: int) -> SetPlan:
        """Return the same, from another seed on."""
        return replace(self, header=replace(self.header, seed=seed))

    def file(self, k: int) -> str:
        """Return the name of the file of the world counted ``k`` from 0."""
        return file_name(self.header, k, str(self.seed(k)))


def file_name(header: ManifestHeader, k: int, called: str) -> str:
    """Return the file name of the world counted ``k`` from 0, in a subfolder if there are many."""
    name = f"{_ODD.sub('-', header.family).lstrip('.') or 'world'}-{called}.grid"
    return f"{k // _SHARD:04}/{name}" if header.count > _FLAT else name


def plan_set(
    family: str, seed: int, count: int, params: Mapping[str, Value], *, metrics: bool = True
) -> SetPlan:
    """Return the plan of ``count`` worlds with seeds from ``seed`` on.

    Args:
        family: Name of a registered family, or ``./file.py:name``.
        seed: Of the first world.
        count: How many.
        params: The family's parameters; those left out have their defaults.
        metrics: Whether each world is measured.

    Raises:
        InvalidParameter: If the family or a parameter is unknown, or there is to be no world at
            all.
    """
    if count < 1:
        raise InvalidParameter(
            "below-minimum", "count={count} is below 1; a set has at least one world", count=count
        )
    found: Family = FAMILIES.get(family)
    complete = found.complete(params)
    header = ManifestHeader(
        found.name, found.version, complete, seed & MASK64, count, metrics, version("worldgen")
    )
    return SetPlan(family, header)
