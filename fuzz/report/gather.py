"""Collect the contents of a report: failures, run again, and their campaigns."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from fuzz.campaign.store import MEMORY, Summary, controller_change, read_summary
from fuzz.corpus import Corpus, distinct, read_corpus
from fuzz.failure import Failure
from fuzz.overview.describe import run_to_draw
from fuzz.triage.replaying import Replay, replay
from sim.episode import Episode
from worldgen.errors import FormatError, InvalidParameter, WorldgenError
from worldgen.files.grid.disk import read_packed, unpack
from worldgen.files.worlds import Skip

# More would make a page of over 10 to 50 MB, about the limit that browsers open without trouble.
MOST_FAILURES = 1_000


@dataclass(frozen=True, eq=False)
class ReplayedFailure:
    """A failure of the report, and the result of running it again.

    Args:
        path: Its file.
        data: The file's bytes, unchanged.
        failure: The failure in it.
        replay: Whether verdict, evidence and certificate are as recorded.
        shown: The run to draw; a breach's run ignores walls. ``None`` if it cannot be run.
        words: What happened, to follow the verdict; empty if the replay is not confirmed.
        original: The failure as found, before shrinking, if the campaign kept it.
        campaign: The campaign that found it, if known.
    """

    path: Path
    data: bytes
    failure: Failure
    replay: Replay
    shown: Episode | None
    words: str
    original: ReplayedFailure | None = None
    campaign: ReportedCampaign | None = None


@dataclass(frozen=True, eq=False)
class ReportedCampaign:
    """A campaign as it appears in the report.

    Args:
        folder: Folder of its failures.
        summary: The campaign in numbers.
        change: A sentence if its controller's file has changed since; else empty.
    """

    folder: Path
    summary: Summary
    change: str = ""


def gather(
    paths: Sequence[Path], skip: Skip | None = None
) -> tuple[Corpus, list[ReportedCampaign]]:
    """Return the different failures, and the campaigns, to report on.

    Args:
        paths: Folders, archives and files. Campaigns keep their state in hidden folders, so read
            those too.
        skip: See :func:`worldgen.files.worlds.walk`.

    Raises:
        InvalidParameter: If there is nothing to report on, or more than ``MOST_FAILURES``.
        FormatError: If a path or a file cannot be read.
    """
    corpus = read_corpus(paths, skip=skip)
    folders = [folder for path in paths for folder in _campaign_folders(path)]
    campaigns = [
        ReportedCampaign(folder, summary, controller_change(folder, summary.controller))
        for folder in dict.fromkeys(folders)
        if (summary := read_summary(folder)) is not None
    ]
    entries = distinct(corpus.entries)
    if not entries and not campaigns:
        raise InvalidParameter(
            "no-failure",
            "{path} has no failure",
            "choose a folder, archive or file that worldgen fuzz or worldgen shrink wrote",
            at_terminal=True,
            path=paths[0],
        )
    if len(entries) > MOST_FAILURES:
        raise InvalidParameter(
            "too-many",
            "{count} failures are more than the {most} that fit into a report",
            "keep only the smallest of each cause: worldgen corpus merge",
            at_terminal=True,
            count=len(entries),
            most=MOST_FAILURES,
        )
    return Corpus(tuple(entries), corpus.others), campaigns


def _campaign_folders(path: Path) -> Iterable[Path]:
    """Return the folder and those below it that belong to campaigns; for a file, its folder."""
    return (
        sorted(memory.parent for memory in path.rglob(MEMORY)) if path.is_dir() else (path.parent,)
    )


def look_at(path: Path, campaigns: Sequence[ReportedCampaign]) -> ReplayedFailure:
    """Read a failure and its original from before shrinking, and run both again.

    Raises:
        FormatError: If a file can no longer be read.
    """
    # Campaigns may be nested, so take the innermost folder that contains the file.
    around = [one for one in campaigns if one.folder in path.parents]
    campaign = max(around, key=lambda one: len(one.folder.parts), default=None)
    seen = _seen(path)
    original = None if campaign is None else _original(seen.failure, campaign.folder)
    return replace(seen, original=original, campaign=campaign)


def _original(failure: Failure, folder: Path) -> ReplayedFailure | None:
    """Return the failure as found, if the record names it and the campaign still has it."""
    if failure.original is None:
        return None
    path = folder / MEMORY / "failures" / f"{failure.original}.grid"
    return _seen(path) if path.is_file() else None


def _seen(path: Path) -> ReplayedFailure:
    data = read_packed(path)
    failure = Failure.found_in(unpack(data, str(path)))
    if failure is None:
        raise FormatError(
            "file-changed",
            "changed while the report was written",
            "do not change it during the run",
            source=str(path),
        )
    found = replay(failure)
    # A run that the replay confirmed is the one to draw. An oracle's evidence is not the run's own.
    known = found.episode if found.confirmed and failure.oracle is None else None
    try:
        shown, words = run_to_draw(failure, known)
    except WorldgenError:
        return ReplayedFailure(path, data, failure, found, None, "")
    return ReplayedFailure(path, data, failure, found, shown, words if found.confirmed else "")
