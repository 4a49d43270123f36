"""Reads what a corpus holds.

Every file's bytes, and its text where the index does not know them.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from fuzz.corpus.entry import CorpusEntry, Facts
from fuzz.corpus.index import Index
from worldgen.errors import FormatError
from worldgen.files.archives import Member, is_archive, members
from worldgen.files.grid.disk import unpack_world
from worldgen.files.grid.schema import MAX_FILE_BYTES
from worldgen.files.worlds import files_in, is_world_file

__all__ = ["Corpus", "Selection", "read_corpus"]


@dataclass(frozen=True)
class Selection:
    """Which failures are meant; of each kind of pattern one must fit, and none given fits all.

    Args:
        controllers: Patterns as of a shell: ``turn-*``.
        kinds: Likewise, for classes.
        verdicts: Likewise.
    """

    controllers: tuple[str, ...] = ()
    kinds: tuple[str, ...] = ()
    verdicts: tuple[str, ...] = ()

    def fits(self, facts: Facts) -> bool:
        """Whether a failure is meant."""
        wanted = (
            (self.controllers, facts.controller),
            (self.kinds, facts.kind),
            (self.verdicts, facts.verdict),
        )
        return all(not patterns or _fits_one(text, patterns) for patterns, text in wanted)


@dataclass(frozen=True)
class Corpus:
    """Failures by path.

    Args:
        entries: In the order of the paths that were given, of a folder by name, of an archive as
            they stand there.
        others: Worlds without a failure, which were passed over.
    """

    entries: tuple[CorpusEntry, ...]
    others: int = 0


def read_corpus(paths: Iterable[Path], selection: Selection | None = None) -> Corpus:
    """What folders, archives and files hold.

    Args:
        paths: A folder stands for the ``.grid`` and ``.grid.gz`` files in it and below; it may hold
            none.
        selection: Which failures are meant; all if left out.

    Raises:
        FormatError: If a path or a file cannot be read.
    """
    entries: list[CorpusEntry] = []
    others = 0
    for path in paths:
        for place, facts, seen in _found(path):
            if facts is None:
                others += 1
            elif selection is None or selection.fits(facts):
                entries.append(CorpusEntry(place, facts, seen))
    return Corpus(tuple(entries), others)


def _fits_one(text: str, patterns: tuple[str, ...]) -> bool:
    return any(text == pattern or fnmatchcase(text, pattern) for pattern in patterns)


def _found(path: Path) -> Iterator[tuple[Path, Facts | None, int | None]]:
    if path.is_dir():
        index = Index(path)
        for file in files_in(path):
            yield file, *_read_file(file, index)
        index.save()
    elif is_archive(path):
        for member in members(path):
            if is_world_file(member.name):
                place = path / member.name
                yield place, Facts.in_world(unpack_world(member, str(place)), str(place)), None
    else:
        yield path, *_read_file(path, None)


def _read_file(file: Path, index: Index | None) -> tuple[Facts | None, int]:
    try:
        with file.open("rb") as stream:
            seen = int(file.stat().st_mtime)
            data = stream.read(MAX_FILE_BYTES + 1)
    except FileNotFoundError as error:
        raise FormatError(
            "no-such-file", "there is no such file", "check the name", source=str(file)
        ) from error
    except (OSError, ValueError) as error:  # the latter for a name with a NUL
        raise FormatError(
            "unreadable",
            "cannot be read: {reason}",
            reason=getattr(error, "strerror", None) or error,
            source=str(file),
        ) from error
    if len(data) > MAX_FILE_BYTES:
        raise FormatError(
            "too-large",
            "longer than {most} bytes, the limit of a .grid file",
            most=MAX_FILE_BYTES,
            source=str(file),
        )
    digest = hashlib.sha256(data).hexdigest()
    known, facts = index.get(digest) if index is not None else (False, None)
    if not known:
        packed = Member(file.name, len(data), lambda limit: data if len(data) <= limit else None)
        facts = Facts.in_world(unpack_world(packed, str(file)), str(file))
        if index is not None:
            index.put(digest, facts)
    return facts, seen
