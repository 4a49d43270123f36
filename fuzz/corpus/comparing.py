"""Compare two corpora cause by cause."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from fuzz.corpus.entry import CorpusEntry
from fuzz.corpus.merging import smallest

Difference = Literal["new", "gone", "smaller", "larger", "same"]


@dataclass(frozen=True)
class CauseDifference:
    """The failures of one cause in two corpora.

    Args:
        change: How they changed.
        old: Its simplest failure in the old corpus, if there is one.
        new: Its simplest failure in the new corpus, if there is one.
    """

    change: Difference
    old: CorpusEntry | None
    new: CorpusEntry | None

    @property
    def entry(self) -> CorpusEntry:
        """The failure to look at: the new one, unless only the old one exists.

        Raises:
            ValueError: If there is neither.
        """
        found = self.new or self.old
        if found is None:
            raise ValueError("a difference without a failure")
        return found


def differences(old: Iterable[CorpusEntry], new: Iterable[CorpusEntry]) -> list[CauseDifference]:
    """Return every cause of either corpus by controller, motion and name, new ones first."""
    before = smallest(old)
    now = smallest(new)
    found = [
        _difference(before.get(key), now.get(key)) for key in sorted(before.keys() | now.keys())
    ]
    return sorted(found, key=lambda difference: difference.change != "new")


def _difference(old: CorpusEntry | None, new: CorpusEntry | None) -> CauseDifference:
    if old is None:
        return CauseDifference("new", old, new)
    if new is None:
        return CauseDifference("gone", old, new)
    if new.facts.size == old.facts.size:
        return CauseDifference("same", old, new)
    return CauseDifference("smaller" if new.facts.size < old.facts.size else "larger", old, new)
