"""The folder ``OUT/.campaign``: written by one process at a time, and consistent at every moment.

Every file is written under another name and then renamed, so that it is complete or absent; files
with failures are written before the entry that names them.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
from collections.abc import Collection
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import msgspec

from fuzz.campaign.store.entry import Done, read_entry, write_entry
from fuzz.campaign.store.fingerprint import Fingerprint
from fuzz.campaign.store.last_error import forget_error
from fuzz.campaign.store.summary import (
    MEMORY,
    OVERVIEW_FILE,
    SUMMARY,
    SUMMARY_FILE,
    Status,
    Summary,
    read_summary,
)
from fuzz.failure import ID_DIGITS, Failure
from worldgen.errors import FormatError, OutputError, WorldgenError
from worldgen.files.grid import loads
from worldgen.files.json_file import JsonFile
from worldgen.files.locks import lock, sign
from worldgen.files.whole import read_text, refused_writes, write_bytes

_SHRUNK = re.compile(
    rf"(?P<key>[0-9a-f]{{{ID_DIGITS}}})-(?P<content>[0-9a-f]{{{ID_DIGITS}}})\.grid"
)
_CUT = ".cut.json"
_WRITTEN = "written.json"
_PARTS = ("units", "failures", "shrunk")


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


_CAMPAIGN_FILE = "campaign.json"
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


class CampaignStore:
    """A campaign's store.

    This one stores nothing; it is for campaigns that are never continued.
    """

    def unit(self, unit: int) -> Done | None:
        """Return a unit that was done before; ``None`` if it has yet to be done."""
        return None

    def cut_unit(self, unit: int) -> Done | None:
        """Return the findings of a unit that was cut short.

        It is ``None`` if there are none, or if the unit has been done since.
        """
        return None

    def units_cut(self) -> list[int]:
        """Return the numbers of the units that were cut short and not done since."""
        return []

    def save_unit(self, unit: int, done: Done) -> None:
        """Store a unit; one that was cut short is stored separately."""

    def seconds(self) -> float:
        """Return the duration of earlier runs, as far as known."""
        return 0.0

    def shrunk(self, failure: Failure) -> Failure | None:
        """Return the stored result of shrinking a failure; ``None`` if it has yet to be shrunk."""
        return None

    def save_shrunk(self, failure: Failure, shrunk: Failure) -> None:
        """Store the result of shrinking a failure."""


class FolderStore(CampaignStore):
    """A campaign's store in ``OUT/.campaign``, locked against other processes until :meth:`close`.

    Args:
        out: Folder of the campaign's failures; created if missing.

    Raises:
        OutputError: If it cannot be written, or another process is writing it.
    """

    def __init__(self, out: Path) -> None:
        self.out = out
        self._path = out / MEMORY
        self._fingerprint = ""
        self._shrunk: dict[str, Path] = {}
        if out.exists() and not out.is_dir():
            raise OutputError("wrong-kind-of-file", "{out} is a file", "choose a folder", out=out)
        with refused_writes(self._path):
            self._path.mkdir(parents=True, exist_ok=True)
            self._lock = os.open(self._path / "lock", os.O_RDWR | os.O_CREAT, 0o666)
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
        file = out / MEMORY / _CAMPAIGN_FILE
        if not file.is_file():
            return None
        stored = _CAMPAIGN.read(file)
        return Fingerprint(stored.configuration, stored.code), stored.goal

    def units_done(self) -> int:
        """Return the number of units in it: one more than the last unit's number."""
        numbers = [
            int(file.stem)
            for file in (self._path / "units").glob("*.json")
            if file.stem.isdecimal()
        ]
        return max(numbers, default=-1) + 1

    def close(self) -> None:
        """Unlock it for other processes."""
        os.close(self._lock)

    def begin(self, fingerprint: Fingerprint, budget: Budget) -> None:
        """Store the fingerprint of a new campaign, or the new budget of an existing one.

        Raises:
            OutputError: If it cannot be written.
        """
        self._fingerprint = fingerprint.digest
        forget_error(self.out)
        with refused_writes(self._path):
            for part in _PARTS:
                (self._path / part).mkdir(exist_ok=True)
            for file in (self._path / "shrunk").iterdir():
                if name := _SHRUNK.fullmatch(file.name):
                    self._shrunk[name["key"]] = file
        stored = _Stored(dict(fingerprint.configuration), dict(fingerprint.code), budget)
        _CAMPAIGN.write(self._path / _CAMPAIGN_FILE, stored)

    def forget(self) -> None:
        """Remove an earlier campaign's store, but not its failures in the folder outside.

        Raises:
            OutputError: If it cannot be removed.
        """
        with refused_writes(self._path):
            # Remove this one first: the rest is then no longer a campaign.
            (self._path / _CAMPAIGN_FILE).unlink(missing_ok=True)
            (self._path / SUMMARY_FILE).unlink(missing_ok=True)
            (self._path / OVERVIEW_FILE).unlink(missing_ok=True)
            (self._path / _WRITTEN).unlink(missing_ok=True)
            for part in _PARTS:
                if (self._path / part).exists():
                    shutil.rmtree(self._path / part)

    def unit(self, unit: int) -> Done | None:
        """Return a unit that was done before; ``None`` if there is no complete entry of it."""
        return self._read_unit(unit, self._unit_file(unit))

    def cut_unit(self, unit: int) -> Done | None:
        """Return the findings of a unit that was cut short.

        It is ``None`` if there are none, or if the unit has been done since.
        """
        done = self._read_unit(unit, self._cut_file(unit))
        return done and replace(done, result=replace(done.result, cut=True))

    def units_cut(self) -> list[int]:
        """Return the numbers of the units that were cut short and not done since."""
        names = [file.name.removesuffix(_CUT) for file in (self._path / "units").glob(f"*{_CUT}")]
        return sorted(int(name) for name in names if name.isdecimal())

    def _read_unit(self, unit: int, file: Path) -> Done | None:
        if not file.is_file():
            return None
        try:
            return read_entry(read_text(file), unit, self._fingerprint, self._failure)
        except (ValueError, WorldgenError):
            return None

    def save_unit(self, unit: int, done: Done) -> None:
        """Store a unit: its failures first, then its entry.

        A continued campaign starts a cut unit again.

        Raises:
            OutputError: If it cannot be written.
        """
        names = []
        for failure in done.result.failures.values():
            names.append(failure.id)
            self.save_original(failure)
        file = self._cut_file(unit) if done.result.cut else self._unit_file(unit)
        write_bytes(file, write_entry(unit, done, self._fingerprint, names), force=True)
        if not done.result.cut:
            self._cut_file(unit).unlink(missing_ok=True)

    def save_original(self, failure: Failure) -> None:
        """Store a failure as it was found.

        Raises:
            OutputError: If it cannot be written.
        """
        self._save(f"failures/{failure.id}.grid", failure.dumps())

    def shrunk(self, failure: Failure) -> Failure | None:
        """Return the stored result of shrinking a failure.

        It is ``None`` if it has yet to be shrunk, or the file is incomplete.
        """
        file = self._shrunk.get(failure.id)
        if file is None:
            return None
        try:
            return _whole_failure(file, file.stem.rpartition("-")[2])
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
        data = shrunk.dumps()
        self._save(f"shrunk/{failure.id}-{_content_name(data)}.grid", data)

    def written(self) -> dict[str, str]:
        """Return a digest of each failure that this campaign wrote to its folder, by file name."""
        try:
            said = msgspec.json.decode(read_text(self._path / _WRITTEN), type=dict[str, str])
        except (RecursionError, ValueError):
            return {}
        return {name: digest for name, digest in said.items() if Path(name).name == name}

    def write_failure(self, name: str, data: bytes) -> None:
        """Write a failure into the campaign's folder.

        It is recorded first, so that there is never an unknown file.

        Raises:
            OutputError: If it cannot be written.
        """
        self._save(
            _WRITTEN,
            (json.dumps(self.written() | {name: _content_name(data)}, indent=1) + "\n").encode(),
        )
        write_bytes(self.out / name, data, force=True)

    def remove_failures_but(self, names: Collection[str]) -> None:
        """Remove the files that this campaign wrote and that are unchanged, except for these.

        The removed files are findings of cut units beyond its end.

        Raises:
            OutputError: If a file cannot be removed.
        """
        with refused_writes(self.out):
            for name, content in self.written().items():
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

    def _unit_file(self, unit: int) -> Path:
        return self._path / "units" / f"{unit:06}.json"

    def _cut_file(self, unit: int) -> Path:
        return self._path / "units" / f"{unit:06}{_CUT}"

    def _failure(self, name: str) -> Failure:
        return _whole_failure(self._path / "failures" / f"{name}.grid", name)

    def _save(self, name: str, data: bytes) -> None:
        write_bytes(self._path / name, data, force=True)


def _whole_failure(file: Path, content: str) -> Failure:
    """Return the failure in a file that is named by its content.

    Raises:
        ValueError: If the content differs; FormatError if it cannot be read.
    """
    data = read_text(file).encode()
    if _content_name(data) != content:
        raise ValueError("the file was changed")
    return Failure.of(loads(data, str(file)))
