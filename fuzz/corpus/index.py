"""A cache of facts by the digest of a file's bytes.

It may be missing, but it is never wrong about a file that has changed.
"""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from pathlib import Path

from fuzz.corpus.entry import Facts
from worldgen.errors import FormatError, OutputError
from worldgen.files.json_file import JsonFile
from worldgen.files.whole import write_bytes

INDEX_FOLDER = ".worldgen-corpus"  # in the corpus; it contains a .gitignore for itself
_FILE = "index.json"
# Version of `Facts` and of how they are read from a file; an index of another version is ignored.
_VERSION = 7


@dataclass(frozen=True)
class _Content:
    files: dict[str, Facts | None]


_INDEX = JsonFile(
    _Content, version=_VERSION, code="invalid-index", problem="not an index: {reason}", remedy=""
)


class Index:
    """The facts of a folder's files.

    Args:
        folder: The corpus.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder / INDEX_FOLDER
        self._known = self._load()
        self._used: dict[str, Facts | None] = {}

    def get(self, digest: str) -> tuple[bool, Facts | None]:
        """Return whether a file with this digest is known, and its facts.

        The facts of a world without a failure are ``None``.
        """
        if digest not in self._known:
            return False, None
        self._used[digest] = self._known[digest]
        return True, self._known[digest]

    def put(self, digest: str, facts: Facts | None) -> None:
        """Store the facts that were read from a file."""
        self._used[digest] = facts

    def save(self) -> None:
        """Write all entries used since the start.

        If writing fails, there is no index, which only costs time.
        """
        if self._used == self._known:
            return
        with contextlib.suppress(OSError, OutputError):
            self._folder.mkdir(exist_ok=True)
            write_bytes(self._folder / ".gitignore", b"*\n", force=True)
            _INDEX.write(self._folder / _FILE, _Content(dict(sorted(self._used.items()))))

    def _load(self) -> dict[str, Facts | None]:
        with contextlib.suppress(FormatError):
            return _INDEX.read(self._folder / _FILE).files
        return {}
