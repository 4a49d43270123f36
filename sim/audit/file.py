"""Read a recorded trajectory from a table of numbers with a header, written by any program."""

from __future__ import annotations

import csv
import io
import math
import sys
from pathlib import Path

import numpy as np
import numpy.typing as npt

from sim.audit.judge import Trajectory
from worldgen.errors import FormatError

__all__ = ["parse_trajectory", "read_trajectory"]

COLUMNS = ("t", "x", "y")
_DELIMITERS = (",", ";", "\t")
# A larger file is refused before it fills the memory.
_MOST_BYTES = 1 << 30


def read_trajectory(path: Path) -> Trajectory:
    """Read a trajectory from a file, or from stdin if the path is ``-``.

    Raises:
        FormatError: If it cannot be read, or is not a trajectory.
    """
    name = "stdin" if str(path) == "-" else str(path)
    try:
        if name == "stdin":
            data = sys.stdin.buffer.read(_MOST_BYTES + 1)
        else:
            with path.open("rb") as stream:
                data = stream.read(_MOST_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else error
        raise FormatError(
            "unreadable", "cannot be read: {reason}", reason=reason, source=name
        ) from error
    if len(data) > _MOST_BYTES:
        raise FormatError(
            "too-large",
            "is larger than {most} MiB",
            "cut it into parts",
            most=_MOST_BYTES >> 20,
            source=name,
        )
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FormatError(
            "not-utf8",
            "is not UTF-8 text: byte {start}",
            "save it as UTF-8",
            start=error.start,
            source=name,
        ) from error
    return parse_trajectory(text, name)


def parse_trajectory(text: str, source: str) -> Trajectory:
    """Read a trajectory from text.

    Args:
        text: A header that names at least the columns t, x and y, then one line per sample. The
            numbers are separated as the names are, by commas, semicolons or tabs. Empty lines are
            ignored.
        source: The file's name, for messages.

    Raises:
        FormatError: If it is not a trajectory; the error names the faulty line.
    """
    # The first line that is not empty is the header.
    stream = io.StringIO(text, newline=None)
    header_line = 0
    header = ""
    for header in stream:
        header_line += 1
        if header.strip():
            break

    # Let numpy read the numbers; if it cannot, read line by line to find the one at fault.
    delimiter, places = _columns(header, max(header_line, 1), source)
    body = stream.read()
    try:
        values = _quick(body, delimiter, places)
    except ValueError:
        values = _slow(body, delimiter, places, header_line, source)

    # Report a fault in the numbers with the line of its sample.
    fault = Trajectory.fault(*values)
    if fault is not None:
        line = _line_of(body, fault[0], header_line) if fault[0] >= 0 else None
        raise FormatError.of(fault[1], line=line, source=source)
    return Trajectory(*values)


def _columns(header: str, line: int, source: str) -> tuple[str, list[int]]:
    """Return the separator of the columns, and the indices of t, x and y."""
    found: list[str] = []
    for delimiter in _DELIMITERS:
        names = [
            name.strip().strip('"').strip() for name in header.strip().lstrip("#").split(delimiter)
        ]
        lower = [name.lower() for name in names]
        if all(lower.count(name) == 1 for name in COLUMNS):
            return delimiter, [lower.index(name) for name in COLUMNS]
        found = names if len(names) > len(found) else found

    # No separator gives all three, so report the one that splits the header furthest.
    lower = [name.lower() for name in found]
    wrong = next(name for name in COLUMNS if lower.count(name) != 1)
    how = f"two columns {wrong!r}" if wrong in lower else f"no column {wrong!r}"
    shown = ", ".join(found)[:80]
    raise FormatError(
        "columns-missing",
        "the header ({shown}) has {fault}",
        "name t, x and y once each, with commas, semicolons or tabs between",
        shown=shown,
        fault=how,
        line=line,
        source=source,
    )


def _quick(body: str, delimiter: str, places: list[int]) -> tuple[npt.NDArray[np.float64], ...]:
    if not body.strip():
        return (np.zeros(0),) * 3
    columns = np.loadtxt(
        io.StringIO(body),
        delimiter=delimiter,
        usecols=places,
        comments=None,
        quotechar='"',
        unpack=True,
        ndmin=2,
    )
    return tuple(columns)


def _slow(
    body: str, delimiter: str, places: list[int], header_line: int, source: str
) -> tuple[npt.NDArray[np.float64], ...]:
    """Read line by line, to report the line that is not a sample."""
    rows: list[list[float]] = []
    for line, text in enumerate(body.split("\n"), header_line + 1):
        if not text.strip():
            continue
        try:
            fields = next(csv.reader([text], delimiter=delimiter, strict=True))
        except csv.Error as error:
            raise FormatError(
                "invalid-csv",
                "not a table: {reason}",
                "write plain numbers",
                reason=str(error),
                line=line,
                source=source,
            ) from None
        if len(fields) <= max(places):
            raise FormatError(
                "line-too-short",
                "the line ends after field {count}, and the header has t, x or y in field {needed}",
                "complete it, or remove it",
                count=len(fields),
                needed=max(places) + 1,
                line=line,
                source=source,
            )
        rows.append(
            [
                _number(name, fields[place], line, source)
                for name, place in zip(COLUMNS, places, strict=True)
            ]
        )
    return tuple(np.array(rows, np.float64).reshape(-1, 3).T)


def _number(name: str, text: str, line: int, source: str) -> float:
    try:
        if "_" in text:  # Python accepts 1_000, but other programs do not.
            raise ValueError
        return float(text)
    except ValueError:
        raise FormatError(
            "not-a-number",
            "{name} {value!r} is not a number",
            "write a number such as 1.25, with a point, or remove the line",
            name=name,
            value=text.strip()[:40],
            line=line,
            source=source,
        ) from None


def _line_of(body: str, sample: int, header_line: int) -> int:
    """Return the line number of a sample."""
    seen = -1
    for line, text in enumerate(body.split("\n"), header_line + 1):
        seen += bool(text.strip())
        if seen == sample:
            return line
    return header_line + 1 + math.floor(sample)
