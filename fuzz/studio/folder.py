"""The one folder that the studio may read and write; no name leads out of it."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from worldgen.errors import InvalidParameter
from worldgen.plain_text import shown
from worldgen.world_files import is_world_file

__all__ = ["MOST_FILES", "Folder"]

MOST_FILES = 2_000  # that are listed; more than anybody scrolls through
_DEEPEST = 4  # folders below the opened one
_LONGEST = 400  # characters of a name


@dataclass(frozen=True)
class Folder:
    """An opened folder.

    Args:
        root: Where it is.
    """

    root: Path

    def __post_init__(self) -> None:
        object.__setattr__(self, "root", Path(os.path.realpath(self.root)))

    def place(self, name: str) -> Path:
        """The path of a name in the folder, whether or not there is a file.

        Args:
            name: Relative to the folder, with ``/`` between its parts.

        Raises:
            InvalidParameter: If it is no such name, is hidden, or leads out of the folder, through links too.
        """
        parts = name.split("/")
        if not name or len(name) > _LONGEST or not name.isprintable() or "\\" in name or ":" in name:
            raise InvalidParameter(
                f"{shown(name[:60])!r} is no name of a file in the opened folder; give one like w.grid"
            )
        if any(part in ("", ".", "..") or part.startswith(".") for part in parts):
            raise InvalidParameter(
                f"{shown(name[:60])!r} leads out of the opened folder or is hidden; give a name in it"
            )
        path = self.root.joinpath(*parts)
        real = Path(os.path.realpath(path))
        if not real.is_relative_to(self.root):
            raise InvalidParameter(f"{shown(name[:60])!r} leads out of the opened folder; copy the file into it")
        return real

    def files(self, endings: tuple[str, ...] = (), below: str = "") -> list[dict[str, Any]]:
        """What there is to open: worlds and files with such endings, none hidden, the first :data:`MOST_FILES`.

        Args:
            endings: Of files that are no worlds.
            below: A folder in it; all of it if left out.
        """
        walked = self._walk(self.place(below) if below else self.root, 0)
        known = (entry for entry in walked if entry["world"] or entry["name"].lower().endswith(endings))
        found = sorted(known, key=lambda entry: (entry["name"].count("/"), entry["name"]))
        return found[:MOST_FILES]

    def folders(self) -> list[str]:
        """The folders in it and below, by name; neither hidden ones nor links."""
        found: list[str] = []
        for top, inner, _ in os.walk(self.root):
            inner[:] = sorted(one for one in inner if not one.startswith(".") and one.isprintable())
            inner[:] = [one for one in inner if not Path(top, one).is_symlink()]
            there = Path(top).relative_to(self.root)
            found += [(there / one).as_posix() for one in inner]
            if len(there.parts) >= _DEEPEST - 1 or len(found) > MOST_FILES:
                inner.clear()
        return found[:MOST_FILES]

    def _walk(self, folder: Path, depth: int) -> Iterator[dict[str, Any]]:
        try:
            entries = sorted(os.scandir(folder), key=lambda entry: entry.name)[: 2 * MOST_FILES]
        except OSError:  # not ours to read
            return
        for entry in entries:
            if entry.name.startswith(".") or entry.is_symlink() or not entry.name.isprintable():
                continue
            if entry.is_dir():
                if depth < _DEEPEST:
                    yield from self._walk(Path(entry.path), depth + 1)
            else:
                facts = entry.stat()
                if stat.S_ISREG(facts.st_mode):
                    name = Path(entry.path).relative_to(self.root).as_posix()
                    yield {"name": name, "bytes": facts.st_size, "world": is_world_file(entry.name)}
