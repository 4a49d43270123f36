"""Read the worlds at a path: in a file, a folder or an archive."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from worldgen.errors import FormatError
from worldgen.files.archives import Member, is_archive, members
from worldgen.files.grid import read_world
from worldgen.files.grid.disk import unpack_world
from worldgen.reach.decision import unread_reason
from worldgen.world import World

_ENDINGS = (".grid", ".grid.gz")

SIDECAR = ".worldgen.grid"
"""Ending of the file next to an exported map with what the map does not store."""

Found = TypeVar("Found")
Skip = Callable[[FormatError], None]
"""Called with the error of a file that cannot be read, before its folder's other files are."""


def is_world_file(name: str) -> bool:
    """Return True if a file's name is a world's, and not that of a map's sidecar."""
    return name.endswith(_ENDINGS) and not name.endswith(SIDECAR)


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

    Folders called ``.name`` are skipped, and so are sidecars of exported maps, next to their map.
    """
    found = (
        file
        for file in folder.rglob("*")
        if file.name.endswith(_ENDINGS) and file.is_file() and not _is_sidecar(file)
    )
    return sorted(file for file in found if not _is_hidden(file.relative_to(folder)))


def _is_sidecar(file: Path) -> bool:
    """Return True if a file is a map's sidecar, and not a world whose name only looks like one."""
    exported = file.name.removesuffix(SIDECAR)
    return exported != file.name and file.with_name(exported).exists()


def _is_hidden(path: Path) -> bool:
    """Return True for files that programs keep for themselves, such as pytest's cache."""
    return any(part.startswith(".") for part in path.parts[:-1])


def walk(
    paths: Iterable[Path],
    read: Callable[[Path, Path, Member | None], Found],
    skip: Skip | None = None,
    *,
    may_be_empty: bool = False,
) -> Iterator[tuple[Path, Found]]:
    """Read each world file of files, folders and archives when it is reached.

    All commands that take a folder walk it here, so that one bad file does not keep them from the
    others.

    Args:
        paths: See :func:`read_worlds`.
        read: Called with one of the paths, the file's own path, and in an archive its member.
        skip: Called with the error of each file that cannot be read, before the walk continues. If
            omitted, the first error is raised.
        may_be_empty: True to accept a folder or an archive without a world.

    Returns:
        The file's path, and what ``read`` returned.

    Raises:
        FormatError: If no file can be read, or a folder or an archive holds no world.
    """
    # Errors wait for the first file that can be read, because without one they end the command.
    waiting: list[FormatError] = []
    has_read = False
    for path in paths:
        for place, found in _read_each(path, read, may_be_empty=may_be_empty):
            if not isinstance(found, _Unreadable):
                has_read = True
                while waiting and skip is not None:
                    skip(waiting.pop(0))
                yield place, found
            elif skip is None:
                raise found.error
            elif has_read:
                skip(found.error)
            else:
                waiting.append(found.error)
    if waiting and skip is not None:
        *others, last = waiting
        for error in others:
            skip(error)
        raise last


@dataclass(frozen=True)
class _Unreadable:
    """What takes the place of a file that cannot be read."""

    error: FormatError


def _read_each(
    path: Path, read: Callable[[Path, Path, Member | None], Found], *, may_be_empty: bool
) -> Iterator[tuple[Path, Found | _Unreadable]]:
    try:
        for place, member in _places(path, may_be_empty=may_be_empty):
            try:
                found = read(path, place, member)
            except FormatError as error:
                yield place, _Unreadable(error)
            else:
                yield place, found
    # The archive itself is damaged, or the folder is empty.
    except FormatError as error:
        yield path, _Unreadable(error)


def _places(path: Path, *, may_be_empty: bool) -> Iterator[tuple[Path, Member | None]]:
    """Yield the world files at a path; any file that is not an archive counts as one."""
    is_empty = True
    if path.is_dir():
        for file in files_in(path):
            is_empty = False
            yield file, None
    elif is_archive(path):
        for member in members(path):
            if is_world_file(member.name):
                is_empty = False
                yield path / member.name, member
    else:
        is_empty = False
        yield path, None
    if is_empty and not may_be_empty:
        raise FormatError(
            "no-map-found",
            "contains no .grid files (those called NAME{sidecar} belong to exported maps)",
            "choose a .grid file, or a folder or archive that contains some",
            source=str(path),
            sidecar=SIDECAR,
        )


def read_worlds(paths: Iterable[Path], skip: Skip | None = None) -> Iterator[tuple[Path, World]]:
    """Yield the worlds of files, folders and archives; each is read when it is reached.

    Args:
        paths: A folder means the ``.grid`` and ``.grid.gz`` files in it and below, sorted by name;
            an archive means those in it, in its order; anything else is read as a world.
        skip: See :func:`walk`.

    Returns:
        Path and world; a world in an archive has the archive's path and then its own name.

    Raises:
        FormatError: If a file cannot be read, or a folder or an archive holds no world.
    """

    def read(_path: Path, place: Path, member: Member | None) -> World:
        return read_world(place) if member is None else unpack_world(member, str(place))

    return walk(paths, read, skip)
