"""Plain text for terminals.

It provides aligned columns, counted nouns, and text without control codes.
"""

from __future__ import annotations

import reprlib
from collections.abc import Collection, Sequence
from numbers import Number

# Gap between two columns.
GAP = "  "

# Decimals of an angle in degrees; headings are multiples of 0.0055.
_DECIMALS = 2

# Only the first items are examined, so that a list of a million is cheap.
_BRIEF = reprlib.Repr()
_BRIEF.maxdict = _BRIEF.maxlist = _BRIEF.maxtuple = _BRIEF.maxset = 20
_BRIEF.maxstring = _BRIEF.maxlong = _BRIEF.maxother = 1_000


def aligned(rows: Sequence[Sequence[str]], right: Collection[int] = ()) -> str:
    """Format rows as lines, with each column as wide as its widest cell.

    Missing cells at the end of a row are empty.

    Args:
        rows: The rows, at least one.
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
    """Return the count and its noun: ``1 map``, ``2 maps``; ``many`` if an s is not enough."""
    return f"{count} {one if count == 1 else many or one + 's'}"


def alternatives(names: Sequence[str]) -> str:
    """Return names as a choice: ``a``, ``a or b``, ``a, b or c``."""
    return " or ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))


def rounded(number: float, digits: int) -> str:
    """Return a number with this many digits, and without an exponent: ``0.045``, ``110``."""
    _, _, power = f"{number:.{digits - 1}e}".partition("e")
    decimals = digits - 1 - int(power)
    fixed = f"{round(number, decimals):,.{max(decimals, 0)}f}"
    return fixed.rstrip("0").rstrip(".") if decimals > 0 else fixed


def rounded_angle(angle: float) -> str:
    """Return degrees with three significant digits and at most two decimals: ``2.58``, ``1,234``."""
    if abs(angle) >= 999.5:
        return f"{angle:,.0f}"
    # Adding zero turns -0 into 0.
    return f"{round(float(f'{angle:.3g}'), _DECIMALS) + 0.0:g}"


def in_degrees(angle: float) -> str:
    """Return an angle with its unit: ``2.58 degrees``, ``1 degree``, ``less than 0.01 degrees``."""
    least = 10.0**-_DECIMALS
    if 0.0 < abs(angle) < least:
        return f"less than {least:g} degrees"
    number = rounded_angle(angle)
    return f"{number} degree" if number in ("1", "-1") else f"{number} degrees"


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
    # Python refuses to print a number of more than 4,300 digits.
    except ValueError:
        return "<too many digits to show>"
    return quoted if len(quoted) <= limit else f"{quoted[: limit - 3]}..."


def _shown_value(value: object) -> str:
    if isinstance(value, str):
        return repr(value)
    return str(value) if isinstance(value, Number) else _BRIEF.repr(value)


def shown(text: object) -> str:
    """Return a text with terminal control codes escaped.

    Names of strangers' files may contain them.
    """
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in str(text))


def shown_lines(text: str) -> str:
    """Do the same for a text of several lines, keeping the line breaks."""
    return "\n".join(map(shown, text.split("\n")))


def describe_value(value: object) -> str:
    """Return a value of a file's header, including lists and tables, on one line.

    Numbers have six digits.
    """
    if isinstance(value, list):
        return ", ".join(map(describe_value, value))
    if isinstance(value, dict):
        return "; ".join(f"{name} {describe_value(item)}" for name, item in value.items())
    return f"{value:.6g}" if isinstance(value, float) else str(value)
