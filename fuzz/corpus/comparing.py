"""What one corpus has that another has not, class by class."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from fuzz.corpus.entry import Entry
from fuzz.corpus.merging import smallest

__all__ = ["Change", "Difference", "differences"]

Change = Literal["new", "gone", "smaller", "larger", "same"]


@dataclass(frozen=True)
class Difference:
    """A class of failures in two corpora.

    Args:
        change: What happened to it.
        old: The smallest failure of it in the old corpus, if there is one.
        new: The smallest in the new one, likewise.
    """

    change: Change
    old: Entry | None
    new: Entry | None

    @property
    def entry(self) -> Entry:
        """The failure to look at: the new one, unless it is gone.

        Raises:
            ValueError: If there is neither.
        """
        found = self.new or self.old
        if found is None:
            raise ValueError("a difference without a failure")
        return found


def differences(old: Iterable[Entry], new: Iterable[Entry]) -> list[Difference]:
    """Every class of either corpus, by controller, motion model and class, the new ones first."""
    before, now = smallest(old), smallest(new)
    found = [_difference(before.get(key), now.get(key)) for key in sorted(before.keys() | now.keys())]
    return sorted(found, key=lambda difference: difference.change != "new")


def _difference(old: Entry | None, new: Entry | None) -> Difference:
    if old is None:
        return Difference("new", old, new)
    if new is None:
        return Difference("gone", old, new)
    if new.facts.size == old.facts.size:
        return Difference("same", old, new)
    return Difference("smaller" if new.facts.size < old.facts.size else "larger", old, new)
