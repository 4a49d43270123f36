"""The worlds at a path: in a file, a folder or an archive."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from worldgen.errors import FormatError
from worldgen.files.archives import is_archive, members
from worldgen.files.grid import read_world
from worldgen.files.grid.disk import unpack_world
from worldgen.reach.decision import unread_reason
from worldgen.world import World

_ENDINGS = (".grid", ".grid.gz")


def is_world_file(name: str) -> bool:
    """Return True if a file's name is a world's."""
    return name.endswith(_ENDINGS)


def read_whole_world(path: Path) -> World:
    """Read a world to search in, or to change, and thereby to prove something about it.

    Raises:
        FormatError: If it cannot be read, or something of the map that it was imported from was
            not read.
    """
    world = read_world(path)
    if world.unread:
        raise FormatError(
            "part-not-read",
            "{reason}, so nothing can be proved in this world",
            "if it cannot, import the map again with --ignore-unread",
            at_terminal=True,
            reason=unread_reason(world.unread),
            source=str(path),
        )
    return world


def files_in(folder: Path) -> list[Path]:
    """Return the world files in a folder and below, sorted by name.

    Folders called ``.name`` are skipped.
    """
    found = (file for file in folder.rglob("*") if is_world_file(file.name) and file.is_file())
    return sorted(file for file in found if not _is_hidden(file.relative_to(folder)))


def _is_hidden(path: Path) -> bool:
    """Return True for files that programs keep for themselves, such as pytest's cache."""
    return any(part.startswith(".") for part in path.parts[:-1])


def read_worlds(paths: Iterable[Path]) -> Iterator[tuple[Path, World]]:
    """Yield the worlds of files, folders and archives; each is read when it is reached.

    Args:
        paths: A folder means the ``.grid`` and ``.grid.gz`` files in it and below, sorted by name;
            an archive means those in it, in its order; anything else is read as a world.

    Returns:
        Path and world; a world in an archive has the archive's path and then its own name.

    Raises:
        FormatError: If a file cannot be read, or a folder or an archive holds no world.
    """
    # A folder or an archive must hold a world.
    for path in paths:
        if path.is_dir():
            files = files_in(path)
            for file in files:
                yield file, read_world(file)
            found = bool(files)
        elif is_archive(path):
            found = False
            for place, world in _archived(path):
                found = True
                yield place, world
        else:
            yield path, read_world(path)
            continue
        if not found:
            raise FormatError(
                "no-map-found",
                "contains no .grid files",
                "choose a .grid file, or a folder or archive that contains some",
                source=str(path),
            )


def _archived(path: Path) -> Iterator[tuple[Path, World]]:
    for member in members(path):
        if is_world_file(member.name):
            place = path / member.name
            yield place, unpack_world(member, str(place))
