"""Values of the header, each checked by the kind that its key declares."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Final, NamedTuple

from worldgen.errors import FormatError
from worldgen.files.grid.schema import MAX_DEPTH, MAX_INTEGER_BITS
from worldgen.plugins.trust import NameInFile
from worldgen.support.plain_text import quote
from worldgen.world import Value

_KINDS = {
    bool: "true or false",
    int: "an integer",
    float: "a number",
    str: "text",
    list: "a list",
    dict: "a table",
}


class Place(NamedTuple):
    """Where a value is.

    Args:
        what: Its name in messages.
        meaning: What it says, in messages.
        line: Returns the line and the file of the key, or of one in it, as an error takes them.
    """

    what: str
    meaning: str
    line: Callable[..., dict[str, Any]]

    def inner(self, key: str) -> Place:
        """Return the place of a key of a table."""
        return Place(f"{self.what}.{quote(key)[1:-1]}", self.meaning, partial(self.line, key))

    def wrong(self, value: object, remedy: str) -> FormatError:
        """Return the error for a value of the wrong type."""
        return FormatError(
            "wrong-type",
            "{what} is {kind}",
            remedy,
            what=self.what,
            kind=kind_of(value),
            meaning=self.meaning,
            **self.line(),
        )


def kind_of(value: object) -> str:
    """Return the kind of a TOML value, for messages."""
    return _KINDS.get(type(value), "a date or time")


def read_number(value: object, place: Place) -> float:
    """Return a number, which must be finite."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise place.wrong(value, "write a number, like 0.1")
    try:
        # No minus zero.
        number = float(value) + 0.0
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise FormatError(
            "not-finite",
            "{what} is {number}",
            "write a finite number within the range of a float64",
            what=place.what,
            number=number,
            **place.line(),
        )
    return number


def _length(value: object, place: Place) -> float:
    number = read_number(value, place)
    if number <= 0.0:
        raise FormatError(
            "not-positive",
            "{what} is {number}; it must be above 0: {meaning}",
            what=place.what,
            number=number,
            meaning=place.meaning,
            **place.line(),
        )
    return number


def read_numbers(value: object, place: Place, count: int) -> tuple[float, ...]:
    """Return the numbers of a list, which must be of this length."""
    if not isinstance(value, list) or len(value) != count:
        raise FormatError(
            "wrong-type",
            "{what} is {kind}",
            "write a list of {count} numbers: {meaning}",
            what=place.what,
            kind=f"a list of {len(value)}" if isinstance(value, list) else kind_of(value),
            count=count,
            meaning=place.meaning,
            **place.line(),
        )
    return tuple(
        read_number(item, place._replace(what=f"{place.what}[{k}]")) for k, item in enumerate(value)
    )


def _disc(value: object, place: Place) -> tuple[float, ...]:
    numbers = read_numbers(value, place, 3)
    # A target without a radius has no disc.
    _length(numbers[2], place._replace(what=f"{place.what}'s radius"))
    return numbers


def _corners(value: object, place: Place) -> tuple[tuple[float, ...], ...]:
    if not isinstance(value, list):
        raise place.wrong(value, "write a list of corners: {meaning}")
    return tuple(
        read_numbers(item, place._replace(what=f"{place.what}[{k}]"), 2)
        for k, item in enumerate(value)
    )


def _tables(value: object, place: Place) -> tuple[dict[str, object], ...]:
    if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
        raise place.wrong(value, "write a list of tables: {meaning}")
    return tuple(value)


def _flag(value: object, place: Place) -> bool:
    if not isinstance(value, bool):
        raise place.wrong(value, "write true or false")
    return value


def _text(value: object, place: Place) -> str:
    if not isinstance(value, str):
        raise place.wrong(value, "write text in double quotes")
    return value


def _integer(value: object, place: Place) -> int:
    # A truth value is an int in Python, but not in TOML.
    if type(value) is int and value.bit_length() <= MAX_INTEGER_BITS:
        return value
    raise FormatError(
        "wrong-type",
        "{what} is {kind}",
        "write an integer of at most {most} bits",
        what=place.what,
        kind="an integer out of range" if type(value) is int else kind_of(value),
        most=MAX_INTEGER_BITS,
        **place.line(),
    )


def _name(value: object, place: Place) -> str:
    return NameInFile(_text(value, place))


def _values(value: object, place: Place) -> dict[str, Value]:
    if not isinstance(value, dict):
        raise place.wrong(value, "write a table: {{ name = 1 }}")
    return {key: _value(item, place.inner(key), 2) for key, item in value.items()}


def _metrics(value: object, place: Place) -> dict[str, float]:
    """Return a table of numbers; integers stay integers."""
    numbers: dict[str, float] = {}
    for key, item in _values(value, place).items():
        if isinstance(item, bool) or not isinstance(item, int | float):
            raise place.inner(key).wrong(item, "a metric must be a number; leave it out")
        numbers[key] = item
    return numbers


def _value(value: object, place: Place, depth: int) -> Value:
    # bool comes first, because it is an int in Python.
    if isinstance(value, bool | str):
        return value
    if isinstance(value, int):
        if value.bit_length() > MAX_INTEGER_BITS:
            raise FormatError(
                "too-large",
                "{what}: an integer may have at most {most} bits",
                "write it as text",
                what=place.what,
                most=MAX_INTEGER_BITS,
                **place.line(),
            )
        return value
    if isinstance(value, float):
        return read_number(value, place)
    if not isinstance(value, list | dict):
        raise place.wrong(value, "write it as text in double quotes")
    # Lists and tables are nested.
    if depth > MAX_DEPTH:
        raise FormatError(
            "nested-too-deep",
            "{what}: nested deeper than {most} levels",
            "flatten it",
            what=place.what,
            most=MAX_DEPTH,
            **place.line(),
        )
    if isinstance(value, list):
        return [_value(item, place, depth + 1) for item in value]
    return {key: _value(item, place.inner(key), depth + 1) for key, item in value.items()}


READERS: Final[Mapping[str, Callable[[Any, Place], Any]]] = {
    "number": read_number,
    "length": _length,
    "pose": partial(read_numbers, count=3),
    "disc": _disc,
    "corners": _corners,
    "tables": _tables,
    "flag": _flag,
    "text": _text,
    "name": _name,
    "integer": _integer,
    "values": _values,
    "metrics": _metrics,
    "any": lambda value, _: value,
}
"""By the kinds of :class:`~worldgen.files.grid.schema.Key`: what checks and returns a value."""
