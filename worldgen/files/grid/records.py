"""What the header's keys and tables mean.

Numbers, provenance, failure, each checked with its line.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Mapping

from worldgen.errors import Message
from worldgen.files.grid.header import Header
from worldgen.files.grid.schema import (
    CERTIFICATE_KINDS,
    HEADER_KEYS,
    MAX_DEPTH,
    MAX_INTEGER_BITS,
    OPTIONAL_KEYS,
    TABLE_KEYS,
)
from worldgen.support.plain_text import quote
from worldgen.world import FailureRecord, Provenance, Value

__all__ = [
    "check_keys",
    "read_certificate",
    "read_failure",
    "read_number",
    "read_provenance",
    "read_triple",
]

_KINDS = {
    bool: "true or false",
    int: "an integer",
    float: "a number",
    str: "text",
    list: "a list",
    dict: "a table",
}


def check_keys(header: Header) -> None:
    """Refuse every key and table that version 1 does not know.

    Raises:
        FormatError: At the unknown key, with the nearest known one.
    """
    for key, value in header.data.items():
        if key not in HEADER_KEYS and key not in TABLE_KEYS:
            raise header.fault(_unknown("key", key, (*HEADER_KEYS, *TABLE_KEYS)), key)
        if key in TABLE_KEYS and not isinstance(value, dict):
            raise header.fault(
                Message(
                    "wrong-type",
                    "{key} is {kind}; it is a table: write [{key}] on a line of its own",
                    key=key,
                    kind=_kind(value),
                ),
                key,
            )
    for table, known in TABLE_KEYS.items():
        for key in header.data.get(table, ()):
            if key not in known:
                message = _unknown(f"key in [{table}]", key, known)
                if key in HEADER_KEYS:
                    message = Message(
                        "wrong-place",
                        "{key} stands in [{table}]; it belongs above the first [table]",
                        key=key,
                        table=table,
                    )
                raise header.fault(message, table, key)


def _unknown(what: str, name: str, known: Iterable[str]) -> Message:
    near = "".join(difflib.get_close_matches(name, list(known), n=1) if len(name) <= 40 else [])
    return Message(
        "unknown-name",
        "unknown {what}: {name!q}",
        "did you mean {near!r}? known: {known!l}" if near else "known: {known!l}",
        what=what,
        name=name,
        near=near,
        known=list(known),
    )


def _kind(value: object) -> str:
    """Return a TOML value's kind, for messages."""
    return _KINDS.get(type(value), "a date or time")


def _finite(header: Header, value: object, what: str, path: tuple[str, ...]) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise header.fault(
            Message(
                "wrong-type",
                "{what} is {kind}",
                "write a number, like 0.1",
                what=what,
                kind=_kind(value),
            ),
            *path,
        )
    try:
        number = float(value) + 0.0  # no minus zero
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise header.fault(
            Message(
                "not-finite",
                "{what} is {number}",
                "write a finite number within the range of a float64",
                what=what,
                number=number,
            ),
            *path,
        )
    return number


def read_number(header: Header, key: str, *, default: float | None = None) -> float:
    """Return a length or speed, above 0."""
    if key not in header.data:
        if default is not None:
            return default
        raise header.missing(
            Message(
                "missing-key",
                "the header has no {key}",
                "add `{key} = ...`: {meaning}",
                key=key,
                meaning=HEADER_KEYS[key],
            )
        )
    number = _finite(header, header.data[key], key, (key,))
    if number <= 0.0:
        raise header.fault(
            Message(
                "not-positive",
                "{key} is {number}; it is above 0: {meaning}",
                key=key,
                number=number,
                meaning=HEADER_KEYS[key],
            ),
            key,
        )
    return number


def read_triple(header: Header, key: str) -> tuple[float, float, float]:
    """Return the three numbers of ``start`` or ``target``."""
    value = header.data[key]
    if not isinstance(value, list) or len(value) != 3:
        came = f"a list of {len(value)}" if isinstance(value, list) else _kind(value)
        raise header.fault(
            Message(
                "wrong-type",
                "{key} is {came}",
                "write three numbers: {meaning}",
                key=key,
                came=came,
                meaning=HEADER_KEYS[key],
            ),
            key,
        )
    x, y, third = (_finite(header, item, f"{key}[{k}]", (key,)) for k, item in enumerate(value))
    if key == "target" and third <= 0.0:
        raise header.fault(
            Message(
                "not-positive",
                "the target's radius is {radius}; it is above 0: {meaning}",
                radius=third,
                meaning=HEADER_KEYS[key],
            ),
            key,
        )
    return x, y, third


def read_provenance(header: Header) -> Provenance | None:
    """Return the ``[provenance]`` table."""
    table = _table(header, "provenance")
    if table is None:
        return None
    return Provenance(
        family=_text(header, table, "provenance", "family"),
        version=_integer(header, table, "provenance", "version"),
        seed=_integer(header, table, "provenance", "seed"),
        params=_values(header, table, "provenance", "params"),
        metrics=_numbers(header, table, "provenance", "metrics"),
    )


def read_certificate(header: Header) -> tuple[str, float] | None:
    """Return the kind and clearance of the ``[certificate]`` table."""
    table = _table(header, "certificate")
    if table is None:
        return None
    kind = table["kind"]
    if kind not in CERTIFICATE_KINDS:
        came = quote(kind) if isinstance(kind, str) else _kind(kind)
        raise header.fault(
            Message(
                "unknown-name", "certificate kind is {came}", 'write "witness" or "cut"', came=came
            ),
            "certificate",
            "kind",
        )
    path = ("certificate", "clearance")
    return str(kind), _finite(header, table["clearance"], "clearance", path)


def read_failure(header: Header) -> FailureRecord | None:
    """Return the ``[failure]`` table."""
    table = _table(header, "failure")
    if table is None:
        return None
    return FailureRecord(
        controller=_text(header, table, "failure", "controller"),
        motion=_text(header, table, "failure", "motion"),
        seed=_integer(header, table, "failure", "seed"),
        verdict=_text(header, table, "failure", "verdict"),
        trace_digest=_text(header, table, "failure", "trace_digest"),
        parameters=_values(header, table, "failure", "parameters"),
        evidence=_values(header, table, "failure", "evidence"),
        details=_values(header, table, "failure", "details"),
    )


def _table(header: Header, name: str) -> Mapping[str, object] | None:
    table: Mapping[str, object] | None = header.data.get(name)
    if table is not None:
        for key in TABLE_KEYS[name]:
            if key not in table and key not in OPTIONAL_KEYS:
                raise header.fault(
                    Message(
                        "missing-key",
                        "[{table}] has no {key}",
                        "add `{key} = ...` to it",
                        table=name,
                        key=key,
                    ),
                    name,
                )
    return table


def _text(header: Header, table: Mapping[str, object], name: str, key: str) -> str:
    value = table[key]
    if not isinstance(value, str):
        raise header.fault(
            Message(
                "wrong-type",
                "{table}.{key} is {kind}",
                "write text in double quotes",
                table=name,
                key=key,
                kind=_kind(value),
            ),
            name,
            key,
        )
    return value


def _integer(header: Header, table: Mapping[str, object], name: str, key: str) -> int:
    value = table[key]
    if (
        isinstance(value, bool)
        or not isinstance(value, int)
        or value.bit_length() > MAX_INTEGER_BITS
    ):
        came = "an integer out of range" if type(value) is int else _kind(value)
        raise header.fault(
            Message(
                "wrong-type",
                "{table}.{key} is {came}",
                "write an integer of at most {most} bits",
                table=name,
                key=key,
                came=came,
                most=MAX_INTEGER_BITS,
            ),
            name,
            key,
        )
    return value


def _values(header: Header, table: Mapping[str, object], name: str, key: str) -> dict[str, Value]:
    value = table.get(key, {})
    if not isinstance(value, dict):
        raise header.fault(
            Message(
                "wrong-type",
                "{table}.{key} is {kind}",
                "write a table: {key} = {{ name = 1 }}",
                table=name,
                key=key,
                kind=_kind(value),
            ),
            name,
            key,
        )
    return {part: _value(header, item, (name, key, part), 2) for part, item in value.items()}


def _numbers(header: Header, table: Mapping[str, object], name: str, key: str) -> dict[str, float]:
    """Return a table of numbers; whole ones stay whole."""
    found: dict[str, float] = {}
    for part, value in _values(header, table, name, key).items():
        if isinstance(value, bool) or not isinstance(value, int | float):
            what = f"{name}.{key}.{quote(part)[1:-1]}"
            raise header.fault(
                Message(
                    "wrong-type",
                    "{what} is {kind}; a metric is a number",
                    "leave it out",
                    what=what,
                    kind=_kind(value),
                ),
                name,
                key,
                part,
            )
        found[part] = value
    return found


def _value(header: Header, value: object, path: tuple[str, ...], depth: int) -> Value:
    what = ".".join(quote(part)[1:-1] for part in path[:4])
    if isinstance(value, bool | str):
        return value
    if isinstance(value, int):
        if value.bit_length() > MAX_INTEGER_BITS:
            raise header.fault(
                Message(
                    "too-large",
                    "{what}: an integer has at most {most} bits",
                    "write it as text",
                    what=what,
                    most=MAX_INTEGER_BITS,
                ),
                *path,
            )
        return value
    if isinstance(value, float):
        return _finite(header, value, what, path)
    if not isinstance(value, list | dict):
        raise header.fault(
            Message(
                "wrong-type",
                "{what} is {kind}",
                "write it as text in double quotes",
                what=what,
                kind=_kind(value),
            ),
            *path,
        )
    if depth > MAX_DEPTH:
        raise header.fault(
            Message(
                "nested-too-deep",
                "{what}: nested deeper than {most} levels",
                "flatten it",
                what=what,
                most=MAX_DEPTH,
            ),
            *path,
        )
    if isinstance(value, list):
        return [_value(header, item, path, depth + 1) for item in value]
    return {key: _value(header, item, (*path, key), depth + 1) for key, item in value.items()}
