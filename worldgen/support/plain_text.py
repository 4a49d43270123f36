"""Plain text for terminals.

Aligned columns, counted nouns, and nothing that a terminal would obey.
"""

from __future__ import annotations

import reprlib
from collections.abc import Collection, Sequence
from numbers import Number

__all__ = ["GAP", "aligned", "counted", "describe_value", "quote", "shown", "shown_lines"]

GAP = "  "  # between two columns

_BRIEF = reprlib.Repr()  # looks at the first items alone, so that a list of a million costs nothing
_BRIEF.maxdict = _BRIEF.maxlist = _BRIEF.maxtuple = _BRIEF.maxset = 20
_BRIEF.maxstring = _BRIEF.maxlong = _BRIEF.maxother = 1_000


def aligned(rows: Sequence[Sequence[str]], right: Collection[int] = ()) -> str:
    """Return rows as lines, each column as wide as its widest cell.

    Cells that a row lacks at its end are empty.

    Args:
        rows: At least one.
        right: Columns that are aligned to the right, counted from 0.
    """
    columns = max(map(len, rows))
    filled = [[*row, *[""] * (columns - len(row))] for row in rows]
    widths = [max(len(row[column]) for row in filled) for column in range(columns)]
    lines = [
        GAP.join(
            cell.rjust(width) if column in right else cell.ljust(width)
            for column, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in filled
    ]
    return "\n".join(line.rstrip() for line in lines)


def counted(count: int, one: str, many: str = "") -> str:
    """Return the count and its noun: ``1 map``, ``2 maps``; ``many`` where an s is not enough."""
    return f"{count} {one if count == 1 else many or one + 's'}"


def quote(text: object, limit: int = 40) -> str:
    """Quote text from outside, short enough for a message and without terminal control codes.

    Args:
        text: Bytes that are not UTF-8 are shown as escapes, numbers (NumPy's too) as they print,
            and anything else by its ``repr``.
        limit: The longest result, in characters.
    """
    if isinstance(text, bytes | bytearray):
        text = bytes(text[: 4 * limit]).decode("utf-8", "backslashreplace")
    try:
        quoted = _shown_value(text)
    except ValueError:  # Python shows no number of more than 4,300 digits
        return "<too many digits to show>"
    return quoted if len(quoted) <= limit else f"{quoted[: limit - 3]}..."


def _shown_value(value: object) -> str:
    if isinstance(value, str):
        return repr(value)
    return str(value) if isinstance(value, Number) else _BRIEF.repr(value)


def shown(text: object) -> str:
    """Return a text with what a terminal would obey.

    As in the names of strangers' files, written as escapes.
    """
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in str(text))


def shown_lines(text: str) -> str:
    """Return the same for a text of several lines, which stay so."""
    return "\n".join(map(shown, text.split("\n")))


def describe_value(value: object) -> str:
    """Return a value of a file's header, lists and tables in it included, on one line.

    Numbers with six digits.
    """
    if isinstance(value, list):
        return ", ".join(map(describe_value, value))
    if isinstance(value, dict):
        return "; ".join(f"{name} {describe_value(item)}" for name, item in value.items())
    return f"{value:.6g}" if isinstance(value, float) else str(value)
