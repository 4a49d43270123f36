"""What a corpus need not hold.

Failures that are none any more, and all but the smallest of each class.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import groupby

from fuzz.corpus.entry import CorpusEntry
from fuzz.failure import Failure
from fuzz.triage.judging import replay
from sim.verdict import BY_THE_CONTROLLER
from worldgen.errors import OutputError

__all__ = ["Judgement", "judge_all", "remove"]


@dataclass(frozen=True)
class Judgement:
    """Whether a failure stays.

    Args:
        entry: The failure.
        keep: Whether it stays.
        reason: Why; empty for the smallest of its class that replays.
        judged: Whether it could be run; one that could not, for want of its controller perhaps,
            stays.
    """

    entry: CorpusEntry
    keep: bool
    reason: str = ""
    judged: bool = True


def judge_all(entries: Iterable[CorpusEntry]) -> Iterator[Judgement]:
    """Replays the failures of each class, the smallest first, until one is confirmed.

    Those behind it may go.
    """
    ordered = sorted(
        entries, key=lambda entry: (entry.facts.key, entry.facts.order, str(entry.path))
    )
    for _, group in groupby(ordered, key=lambda entry: entry.facts.key):
        kept: CorpusEntry | None = None
        for entry in group:
            if kept is not None:
                what = (
                    "the same world"
                    if kept.facts.digest == entry.facts.digest
                    else "a smaller world"
                )
                yield Judgement(entry, False, f"{kept.path} is {what} of its class")
                continue
            judgement = _judge(entry)
            if judgement.keep and judgement.judged:
                kept = entry
            yield judgement


def _judge(entry: CorpusEntry) -> Judgement:
    shown = replay(Failure.read(entry.path))
    if shown.confirmed:
        return Judgement(entry, True)
    if shown.verdict in BY_THE_CONTROLLER:  # as a program does whose files are not here
        reason = f"its controller ends in {shown.verdict} here: {shown.reason}"
        return Judgement(entry, True, reason, judged=False)
    if shown.verdict == "error":
        return Judgement(entry, True, f"cannot be replayed here: {shown.reason}", judged=False)
    return Judgement(entry, False, f"no longer replays: {shown.reason}")


def remove(entry: CorpusEntry) -> None:
    """Deletes a failure's file.

    Raises:
        OutputError: If it cannot be deleted.
    """
    try:
        entry.path.unlink(missing_ok=True)
    except OSError as error:
        raise OutputError(
            "cannot-delete",
            "{path}: cannot be deleted: {reason}",
            path=entry.path,
            reason=error.strerror or str(error),
        ) from error
