"""Values of the header, each checked, with the line of its key in every error."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from worldgen.errors import FormatError
from worldgen.files.grid.header import Header
from worldgen.files.grid.schema import MAX_DEPTH, MAX_INTEGER_BITS
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


def kind_of(value: object) -> str:
    """Return the kind of a TOML value, for messages."""
    return _KINDS.get(type(value), "a date or time")


def finite(value: object, what: str, at: Callable[[], dict[str, Any]]) -> float:
    """Return a number that must be finite.

    Args:
        value: The value.
        what: Its name in messages.
        at: Returns its place for an error.
    """
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise FormatError(
            "wrong-type",
            "{what} is {kind}",
            "write a number, like 0.1",
            what=what,
            kind=kind_of(value),
            **at(),
        )
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
            what=what,
            number=number,
            **at(),
        )
    return number


def text_at(header: Header, table: Mapping[str, object], name: str, key: str) -> str:
    """Return the text of a key in a table."""
    value = table[key]
    if not isinstance(value, str):
        raise FormatError(
            "wrong-type",
            "{table}.{key} is {kind}",
            "write text in double quotes",
            table=name,
            key=key,
            kind=kind_of(value),
            **header.at(name, key),
        )
    return value


def integer_at(header: Header, table: Mapping[str, object], name: str, key: str) -> int:
    """Return the integer of a key in a table."""
    value = table[key]
    if (
        isinstance(value, bool)
        or not isinstance(value, int)
        or value.bit_length() > MAX_INTEGER_BITS
    ):
        came = "an integer out of range" if type(value) is int else kind_of(value)
        raise FormatError(
            "wrong-type",
            "{table}.{key} is {came}",
            "write an integer of at most {most} bits",
            table=name,
            key=key,
            came=came,
            most=MAX_INTEGER_BITS,
            **header.at(name, key),
        )
    return value


def values_at(header: Header, table: Mapping[str, object], name: str, key: str) -> dict[str, Value]:
    """Return the table of values of a key in a table; empty if it is missing."""
    value = table.get(key, {})
    if not isinstance(value, dict):
        raise FormatError(
            "wrong-type",
            "{table}.{key} is {kind}",
            "write a table: {key} = {{ name = 1 }}",
            table=name,
            key=key,
            kind=kind_of(value),
            **header.at(name, key),
        )
    return {part: _value(header, item, (name, key, part), 2) for part, item in value.items()}


def numbers_at(
    header: Header, table: Mapping[str, object], name: str, key: str
) -> dict[str, float]:
    """Return a table of numbers; integers stay integers."""
    found: dict[str, float] = {}
    for part, value in values_at(header, table, name, key).items():
        if isinstance(value, bool) or not isinstance(value, int | float):
            what = f"{name}.{key}.{quote(part)[1:-1]}"
            raise FormatError(
                "wrong-type",
                "{what} is {kind}; a metric must be a number",
                "leave it out",
                what=what,
                kind=kind_of(value),
                **header.at(name, key, part),
            )
        found[part] = value
    return found


def _value(header: Header, value: object, path: tuple[str, ...], depth: int) -> Value:
    # bool comes first, because it is an int in Python.
    what = ".".join(quote(part)[1:-1] for part in path[:4])
    if isinstance(value, bool | str):
        return value
    if isinstance(value, int):
        if value.bit_length() > MAX_INTEGER_BITS:
            raise FormatError(
                "too-large",
                "{what}: an integer may have at most {most} bits",
                "write it as text",
                what=what,
                most=MAX_INTEGER_BITS,
                **header.at(*path),
            )
        return value
    if isinstance(value, float):
        return finite(value, what, partial(header.at, *path))
    if not isinstance(value, list | dict):
        raise FormatError(
            "wrong-type",
            "{what} is {kind}",
            "write it as text in double quotes",
            what=what,
            kind=kind_of(value),
            **header.at(*path),
        )
    # Lists and tables are nested.
    if depth > MAX_DEPTH:
        raise FormatError(
            "nested-too-deep",
            "{what}: nested deeper than {most} levels",
            "flatten it",
            what=what,
            most=MAX_DEPTH,
            **header.at(*path),
        )
    if isinstance(value, list):
        return [_value(header, item, path, depth + 1) for item in value]
    return {key: _value(header, item, (*path, key), depth + 1) for key, item in value.items()}
