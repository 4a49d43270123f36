"""Known failures: their classes are no news."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from fuzz.corpus.entry import Facts
from fuzz.corpus.reading import read_corpus
from worldgen.world import World

__all__ = ["Baseline"]


@dataclass(frozen=True)
class Baseline:
    """Classes that are known.

    Args:
        classes: Controller, motion model and class of each.
    """

    classes: frozenset[tuple[str, str, str]] = frozenset()

    @classmethod
    def read(cls, paths: Iterable[Path]) -> Baseline:
        """The classes of the failures in folders, archives and files.

        Raises:
            FormatError: If a path or a file cannot be read.
        """
        return cls(frozenset(entry.facts.key for entry in read_corpus(paths).entries))

    def has(self, failure: World) -> bool:
        """Whether a failure is of a class that is known."""
        facts = Facts.of(failure, "the failure")
        return facts is not None and facts.key in self.classes
