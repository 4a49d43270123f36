"""The journal of a campaign: a record of each piece of work that is done, appended and kept.

A line is a digest, a space, and the record as JSON. The digest covers the record and the campaign's
fingerprint: a line that is torn, changed or another campaign's is as if it were not there.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, BinaryIO, TypeAlias

import msgspec

from fuzz.failure import ID_DIGITS, Failure
from fuzz.layouts.layout_bytes import SCENE_BYTES
from fuzz.unit.result import Elite, FirstMet, ScreenedRun, Seconds, UnitCount, UnitResult
from worldgen.errors import FormatError
from worldgen.files.whole import open_no_link, refused_writes

# Limit on the bytes of a line, because a folder may come from anyone.
_LONGEST = 64 << 20

_FailureId = Annotated[str, msgspec.Meta(pattern=rf"^[0-9a-f]{{{ID_DIGITS}}}\Z")]
_Layout = Annotated[str, msgspec.Meta(pattern=rf"^[0-9a-f]{{{2 * SCENE_BYTES}}}\Z")]
_Name = Annotated[str, msgspec.Meta(min_length=1, max_length=10_000)]
_Rows = msgspec.Meta(max_length=100_000)
_Cell = Annotated[
    tuple[Annotated[int, msgspec.Meta(ge=0, le=1_000)], ...],
    msgspec.Meta(min_length=2, max_length=8),
]

StoredElite: TypeAlias = tuple[_Cell, _Layout, float, _Name]
"""Cell of the archive, layout, quality and verdict."""


class UnitRecord(msgspec.Struct, frozen=True, kw_only=True, tag="unit"):
    """A unit is done, or was cut short.

    Args:
        unit: Number of the unit.
        cut: True if it must be done again.
        seconds: Seconds of the campaign, over all runs, when the unit was merged.
        strategy: See :class:`UnitResult`, also for the other fields.
        failures: IDs of the failures.
        first_met: Of each of them in turn, when the unit first met one of its key.
    """

    unit: UnitCount
    cut: bool
    seconds: Seconds
    strategy: _Name
    worlds: UnitCount
    steps: UnitCount
    verdicts: Annotated[dict[_Name, UnitCount], _Rows]
    judged: UnitCount
    met: Annotated[list[tuple[_Name, _Name, UnitCount]], _Rows]
    failures: Annotated[list[_FailureId], _Rows]
    first_met: Annotated[list[FirstMet], _Rows]
    elites: Annotated[list[StoredElite], _Rows]
    tried: Annotated[dict[_Name, UnitCount], _Rows] = {}
    lines: Annotated[list[UnitCount], _Rows] = []
    screened: Annotated[dict[UnitCount, ScreenedRun], _Rows] = {}

    @classmethod
    def of(cls, unit: int, result: UnitResult, seconds: float) -> UnitRecord:
        """Return the record of a unit's result."""
        return cls(
            unit=unit,
            cut=result.cut,
            seconds=round(seconds, 3),
            strategy=result.strategy,
            worlds=result.worlds,
            steps=result.steps,
            verdicts=dict(result.verdicts),
            judged=result.judged,
            met=[(*kind, count) for kind, count in result.met.items()],
            failures=[failure.id for failure in result.failures.values()],
            first_met=[result.first_met[key] for key in result.failures],
            elites=[
                (cell, elite.layout.hex(), elite.quality, elite.verdict)
                for cell, elite in result.elites.items()
            ],
            tried=dict(result.tried),
            lines=sorted(result.lines),
            screened=result.screened if result.cut else {},
        )

    def result(self, failure: Callable[[str], Failure]) -> UnitResult:
        """Return the unit's result.

        Args:
            failure: Returns the failure with an ID.
        """
        failures = [*map(failure, self.failures)]
        return UnitResult(
            strategy=self.strategy,
            worlds=self.worlds,
            steps=self.steps,
            verdicts=Counter(self.verdicts),
            tried=Counter(self.tried),
            judged=self.judged,
            met=Counter({(group, verdict): count for group, verdict, count in self.met}),
            failures={one.key: one for one in failures},
            first_met={one.key: at for one, at in zip(failures, self.first_met, strict=True)},
            elites={
                cell: Elite(bytes.fromhex(layout), quality, verdict)
                for cell, layout, quality, verdict in self.elites
            },
            lines=frozenset(self.lines),
            screened=self.screened,
            cut=self.cut,
            stored_at=self.seconds,
        )


class ShrunkRecord(msgspec.Struct, frozen=True, tag="shrunk"):
    """A failure is shrunk; both are IDs."""

    found: _FailureId
    shrunk: _FailureId


class ShownRecord(msgspec.Struct, frozen=True, tag="shown"):
    """A failure is about to be written to a file in the campaign's folder."""

    file: _Name
    failure: _FailureId


Record: TypeAlias = UnitRecord | ShrunkRecord | ShownRecord


class Journal:
    """The records in a file.

    Args:
        file: The file; created with the first record.
        fingerprint: Digest of the campaign's fingerprint.
    """

    def __init__(self, file: Path, fingerprint: str) -> None:
        self.fingerprint = fingerprint
        self._file = file

    def is_begun(self) -> bool:
        """Return True if the file holds anything, even if no record in it is intact."""
        try:
            return self._file.lstat().st_size > 0
        except OSError:
            return False

    def __iter__(self) -> Iterator[tuple[int, Record]]:
        """Yield the intact records in order, each with its offset.

        Raises:
            FormatError: If the file cannot be read.
        """
        if not self._file.is_file() or self._file.is_symlink():
            return
        with self._opened() as stream:
            at = 0
            while line := stream.readline(_LONGEST):
                record = self._read(line)
                if record is not None:
                    yield at, record
                at += len(line)

    def at(self, offset: int) -> Record | None:
        """Return the record at an offset, or ``None`` if its line has been damaged.

        Raises:
            FormatError: If the file cannot be read.
        """
        with self._opened() as stream:
            stream.seek(offset)
            return self._read(stream.readline(_LONGEST))

    @contextlib.contextmanager
    def _opened(self) -> Iterator[BinaryIO]:
        try:
            with self._file.open("rb") as stream:
                yield stream
        except OSError as error:
            raise FormatError.unreadable(self._file, error) from error

    def append(self, record: Record) -> int:
        """Add a record and return its offset; it is on the disk then.

        Raises:
            OutputError: If it cannot be written.
        """
        text = msgspec.json.encode(record)
        return append_line(self._file, self._seal(text) + b" " + text)

    def _read(self, line: bytes) -> Record | None:
        seal, _, text = line.removesuffix(b"\n").partition(b" ")
        if seal != self._seal(text):
            return None
        try:
            record: Record = msgspec.json.decode(text, type=Record)
        # Whoever knows the fingerprint can seal anything.
        except (RecursionError, ValueError):
            return None
        return record

    def _seal(self, text: bytes) -> bytes:
        digest = hashlib.sha256(f"{self.fingerprint} ".encode() + text)
        return digest.hexdigest()[:ID_DIGITS].encode()


def append_line(file: Path, line: bytes) -> int:
    """Append a line to a file, sync it, and return its offset.

    Raises:
        OutputError: If it cannot be written, or is a link.
    """
    with refused_writes(file), os.fdopen(open_no_link(file, os.O_APPEND), "ab+") as stream:
        end = stream.seek(0, os.SEEK_END)
        # Whatever a crash or a full disk left of the last line must not swallow this one.
        if end:
            stream.seek(end - 1)
            if stream.read(1) != b"\n":
                end += stream.write(b"\n")
        stream.write(line + b"\n")
        stream.flush()
        os.fsync(stream.fileno())
    return end
