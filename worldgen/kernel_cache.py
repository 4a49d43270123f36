"""Keeps compiled kernels in files that only their owner can have written, and notices damaged ones.

A cached kernel is a pickle with machine code in it: whoever writes the file runs code as whoever reads it. So a file
counts only if this user owns it and nobody else can write it. A file that a crash left half written, or full of
zeros, does not match its digest, and the kernel is compiled again.
"""

# mypy: disable-error-code="no-untyped-call"
from __future__ import annotations

import contextlib
import hashlib
import os
import pickle
import stat
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba.core.caching import FunctionCache, IndexDataCacheFile

__all__ = ["KernelCache"]

_DIGEST = hashlib.sha256().digest_size


class _CheckedFiles(IndexDataCacheFile):
    """Numba's index and data files, each behind a digest, read only if they are this user's own."""

    def _load_index(self) -> dict[Any, str]:
        found = _unpickled(Path(self._index_path))
        if not isinstance(found, tuple) or len(found) != 3:
            return {}
        version, stamp, overloads = found
        return overloads if (version, stamp) == (self._version, self._source_stamp) else {}

    def _save_index(self, overloads: dict[Any, str]) -> None:
        _write(Path(self._index_path), self._dump((self._version, self._source_stamp, overloads)))

    def _load_data(self, name: str) -> Any:
        return _unpickled(Path(self._data_path(name)))

    def _save_data(self, name: str, data: Any) -> None:
        _write(Path(self._data_path(name)), self._dump(data))


class KernelCache(FunctionCache):
    """The cache of one kernel.

    Args:
        function: What is compiled.
        folder: Of the user's own, as :func:`worldgen.jit.cache_folder` has checked.
        missed: Called when the kernel must be compiled, before that begins.
    """

    def __init__(self, function: Callable[..., Any], folder: Path, missed: Callable[[], object]) -> None:
        super().__init__(function)
        self._missed = missed
        # Numba falls back to folders that nobody has checked, and names them by where the source lies. The digest in
        # the name of ours stands for all sources and for the compiler, so two installations of the same worldgen and
        # the same numba share what is compiled.
        self._cache_path = str(folder / function.__module__)
        self._cache_file = _CheckedFiles(self._cache_path, f"{self._impl.filename_base}.checked", "")

    def load_overload(self, signature: Any, target_context: Any) -> Any:
        """The compiled kernel, or None where there is none that can be trusted."""
        found = None
        with contextlib.suppress(OSError):
            found = super().load_overload(signature, target_context)
        if found is None:
            self._missed()
        return found

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Keep a compiled kernel; on a full disk it is only not kept."""
        with contextlib.suppress(OSError):
            super().save_overload(signature, compiled)


def _unpickled(path: Path) -> Any:
    """What a file of our own holds; None if there is none, it is somebody else's, or it is damaged."""
    try:
        # A symlink, or a pipe that blocks the reader, is not a file of ours. What was opened is what is checked.
        flags = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
        with os.fdopen(os.open(path, flags), "rb") as stream:
            if not _is_our_own(os.fstat(stream.fileno())):
                return None
            data = stream.read()
    except OSError:
        return None
    digest = data[:_DIGEST]
    content = data[_DIGEST:]
    if hashlib.sha256(content).digest() != digest:
        return None
    try:
        return pickle.loads(content)
    except Exception:  # noqa: BLE001 - it is our own, but written by a numba whose classes are no longer there
        return None


def _is_our_own(status: os.stat_result) -> bool:
    if not stat.S_ISREG(status.st_mode):
        return False
    if not hasattr(os, "geteuid"):  # Windows keeps the cache in the user's own profile
        return True
    return status.st_uid == os.geteuid() and not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def _write(path: Path, content: bytes) -> None:
    """Put a file in its place in one move, readable and writable by its owner only."""
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    descriptor, temporary = tempfile.mkstemp(dir=path.parent, prefix=".worldgen-")
    try:
        with os.fdopen(descriptor, "wb") as stream:
            stream.write(hashlib.sha256(content).digest() + content)
        Path(temporary).replace(path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise
