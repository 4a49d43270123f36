"""Split text into a table: its header, what separates its columns, and its numbers."""

from __future__ import annotations

import csv
import datetime
import io
import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from worldgen.errors import FormatError
from worldgen.support.arrays import Floats

# None: any blanks.
DELIMITERS = (",", ";", "\t", None)
_COMMENTS = ("#", "%")
# Lines before the numbers in which a header is looked for.
_MOST_LINES = 100


@dataclass(frozen=True)
class Table:
    """A text whose lines are samples.

    Args:
        headers: Lines before the first sample that may be its header, without marks of comments,
            the likeliest last, each with its number.
        named: True if one of them is not a comment.
        first: Fields of the first sample; empty if there is none.
        delimiter: What separates its fields; None for blanks.
        body: The text after the headers.
        line: Number of the line before the body.
    """

    headers: tuple[tuple[int, str], ...]
    named: bool
    first: tuple[str, ...]
    delimiter: str | None
    body: str
    line: int

    @classmethod
    def of(cls, text: str) -> Table:
        """Find where the samples begin and how their fields are separated."""
        text = text.replace("\r\n", "\n").replace("\r", "\n")
        headers: list[tuple[int, str]] = []
        named = False
        at = 0
        number = 0
        while at < len(text) and number < _MOST_LINES:
            end = text.find("\n", at) + 1 or len(text)
            line = text[at:end].strip()
            is_comment = line.startswith(_COMMENTS)
            if line and not is_comment:
                delimiter, fields = _fields_of_sample(line)
                if fields:
                    break
                named = True
            if line:
                headers.append((number + 1, line.lstrip("#% \t")))
            number += 1
            at = end
        else:
            delimiter, fields = ",", []
        return cls(tuple(headers), named, tuple(fields), delimiter, text[at:], number)

    def names(self) -> Iterator[tuple[int, list[str]]]:
        """Yield ways to read the header, with its line: the likeliest first."""
        for (line, text), (_, below) in itertools.pairwise(self.headers):
            names, units = split(text, self.delimiter), split(below, self.delimiter)
            in_brackets = [unit[:1] + unit[-1:] in ("[]", "()", "") for unit in units]
            if len(names) == len(units) > 1 and all(in_brackets):
                yield line, [f"{name} {unit}" for name, unit in zip(names, units, strict=True)]
        ways = [
            (line, split(text, delimiter), delimiter)
            for line, text in reversed(self.headers)
            for delimiter in dict.fromkeys((self.delimiter, *DELIMITERS))
        ]
        width = len(self.first)
        for line, names, delimiter in sorted(ways, key=lambda way: len(way[1]) != width):
            # Blanks are also in names, so their number has to be that of the columns.
            if len(names) > 1 and (delimiter is not None or len(names) == width or not width):
                yield line, names

    def numbers(self, places: Mapping[str, int]) -> dict[str, Floats]:
        """Return some columns, (n,) each, by what they are called in messages.

        Raises:
            FormatError: If a line lacks one of them, or it isn't a number; with the line.
        """
        if not self.first:
            return {name: np.zeros(0) for name in places}
        body = self.body
        if any(mark in body for mark in _COMMENTS):
            body = "\n".join(line for _, line in self.lines())
        if self.delimiter != "," and any(
            "," in field for place, field in enumerate(self.first) if place in places.values()
        ):
            body = body.replace(",", ".")
        try:
            # Let numpy read the numbers; if it cannot, look for the line at fault.
            columns = np.loadtxt(
                io.StringIO(body),
                delimiter=self.delimiter,
                usecols=list(places.values()),
                comments=None,
                quotechar='"',
                unpack=True,
                ndmin=2,
            )
        except ValueError:
            columns = self._line_by_line(places)
        return dict(zip(places, columns, strict=True))

    def texts(self, places: Sequence[int]) -> list[set[str]]:
        """Return the different values in each of some columns of texts."""
        found: list[set[str]] = [set() for _ in places]
        if not places:
            return found
        for _, line in self.lines():
            fields = split(line, self.delimiter)
            for values, place in zip(found, places, strict=True):
                if len(fields) > place:
                    values.add(fields[place])
        return found

    def rows(self, most: int) -> list[list[str]]:
        """Return the fields of the first samples."""
        return [split(line, self.delimiter) for _, line in itertools.islice(self.lines(), most)]

    def lines(self) -> Iterator[tuple[int, str]]:
        """Yield each sample's line, and its number."""
        for number, line in enumerate(self.body.split("\n"), self.line + 1):
            if line.strip() and not line.lstrip().startswith(_COMMENTS):
                yield number, line

    def line_of(self, sample: int) -> int:
        """Return the number of the line of a sample, counted from 0."""
        return next(
            (number for index, (number, _) in enumerate(self.lines()) if index == sample),
            self.line + 1,
        )

    def _line_by_line(self, places: Mapping[str, int]) -> Floats:
        rows: list[list[float]] = []
        for line, text in self.lines():
            try:
                fields = split(text, self.delimiter, strict=True)
            except csv.Error as error:
                raise FormatError(
                    "invalid-csv",
                    "not a table: {reason}",
                    "write plain numbers",
                    reason=str(error),
                    line=line,
                ) from None
            if len(fields) <= max(places.values()):
                raise FormatError(
                    "line-too-short",
                    "the line ends after field {count}, and field {needed} is read",
                    "complete it, or remove it",
                    count=len(fields),
                    needed=max(places.values()) + 1,
                    line=line,
                )
            row = []
            for name, place in places.items():
                value = number_of(fields[place], is_time=name == "t")
                if value is None:
                    raise FormatError(
                        "not-a-number",
                        "{name} {value!r} is not a number",
                        "write a number such as 1.25, or remove the line",
                        name=name,
                        value=fields[place].strip()[:40],
                        line=line,
                    )
                row.append(value)
            rows.append(row)
        return np.array(rows, np.float64).reshape(-1, len(places)).T


def split(line: str, delimiter: str | None, *, strict: bool = False) -> list[str]:
    """Return the fields of a line; the whole line if it has none, as its fields are too long.

    Raises:
        csv.Error: If ``strict``, and a quotation mark is never closed, or a field is too long.
    """
    if delimiter is None:
        return line.replace('"', " ").split()
    line = line.strip(" \n")
    rows = csv.reader([line], delimiter=delimiter, strict=strict, skipinitialspace=True)
    try:
        return [field.strip() for field in next(rows, [])]
    except csv.Error:
        if strict:
            raise
        return [line]


def number_of(text: str, *, is_time: bool = False) -> float | None:
    """Return the number in a field, or None: ``1.25``, ``1,25``, or a time such as in ISO 8601."""
    text = text.strip()
    if text.count(",") == 1 and "." not in text:
        text = text.replace(",", ".")
    # Python accepts 1_000, but other programs do not.
    if "_" not in text:
        try:
            return float(text)
        except ValueError:
            pass
    if is_time:
        try:
            return _timestamp(text)
        except (ValueError, OverflowError):
            pass
    return None


def _timestamp(text: str) -> float:
    """Return the s since 1970 of a date; one without a zone counts as universal time."""
    date = datetime.datetime.fromisoformat(text)
    return (date if date.tzinfo else date.replace(tzinfo=datetime.UTC)).timestamp()


def _fields_of_sample(line: str) -> tuple[str | None, Sequence[str]]:
    """Return the separator and the fields of a line, or no fields if it is not one of numbers."""
    best: tuple[tuple[float, int], str | None, list[str]] = ((0.0, 0), ",", [])
    for delimiter in DELIMITERS:
        fields = split(line, delimiter)
        count = sum(number_of(field, is_time=True) is not None for field in fields)
        rank = (count / len(fields), len(fields)) if len(fields) > 1 and count > 1 else (0.0, 0)
        if rank > best[0]:
            best = (rank, delimiter, fields)
    return best[1:]
