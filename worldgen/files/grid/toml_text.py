"""Write TOML with one canonical spelling of every value, so that equal worlds give equal bytes."""

from __future__ import annotations

import math
from collections.abc import Mapping

from worldgen.errors import InvalidWorld
from worldgen.files.grid.schema import BARE_KEY, MAX_DEPTH, MAX_INTEGER_BITS

_ESCAPES = {
    "\b": "\\b",
    "\t": "\\t",
    "\n": "\\n",
    "\f": "\\f",
    "\r": "\\r",
    '"': '\\"',
    "\\": "\\\\",
}
# This includes Unicode's line ends, so that no tool sees a line where the format has none.
_ESCAPE_TABLE = str.maketrans(
    {chr(code): f"\\u{code:04X}" for code in (*range(0x20), 0x7F, 0x85, 0x2028, 0x2029)} | _ESCAPES
)


def number_text(value: float, what: str) -> str:
    """Return the shortest decimal that reads back as the same float64; minus zero becomes zero.

    Raises:
        InvalidWorld: If it isn't finite; the message names ``what``.
    """
    # -0.0 + 0.0 is 0.0.
    number = float(value) + 0.0
    if not math.isfinite(number):
        raise InvalidWorld(
            "not-finite",
            "{what} is {number}: a .grid file holds only finite numbers",
            "omit it or clamp it",
            what=what,
            number=number,
        )
    return repr(number)


def value_text(value: object, what: str, depth: int = 1) -> str:
    """Return one value on one line: inline tables with sorted keys, lists, text, numbers, Booleans.

    Args:
        value: A ``Value``.
        what: Its name in messages, as a dotted key.
        depth: Levels it is nested in, including its own.

    Raises:
        InvalidWorld: If TOML or the format's limits do not allow it.
    """
    # bool comes first, because it is an int in Python.
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return _integer_text(value, what)
    if isinstance(value, float):
        return number_text(value, what)
    if isinstance(value, str):
        return _string_text(value, what)
    if not isinstance(value, list | Mapping):
        raise InvalidWorld(
            "wrong-type",
            "{what} is a {kind}: a .grid file holds bool, int, float, str, list and dict",
            "convert it",
            what=what,
            kind=type(value).__name__,
        )
    if depth > MAX_DEPTH:
        raise InvalidWorld(
            "nested-too-deep",
            "{what}: values are nested deeper than {most} levels",
            "flatten them",
            what=what,
            most=MAX_DEPTH,
        )
    # Lists and tables are nested.
    if isinstance(value, list):
        return "[" + ", ".join(value_text(item, what, depth + 1) for item in value) + "]"
    return _table_text(value, what, depth)


def _integer_text(value: int, what: str) -> str:
    if int(value).bit_length() > MAX_INTEGER_BITS:
        raise InvalidWorld(
            "too-large",
            "{what}: an integer has more than {most} bits",
            "write it as text",
            what=what,
            most=MAX_INTEGER_BITS,
        )
    return repr(int(value))


def _string_text(value: str, what: str) -> str:
    try:
        value.encode("utf-8")
    except UnicodeEncodeError as error:
        raise InvalidWorld(
            "not-utf8",
            "{what}: the text has a lone surrogate at {place}, which UTF-8 cannot hold",
            "replace it",
            what=what,
            place=error.start,
        ) from error
    return '"' + value.translate(_ESCAPE_TABLE) + '"'


def _table_text(value: Mapping[object, object], what: str, depth: int) -> str:
    parts = []
    for key in value:
        if not isinstance(key, str):
            raise InvalidWorld(
                "wrong-type",
                "{what} has the key {key!r}: keys are text",
                "convert it",
                what=what,
                key=key,
            )
    for key in sorted(value, key=str):
        name = str(key) if BARE_KEY.match(str(key)) else _string_text(str(key), what)
        parts.append(f"{name} = {value_text(value[key], f'{what}.{key}', depth + 1)}")
    return "{ " + ", ".join(parts) + " }" if parts else "{}"
