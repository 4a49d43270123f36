"""Collect the contents of the report's first screen: does it work, how bad is it, why, what to do."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from fuzz.campaign.store import Summary
from fuzz.corpus import CorpusEntry
from fuzz.corpus.entry import Facts
from fuzz.failure import Failure
from fuzz.overview.building import explained
from fuzz.overview.causes import CauseTotals, causes_of
from fuzz.overview.clearest import clearest
from fuzz.overview.overview import read_overview
from fuzz.triage.cause import Severity
from fuzz.triage.diagnosis import cause_of
from worldgen.errors import WorldgenError

__all__ = ["Answer", "answers_for", "entry_of"]

# Limit on the causes explained here if no campaign did so: each takes about a second.
_MOST_EXPLAINED = 5


@dataclass(frozen=True)
class Answer:
    """The facts known about one controller under one motion model.

    Args:
        controller: With its options.
        motion: Name of the motion model.
        causes: Causes in JSON's types, the worst first; ``file`` is a path.
        natural: Its results in natural worlds, if a campaign ran some.
        comparison: What changed since an earlier campaign, if one was compared.
        campaign: Index of the campaign on the page; -1 for none.
    """

    controller: str
    motion: str
    causes: Sequence[Mapping[str, Any]]
    natural: Mapping[str, Any] | None = None
    comparison: Mapping[str, Any] | None = None
    campaign: int = -1

    def table(self) -> dict[str, Any]:
        """Return the contents of the page."""
        return {
            "controller": self.controller,
            "motion": self.motion,
            "causes": list(self.causes),
            "natural": self.natural,
            "comparison": self.comparison,
            "campaign": self.campaign,
        }


def answers_for(entries: Sequence[CorpusEntry], campaigns: Sequence[Summary]) -> list[Answer]:
    """Return an answer for each campaign, and for each controller without a campaign.

    Args:
        entries: The failures of the report.
        campaigns: The campaigns whose folders were given.

    Raises:
        FormatError: If a file cannot be read.
    """
    answers = []
    told: set[tuple[str, str]] = set()
    for index, summary in enumerate(campaigns):
        overview = read_overview(summary.folder)
        if overview is None:
            continue
        causes = [_placed(cause, summary.folder) for cause in overview["causes"]]
        answers.append(
            Answer(
                summary.controller,
                summary.motion,
                causes,
                overview["natural"],
                overview["comparison"],
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


def _worst(answer: Answer) -> int:
    """Return the severity of the worst cause, so that the worst controller comes first."""
    words = [severity.word for severity in Severity]
    found = [words.index(str(cause["severity"])) for cause in answer.causes[:1]]
    return found[0] if found else len(words)


def entry_of(path: Path) -> CorpusEntry | None:
    """Return the entry of a failure's file; ``None`` if it does not exist or cannot be read."""
    try:
        return CorpusEntry(path, Facts.of(Failure.read(path), str(path)))
    except WorldgenError:
        return None


def _placed(cause: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    files = {name: str(folder / cause[name]) for name in ("file", "smallest") if cause[name]}
    return {**cause, **files}


def _of_entries(controller: str, motion: str, entries: Iterable[CorpusEntry]) -> Answer:
    """Return the answer for failures without a known campaign: their causes."""
    failures = {entry.path: Failure.read(entry.path) for entry in entries if entry.path.is_file()}
    found: dict[str, Failure] = {}
    for failure in failures.values():
        found.setdefault(failure.bucket, failure)
    causes = [
        _explained(one, failures, number < _MOST_EXPLAINED)
        for number, one in enumerate(causes_of(found, {}))
    ]
    return Answer(controller, motion, [one.table() for one in causes])


def _explained(
    cause: CauseTotals, failures: Mapping[Path, Failure], is_explained: bool
) -> CauseTotals:
    own = {path: one for path, one in failures.items() if cause_of(one) == cause.cause}
    best = clearest(own.values(), cause.cause)
    if best is None:
        return cause
    smallest = min(own, key=lambda path: (own[path].size, str(path)))
    file = min(path for path, failure in own.items() if failure is best)
    why = explained(best) if is_explained else None
    return replace(cause, file=str(file), smallest=str(smallest), why=why)
