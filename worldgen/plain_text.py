"""Plain text for terminals: aligned columns, counted nouns, and nothing that a terminal would obey."""

from __future__ import annotations

from collections.abc import Collection, Sequence

__all__ = ["GAP", "aligned", "counted", "shown", "shown_lines"]

GAP = "  "  # between two columns


def aligned(rows: Sequence[Sequence[str]], right: Collection[int] = ()) -> str:
    """Rows as lines, each column as wide as its widest cell; cells that a row lacks at its end are empty.

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
    """The count and its noun: ``1 map``, ``2 maps``; ``many`` where an s is not enough."""
    return f"{count} {one if count == 1 else many or one + 's'}"


def shown(text: object) -> str:
    """A text with what a terminal would obey, as in the names of strangers' files, written as escapes."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in str(text))


def shown_lines(text: str) -> str:
    """The same for a text of several lines, which stay so."""
    return "\n".join(map(shown, text.split("\n")))
