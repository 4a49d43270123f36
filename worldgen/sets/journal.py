"""The manifest of a set in progress: a world's line is appended once its file is safe."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from worldgen.errors import FormatError, OutputError
from worldgen.files.locks import lock
from worldgen.files.whole import refused_writes
from worldgen.sets.manifest import Manifest, parse_manifest


class Journal:
    """A manifest that grows by whole lines, written by one process at a time.

    A killed process leaves only complete lines.

    Args:
        path: The file.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._file: int | None = None
        # Length of the whole lines, bytes.
        self._end = 0

    def read(self, *, force: bool = False) -> Manifest | None:
        """Return the existing manifest, and lock it against other processes until ``close``.

        Args:
            force: True if the file may be something else, which is then replaced.

        Returns:
            The manifest; ``None`` if there is none, or not even a complete first line, or, with
            ``force``, something else.

        Raises:
            FormatError: If it isn't a manifest.
            OutputError: If another process is writing it, or it cannot be written.
        """
        if not self.path.is_file():
            return None
        self._open(os.O_RDWR)
        with refused_writes(self.path), self.path.open("rb") as stream:
            lines = list(stream)
        # The header was never written completely, so nothing was recorded.
        if not lines or not lines[0].endswith(b"\n"):
            return None
        try:
            return parse_manifest(lines, str(self.path))
        except FormatError:
            if force:
                # With --force, a damaged record counts as missing.
                return None
            raise

    def start(self, header: bytes) -> None:
        """Start again with this line.

        Raises:
            OutputError: If it cannot be written, or another process has begun, or even finished,
                since ``read``.
        """
        # There was nothing to read.
        if self._file is None:
            self._open(os.O_RDWR | os.O_CREAT)
            with refused_writes(self.path):
                begun = os.fstat(self._opened()).st_size > 0
            if begun:
                raise OutputError(
                    "written-meanwhile",
                    "{path} was written by another command in the meantime",
                    "look at it, or choose another folder",
                    path=self.path,
                )
        self.cut(0)
        self.append(header)

    def cut(self, end: int) -> None:
        """Truncate the file to this many bytes, and continue from there."""
        with refused_writes(self.path):
            os.ftruncate(self._opened(), end)
        self._end = end

    def append(self, line: bytes) -> None:
        """Append a line, or leave the file unchanged.

        Raises:
            OutputError: If it cannot be written.
        """
        with refused_writes(self.path):
            try:
                append_at(self._opened(), self._end, line)
            except OSError:
                with contextlib.suppress(OSError):
                    os.ftruncate(self._opened(), self._end)
                raise
        self._end += len(line)

    def sync(self) -> None:
        """Wait until the disk has stored it."""
        with refused_writes(self.path):
            os.fsync(self._opened())

    def close(self) -> None:
        """Unlock it for other processes."""
        if self._file is not None:
            os.close(self._file)
            self._file = None

    def _open(self, flags: int) -> None:
        with refused_writes(self.path):
            self._file = os.open(self.path, flags | getattr(os, "O_BINARY", 0), 0o666)
        if not lock(self._file):
            self.close()
            raise OutputError(
                "written-meanwhile",
                "{path} is being written by another command",
                "wait until it ends",
                path=self.path,
            )
        # It was removed between opening and locking.
        if os.fstat(self._file).st_nlink == 0:
            self.close()
            raise OutputError(
                "written-meanwhile",
                "{path} was finished by another command in the meantime",
                "look at the set that it made",
                path=self.path,
            )

    def _opened(self) -> int:
        if self._file is None:
            raise OutputError(
                "not-open", "{path} is not open", "start the set first", path=self.path
            )
        return self._file


def append_at(file: int, end: int, data: bytes) -> None:
    """Write all of the data after the first ``end`` bytes of an open file."""
    os.lseek(file, end, os.SEEK_SET)
    left = memoryview(data)
    while left:
        left = left[os.write(file, left) :]
