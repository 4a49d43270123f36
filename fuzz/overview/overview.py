"""The answer of a campaign, as data: written next to its summary, read by reports and the studio."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fuzz.campaign.store import MEMORY, OVERVIEW_FILE
from fuzz.overview.causes import CauseTotals
from fuzz.overview.comparison import RegressionView
from fuzz.overview.natural import NaturalRuns
from fuzz.triage.cause import Severity
from worldgen.errors import FormatError
from worldgen.files.whole import read_text, write_bytes

__all__ = ["Overview", "read_overview", "write_overview"]

_VERSION = 1


@dataclass(frozen=True)
class Overview:
    """The answer: does it work, how bad is it, and why.

    Args:
        causes: The causes, the worst first.
        natural: The results in natural worlds; ``None`` if none were run.
        comparison: What changed since an earlier campaign; ``None`` if there is none.
    """

    causes: tuple[CauseTotals, ...]
    natural: NaturalRuns | None = None
    comparison: RegressionView | None = None

    def table(self) -> dict[str, Any]:
        """Return the keys that ``worldgen fuzz --json`` adds to its summary."""
        return {
            "causes": [one.table() for one in self.causes],
            "natural": None if self.natural is None else self.natural.table(),
            "comparison": None if self.comparison is None else self.comparison.table(),
        }


def write_overview(overview: Overview, folder: Path) -> None:
    """Write an overview into a campaign's folder.

    Raises:
        OutputError: If it cannot be written.
    """
    table = {"version": _VERSION, **overview.table()}
    data = (json.dumps(table, indent=1) + "\n").encode()
    write_bytes(folder / MEMORY / OVERVIEW_FILE, data, force=True)


def read_overview(folder: Path) -> dict[str, Any] | None:
    """Return the overview in a campaign's folder, in JSON's types; ``None`` if there is none.

    The form is checked, so that pages can rely on it whatever the file's origin.

    Raises:
        FormatError: If the file cannot be read, or is not an overview of version 1.
    """
    path = folder / MEMORY / OVERVIEW_FILE
    if not path.is_file():
        return None
    text = read_text(path)
    try:
        table = json.loads(text)
        if not isinstance(table, dict) or table.get("version") != _VERSION:
            raise _FormError(f"its version is not {_VERSION}")
        return {
            "causes": [_checked_cause(one) for one in _list(table.get("causes"))],
            "natural": _checked_or_none(table.get("natural"), _NATURAL),
            "comparison": _checked_or_none(table.get("comparison"), _COMPARISON),
        }
    except (_FormError, ValueError, RecursionError) as error:
        raise FormatError(
            "invalid-overview",
            "not an overview of a campaign: {reason}",
            "run the campaign again, or delete the file to do without",
            reason=str(error),
            source=str(path),
        ) from error


class _FormError(Exception):
    """Raised if a part of the file does not have the required form."""


# Forms of objects: a type, a list of one form, or the form of every value behind "*".
_COUNTS = {"*": int}
_ROWS = {"*": {"worlds": int, "arrived": int}}
_LISTS = {"new": [str], "still": [str], "fixed": [str]}
_CAUSE = {
    "cause": str,
    "sentence": str,
    "advice": str,
    "severity": str,
    "state": str,
    "met": int,
    "verdicts": _COUNTS,
    "natural": int | None,
    "classes": [str],
    "file": str,
    "smallest": str,
    "fault": str,
    "why": str,
}
_NATURAL = {
    "worlds": int,
    "arrived": int,
    "unsensed": int,
    "share": float | int | None,
    "low": float | int,
    "high": float | int,
    "verdicts": _COUNTS,
    "causes": _COUNTS,
    "families": _ROWS,
    "clearances": _ROWS,
    "turns": _ROWS,
    "complete": bool,
}
_COMPARISON = {"against": str, "causes": _LISTS, "classes": _LISTS, "sentence": str}


# A failure of the campaign, or its original before shrinking; nothing outside its folder.
_FILE = re.compile(rf"({re.escape(MEMORY)}/failures/)?[^/\\]+\.grid")


def _checked_cause(value: object) -> dict[str, Any]:
    # Older campaigns do not have the fault.
    if isinstance(value, dict):
        value = {"fault": "", **value}
    cause: dict[str, Any] = _checked(value, _CAUSE)
    if cause["severity"] not in {severity.word for severity in Severity}:
        raise _FormError(f"{cause['severity']!r} is not a severity")
    for name in ("file", "smallest"):
        if cause[name] and not _FILE.fullmatch(cause[name]):
            raise _FormError(f"{cause[name]!r} is not a file of the campaign")
    return cause


def _checked_or_none(value: object, form: Mapping[str, Any]) -> Any:
    return None if value is None else _checked(value, form)


def _checked(value: object, form: Any) -> Any:
    """Return the part of a value that its form describes; other names are dropped."""
    if isinstance(form, list):
        return [_checked(item, form[0]) for item in _list(value)]
    if isinstance(form, dict):
        if not isinstance(value, dict):
            raise _FormError("an object is missing")
        if "*" in form:
            return {name: _checked(item, form["*"]) for name, item in value.items()}
        missing = form.keys() - value.keys()
        if missing:
            raise _FormError(f"{min(missing)!r} is missing")
        return {name: _checked(value[name], part) for name, part in form.items()}
    # bool is an int in Python, but not in JSON.
    if not isinstance(value, form) or (isinstance(value, bool) and form is not bool):
        raise _FormError(f"{value!r} has the wrong type")
    return value


def _list(value: object) -> Sequence[object]:
    if not isinstance(value, list):
        raise _FormError("a list is missing")
    return value
