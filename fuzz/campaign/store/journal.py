"""The journal of a campaign: a record of each piece of work that is done, appended and kept.

A line is a digest, a space, and the record as JSON. The digest covers the record and the campaign's
fingerprint: a line that is torn, changed or another campaign's is as if it were not there.
"""

from __future__ import annotations

import hashlib
import os
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, TypeAlias

import msgspec

from fuzz.failure import ID_DIGITS, Failure
from fuzz.unit.result import Elite, FirstMet, UnitResult
from worldgen.files.whole import refused_writes

# Limit on the bytes of a line, because a folder may come from anyone.
_LONGEST = 64 << 20

_FailureId = Annotated[str, msgspec.Meta(pattern=rf"^[0-9a-f]{{{ID_DIGITS}}}\Z")]
_Hex = Annotated[str, msgspec.Meta(pattern=r"^([0-9a-f]{2})*\Z")]

StoredElite: TypeAlias = tuple[tuple[int, ...], _Hex, float, str]
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

    unit: int
    cut: bool
    seconds: float
    strategy: str
    worlds: int
    steps: int
    verdicts: dict[str, int]
    judged: int
    met: list[tuple[str, str, int]]
    failures: list[_FailureId]
    first_met: list[FirstMet]
    elites: list[StoredElite]

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
            judged=self.judged,
            met=Counter({(group, verdict): count for group, verdict, count in self.met}),
            failures={one.key: one for one in failures},
            first_met={one.key: at for one, at in zip(failures, self.first_met, strict=True)},
            elites={
                cell: Elite(bytes.fromhex(layout), quality, verdict)
                for cell, layout, quality, verdict in self.elites
            },
            cut=self.cut,
            stored_at=self.seconds,
        )


class ShrunkRecord(msgspec.Struct, frozen=True, tag="shrunk"):
    """A failure is shrunk; both are IDs."""

    found: _FailureId
    shrunk: _FailureId


class ShownRecord(msgspec.Struct, frozen=True, tag="shown"):
    """A failure is about to be written to a file in the campaign's folder."""

    file: str
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
        """Yield the intact records in order, each with its offset."""
        if not self._file.is_file() or self._file.is_symlink():
            return
        with self._file.open("rb") as stream:
            at = 0
            while line := stream.readline(_LONGEST):
                record = self._read(line)
                if record is not None:
                    yield at, record
                at += len(line)

    def at(self, offset: int) -> Record | None:
        """Return the record at an offset; ``None`` if it is no longer intact."""
        with self._file.open("rb") as stream:
            stream.seek(offset)
            return self._read(stream.readline(_LONGEST))

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
    """Append a line to a file, sync it, and return its offset."""
    with refused_writes(file), file.open("ab+") as stream:
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
