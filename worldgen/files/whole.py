"""Read and write files safely: a file is read completely, within limits.

A written file is complete, or does not exist.
"""

from __future__ import annotations

import contextlib
import errno
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Protocol

from worldgen.errors import FormatError, OutputError, WorldgenError
from worldgen.support.paths import real_path
from worldgen.support.results import opened_as

_MOST_BYTES = 64 << 20
# Bytes read at a time.
_PIECE = 1 << 20


def check_output(path: Path, force: bool) -> None:
    """Reject, before the work, output that could not be written after it.

    Raises:
        OutputError: If the file exists and ``force`` is not set, or its folder is missing or not
            writable.
    """
    if path.is_dir():
        raise OutputError("is-a-folder", "{path} is a folder", "choose a file in it", path=path)
    # A device or a pipe is never overwritten, so it needs no --force.
    if opened_as(path).is_file() and not force:
        raise OutputError(
            "file-exists",
            "{path} already exists",
            "use --force to overwrite it, or choose another name",
            at_terminal=True,
            path=path,
        )
    if not path.parent.is_dir():
        raise OutputError(
            "no-such-folder",
            "{path}: the folder {folder} does not exist",
            "make it first",
            path=path,
            folder=path.parent,
        )
    # A file is replaced, which needs its folder; a device or a pipe is written itself.
    if path.is_file() or not path.exists():
        check_writable(path, real_path(path).parent)


def check_writable(path: Path, folder: Path) -> None:
    """Reject a path in a folder where this user may not write.

    Raises:
        OutputError: If the user may not.
    """
    if not os.access(folder, os.W_OK):
        raise OutputError(
            "unwritable",
            "{path}: cannot be written: {reason}",
            "choose another place",
            path=path,
            reason=os.strerror(errno.EACCES),
        )


class SupportsRead(Protocol):
    """A stream that can be read piece by piece."""

    def read(self, size: int, /) -> bytes:
        """Return the next bytes, or none at the end."""


def read_up_to(stream: SupportsRead, most: int) -> bytes | None:
    """Return a whole stream, or None if it exceeds a limit, because a device may never end."""
    pieces: list[bytes] = []
    left = most
    while piece := stream.read(_PIECE):
        left -= len(piece)
        if left < 0:
            return None
        pieces.append(piece)
    return b"".join(pieces)


def read_bytes(path: Path, most: int, remedy: str = "split it") -> bytes:
    """Return the bytes of a file.

    Args:
        path: The file.
        most: The largest size, bytes.
        remedy: The way out if it is larger.

    Raises:
        FormatError: If it cannot be read, or is larger.
    """
    try:
        stream = path.open("rb")
    # ValueError means that the name contains a NUL.
    except (OSError, ValueError) as error:
        raise FormatError.unreadable(path, error) from error
    with stream:
        return read_stream(stream, str(path), most, remedy)


def read_stream(stream: SupportsRead, source: str, most: int, remedy: str = "split it") -> bytes:
    """Return the bytes of an open file, as :func:`read_bytes` does; ``source`` is its name."""
    try:
        data = read_up_to(stream, most)
    except (OSError, ValueError) as error:
        raise FormatError.unreadable(source, error) from error
    if data is None:
        raise FormatError(
            "too-large", "is larger than {most} bytes", remedy, most=most, source=source
        )
    return data


def read_text(path: Path, most: int = _MOST_BYTES) -> str:
    """Return the text of a small file, as :func:`read_bytes` does.

    Raises:
        FormatError: If it cannot be read, is larger, or isn't UTF-8.
    """
    return decoded(read_bytes(path, most), str(path))


def decoded(data: bytes, source: str) -> str:
    """Return the text in the bytes of a file.

    Raises:
        FormatError: If it isn't UTF-8.
    """
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FormatError(
            "not-utf8",
            "is not UTF-8 text: byte {byte}",
            "save it as UTF-8",
            byte=error.start,
            source=source,
        ) from error


def write_bytes(path: Path, data: bytes, *, force: bool) -> None:
    """Write a file completely or not at all.

    Raises:
        OutputError: If the file exists and ``force`` is not set, its folder is missing, or the disk
            is full or not writable; no partial file is left behind.
    """
    with refused_writes(path):
        check_output(path, force)
        path = opened_as(path)
        # A device or pipe cannot be replaced.
        if path.exists() and not path.is_file():
            path.write_bytes(data)
        else:
            # Write through a link, as any editor does.
            _replace(real_path(path), data)


@contextlib.contextmanager
def refused_writes(path: Path) -> Iterator[None]:
    """Report system errors while the body writes to ``path``.

    Raises:
        OutputError: If the body raises ``OSError``, or ``ValueError`` for a name with a NUL.
    """
    try:
        yield
    # Some are ValueErrors.
    except WorldgenError:
        raise
    except OSError as error:
        raise OutputError(
            "unwritable",
            "{path}: cannot be written: {reason}",
            "choose another place",
            path=path,
            reason=error.strerror or str(error),
        ) from error
    # The name contains a NUL.
    except ValueError as error:
        raise OutputError(
            "unwritable",
            "{path!r}: cannot be written: {reason}",
            "choose another name",
            path=str(path),
            reason=str(error),
        ) from error


def open_no_link(path: Path, flags: int = 0) -> int:
    """Open a file in place to read and write, and create it if it is missing.

    A folder may come from anyone, so a link in it is not followed where the system can tell.

    Args:
        path: The file.
        flags: More flags of ``os.open``.

    Returns:
        The descriptor.

    Raises:
        OutputError: If it is a link, or cannot be written.
    """
    more = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
    with refused_writes(path):
        try:
            return os.open(path, os.O_RDWR | os.O_CREAT | more | flags, 0o666)
        except OSError as error:
            if not path.is_symlink():
                raise
            raise OutputError(
                "is-a-link",
                "{path} is a link, so it is not written",
                "remove it, or choose another folder",
                path=path,
            ) from error


def _replace(path: Path, data: bytes) -> None:
    # Write to a temporary file in the same folder, which can then be renamed.
    temporary = None
    try:
        descriptor, temporary = tempfile.mkstemp(dir=path.parent, prefix=".worldgen-")
        with os.fdopen(descriptor, "wb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        # mkstemp makes private files; give this one the usual permissions.
        umask = os.umask(0)
        os.umask(umask)
        Path(temporary).chmod(0o666 & ~umask)
        Path(temporary).replace(path)
        temporary = None
    finally:
        if temporary is not None:
            Path(temporary).unlink(missing_ok=True)
