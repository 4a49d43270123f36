"""Files that a map file names: they lie next to it or below it, nothing else is opened."""

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
        key: What names the other one, for messages.
        name: Its name as it stands there.

    Raises:
        InvalidParameter: If it leads out of the map's folder, or nothing is there; callers add the
            line.
    """
    if "\0" in name:
        raise InvalidParameter(
            "not-a-file-name", "{key} has a NUL in its name", "correct it", key=key
        )
    folder = Path(os.path.realpath(path.parent))
    other = Path(os.path.realpath(folder / name))
    if not other.is_relative_to(folder):
        raise InvalidParameter(
            "outside-folder",
            "{key} {name} lies outside the map's folder",
            "copy it there and name it without a path",
            key=key,
            name=quote(name, 80),
        )
    try:
        there = other.is_file()
    except OSError:  # a name too long for the disk
        there = False
    if not there:
        raise InvalidParameter(
            "no-such-file",
            "{key} {name} is not there",
            "put it beside {map}",
            key=key,
            name=quote(name, 80),
            map=path.name,
        )
    return path.parent / other.relative_to(folder)
