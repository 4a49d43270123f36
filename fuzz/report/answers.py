"""Collect the facts of the report's first screen: does it work, how bad is it, why, what to do."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from fuzz.cause import Severity
from fuzz.corpus import CorpusEntry
from fuzz.corpus.entry import Facts
from fuzz.failure import Failure
from fuzz.overview.building import WorldFile, with_worlds
from fuzz.overview.causes import causes_of
from fuzz.overview.natural import whole_percent
from fuzz.overview.overview import read_overview
from fuzz.overview.table import CauseRow, ComparisonRow, NaturalRow
from fuzz.overview.terminal import how_often_it_arrives, never_tried
from fuzz.report.gather import ReportedCampaign
from fuzz.triage.diagnosis import cause_of
from worldgen.errors import WorldgenError
from worldgen.files.json_file import plain


@dataclass(frozen=True)
class ControllerSummary:
    """The facts known about one controller under one motion model.

    Args:
        controller: With its options.
        motion: Name of the motion model.
        causes: Its causes, the worst first; their files are paths.
        natural: Its results in natural worlds, if a campaign ran some.
        comparison: What changed since an earlier campaign, if one was compared.
        campaign: Index of the campaign on the page; -1 for none.
    """

    controller: str
    motion: str
    causes: Sequence[CauseRow]
    natural: NaturalRow | None = None
    comparison: ComparisonRow | None = None
    campaign: int = -1

    def table(self) -> dict[str, Any]:
        """Return the contents of the page."""
        return {
            "controller": self.controller,
            "motion": self.motion,
            "causes": [_shown(cause) for cause in self.causes],
            "natural": None if self.natural is None else _natural(self.natural),
            "comparison": None if self.comparison is None else plain(self.comparison),
            "arrives": how_often_it_arrives(self.natural),
            "campaign": self.campaign,
        }


def _natural(natural: NaturalRow) -> dict[str, Any]:
    """Return natural worlds with what follows from them, so that page and terminal agree."""
    return {
        **plain(natural),
        "percent": whole_percent(natural.arrived, natural.worlds),
        "never": never_tried(natural),
    }


def _shown(cause: CauseRow) -> dict[str, Any]:
    """Return a cause without the facts about its run, which the page has from running it again."""
    facts = ("inside", "reactions")
    return {name: value for name, value in plain(cause).items() if name not in facts}


def answers_for(
    entries: Sequence[CorpusEntry], campaigns: Sequence[ReportedCampaign]
) -> list[ControllerSummary]:
    """Return an answer for each campaign, and for each controller without a campaign.

    Args:
        entries: The failures of the report.
        campaigns: The campaigns whose folders were given.

    Raises:
        FormatError: If a file cannot be read.
    """
    answers = []
    told: set[tuple[str, str]] = set()
    for index, campaign in enumerate(campaigns):
        overview = read_overview(campaign.folder)
        if overview is None:
            continue
        summary = campaign.summary
        answers.append(
            ControllerSummary(
                summary.controller,
                summary.motion,
                [_placed(cause, campaign.folder) for cause in overview.causes],
                overview.natural,
                overview.comparison,
                index,
            )
        )
        told.add((summary.controller, summary.motion))
    others: dict[tuple[str, str], list[CorpusEntry]] = {}
    for entry in entries:
        key = (entry.facts.controller, entry.facts.motion)
        if key not in told:
            others.setdefault(key, []).append(entry)
    answers += [_of_entries(*key, found) for key, found in sorted(others.items())]
    return sorted(answers, key=_worst)


def _worst(answer: ControllerSummary) -> int:
    """Return the severity of the worst cause, so that the worst controller comes first."""
    words = [severity.word for severity in Severity]
    found = [words.index(cause.severity) for cause in answer.causes[:1]]
    return found[0] if found else len(words)


def entry_of(path: Path) -> CorpusEntry | None:
    """Return the entry of a failure's file; ``None`` if it does not exist or cannot be read."""
    try:
        return CorpusEntry(path, Facts.of(Failure.read(path), str(path)))
    except WorldgenError:
        return None


def _placed(cause: CauseRow, folder: Path) -> CauseRow:
    """Return a cause with the folder added to its files."""
    file = str(folder / cause.file) if cause.file else ""
    smallest = str(folder / cause.smallest) if cause.smallest else ""
    return msgspec.structs.replace(cause, file=file, smallest=smallest)


def _of_entries(controller: str, motion: str, entries: Iterable[CorpusEntry]) -> ControllerSummary:
    """Return the answer for failures without a known campaign: their causes.

    The page shows the code of each failure's controller, so the causes need not.
    """
    files = [
        WorldFile(Failure.read(entry.path), str(entry.path))
        for entry in entries
        if entry.path.is_file()
    ]
    causes = with_worlds(
        causes_of([one.failure for one in files]),
        lambda cause: [one for one in files if cause_of(one.failure) == cause],
        with_code=False,
    )
    return ControllerSummary(controller, motion, [one.table() for one in causes])
