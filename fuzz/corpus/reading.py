"""Read the failures of folders, archives and files."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from fuzz.corpus.entry import CorpusEntry, Facts
from worldgen.errors import FormatError
from worldgen.files.archives import Member
from worldgen.files.grid.disk import read_packed, unpack, unpack_world
from worldgen.files.worlds import Skip, walk


@dataclass(frozen=True)
class Selection:
    """Patterns that select failures.

    A failure must match one pattern of each field; no patterns for a field match all failures.

    Args:
        patterns: Fields (``verdict``, ``cause``, ``controller``), each with a shell pattern such as
            ``turn-*``.
    """

    patterns: tuple[tuple[str, str], ...] = ()

    def fits(self, facts: Facts) -> bool:
        """Return True if a failure is selected."""
        texts = {"verdict": facts.verdict, "cause": facts.group, "controller": facts.controller}
        asked = {
            name: [pattern for field, pattern in self.patterns if field == name]
            for name, _ in self.patterns
        }
        return all(_fits_one(texts[name], patterns) for name, patterns in asked.items())


@dataclass(frozen=True)
class Corpus:
    """Failures by path.

    Args:
        entries: In the order of the given paths; within a folder by name, within an archive in
            their order there.
        others: Number of worlds without a failure, which were ignored.
    """

    entries: tuple[CorpusEntry, ...]
    others: int = 0


def read_corpus(
    paths: Iterable[Path], selection: Selection | None = None, skip: Skip | None = None
) -> Corpus:
    """Return the contents of folders, archives and files.

    Args:
        paths: For a folder, all ``.grid`` and ``.grid.gz`` files in it and below are read; it may
            be empty.
        selection: The failures to select; all if omitted.
        skip: See :func:`worldgen.files.worlds.walk`.

    Raises:
        FormatError: If a path or a file cannot be read.
    """
    entries: list[CorpusEntry] = []
    others = 0

    def read(path: Path, place: Path, member: Member | None) -> tuple[Facts | None, int | None]:
        if member is not None:
            return Facts.in_world(unpack_world(member, str(place)), str(place)), None
        return _read_file(place)

    for place, (facts, seen) in walk(paths, read, skip, may_be_empty=True):
        if facts is None:
            others += 1
        elif selection is None or selection.fits(facts):
            entries.append(CorpusEntry(place, facts, seen))
    return Corpus(tuple(entries), others)


def _fits_one(text: str, patterns: Iterable[str]) -> bool:
    return any(text == pattern or fnmatchcase(text, pattern) for pattern in patterns)


def _read_file(file: Path) -> tuple[Facts | None, int]:
    data = read_packed(file)
    try:
        seen = int(file.stat().st_mtime)
    # It was deleted in the meantime.
    except OSError as error:
        raise FormatError.unreadable(file, error) from error
    return Facts.in_world(unpack(data, str(file)), str(file)), seen
