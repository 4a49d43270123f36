"""The result of a campaign, as data: does it work, how bad is it, why, and what to do.

The terminal, ``--json``, reports, CI files and the studio all show these records. A campaign keeps
them in ``.campaign/overview.json``; ``docs/reference/verdicts.md`` describes the parts.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Literal

import msgspec

from fuzz.campaign.store import MEMORY, OVERVIEW_FILE, Summary
from fuzz.cause import Cause, Severity
from fuzz.overview.counterfactual import Change
from fuzz.triage.inside import Inside
from fuzz.triage.reactions import Reaction
from worldgen.files.json_file import JsonFile
from worldgen.support.intervals import interval_95

_Count = Annotated[int, msgspec.Meta(ge=0)]

# In a file: a failure of the campaign, or its original before shrinking;
# nothing outside its folder.
_File = Annotated[
    str, msgspec.Meta(pattern=rf"^(({re.escape(MEMORY)}/failures/)?[^/\\]+\.grid)?\Z")
]
_SEVERITIES = frozenset(severity.word for severity in Severity)


class CauseResult(msgspec.Struct, frozen=True, kw_only=True):
    """A cause, and its occurrences in a campaign.

    Args:
        cause: The cause.
        sentence: What goes wrong in ``file``, in one sentence.
        advice: What to do about it.
        severity: How bad it is.
        state: ``new`` or ``still`` compared with the known failures; empty if there were none.
        met: Number of examined failures.
        verdicts: The same by verdict.
        natural: Number of natural worlds in which it occurred; ``None`` if none were tried.
        groups: Names under which its failures are filed: its own or, if errors have different
            reasons, theirs.
        files: All its files, the clearest first.
        file: File of the world to look at, relative to the campaign's folder, or an empty
            string.
        smallest: File of the simplest world, or an empty string.
        fault: The controller's error in ``file``, and its place: ``mine.py:6: KeyError: 'left'``;
            empty if the controller raised none.
        repeats: See :class:`fuzz.triage.run_facts.RunFacts`, as for the next two.
        inside: What runs inside the controller in ``file``.
        reactions: What the robot does by what is around it.
        why: After which single changes the robot of ``file`` arrives; empty if that was not tried.
        changes: These changes.
    """

    cause: Cause
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
    inside: Inside | None = None
    reactions: list[Reaction] = []
    why: str
    changes: list[Change] = []

    def __post_init__(self) -> None:
        if self.severity not in _SEVERITIES:
            raise ValueError(f"{self.severity!r} is not a severity")

    @classmethod
    def of(
        cls,
        cause: Cause,
        groups: Sequence[str] = (),
        verdicts: Mapping[str, int] | None = None,
        natural: int | None = None,
    ) -> CauseResult:
        """Return a cause of which no world has been chosen yet."""
        counts = dict(verdicts or {})
        return cls(
            cause=cause,
            sentence=cause.sentence,
            advice=cause.advice,
            severity=cause.severity.word,
            state="",
            met=sum(counts.values()),
            verdicts=counts,
            natural=natural,
            groups=list(groups),
            files=[],
            file="",
            smallest="",
            why="",
        )

    @property
    def is_met(self) -> bool:
        """True if a world of the search or a natural one shows it, and not only a shrunk one."""
        return self.met > 0 or bool(self.natural)


class NaturalTally(msgspec.Struct, frozen=True):
    """Counts of natural worlds under one name."""

    worlds: _Count
    arrived: _Count


class NaturalResult(msgspec.Struct, frozen=True, kw_only=True):
    """A controller's results in natural worlds.

    Args:
        worlds: Number of worlds run, except those in which a hazard that the controller cannot
            sense harmed the robot, because it could not have avoided it.
        arrived: Number of these in which the robot arrived.
        unsensed: Number of worlds in which such a hazard harmed it.
        share: Share of the worlds in which it arrived; ``None`` if none were run.
        low: Lower end of the 95 % interval of that share.
        high: Its upper end.
        verdicts: Counts of each verdict.
        causes: Counts of each cause.
        families: By family, the worlds run and those in which the robot arrived.
        clearances: By name in :data:`fuzz.overview.natural.CLEARANCES`, the same.
        turns: By name in :data:`fuzz.overview.natural.TURNS`, the same.
        complete: False if time ran out before all worlds were run.
    """

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

    @property
    def finished(self) -> int:
        """Number of worlds run, with those in which such a hazard harmed the robot."""
        return self.worlds + self.unsensed

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % interval of the share, not rounded."""
        return interval_95(self.arrived, self.worlds)

    @property
    def percent(self) -> int:
        """The share in percent; 100 only for all worlds, 0 if none were run."""
        share = round(100 * self.arrived / max(self.worlds, 1))
        return min(share, 99 + (self.arrived == self.worlds))


class CampaignComparison(msgspec.Struct, frozen=True, kw_only=True):
    """What changed since an earlier campaign or a baseline.

    Failures are compared by group: by cause, or by the reason of an error.

    Args:
        against: ``baseline`` or ``last campaign``.
        causes: Groups that are new, that still fail, and that no longer fail.
        sentence: All of it as a sentence without a full stop.
    """

    against: str
    causes: dict[Literal["new", "still", "fixed"], list[str]]
    sentence: str


class CampaignResult(msgspec.Struct, frozen=True, kw_only=True):
    """What a campaign found.

    Args:
        causes: The causes, the worst first.
        natural: The results in natural worlds; ``None`` if none were run.
        comparison: Changes since an earlier campaign; ``None`` if it is the first.
        summary: Its numbers; not set if unknown. They have a file of their own, which the campaign
            also writes while it runs.
    """

    causes: list[CauseResult]
    natural: NaturalResult | None = None
    comparison: CampaignComparison | None = None
    summary: Summary | msgspec.UnsetType = msgspec.UNSET


_FILE = JsonFile(
    CampaignResult,
    version=2,
    code="invalid-overview",
    problem="not an overview of a campaign: {reason}",
    remedy="run the campaign again, or delete the file if you don't need the overview",
)


def write_overview(result: CampaignResult, folder: Path) -> None:
    """Write a result, without its numbers, into a campaign's folder.

    Raises:
        OutputError: If it cannot be written.
    """
    _FILE.write(
        folder / MEMORY / OVERVIEW_FILE, msgspec.structs.replace(result, summary=msgspec.UNSET)
    )


def read_overview(folder: Path) -> CampaignResult | None:
    """Return the stored result of a campaign without its numbers, or ``None`` before its end.

    The form is checked, so that pages can rely on it whatever the file's origin.

    Raises:
        FormatError: If the file cannot be read, or is not an overview of version 2.
    """
    return _FILE.find(folder / MEMORY / OVERVIEW_FILE)
