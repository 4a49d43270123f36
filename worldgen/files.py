"""Safe writing: a file is there whole, or it is not there."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from worldgen.errors import OutputError

__all__ = ["check_output", "write_bytes"]


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
