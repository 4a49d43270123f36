"""Plain text for terminals, logs and reports.

It provides aligned columns, counted nouns, and the one place where text that is not ours becomes
safe: :func:`shown` for a part of a line, :func:`shown_lines` for whole lines. The output functions
of :mod:`worldgen.cli.output`, the messages of :mod:`worldgen.errors` and the reports for CI apply
it themselves, so a caller that forgets it prints an escape instead of a control code.
"""

from __future__ import annotations

import re
import reprlib
from collections.abc import Collection, Iterable, Sequence
from numbers import Number

# Gap between two columns.
GAP = "  "

# Decimals of an angle in degrees; headings are multiples of 0.0055.
_DECIMALS = 2

# Only the first items are examined, so that a list of a million is cheap.
_BRIEF = reprlib.Repr()
_BRIEF.maxdict = _BRIEF.maxlist = _BRIEF.maxtuple = _BRIEF.maxset = 20
_BRIEF.maxstring = _BRIEF.maxlong = _BRIEF.maxother = 1_000

# Characters that Unicode calls printable although nothing is drawn for them: joiners, fillers,
# variation selectors. They can hide or forge a part of a name.
_INVISIBLE = re.compile(
    "[\u034f\u115f\u1160\u17b4\u17b5\u180b-\u180f\u3164\ufe00-\ufe0f\uffa0\U000e0100-\U000e01ef]"
)

# What CI services take as a command in a log: GitHub, Azure Pipelines and TeamCity the first ones
# anywhere in a line, GitHub the second at its beginning, after blanks.
_COMMAND = re.compile(r"##(?=(?:vso|teamcity)?\[)")
_COMMAND_LINE = re.compile(r"^((?:[^\S\n]|\x1b\[[0-9;]*m)*)::", re.MULTILINE)


def aligned(rows: Sequence[Sequence[str]], right: Collection[int] = ()) -> Styled:
    """Format rows as lines, with each column as wide as its widest cell.

    Cells may hold text from outside. Missing cells at the end of a row are empty.

    Args:
        rows: The rows, at least one.
        right: Columns that are aligned to the right, counted from 0.
    """
    columns = max(map(len, rows))
    filled = [[*map(shown, row), *[""] * (columns - len(row))] for row in rows]
    widths = [max(len(row[column]) for row in filled) for column in range(columns)]
    lines = [
        GAP.join(
            cell.rjust(width) if column in right else cell.ljust(width)
            for column, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in filled
    ]
    return Styled("\n".join(line.rstrip() for line in lines))


def lasting(seconds: float) -> str:
    """Return a duration in words: ``2.5 s``, ``40 s``, ``12 min`` or ``3 h 5 min``."""
    if seconds < 120.0:
        return f"{seconds:.0f} s" if seconds >= 10.0 else f"{seconds:.1f} s"
    minutes = int(seconds // 60.0)
    return f"{minutes} min" if minutes < 120 else f"{minutes // 60} h {minutes % 60} min"


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


class Styled(str):
    """Text that is safe to print as it is, with the lines and colours that we gave it.

    Make one with :func:`styled`, :func:`joined`, :func:`stacked` or :func:`aligned`.
    """

    __slots__ = ()


def shown(text: object) -> str:
    r"""Return text from outside in a form that is safe within a line.

    Control characters, line ends, characters that reorder or hide text, and lone surrogates become
    escapes such as ``\x1b``, and so do commands of CI services. Strangers' files may contain any of
    them, even in their names.
    """
    whole = _COMMAND.sub(r"\\x23#", str(text))
    # Nearly all text is plain, and these two checks are a hundred times as fast as the loop.
    if whole.isascii() and whole.isprintable():
        return whole
    return "".join(map(_shown_character, whole))


def _shown_character(character: str) -> str:
    if character.isprintable() and not _INVISIBLE.match(character):
        return character
    return character.encode("unicode_escape").decode()


def shown_lines(text: str) -> str:
    """Do the same for a text of several lines, keeping its line breaks and tabs.

    Use it only where no part of the text can bring a line break of its own. Styled text keeps its
    colours.
    """
    if isinstance(text, Styled):
        return text
    return "\n".join("\t".join(map(shown, line.split("\t"))) for line in text.split("\n"))


def styled(text: object, code: str) -> Styled:
    """Return text from outside in a style of the terminal.

    Args:
        text: The text.
        code: Parameters of the escape sequence "select graphic rendition": ``1;31`` is bold red.
    """
    return Styled(f"\x1b[{code}m{shown(text)}\x1b[0m")


def joined(*parts: str) -> Styled:
    """Join parts into one text, in which only styled parts keep their escape sequences."""
    return Styled("".join(map(shown_lines, parts)))


def stacked(lines: Iterable[str]) -> Styled:
    """Put lines below each other; a line break within one of them becomes an escape."""
    return Styled("\n".join(line if isinstance(line, Styled) else shown(line) for line in lines))


def printed(text: str) -> str:
    """Return what an output function prints for a text: the last door, which none can forget.

    A plain text becomes one line; :func:`stacked` makes a text of several. A line that begins like
    a command of a CI service, such as ``::error::``, becomes harmless.
    """
    safe = text if isinstance(text, Styled) else shown(text)
    return _COMMAND_LINE.sub(r"\1\\x3a:", safe)


def describe_value(value: object) -> str:
    """Return a value of a file's header, including lists and tables, on one line.

    Numbers have six digits.
    """
    if isinstance(value, list):
        return ", ".join(map(describe_value, value))
    if isinstance(value, dict):
        return "; ".join(f"{name} {describe_value(item)}" for name, item in value.items())
    return f"{value:.6g}" if isinstance(value, float) else str(value)
