"""Open files that a map file names: only those next to it or below it."""

from __future__ import annotations

import os
from pathlib import Path

from worldgen.errors import InvalidParameter
from worldgen.support.plain_text import quote

__all__ = ["sibling_file"]


def sibling_file(path: Path, key: str, name: str) -> Path:
    """Return the path of a file that a map file names.

    Args:
        path: The map file.
        key: The key that names the other file, for messages.
        name: The other file's name as written there.

    Raises:
        InvalidParameter: If it leads out of the map's folder, or does not exist; callers add the
            line.
    """
    if "\0" in name:
        raise InvalidParameter(
            "not-a-file-name", "{key} has a NUL character in its name", "correct it", key=key
        )
    folder = Path(os.path.realpath(path.parent))
    other = Path(os.path.realpath(folder / name))
    if not other.is_relative_to(folder):
        raise InvalidParameter(
            "outside-folder",
            "{key} {name} is outside the map's folder",
            "copy it there and name it without a path",
            key=key,
            name=quote(name, 80),
        )
    try:
        there = other.is_file()
    # The name is too long for the file system.
    except OSError:
        there = False
    if not there:
        raise InvalidParameter(
            "no-such-file",
            "{key} {name} does not exist",
            "put it next to {map}",
            key=key,
            name=quote(name, 80),
            map=path.name,
        )
    return path.parent / other.relative_to(folder)
