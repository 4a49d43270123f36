"""Compare a set with its manifest."""

from __future__ import annotations

import hashlib
import io
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from worldgen.errors import FormatError
from worldgen.files.archives import is_archive, members
from worldgen.sets.manifest import MANIFEST, Manifest, parse_manifest, read_manifest

# Limit on the bytes of a file; a .grid file is never larger.
_MOST = 512 << 20


@dataclass(frozen=True)
class SetDifference:
    """A difference between a set and its manifest.

    Args:
        kind: ``missing``, ``changed``, ``extra`` or ``unfinished``.
        file: Name of the file in the set.
    """

    kind: str
    file: str


def manifest_of(path: Path) -> Manifest:
    """Return the manifest of a set.

    Args:
        path: The set's folder, its archive, or the manifest itself.

    Raises:
        FormatError: If there is none, or it cannot be read.
    """
    if path.is_dir():
        return read_manifest(path / MANIFEST)
    if not is_archive(path):
        return read_manifest(path)
    for member in members(path):
        if member.name == MANIFEST:
            source = f"{path}/{MANIFEST}"
            # Read line by line, because the file may be a decompression bomb.
            return parse_manifest(io.BytesIO(member.read_all(_MOST, source)), source)
    raise FormatError(
        "no-manifest", "holds no {manifest}; it is not a set", manifest=MANIFEST, source=str(path)
    )


def check_set(place: Path, manifest: Manifest) -> list[SetDifference]:
    """Return every difference between a set and a manifest, in its order, then extra files.

    Args:
        place: The set's folder or archive.
        manifest: What it should contain.

    Raises:
        FormatError: If the archive or a file cannot be read.
    """
    found: dict[str, str] = {}
    extra = []
    for name, sha256 in (
        _archived(place) if is_archive(place) and place.is_file() else _in_folder(place)
    ):
        # The archive has this file twice, and programs that unpack it use the first.
        if found.setdefault(name, sha256) != sha256:
            extra.append(name)
    differences = []
    for entry in manifest.entries:
        came = found.pop(entry.file, None)
        if came != entry.sha256:
            differences.append(SetDifference("missing" if came is None else "changed", entry.file))
    found.pop(MANIFEST, None)
    differences += [SetDifference("extra", name) for name in sorted([*found, *extra])]
    if not manifest.finished:
        differences.append(SetDifference("unfinished", MANIFEST))
    return differences


def _in_folder(folder: Path) -> Iterator[tuple[str, str]]:
    for path in folder.rglob("*"):
        name = path.relative_to(folder)
        if path.is_file() and not any(part.startswith(".") for part in name.parts):
            try:
                with path.open("rb") as stream:
                    yield name.as_posix(), hashlib.file_digest(stream, "sha256").hexdigest()
            except OSError as error:
                raise FormatError.unreadable(path, error) from error


def _archived(archive: Path) -> Iterator[tuple[str, str]]:
    for member in members(archive):
        data = member.read(_MOST)
        yield member.name, "" if data is None else hashlib.sha256(data).hexdigest()
