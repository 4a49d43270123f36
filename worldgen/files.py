"""Safe reading and writing: a file is read whole within bounds; it is there whole, or it is not there."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from worldgen.errors import FormatError, OutputError

__all__ = ["check_output", "read_text", "write_bytes"]

_MOST_BYTES = 64 << 20


def check_output(path: Path, force: bool) -> None:
    """Refuses before the work what could not be written after it.

    Raises:
        OutputError: If the file is there and ``force`` is not set, or its folder is missing.
    """
    if path.is_dir():
        raise OutputError(f"{path} is a folder; name a file in it")
    if path.is_file() and not force:
        raise OutputError(f"{path} is there already; give --force to overwrite it, or another name")
    if not path.parent.is_dir():
        raise OutputError(f"{path}: the folder {path.parent} does not exist; make it first")


def read_text(path: Path) -> str:
    """The text of a small file.

    Raises:
        FormatError: If it cannot be read, is larger than 64 MiB, or is no UTF-8.
    """
    try:
        with path.open("rb") as stream:
            data = stream.read(_MOST_BYTES + 1)
        if len(data) > _MOST_BYTES:
            raise FormatError(f"is larger than {_MOST_BYTES >> 20} MiB; give a smaller file", source=str(path))
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FormatError(f"is no UTF-8 text: byte {error.start}; save it as UTF-8", source=str(path)) from error
    except FormatError:
        raise
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else error
        raise FormatError(f"cannot be read: {reason}", source=str(path)) from error


def write_bytes(path: Path, data: bytes, *, force: bool) -> None:
    """Writes a file whole or not at all.

    Raises:
        OutputError: If the file is there and ``force`` is not set, its folder is missing, or the disk
            is full or not writable; nothing is left half written.
    """
    try:
        if path.is_dir():
            raise OutputError(f"{path} is a folder; name a file in it")
        if path.exists() and not force:
            raise OutputError(f"{path} is there already; give --force to overwrite it, or another name")
        if not path.parent.is_dir():
            raise OutputError(f"{path}: the folder {path.parent} does not exist; make it first")
        if path.exists() and not path.is_file():  # a device or pipe cannot be replaced
            path.write_bytes(data)
        else:
            _replace(Path(os.path.realpath(path)), data)  # through a link, as any editor writes
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror or error}; choose another place") from error
    except ValueError as error:  # a name with a NUL
        raise OutputError(f"{str(path)!r}: cannot be written: {error}; choose another name") from error


def _replace(path: Path, data: bytes) -> None:
    temporary = None
    try:
        descriptor, temporary = tempfile.mkstemp(dir=path.parent, prefix=".worldgen-")
        with os.fdopen(descriptor, "wb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        umask = os.umask(0)
        os.umask(umask)
        Path(temporary).chmod(0o666 & ~umask)
        Path(temporary).replace(path)
        temporary = None
    finally:
        if temporary is not None:
            Path(temporary).unlink(missing_ok=True)
