"""Plan the contents of a set before any of it is made."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from importlib.metadata import version
from typing import Self

import msgspec

from worldgen.domain import MASK64
from worldgen.errors import InvalidParameter
from worldgen.family import FAMILIES, Family
from worldgen.plugins.trust import admit_argument
from worldgen.sets.making import Job, Made, make_all
from worldgen.sets.manifest import ManifestHeader
from worldgen.world import Value

# Limit on the worlds in one folder.
_FLAT = 10_000
# Worlds in each subfolder if there are more.
_SHARD = 1_000
_ODD = re.compile(r"[^A-Za-z0-9._-]+")


@dataclass(frozen=True, kw_only=True)
class SetPlan(ABC):
    """The plan of a set: its header, and how to make its worlds.

    Args:
        header: First line of the set's manifest.
    """

    header: ManifestHeader

    def with_seed(self, seed: int) -> Self:
        """Return the same plan with another seed."""
        return replace(self, header=msgspec.structs.replace(self.header, seed=seed))

    @abstractmethod
    def made(self, first: int, workers: int) -> Iterator[Made]:
        """Make the worlds starting with this one, counted from 0.

        Args:
            first: Number of the first world.
            workers: Number of processes, if the plan can use several.
        """

    def file(self, k: int) -> str:
        """Return the name of the file of the world counted ``k`` from 0.

        It has the world's number, because two worlds of a search can have the same seed.
        """
        return self._file(k, f"{k + 1:0{len(str(self.header.count))}d}")

    def _file(self, k: int, suffix: str) -> str:
        """Return a file's name; large sets have subfolders."""
        name = f"{_ODD.sub('-', self.header.family).lstrip('.') or 'world'}-{suffix}.grid"
        return f"{k // _SHARD:04}/{name}" if self.header.count > _FLAT else name


@dataclass(frozen=True, kw_only=True)
class SeededPlan(SetPlan):
    """A set of worlds with consecutive seeds.

    Args:
        family: The family as the registry finds it: its name, or ``./file.py:name``.
    """

    family: str

    def jobs(self, first: int = 0) -> Iterator[Job]:
        """Yield the worlds to make, starting with this one, counted from 0."""
        for k in range(first, self.header.count):
            yield Job(
                self.family, self.seed(k), self.header.params, None if self.header.metrics else {}
            )

    def made(self, first: int, workers: int) -> Iterator[Made]:
        """Make the worlds starting with this one, in this many processes."""
        return make_all(self.jobs(first), workers)

    def seed(self, k: int) -> int:
        """Return the seed of the world counted ``k`` from 0."""
        return (self.header.seed + k) & MASK64

    def file(self, k: int) -> str:
        """Return the name of the file of the world counted ``k`` from 0."""
        return self._file(k, str(self.seed(k)))


def plan_set(
    family: str, seed: int, count: int, params: Mapping[str, Value], *, metrics: bool = True
) -> SeededPlan:
    """Return the plan of ``count`` worlds with consecutive seeds starting at ``seed``.

    Args:
        family: Name of a registered family, or ``./file.py:name``.
        seed: Seed of the first world.
        count: Number of worlds.
        params: The family's parameters; omitted ones have their defaults.
        metrics: True to measure each world.

    Raises:
        InvalidParameter: If the family or a parameter is unknown, or the count is 0.
    """
    if count < 1:
        raise InvalidParameter(
            "below-minimum", "count={count} is below 1; a set has at least one world", count=count
        )
    admit_argument(family)
    found: Family = FAMILIES.get(family)
    complete = found.provenance(seed, found.complete(params)).params
    header = header_of(found, complete, seed, count, metrics=metrics)
    return SeededPlan(family=family, header=header)


def header_of(
    family: Family, params: Mapping[str, Value], seed: int, count: int, *, metrics: bool
) -> ManifestHeader:
    """Return the first line of the manifest of a set that this version of worldgen makes.

    Args:
        family: The family.
        params: Parameters with fixed values.
        seed: Seed of the first world, or of the search.
        count: Number of worlds.
        metrics: True to measure every metric of each world.
    """
    return ManifestHeader(
        family.name, family.version, params, seed & MASK64, count, metrics, version("worldgen")
    )
