"""Errors that a user can cause, each a sentence: what came, the rule, the way out."""

from __future__ import annotations

__all__ = [
    "FormatError",
    "GenerationFailed",
    "InvalidParameter",
    "InvalidWorld",
    "NotAGrid",
    "OutputError",
    "WorldgenError",
]


class WorldgenError(Exception):
    """Base of every error that is the input's fault, not the program's.

    The command line prints the message alone and exits with 2.
    """


class InvalidParameter(WorldgenError, ValueError):
    """A number or a name outside its documented range."""


class InvalidWorld(WorldgenError, ValueError):
    """Parts that do not make a world: a start in a wall, a target outside the grid."""


class GenerationFailed(WorldgenError):
    """A family found no solvable world within its bounded retries."""


class OutputError(WorldgenError):
    """A file that cannot be written, or that is there already."""


class FormatError(WorldgenError, ValueError):
    """A file that breaks the rules of its format.

    Args:
        message: What came, the rule, the way out.
        line: Line of the fault, counted from 1; ``None`` where the file has no lines.
        source: The file's name for the message.
    """

    def __init__(self, message: str, *, line: int | None = None, source: str | None = None) -> None:
        self.message, self.line, self.source = message, line, source
        place = ":".join(str(part) for part in (source, line) if part is not None)
        if source is None and line is not None:
            place = f"line {line}"
        super().__init__(f"{place}: {message}" if place else message)


class NotAGrid(FormatError):
    """A file that does not begin as a ``.grid`` file does; it may be a map of another program."""
