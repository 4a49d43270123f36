"""The folder ``OUT/.campaign``: written by one process at a time, and consistent at every moment.

Each failure is stored once, in a file named by its content. What is done is in the journal, which
names failures that are already there. The ``.grid`` files in ``OUT`` only show some of them.
"""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from fuzz.campaign.store.fingerprint import Fingerprint
from fuzz.campaign.store.journal import Journal, ShownRecord, ShrunkRecord, StoredElite, UnitRecord
from fuzz.campaign.store.last_error import forget_error
from fuzz.campaign.store.summary import (
    CAMPAIGN_FILE,
    MEMORY,
    OVERVIEW_FILE,
    SUMMARY,
    SUMMARY_FILE,
    Status,
    Summary,
    read_summary,
)
from fuzz.failure import ID_DIGITS, Failure
from fuzz.unit.result import UnitResult
from worldgen.errors import FormatError, OutputError, WorldgenError
from worldgen.files.grid import loads
from worldgen.files.json_file import JsonFile
from worldgen.files.locks import lock, sign
from worldgen.files.whole import open_no_link, read_text, refused_writes, write_bytes

_JOURNAL = "journal.txt"
_FAILURES = "failures"


@dataclass(frozen=True)
class Budget:
    """The budget of a campaign.

    Args:
        units: Amount of work, or ``None``.
        seconds: Time for this run, or ``None``.
    """

    units: int | None = None
    seconds: float | None = None


@dataclass(frozen=True)
class _Stored:
    configuration: dict[str, Any]
    code: dict[str, str]
    goal: Budget


_CAMPAIGN = JsonFile(
    _Stored,
    version=3,
    code="invalid-campaign",
    problem="is not a campaign's configuration: {reason}",
    remedy="--force begins a new campaign",
    at_terminal=True,
)


def _content_name(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:ID_DIGITS]


class FolderStore:
    """A campaign's store in ``OUT/.campaign``, locked against other processes until :meth:`close`.

    Args:
        out: Folder of the campaign's failures; created if missing.

    Raises:
        OutputError: If it cannot be written, or another process is writing it.
    """

    def __init__(self, out: Path) -> None:
        self.out = out
        self._path = out / MEMORY
        self._forget_journal()
        if out.exists() and not out.is_dir():
            raise OutputError("wrong-kind-of-file", "{out} is a file", "choose a folder", out=out)
        with refused_writes(self._path):
            self._path.mkdir(parents=True, exist_ok=True)
            self._lock = open_no_link(self._path / "lock")
        if not lock(self._lock):
            os.close(self._lock)
            raise OutputError(
                "campaign-is-running",
                "another worldgen fuzz is writing {out}",
                "wait until it ends, or choose another folder",
                out=out,
            )
        sign(self._lock)

    @staticmethod
    def stored_in(out: Path) -> tuple[Fingerprint, Budget] | None:
        """Return the fingerprint and the budget of the campaign in a folder.

        It is ``None`` if there is none.

        Raises:
            FormatError: If it cannot be read.
        """
        file = out / MEMORY / CAMPAIGN_FILE
        if not file.is_file():
            return None
        stored = _CAMPAIGN.read(file)
        return Fingerprint(stored.configuration, stored.code), stored.goal

    def has_results(self) -> bool:
        """Return True if anything was done or found.

        Records that do not fit the campaign's configuration count too: either may have been
        changed by accident.
        """
        return self._journal.is_begun() or any((self._path / _FAILURES).glob("*.grid"))

    def units_done(self) -> int:
        """Return the number of units in it: one more than the last unit's number.

        Raises:
            FormatError: If the campaign's configuration cannot be read.
        """
        stored = self.stored_in(self.out)
        if stored is not None:
            self._read_journal(stored[0].digest)
        return max(self._units, default=-1) + 1

    def close(self) -> None:
        """Unlock it for other processes."""
        os.close(self._lock)

    def begin(self, fingerprint: Fingerprint, budget: Budget) -> None:
        """Store the fingerprint of a new campaign, or the new budget of an existing one.

        Raises:
            OutputError: If it cannot be written.
        """
        forget_error(self.out)
        with refused_writes(self._path):
            (self._path / _FAILURES).mkdir(exist_ok=True)
        stored = _Stored(dict(fingerprint.configuration), dict(fingerprint.code), budget)
        _CAMPAIGN.write(self._path / CAMPAIGN_FILE, stored)
        self._read_journal(fingerprint.digest)

    def forget(self) -> None:
        """Remove an earlier campaign's store, but not its failures in the folder outside.

        Raises:
            OutputError: If it cannot be removed.
        """
        self._forget_journal()
        # The journal goes first: it must not name failures that are gone.
        names = (_JOURNAL, CAMPAIGN_FILE, SUMMARY_FILE, OVERVIEW_FILE, _FAILURES)
        with refused_writes(self._path):
            for path in (self._path / name for name in names):
                if path.is_dir():
                    shutil.rmtree(path)
                else:
                    path.unlink(missing_ok=True)

    def _forget_journal(self) -> None:
        self._journal = Journal(self._path / _JOURNAL, "")
        # Offsets of the records of whole units and of those cut short, by number.
        self._units: dict[int, int] = {}
        self._cut: dict[int, int] = {}
        # IDs of shrunk failures, by those of the failures as found.
        self._shrunk: dict[str, str] = {}
        # IDs of the failures written to the campaign's folder, by the files' names.
        self._shown: dict[str, str] = {}

    def _read_journal(self, fingerprint: str) -> None:
        if self._journal.fingerprint == fingerprint:
            return
        self._forget_journal()
        self._journal = Journal(self._path / _JOURNAL, fingerprint)
        for offset, record in self._journal:
            if isinstance(record, UnitRecord):
                (self._cut if record.cut else self._units)[record.unit] = offset
            elif isinstance(record, ShrunkRecord):
                self._shrunk[record.found] = record.shrunk
            elif Path(record.file).name == record.file:
                self._shown[record.file] = record.failure

    def unit(self, unit: int) -> UnitResult | None:
        """Return a unit that was done before; ``None`` if part of it is missing."""
        return self._read_unit(self._units.get(unit))

    def cut_unit(self, unit: int) -> UnitResult | None:
        """Return the findings of a unit that was cut short.

        It is ``None`` if there are none, or if the unit has been done since.
        """
        return None if unit in self._units else self._read_unit(self._cut.get(unit))

    def units_cut(self) -> list[int]:
        """Return the numbers of the units that were cut short and not done since."""
        return sorted(self._cut.keys() - self._units.keys())

    def _read_unit(self, offset: int | None) -> UnitResult | None:
        record = None if offset is None else self._journal.at(offset)
        if not isinstance(record, UnitRecord):
            return None
        try:
            return record.result(self._failure)
        except (ValueError, WorldgenError):
            return None

    def save_unit(self, unit: int, result: UnitResult, seconds: float) -> None:
        """Store a unit: its failures first, then its record.

        A continued campaign starts a cut unit again, with the runs that it need not repeat.

        Args:
            unit: Number of the unit.
            result: Its result, with only those failures and elites that are worth keeping.
            seconds: Seconds of the campaign, over all runs, so far.

        Raises:
            OutputError: If it cannot be written.
        """
        for failure in result.failures.values():
            self.save_original(failure)
        offset = self._journal.append(UnitRecord.of(unit, result, seconds))
        (self._cut if result.cut else self._units)[unit] = offset

    def save_original(self, failure: Failure) -> None:
        """Store a failure as it was found.

        Raises:
            OutputError: If it cannot be written.
        """
        self._save_failure(failure.dumps())

    def shrunk(self, failure: Failure) -> Failure | None:
        """Return the stored result of shrinking a failure.

        It is ``None`` if it has yet to be shrunk, or the file is incomplete.
        """
        name = self._shrunk.get(failure.id)
        try:
            return None if name is None else self._failure(name)
        except (ValueError, WorldgenError):
            return None

    def save_shrunk(self, failure: Failure, shrunk: Failure) -> None:
        """Store the result of shrinking a failure.

        Args:
            failure: The failure before shrinking.
            shrunk: The failure after shrinking.

        Raises:
            OutputError: If it cannot be written.
        """
        name = self._save_failure(shrunk.dumps())
        self._journal.append(ShrunkRecord(failure.id, name))
        self._shrunk[failure.id] = name

    def written(self) -> dict[str, str]:
        """Return the ID of each failure that this campaign wrote to its folder, by file name."""
        return dict(self._shown)

    def write_failure(self, name: str, data: bytes) -> None:
        """Write a failure into the campaign's folder.

        It is recorded first, so that there is never an unknown file.

        Raises:
            OutputError: If it cannot be written.
        """
        failure = self._save_failure(data)
        if self._shown.get(name) != failure:
            self._journal.append(ShownRecord(name, failure))
            self._shown[name] = failure
        write_bytes(self.out / name, data, force=True)

    def remove_failures_but(self, names: Collection[str]) -> None:
        """Remove the files that this campaign wrote and that are unchanged, except for these.

        The removed files are findings of cut units beyond its end.

        Raises:
            OutputError: If a file cannot be removed.
        """
        with refused_writes(self.out):
            for name, content in self._shown.items():
                file = self.out / name
                if (
                    name not in names
                    and file.is_file()
                    and _content_name(file.read_bytes()) == content
                ):
                    file.unlink()

    def seconds(self) -> float:
        """Return the duration of earlier runs, including shrinking after the last unit.

        It is 0 if that cannot be read.
        """
        try:
            summary = read_summary(self.out)
        except FormatError:
            return 0.0
        return 0.0 if summary is None else max(summary.seconds, 0.0)

    def save_summary(self, summary: Summary) -> None:
        """Write the file that reports read.

        Raises:
            OutputError: If it cannot be written.
        """
        SUMMARY.write(self._path / SUMMARY_FILE, summary)

    def save_status(self, status: Status) -> None:
        """Write the campaign's status into the existing summary, if there is one.

        Raises:
            OutputError: If it cannot be written.
        """
        try:
            summary = read_summary(self.out)
        except FormatError:
            # The next reader reports it.
            return
        if summary is not None:
            # An earlier run's answer is not the answer of one that is under way.
            outdated = dict.fromkeys(("answer", "answer_reason", "answer_numbers"), msgspec.UNSET)
            changes = outdated if status == Status.RUNNING else {}
            self.save_summary(msgspec.structs.replace(summary, status=status, **changes))

    def _save_failure(self, data: bytes) -> str:
        """Store a failure unless it is there, and return its ID."""
        name = _content_name(data)
        file = self._failure_file(name)
        if not file.is_file() or file.read_bytes() != data:
            write_bytes(file, data, force=True)
        return name

    def _failure(self, name: str) -> Failure:
        """Return the failure with an ID.

        Raises:
            ValueError: If its file was changed.
            FormatError: If it cannot be read.
        """
        file = self._failure_file(name)
        data = read_text(file).encode()
        if _content_name(data) != name:
            raise ValueError("the file was changed")
        return Failure.of(loads(data, str(file)))

    def _failure_file(self, name: str) -> Path:
        return self._path / _FAILURES / f"{name}.grid"


def stored_elites(out: Path) -> Iterator[StoredElite]:
    """Yield the entries that units added to a campaign's archive, in order.

    Raises:
        FormatError: If the campaign's configuration cannot be read.
    """
    stored = FolderStore.stored_in(out)
    if stored is not None:
        for _, record in Journal(out / MEMORY / _JOURNAL, stored[0].digest):
            if isinstance(record, UnitRecord):
                yield from record.elites
