"""The only folder that the studio may read and write; no name leads out of it."""

from __future__ import annotations

import errno
import functools
import glob
import hashlib
import os
import stat
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fuzz.studio.requests.protocol import ListedFile, Refusal, Request, SendPart
from fuzz.studio.requests.refusals import refusal
from worldgen.errors import InvalidParameter, Message, OutputError, WorldgenError
from worldgen.files.archives import ENDINGS
from worldgen.files.grid import read_world
from worldgen.files.worlds import is_world_file
from worldgen.support.paths import real_path
from worldgen.support.plain_text import shown

KNOWN = "known"
"""The folder, in the opened one, of failures that are marked as known.

It is the baseline of campaigns started in the studio.
"""

_MEMORY = ".campaign"  # name of the campaign store in a campaign's folder
MOST_FILES = 2_000  # listed files; more than anyone scrolls through
MOST_FAILURES = 20_000  # failures in the gallery, which has filters
_DEEPEST = 4  # levels of folders below the opened one
_LONGEST = 400  # characters of a name


@dataclass(frozen=True)
class Folder:
    """An opened folder.

    Args:
        root: Its path.
    """

    root: Path

    def __post_init__(self) -> None:
        object.__setattr__(self, "root", real_path(self.root))

    def place(self, name: str) -> Path:
        """Return the path of a name in the folder, whether or not the file exists.

        Args:
            name: Relative to the folder, with ``/`` between its parts.

        Raises:
            InvalidParameter: If it is not a valid name, is hidden, leads out of the folder, also
                through links, or names a pipe or device.
        """
        parts = name.split("/")
        if not (name and len(name) <= _LONGEST and name.isprintable()) or {"\\", ":"} & {*name}:
            raise _refused(
                "not-a-file-name",
                name,
                "is not the name of a file in the opened folder",
                "choose a name such as w.grid",
            )
        if any(part in ("", ".", "..") or part.startswith(".") for part in parts):
            raise _refused(
                "outside-of-folder",
                name,
                "is outside the opened folder or is hidden",
                "choose a name in the folder",
            )
        # Resolve links before looking at the file, so that a link cannot lead out.
        path = self.root.joinpath(*parts)
        real = real_path(path)
        if not real.is_relative_to(self.root):
            raise _refused(
                "outside-of-folder", name, "is outside the opened folder", "copy the file into it"
            )
        try:
            mode = real.stat().st_mode
        except OSError as error:
            if error.errno == errno.ENAMETOOLONG:
                raise _refused(
                    "name-too-long",
                    name,
                    "is too long for a file in the opened folder",
                    "shorten it",
                ) from error
            return real
        # Reading a pipe could block forever.
        if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
            raise _refused(
                "wrong-kind-of-file",
                name,
                "in the opened folder is not a regular file",
                "choose another",
            )
        return real

    def file_in_option(self, text: str, known: Collection[str] = ()) -> str:
        """Return the value of an option, in which a file in the folder has its full path.

        File names are relative to the folder.

        Args:
            text: The value; one that names no file is returned unchanged.
            known: Names that are not files.

        Raises:
            InvalidParameter: If it names a file outside the folder, as :meth:`place` defines it.
        """
        # Options of what is named follow a plus: ./mine.py:rooms+size=20.
        name, plus, rest = text.partition("+")
        if name in known:
            return text
        is_file = "/" in name or "\\" in name or name.startswith("~") or Path(name).suffix
        if not (is_file or (self.root / name).exists() or Path(name).exists()):
            return text
        path = Path(name)
        if path.is_absolute() and path.is_relative_to(self.root):
            name = path.relative_to(self.root).as_posix()
        return f"{self.place(name.removeprefix('./'))}{plus}{rest}"

    def check_replaceable(self, place: Path, written: Mapping[Path, str] | None = None) -> None:
        """Refuse to replace a file that is not a world, and was not written here.

        Args:
            place: The file, which may not exist.
            written: Digests of the files that this studio has written, by path.

        Raises:
            OutputError: If it is anything else, such as code.
        """
        if not place.is_file() or digest_of(place) == (written or {}).get(place):
            return
        try:
            read_world(place)
        except (OSError, WorldgenError):
            raise OutputError(
                "not-a-world",
                "{name} is not a world that the studio could have written, so it stays as it is",
                "choose another name",
                name=place.relative_to(self.root).as_posix(),
            ) from None

    def refusal(self, error: WorldgenError | Message) -> Refusal:
        """Return an error as the page expects it, with paths relative to this folder."""
        return refusal(error, self.root)

    def place_of_map(self, name: str) -> Path:
        """Return the path of a map, if no file with the same stem leads out of the folder.

        Formats read such files along with the map.

        Raises:
            InvalidParameter: As for ``place``, even if such a link exists.
        """
        place = self.place(name)
        if place.is_file():
            for other in place.parent.glob(f"{glob.escape(place.stem)}*"):
                if not real_path(other).is_relative_to(self.root):
                    raise _refused(
                        "outside-of-folder",
                        other.name,
                        "to which the file refers, is outside the opened folder",
                        "copy the file into it",
                    )
        return place

    def files(
        self, endings: tuple[str, ...] = (), below: str = "", most: int = MOST_FILES
    ) -> list[ListedFile]:
        """Return the worlds and the files with these suffixes that can be opened; no hidden ones.

        Files found by campaigns come last.

        Args:
            endings: Suffixes of files other than worlds.
            below: A subfolder; the whole folder if omitted.
            most: Maximum number of files to return.
        """
        walked = self._walk(self.place(below) if below else self.root, 0, 2 * most, False)
        known = (file for file in walked if file.world or file.name.lower().endswith(endings))
        return sorted(known, key=lambda file: (file.found, file.name.count("/"), file.name))[:most]

    def archives(self) -> list[str]:
        """Return the names of archives, which may contain worlds."""
        names = [file.name for file in self._walk(self.root, 0, 2 * MOST_FILES, False)]
        packed = (name for name in names if name.lower().endswith(ENDINGS))
        return sorted(packed, key=lambda name: (name.count("/"), name))[:MOST_FILES]

    def folders(self) -> list[str]:
        """Return the names of the subfolders, without hidden ones and links."""
        found: list[str] = []
        for top, inner, _ in os.walk(self.root):
            inner[:] = sorted(one for one in inner if not one.startswith(".") and one.isprintable())
            inner[:] = [one for one in inner if not Path(top, one).is_symlink()]
            there = Path(top).relative_to(self.root)
            found += [(there / one).as_posix() for one in inner]
            if len(there.parts) >= _DEEPEST - 1 or len(found) > MOST_FILES:
                inner.clear()
        return found[:MOST_FILES]

    def _walk(self, folder: Path, depth: int, most: int, found: bool) -> Iterator[ListedFile]:
        try:
            entries = sorted(os.scandir(folder), key=lambda entry: entry.name)
        except OSError:  # not readable for this user
            return
        found = (
            found or folder == self.root / KNOWN or any(entry.name == _MEMORY for entry in entries)
        )
        for entry in entries[:most]:
            if entry.name.startswith(".") or entry.is_symlink() or not entry.name.isprintable():
                continue
            try:
                facts = entry.stat(follow_symlinks=False)
            except OSError:  # deleted in the meantime, as a running campaign does with its files
                continue
            if stat.S_ISDIR(facts.st_mode) and depth < _DEEPEST:
                yield from self._walk(Path(entry.path), depth + 1, most, found)
            elif stat.S_ISREG(facts.st_mode):
                name = Path(entry.path).relative_to(self.root).as_posix()
                yield ListedFile(name, facts.st_size, is_world_file(entry.name), found)


def _refused(code: str, name: str, problem: str, remedy: str) -> InvalidParameter:
    return InvalidParameter(code, f"{{name!r}} {problem}", remedy, name=shown(name[:60]))


def digest_of(place: Path) -> str:
    """Return the digest of a file, which reveals changes since it was opened or written."""
    return hashlib.sha256(place.read_bytes()).hexdigest()


@dataclass(frozen=True)
class Opened:
    """The folder and the controllers with which the studio was started.

    Args:
        folder: The folder that can be read and written.
        named: Controllers that were named at the start, in addition to the registered ones.
        written: Digests of the files that were exported to the folder, by path.
    """

    folder: Folder
    named: Sequence[str] = ()
    written: dict[Path, str] = field(default_factory=dict)


@functools.singledispatch
def answer(request: Request, opened: Opened, part: SendPart[Any]) -> Any:
    """Answer a request of the page, by the function that is registered for its type.

    Args:
        request: The request.
        opened: What the studio was started with.
        part: Called with parts of the answer that are ready earlier.
    """
    raise NotImplementedError(request.do)
