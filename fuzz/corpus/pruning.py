"""Find failures that a corpus does not need: fixed ones, and all but the simplest of each cause."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import groupby

from fuzz.corpus.entry import CorpusEntry
from fuzz.failure import MOST_SHOWN, Failure
from fuzz.triage.replaying import replay
from sim.verdict import BY_THE_CONTROLLER
from worldgen.errors import OutputError


@dataclass(frozen=True)
class Judgement:
    """The decision on whether a failure stays in the corpus.

    Args:
        entry: The failure.
        keep: True if it stays.
        reason: The reason; empty for the simplest of its cause that replay.
        judged: False if it could not be run, perhaps because its controller is missing; it then
            stays.
    """

    entry: CorpusEntry
    keep: bool
    reason: str = ""
    judged: bool = True


def judge_all(entries: Iterable[CorpusEntry]) -> Iterator[Judgement]:
    """Replay the failures of each cause, simplest first, until three different ones are confirmed.

    The rest of the cause can be deleted.
    """
    ordered = sorted(entries, key=lambda entry: entry.order)
    for _, group in groupby(ordered, key=lambda entry: entry.facts.key):
        kept: dict[str, CorpusEntry] = {}
        for entry in group:
            # A simpler failure that looks the same is confirmed, or enough of the cause are, so
            # this one need not be run.
            alike = kept.get(entry.facts.signature)
            if alike is not None and alike.facts.digest == entry.facts.digest:
                yield Judgement(entry, False, f"{alike.path} is the same world")
            elif alike is not None:
                yield Judgement(
                    entry, False, f"{alike.path} is a smaller world that looks the same"
                )
            elif len(kept) == MOST_SHOWN:
                yield Judgement(entry, False, f"{MOST_SHOWN} smaller worlds have its cause")
            else:
                judgement = _judge(entry)
                if judgement.keep and judgement.judged:
                    kept[entry.facts.signature] = entry
                yield judgement


def _judge(entry: CorpusEntry) -> Judgement:
    shown = replay(Failure.read(entry.path))
    if shown.confirmed:
        return Judgement(entry, True)
    # A program whose files are missing ends like this too, so the failure stays.
    if shown.verdict in BY_THE_CONTROLLER:
        reason = f"its controller ends with {shown.verdict} here: {shown.reason}"
        return Judgement(entry, True, reason, judged=False)
    if shown.verdict == "error":
        return Judgement(entry, True, f"cannot be replayed here: {shown.reason}", judged=False)
    return Judgement(entry, False, f"no longer replays: {shown.reason}")


def remove(entry: CorpusEntry) -> None:
    """Delete a failure's file.

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
