"""Collect the facts of the report's first screen: does it work, how bad is it, why, what to do."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from msgspec import structs

from fuzz.cause import Cause, Severity
from fuzz.corpus import CorpusEntry
from fuzz.failure import Failure
from fuzz.overview.answer import NO_ANSWER, headline, more_seconds
from fuzz.overview.building import with_worlds
from fuzz.overview.causes import causes_of
from fuzz.overview.result import CampaignResult, CauseResult, NaturalResult, read_overview
from fuzz.overview.terminal import never_tried
from fuzz.report.gather import ReportedCampaign
from fuzz.triage.diagnosis import cause_of
from fuzz.unit.answer import AnswerNumbers
from worldgen.files.json_file import plain

# Limits on explaining the causes of controllers without a campaign, for all of them together. A
# folder can have failures of dozens, and the work must not depend on the time that it takes.
_CAUSES_TO_EXPLAIN = 5
_STEPS_TO_EXPLAIN = 2_000_000

# Failures of a cause that are run to find the clearest, the smallest first.
_CANDIDATES = 8


@dataclass(frozen=True)
class ControllerSummary:
    """The facts known about one controller under one motion model.

    Args:
        controller: With its options.
        motion: Name of the motion model.
        result: The result of its campaign, or the causes of its failures; their files are paths.
        campaign: The campaign, if there is one.
    """

    controller: str
    motion: str
    result: CampaignResult
    campaign: ReportedCampaign | None = None

    def table(self) -> dict[str, Any]:
        """Return the contents of the page."""
        natural = self.result.natural
        comparison = self.result.comparison
        first = headline(self.result)
        return {
            "controller": self.controller,
            "motion": self.motion,
            "headline": {**plain(first), "more": self._more() if first.tone == NO_ANSWER else ""},
            "causes": [_shown(cause) for cause in self.result.causes],
            "natural": None if natural is None else _natural(natural),
            "comparison": None if comparison is None else plain(comparison),
        }

    def _more(self) -> str:
        """Return the command that is likely to bring an answer."""
        assert self.campaign is not None, "only a campaign can lack an answer"
        numbers = self.campaign.summary
        seconds = more_seconds(numbers.seconds, numbers.answer_numbers or AnswerNumbers())
        folder = shlex.quote(str(self.campaign.folder))
        return f"worldgen fuzz --resume {folder} --budget {seconds // 60}m"


def _natural(natural: NaturalResult) -> dict[str, Any]:
    """Return natural worlds with what follows from them, so that page and terminal agree."""
    return {**plain(natural), "percent": natural.percent, "never": never_tried(natural)}


def _shown(cause: CauseResult) -> dict[str, Any]:
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
    for campaign in campaigns:
        result = read_overview(campaign.folder)
        if result is None:
            continue
        summary = campaign.summary
        causes = [_placed(cause, campaign.folder) for cause in result.causes]
        result = structs.replace(result, causes=causes, summary=summary)
        answers.append(ControllerSummary(summary.controller, summary.motion, result, campaign))
        told.add((summary.controller, summary.motion))
    others: dict[tuple[str, str], list[CorpusEntry]] = {}
    for entry in entries:
        key = (entry.facts.controller, entry.facts.motion)
        if key not in told:
            others.setdefault(key, []).append(entry)
    answers += [_of_entries(*key, found, len(others)) for key, found in sorted(others.items())]
    return sorted(answers, key=_worst)


def _worst(answer: ControllerSummary) -> int:
    """Return the severity of the worst cause, so that the worst controller comes first."""
    words = [severity.word for severity in Severity]
    found = [words.index(cause.severity) for cause in answer.result.causes[:1]]
    return found[0] if found else len(words)


def _placed(cause: CauseResult, folder: Path) -> CauseResult:
    """Return a cause with the folder added to its files."""
    file = str(folder / cause.file) if cause.file else ""
    smallest = str(folder / cause.smallest) if cause.smallest else ""
    return structs.replace(cause, file=file, smallest=smallest)


def _of_entries(
    controller: str, motion: str, entries: Iterable[CorpusEntry], of: int
) -> ControllerSummary:
    """Return the answer for failures without a known campaign: their causes.

    The page shows the code of each failure's controller, so the causes need not.

    Args:
        controller: With its options.
        motion: Name of the motion model.
        entries: The failures.
        of: Number of such controllers, which share the work of explaining causes.
    """
    failures = {entry.path: Failure.read(entry.path) for entry in entries}
    own: dict[Cause, list[Failure]] = {}
    for failure in sorted(failures.values(), key=lambda one: one.order):
        own.setdefault(cause_of(failure), []).append(failure)
    causes, examples = with_worlds(
        causes_of(failures.values()),
        lambda cause: own[cause][:_CANDIDATES],
        most=max(1, _CAUSES_TO_EXPLAIN // of),
        with_code=False,
        most_steps=math.inf if of == 1 else _STEPS_TO_EXPLAIN / of,
    )
    paths = {failure.id: str(path) for path, failure in failures.items()}
    placed = [
        structs.replace(
            one, file=paths[examples[one.cause].id], smallest=paths[own[one.cause][0].id]
        )
        for one in causes
    ]
    return ControllerSummary(controller, motion, CampaignResult(causes=placed))
