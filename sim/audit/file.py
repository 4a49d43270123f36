"""Read recorded trajectories and plans from a table of numbers with a header."""

from __future__ import annotations

import csv
import io
import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from sim.audit.judge import Trajectory
from worldgen.errors import FormatError
from worldgen.files.whole import decoded, read_stream, read_text
from worldgen.support.arrays import Floats, Ints

COLUMNS: tuple[str, ...] = ("t", "x", "y")
# A plan has no times.
_PLACE: tuple[str, ...] = ("x", "y")
# Names for the column of headings, rad; the first one of a header counts.
HEADINGS = ("heading", "yaw", "theta")
# A header with one of these in a name has times, even if they are not called t.
_SIGNS_OF_TIME = ("time", "stamp", "sec")
# Column with the robot of each sample, in a recording of several robots.
_ROBOT = "robot"
_DELIMITERS = (",", ";", "\t")
# A larger file is refused before it fills the memory.
_MOST_BYTES = 1 << 30


def read_trajectories(
    path: Path, robots: int = 1, only: int | None = None, *, headings: bool = False
) -> dict[int, Trajectory]:
    """Read trajectories from a file, or from stdin if the path is ``-``.

    Args:
        path: The file.
        robots: Number of robots in the world.
        only: The robot whose trajectory to read; all if omitted.
        headings: True to read headings, if the file has any.

    Returns:
        Trajectories by the robots' numbers, from 1. A file without a column ``robot`` has one
        trajectory, of the first robot or of the chosen one; in a world with one robot, that column
        is ignored.

    Raises:
        FormatError: If it cannot be read, or is not a trajectory.
    """
    if str(path) == "-":
        data = read_stream(sys.stdin.buffer, "stdin", _MOST_BYTES)
        text = decoded(data, "stdin")
        return parse_trajectories(text, "stdin", robots, only, headings=headings)
    text = read_text(path, _MOST_BYTES)
    return parse_trajectories(text, str(path), robots, only, headings=headings)


def parse_trajectories(
    text: str, source: str, robots: int = 1, only: int | None = None, *, headings: bool = False
) -> dict[int, Trajectory]:
    """Read trajectories from text.

    Args:
        text: A header that names at least the columns t, x and y, then one line per sample. Without
            a column of times, it is a plan. Headings are in a column heading, yaw or theta. The
            numbers are separated as the names are, by commas, semicolons or tabs. Empty lines are
            ignored.
        source: The file's name, for messages.
        robots: Number of robots in the world.
        only: The robot whose trajectory to read; all if omitted.
        headings: True to read headings, if the file has any.

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
    is_plan = _is_plan(header)
    names = _PLACE if is_plan else COLUMNS
    names += tuple(name for name in HEADINGS if headings and _has(header, name))[:1]
    width = len(names)
    names += (_ROBOT,) * (robots > 1 and _has(header, _ROBOT))
    delimiter, places = _columns(header, names, max(header_line, 1), source)
    body = stream.read()
    try:
        values = _quick(body, delimiter, places)
    except ValueError:
        values = _slow(body, delimiter, dict(zip(names, places, strict=True)), header_line, source)

    # Divide the samples among the robots.
    if len(names) == width:
        samples = {only or 1: np.arange(len(values[0]))}
    else:
        owners = values[-1]
        samples = _samples(owners, robots, only, body, header_line, source)

    # Report a fault in the numbers with the line of its sample.
    found = {}
    for robot, rows in samples.items():
        own = [column[rows] for column in values[:width]]
        if is_plan:
            own.insert(0, np.arange(len(rows), dtype=np.float64))
        times, x, y = own[:3]
        turned = own[3] if len(own) > 3 else None
        fault = Trajectory.fault(times, x, y, turned)
        if fault is not None:
            sample, message = fault
            line = _line_of(body, int(rows[sample]), header_line) if sample >= 0 else None
            if len(names) > width:
                message = message.behind("robot {robot}: ", robot=robot)
            raise FormatError.of(message, line=line, source=source)
        found[robot] = Trajectory(times, x, y, turned, is_plan)
    return found


def _has(header: str, name: str) -> bool:
    return any(_names(header.lower(), delimiter).count(name) == 1 for delimiter in _DELIMITERS)


def _is_plan(header: str) -> bool:
    """Return True if a header has places and no times."""
    names = header.lower()
    return all(_has(header, name) for name in _PLACE) and not (
        _has(header, "t") or any(sign in names for sign in _SIGNS_OF_TIME)
    )


def _samples(
    owners: Floats, robots: int, only: int | None, body: str, header_line: int, source: str
) -> dict[int, Ints]:
    """Return the rows of each robot's samples."""
    wrong = np.flatnonzero(~np.isin(owners, np.arange(1, robots + 1)))
    if len(wrong):
        raise FormatError(
            "out-of-range",
            "robot {robot:g} is not in the world, which has {robots}",
            "number the robots from 1, or use the world in which it was recorded",
            robot=float(owners[wrong[0]]),
            robots=robots,
            line=_line_of(body, int(wrong[0]), header_line),
            source=source,
        )
    known = np.unique(owners).astype(int).tolist()
    if (only is not None and only not in known) or not known:
        raise FormatError(
            "too-few-samples",
            "the file has no samples of robot {robot}",
            "choose a robot that was recorded" if known else "record a run first",
            robot=only or 1,
            source=source,
        )
    wanted = known if only is None else [only]
    return {robot: np.flatnonzero(owners == robot) for robot in wanted}


def _names(header: str, delimiter: str) -> list[str]:
    """Return the names of the columns."""
    names = header.strip().lstrip("#").split(delimiter)
    return [name.strip().strip('"').strip() for name in names]


def _columns(header: str, wanted: Sequence[str], line: int, source: str) -> tuple[str, list[int]]:
    """Return the separator of the columns, and the indices of the wanted ones."""
    for delimiter in _DELIMITERS:
        lower = _names(header.lower(), delimiter)
        if all(lower.count(name) == 1 for name in wanted):
            return delimiter, [lower.index(name) for name in wanted]

    # No separator gives all of them, so report the one that splits the header into most columns.
    furthest = max(_DELIMITERS, key=header.count)
    found = _names(header, furthest)
    lower = [name.lower() for name in found]
    wrong = next(name for name in COLUMNS if lower.count(name) != 1)
    how = f"two columns {wrong!r}" if wrong in lower else f"no column {wrong!r}"
    shown = ", ".join(found)[:80]
    raise FormatError(
        "columns-missing",
        "the header ({shown}) has {fault}",
        "name t, x and y once each, or only x and y for a plan without times, separated by commas, "
        "semicolons or tabs",
        shown=shown,
        fault=how,
        line=line,
        source=source,
    )


def _quick(body: str, delimiter: str, places: list[int]) -> tuple[Floats, ...]:
    if not body.strip():
        return (np.zeros(0),) * len(places)
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
    body: str, delimiter: str, places: Mapping[str, int], header_line: int, source: str
) -> tuple[Floats, ...]:
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
        if len(fields) <= max(places.values()):
            raise FormatError(
                "line-too-short",
                "the line ends after field {count}, and the header has a column to read in field "
                "{needed}",
                "complete it, or remove it",
                count=len(fields),
                needed=max(places.values()) + 1,
                line=line,
                source=source,
            )
        rows.append([_number(name, fields[place], line, source) for name, place in places.items()])
    return tuple(np.array(rows, np.float64).reshape(-1, len(places)).T)


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
