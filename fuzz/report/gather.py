"""What a report is about.

Failures from folders, archives and files, run again, and their campaigns.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from fuzz.campaign.store import MEMORY, Summary, read_summary
from fuzz.corpus import CorpusEntry, read_corpus
from fuzz.describe import run_to_draw
from fuzz.failure import Failure
from fuzz.triage.judging import Replay, replay
from sim.episode import Episode
from worldgen.errors import FormatError, InvalidParameter, WorldgenError
from worldgen.files.archives import Member, archive_in, members
from worldgen.files.grid.disk import expansion_limit, unpack_world
from worldgen.files.grid.schema import MAX_FILE_BYTES

__all__ = ["MOST_FAILURES", "ReplayedFailure", "ReportSubject", "Reported", "gather", "look_at"]

MOST_FAILURES = 1_000  # of a report: 10 to 50 MB, about what a browser opens without complaint


@dataclass(frozen=True, eq=False)
class ReplayedFailure:
    """A failure's file and what running it again showed.

    Args:
        name: The file's own name.
        data: Its bytes, as they are.
        failure: What it holds.
        replay: Whether verdict, evidence and certificate are as recorded.
        shown: The run to draw: of a breach the one that walls do not end. ``None`` where it cannot
            be run.
        words: What happened, to stand behind the verdict; empty where the replay is not confirmed.
    """

    name: str
    data: bytes
    failure: Failure
    replay: Replay
    shown: Episode | None
    words: str


@dataclass(frozen=True, eq=False)
class Reported:
    """A failure of a corpus, and what is to be said of it.

    Args:
        entry: Its place and its facts.
        seen: The file and its run.
        original: The failure as it was found, before shrinking, where the campaign kept it.
        campaign: Which campaign found it, as an index; -1 where that is not known.
    """

    entry: CorpusEntry
    seen: ReplayedFailure
    original: ReplayedFailure | None
    campaign: int


@dataclass(frozen=True, eq=False)
class ReportSubject:
    """What a report is about.

    ``others`` counts worlds without a failure, which were passed over.
    """

    entries: list[CorpusEntry]
    campaigns: list[Summary]
    others: int


def gather(paths: Sequence[Path]) -> ReportSubject:
    """Reads what failures and campaigns there are.

    Args:
        paths: Folders, archives and files. What campaigns remember in hidden folders is read for
            what it is.

    Raises:
        InvalidParameter: If there is nothing to report on, or more than ``MOST_FAILURES``.
        FormatError: If a path or a file cannot be read.
    """
    corpus = read_corpus(paths)
    folders = [folder for path in paths for folder in _campaign_folders(path)]
    campaigns = [
        summary
        for folder in dict.fromkeys(folders)
        if (summary := read_summary(folder)) is not None
    ]
    entries = _distinct(corpus.entries)
    if not entries and not campaigns:
        raise InvalidParameter(
            "no-failure",
            "{path} holds no failure",
            "name a folder, archive or file that worldgen fuzz or worldgen shrink wrote",
            at_terminal=True,
            path=paths[0],
        )
    if len(entries) > MOST_FAILURES:
        raise InvalidParameter(
            "too-many",
            "{count} failures are more than the {most} of a report",
            "keep the smallest of each class: worldgen corpus merge",
            at_terminal=True,
            count=len(entries),
            most=MOST_FAILURES,
        )
    return ReportSubject(entries, campaigns, corpus.others)


def _campaign_folders(path: Path) -> Iterable[Path]:
    """The folder, and those below it, that campaigns may have written.

    Of a file the folder that it is in.
    """
    return (
        sorted(memory.parent for memory in path.rglob(MEMORY)) if path.is_dir() else (path.parent,)
    )


def _distinct(entries: Iterable[CorpusEntry]) -> list[CorpusEntry]:
    """Of equal failures the one whose path comes first."""
    chosen: dict[str, CorpusEntry] = {}
    for entry in sorted(entries, key=lambda entry: str(entry.path)):
        chosen.setdefault(entry.facts.digest, entry)
    return sorted(chosen.values(), key=lambda entry: (entry.facts.key, entry.facts.order))


def look_at(entry: CorpusEntry, campaigns: Sequence[Summary]) -> Reported:
    """Reads a failure, and what it was before shrinking, and runs both again.

    Raises:
        FormatError: If a file cannot be read any more.
    """
    around = [k for k, summary in enumerate(campaigns) if summary.folder in entry.path.parents]
    campaign = max(around, key=lambda k: len(campaigns[k].folder.parts), default=-1)
    seen = _seen(entry.path)
    original = _original(seen.failure, campaigns[campaign].folder) if around else None
    return Reported(entry, seen, original, campaign)


def _original(failure: Failure, folder: Path) -> ReplayedFailure | None:
    """The failure as found, where the record names it and the campaign still has it."""
    if failure.original is None:
        return None
    path = folder / MEMORY / "failures" / f"{failure.original}.grid"
    return _seen(path) if path.is_file() else None


def _seen(path: Path) -> ReplayedFailure:
    data = _bytes_of(path)
    packed = Member(path.name, len(data), lambda limit: data if len(data) <= limit else None)
    failure = Failure.found_in(unpack_world(packed, str(path)))
    if failure is None:
        raise FormatError(
            "file-changed",
            "held a failure a moment ago",
            "do not change it meanwhile",
            source=str(path),
        )
    found = replay(failure)
    try:
        shown, words = run_to_draw(failure)
    except WorldgenError:
        return ReplayedFailure(path.name, data, failure, found, None, "")
    return ReplayedFailure(path.name, data, failure, found, shown, words if found.confirmed else "")


def _bytes_of(path: Path) -> bytes:
    """A file's bytes, also of one in an archive."""
    place = None if path.is_file() else archive_in(path)
    if place is None:
        with path.open("rb") as stream:
            return stream.read(MAX_FILE_BYTES + 1)
    for member in members(place[0]):
        data = member.read(expansion_limit(member.packed)) if member.name == place[1] else None
        if data is not None:
            return data
    raise FormatError(
        "file-changed",
        "is not there any more",
        "do not change the archive meanwhile",
        source=str(path),
    )
