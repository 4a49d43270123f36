"""The form of an overview in JSON; ``docs/reference/verdicts.md`` describes its parts."""

from __future__ import annotations

import re
from typing import Annotated, Any

import msgspec

from fuzz.campaign.store import MEMORY
from fuzz.cause import Severity

_Count = Annotated[int, msgspec.Meta(ge=0)]

# In a file: a failure of the campaign, or its original before shrinking;
# nothing outside its folder.
_File = Annotated[
    str, msgspec.Meta(pattern=rf"^(({re.escape(MEMORY)}/failures/)?[^/\\]+\.grid)?\Z")
]
_SEVERITIES = frozenset(severity.word for severity in Severity)


class CauseRow(msgspec.Struct, frozen=True, kw_only=True):
    """A cause and its occurrences; see :class:`fuzz.overview.causes.CauseTotals`."""

    cause: str
    sentence: str
    advice: str
    severity: str
    state: str
    met: _Count
    verdicts: dict[str, _Count]
    natural: _Count | None
    groups: list[str]
    files: list[_File]
    file: _File
    smallest: _File
    fault: str = ""  # earlier versions did not write it
    repeats: str = ""  # the same
    inside: dict[str, Any] | None = None
    reactions: list[list[Any]] = []
    why: str
    changes: list[dict[str, Any]] = []

    def __post_init__(self) -> None:
        if self.severity not in _SEVERITIES:
            raise ValueError(f"{self.severity!r} is not a severity")


class NaturalTally(msgspec.Struct, frozen=True):
    """Counts of natural worlds under one name."""

    worlds: _Count
    arrived: _Count


class NaturalRow(msgspec.Struct, frozen=True, kw_only=True):
    """The results in natural worlds; see :class:`fuzz.overview.natural.NaturalRuns`."""

    worlds: _Count
    arrived: _Count
    unsensed: _Count
    share: float | None
    low: float
    high: float
    verdicts: dict[str, _Count]
    causes: dict[str, _Count]
    families: dict[str, NaturalTally]
    clearances: dict[str, NaturalTally]
    turns: dict[str, NaturalTally]
    complete: bool


class ChangesRow(msgspec.Struct, frozen=True):
    """Names that are new, still there, or fixed."""

    new: list[str]
    still: list[str]
    fixed: list[str]


class ComparisonRow(msgspec.Struct, frozen=True, kw_only=True):
    """Changes since an earlier campaign; see :class:`fuzz.overview.comparison.RegressionView`."""

    against: str
    causes: ChangesRow
    sentence: str


class OverviewTable(msgspec.Struct, frozen=True, kw_only=True):
    """An overview: what ``worldgen fuzz --json`` adds to its summary, and ``overview.json``."""

    causes: list[CauseRow]
    natural: NaturalRow | None = None
    comparison: ComparisonRow | None = None
