"""Choose entries from several corpora, and merge them, keeping the simplest of each cause."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from fuzz.corpus.entry import CorpusEntry, name_of
from fuzz.failure import Failure, few_of_each
from fuzz.simplicity import FailureOrder
from worldgen.errors import OutputError
from worldgen.files.whole import refused_writes, write_bytes
from worldgen.files.worlds import files_in


def distinct(entries: Iterable[CorpusEntry]) -> list[CorpusEntry]:
    """Return one entry for each failure, in order; of equal files, the first by path."""
    chosen: dict[str, CorpusEntry] = {}
    for entry in sorted(entries, key=lambda entry: entry.order):
        chosen.setdefault(entry.facts.digest, entry)
    return list(chosen.values())


def places(entries: Iterable[CorpusEntry]) -> dict[FailureOrder, int]:
    """Return the failures' places in order, from 0, for pages that sort by it."""
    return {
        order: place for place, order in enumerate(sorted({entry.facts.order for entry in entries}))
    }


def shortlist(entries: Iterable[CorpusEntry]) -> dict[tuple[str, str, str], list[CorpusEntry]]:
    """Return the failures to keep by controller, motion model and cause, the simplest first."""
    return few_of_each(
        distinct(entries), lambda one: one.facts.key, lambda one: one.facts.signature
    )


def smallest(entries: Iterable[CorpusEntry]) -> dict[tuple[str, str, str], CorpusEntry]:
    """Return the simplest failure by controller, motion model and cause, regardless of order."""
    return {key: own[0] for key, own in shortlist(entries).items()}


def merge(
    entries: Iterable[CorpusEntry], out: Path, *, force: bool = False
) -> dict[Path, CorpusEntry]:
    """Write the simplest failures of each cause to a folder, dated by the first of its cause.

    Args:
        entries: Entries of any number of corpora.
        out: The folder; created if missing. Files that are already correct stay untouched.
        force: Replace files of the same name, and allow other files in the folder.

    Returns:
        Each new path, with the entry that it came from.

    Raises:
        OutputError: If the folder holds other failures, or cannot be written.
        FormatError: If a file can no longer be read.
    """
    entries = list(entries)
    kept = shortlist(entries)
    names = {name_of(own[0].facts) for own in kept.values()}
    chosen = {
        out / f"{name_of(entry.facts, number, names)}.grid": entry
        for own in kept.values()
        for number, entry in enumerate(own, 1)
    }
    texts = {path: Failure.read(entry.path).dumps() for path, entry in chosen.items()}
    if not force:
        _refuse_others(out, texts)
    # A cause is as old as its oldest failure, whichever failure is the simplest.
    first: dict[tuple[str, str, str], int] = {}
    for entry in entries:
        if entry.seen is not None:
            first[entry.facts.key] = min(entry.seen, first.get(entry.facts.key, entry.seen))
    for path, text in texts.items():
        _write(path, text, first.get(chosen[path].facts.key))
    return chosen


def _refuse_others(out: Path, texts: dict[Path, bytes]) -> None:
    if out.exists() and not out.is_dir():
        raise OutputError("wrong-kind-of-file", "{out} is a file", "choose a folder", out=out)
    others = [path for path in files_in(out) if texts.get(path) != path.read_bytes()]
    if others:
        more = f" and {len(others) - 1} more" if len(others) > 1 else ""
        raise OutputError(
            "folder-holds-worlds",
            "{out} holds other worlds: {first}{more}",
            "use --force to replace files that have the same name and keep the others, or choose "
            "another folder",
            at_terminal=True,
            out=out,
            first=others[0].relative_to(out),
            more=more,
        )


def _write(path: Path, text: bytes, seen: int | None) -> None:
    with refused_writes(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        if not (path.is_file() and path.read_bytes() == text):
            write_bytes(path, text, force=True)
        if seen is not None:
            os.utime(path, (seen, seen))
