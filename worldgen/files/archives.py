"""Archives of many small files.

Zip files are written reproducibly; those and tar files are read one file at a time within limits.
Times, owners and modes are fixed, so equal files in equal order give an equal archive. The
compressed bytes depend on zlib.
"""

from __future__ import annotations

import bz2
import contextlib
import gzip
import struct
import tarfile
import zipfile
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from worldgen.errors import FormatError, OutputError
from worldgen.files.whole import SupportsRead, read_up_to

ENDINGS = (".zip", ".tar.gz", ".tgz", ".tar.bz2", ".tar")

# Compression level: zlib's own default, fixed.
_LEVEL = 6
# The earliest time that a zip file can store.
_FIRST_DAY = (1980, 1, 1, 0, 0, 0)
_MODE = 0o644
# Block size of a tar file, bytes.
_BLOCK = 512
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
# Bytes skipped at a time.
_PIECE = 1 << 20


@dataclass(frozen=True)
class Member:
    """A file of an archive.

    Args:
        name: Its name in the archive, with forward slashes.
        packed: Its compressed size, bytes; the whole archive's if it is compressed as one.
        read: Returns its bytes, or ``None`` if there are more than its argument. For a tar file it
            must be called before the next member is requested.
    """

    name: str
    packed: int
    read: Callable[[int], bytes | None]

    def read_all(self, most: int, source: str) -> bytes:
        """Return the file's bytes.

        Raises:
            FormatError: If it is longer than a limit, or cannot be read; ``source`` names it.
        """
        data = self.read(most)
        if data is None:
            raise FormatError(
                "too-large",
                "longer than {most} bytes, the limit in such an archive",
                "unpack it by hand",
                most=most,
                source=source,
            )
        return data


class ZipWriter:
    """A zip file that grows file by file.

    Args:
        stream: Stream to write to.
    """

    def __init__(self, stream: IO[bytes]) -> None:
        self._zip = zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED, compresslevel=_LEVEL)

    def add(self, name: str, data: bytes) -> None:
        """Append a file."""
        entry = zipfile.ZipInfo(name, _FIRST_DAY)
        entry.compress_type = zipfile.ZIP_DEFLATED
        entry.create_system = 3
        entry.external_attr = _MODE << 16
        self._zip.writestr(entry, data, compresslevel=_LEVEL)

    def close(self) -> None:
        """Write the end of the archive."""
        self._zip.close()


def is_archive(path: Path) -> bool:
    """Return True if the name is an archive's."""
    return path.name.lower().endswith(ENDINGS)


def check_written(path: Path) -> None:
    """Refuse to write an archive that isn't a zip file.

    Raises:
        OutputError: If the name is that of another archive.
    """
    if is_archive(path) and path.suffix.lower() != ".zip":
        raise OutputError(
            "unknown-format",
            "{path}: worldgen reads such archives, and writes .zip",
            "choose a name that ends in .zip",
            path=path,
        )


@contextlib.contextmanager
def _damage_reported(source: str) -> Iterator[None]:
    """Raise whatever goes wrong with a damaged archive as a ``FormatError``."""
    try:
        yield
    except (
        zipfile.BadZipFile,
        tarfile.TarError,
        EOFError,
        zlib.error,
        struct.error,
        ValueError,
    ) as error:
        if isinstance(error, FormatError):
            raise
        raise FormatError(
            "damaged-file",
            "not a valid archive: {reason}",
            "copy it again",
            reason=error or "it is truncated",
            source=source,
        ) from error
    # Another compression method, or encryption.
    except (NotImplementedError, RuntimeError) as error:
        raise FormatError(
            "unsupported",
            "cannot be unpacked: {reason}",
            "pack it again without it",
            reason=str(error),
            source=source,
        ) from error
    except OSError as error:
        raise FormatError.unreadable(source, error) from error


def members(path: Path) -> Iterator[Member]:
    """Yield the files of an archive in order, one at a time.

    Raises:
        FormatError: If it cannot be read.
    """
    with _damage_reported(str(path)), path.open("rb") as stream:
        name = path.name.lower()
        packed = path.stat().st_size
        if name.endswith(".zip"):
            yield from _zip_members(stream, str(path), packed)
        elif name.endswith((".gz", ".tgz")):
            yield from _tar_members(gzip.GzipFile(fileobj=stream), str(path), packed)
        else:
            yield from _tar_members(
                bz2.BZ2File(stream) if name.endswith(".bz2") else stream, str(path), packed
            )


def archive_in(path: Path) -> tuple[Path, str] | None:
    """Split a path into an archive and the name of a file in it.

    An example is ``set.zip/maze-7.grid``.
    """
    for parent in path.parents:
        if is_archive(parent) and parent.is_file():
            return parent, path.relative_to(parent).as_posix()
    return None


def _zip_members(stream: IO[bytes], source: str, most: int) -> Iterator[Member]:
    with zipfile.ZipFile(stream) as archive:
        for entry in archive.infolist():

            def read(limit: int, entry: zipfile.ZipInfo = entry) -> bytes | None:
                # Other modes take as much memory as the file demands.
                if entry.compress_type not in _METHODS:
                    raise FormatError(
                        "unsupported",
                        "is compressed by a method other than deflate",
                        "pack it again with deflate",
                        source=f"{source}/{entry.filename}",
                    )
                with _damage_reported(f"{source}/{entry.filename}"), archive.open(entry) as file:
                    return read_up_to(file, limit)

            # A broken archive may have no name.
            if entry.filename and not entry.is_dir():
                yield Member(entry.filename, min(entry.compress_size, most), read)


def _tar_members(stream: SupportsRead, source: str, packed: int) -> Iterator[Member]:
    """Parse tar here, because the library trusts the length of a long header."""
    # Read the headers, block by block.
    while len(head := stream.read(_BLOCK)) == _BLOCK and head.strip(b"\0"):
        entry = tarfile.TarInfo.frombuf(head, "utf-8", "surrogateescape")
        if entry.size < 0:
            raise tarfile.ReadError("a file in it has a length below 0")
        left = entry.size + -entry.size % _BLOCK

        def read(limit: int, size: int = entry.size) -> bytes | None:
            nonlocal left
            if size > limit:
                return None
            with _damage_reported(source):
                data = stream.read(size)
                if len(data) < size:
                    raise EOFError("it is truncated")
            left -= size
            return data

        # Yield regular files; skip any bytes that the caller did not read.
        if entry.type in (tarfile.REGTYPE, tarfile.AREGTYPE):
            yield Member(entry.name, packed, read)
        while left > 0:
            skipped = len(stream.read(min(left, _PIECE)))
            if not skipped:
                raise EOFError("it is truncated")
            left -= skipped
    if 0 < len(head) < _BLOCK:
        raise EOFError("it is truncated")
