"""Errors that a user can cause, as data.

An error is a code, facts, and templates that put them into words.
"""

from __future__ import annotations

import string
from collections.abc import Mapping
from pathlib import PurePath
from typing import Any, Self

from worldgen.support.plain_text import quote, shown

__all__ = [
    "FormatError",
    "GenerationFailed",
    "InvalidParameter",
    "InvalidWorld",
    "Message",
    "NotAGrid",
    "Note",
    "OutputError",
    "WorldgenError",
]


# Limit on the characters of a fact; messages quote far fewer.
_MOST_BYTES = 1000


class _Listed(str):
    """A list joined by commas; the format specification is the text for an empty list."""

    def __format__(self, if_empty: str) -> str:
        return str(self) or if_empty


class _Words(string.Formatter):
    """``str.format`` with conversions for messages, in which every fact is safe to print.

    A fact can be a stranger's text: a file's name, an exception's words. The template is ours.

    ``{name!q}`` quotes text from outside; ``{names!l:none}`` joins the items of a list by commas,
    and becomes ``none`` if there are no items; ``{size!n}`` is a number with six digits, or all
    digits of an integer; ``{unit!u}`` puts a space before a unit, if there is one.
    """

    def convert_field(self, value: Any, conversion: Any) -> Any:
        if conversion == "q":
            return quote(value)
        if conversion == "l":
            return _Listed(", ".join(map(str, value)))
        if conversion == "n":
            return str(value) if isinstance(value, int) else f"{value:g}"
        if conversion == "u":
            return value and f" {value}"
        return super().convert_field(value, conversion)

    def format_field(self, value: Any, format_spec: str) -> str:
        return shown(super().format_field(value, format_spec))


def _plain(value: Any) -> Any:
    """Convert a fact to JSON's types.

    A path becomes text, bytes become the text they begin with, a NumPy number a number.
    """
    if isinstance(value, PurePath):
        return str(value)
    if isinstance(value, bytes | bytearray):
        return bytes(value[:_MOST_BYTES]).decode("utf-8", "backslashreplace")
    if type(value) in (list, tuple):
        return type(value)(map(_plain, value))
    # Compare by name, because importing NumPy would slow down `worldgen --help`.
    return value.tolist() if type(value).__module__ == "numpy" else value


class Message:
    """A message from a program to its user: a code and facts, with their wording.

    Programs and tests compare ``code`` and ``facts``, which stay the same when the wording changes.
    A front end other than the command line, such as the studio's page,
    words the remedy itself, based on the code.

    Args:
        code: Names the rule, in lower case with dashes: ``door-too-narrow``.
        problem: Template of the problem and the rule: ``"door_width={door_width:g} m is less than
            {least:g} m"``. Fields are facts, as in ``str.format``; ``{name!q}`` quotes text from
            outside, ``{names!l:none}`` lists, ``{size!n}{unit!u}`` is a number and its unit.
        remedy: Template of the way out: ``"widen the door"``; empty if the problem already says it.
        at_terminal: Whether the way out needs a terminal, because it names an option or a command.
        facts: The values, by name.
    """

    def __init__(
        self,
        code: str,
        problem: str,
        remedy: str = "",
        /,
        *,
        at_terminal: bool = False,
        **facts: Any,
    ) -> None:
        self.code = code
        self.at_terminal = at_terminal
        self.facts = {name: _plain(value) for name, value in facts.items()}
        self._problem = problem
        self._remedy = remedy

    @property
    def problem(self) -> str:
        """The problem in words: the value and the rule that it breaks."""
        return self.word(self._problem)

    @property
    def remedy(self) -> str:
        """The remedy, worded for the command line; empty if there is none."""
        return self.word(self._remedy)

    def behind(self, prefix: str, /, **facts: Any) -> Message:
        """Return the message with a prefix before its problem, such as a place the caller knows.

        Args:
            prefix: Template, including the separator: ``"{file}: "``.
            facts: Its values; if one has the name of a fact of the message, the message's value is
                kept.
        """
        words, more = self._beside(prefix, facts)
        return self._copy(words + self._problem, self._remedy, more)

    def before(self, suffix: str, /, **facts: Any) -> Message:
        """Return the message with a suffix, such as the line that it is about.

        Args:
            suffix: Template, including the separator: ``", in {file}"``.
            facts: Its values.
        """
        words, more = self._beside(suffix, facts)
        if self._remedy:
            return self._copy(self._problem, self._remedy + words, more)
        return self._copy(self._problem + words, "", more)

    def with_remedy(self, remedy: str, /, **facts: Any) -> Message:
        """Return the message with another remedy, such as an outer caller's."""
        return self._copy(self._problem, remedy, facts)

    def replaced(self, facts: Mapping[str, Any]) -> Message:
        """Return the message with other facts, such as shorter paths for this reader."""
        return self._copy(self._problem, self._remedy, facts)

    @property
    def templates(self) -> tuple[str, str]:
        """The templates of problem and remedy, to store the message and format it later."""
        return self._problem, self._remedy

    def _beside(self, template: str, facts: dict[str, Any]) -> tuple[str, dict[str, Any]]:
        """Return a template to combine with this message's, and facts to combine with its own."""
        if facts.keys().isdisjoint(self.facts):
            return template, facts
        return Message("", template, **facts).problem.replace("{", "{{").replace("}", "}}"), {}

    def _copy(self, problem: str, remedy: str, facts: Mapping[str, Any]) -> Message:
        """Return the message with other templates, and with these facts added to its own."""
        return Message(
            self.code, problem, remedy, at_terminal=self.at_terminal, **{**self.facts, **facts}
        )

    def word(self, template: str) -> str:
        """Fill in a template with the facts, such as a front end's own remedy for this code."""
        return _Words().vformat(template, (), self.facts)

    def __str__(self) -> str:
        return "; ".join(filter(None, (self.problem, self.remedy)))


class Note(str):
    """A remark that is not an error.

    ``message`` has its code and facts.

    Args:
        code: Same as in `Message`, like the other fields.
        problem: Template of the observation.
        remedy: Template of the remedy.
        facts: The values, by name.
    """

    message: Message

    def __new__(cls, code: str, problem: str, remedy: str = "", /, **facts: Any) -> Self:
        """Return the text of a message."""
        message = Message(code, problem, remedy, **facts)
        note = super().__new__(cls, str(message))
        note.message = message
        return note


class WorldgenError(Exception):
    """Base of every error that the input causes, not the program.

    The command line prints the error and exits with 2. ``str(error)`` is the whole sentence.

    Args:
        code: Same as in `Message`, like the other fields.
        problem: Template of the problem and the rule.
        remedy: Template of the remedy.
        facts: The values, by name.
    """

    def __init__(self, code: str, problem: str, remedy: str = "", /, **facts: Any) -> None:
        super().__init__(code)
        self.message = Message(code, problem, remedy, **facts)

    @classmethod
    def of(cls, message: Message, **more: Any) -> Self:
        """Return the error with a given message, such as another error's.

        Args:
            message: The message.
            more: Other arguments of the class: ``line`` and ``source`` of a `FormatError`.
        """
        error = cls(message.code, message._problem, message._remedy, **more)
        error.message = message
        return error

    notes: tuple[str, ...] = ()
    """What was learned about the input before the fault, in sentences; shown before the error."""

    @property
    def code(self) -> str:
        """The rule that was broken, in lower case with dashes.

        It stays the same when the wording changes.
        """
        return self.message.code

    @property
    def facts(self) -> dict[str, Any]:
        """The values that the message is about, by name."""
        return self.message.facts

    def __str__(self) -> str:
        return str(self.message)

    def __reduce__(self) -> tuple[Any, ...]:
        # An exception is pickled by its arguments, which cannot be keywords.
        return _restore, (type(self), self.args, self.__dict__)


def _restore(
    kind: type[WorldgenError], args: tuple[Any, ...], state: dict[str, Any]
) -> WorldgenError:
    error = kind.__new__(kind, *args)
    error.__dict__.update(state)
    return error


class InvalidParameter(WorldgenError, ValueError):
    """A number or a name outside its documented range."""


class InvalidWorld(WorldgenError, ValueError):
    """Parts that do not make a world: a start in a wall, a target outside the grid."""


class GenerationFailed(WorldgenError):
    """A family found no solvable world within its bounded retries."""


class OutputError(WorldgenError):
    """A file that cannot be written, or that already exists."""


class FormatError(WorldgenError, ValueError):
    """A file that breaks the rules of its format.

    Args:
        code: Same as in `Message`, like the other fields.
        problem: Template of the problem and the rule.
        remedy: Template of the remedy.
        line: Line of the fault, counted from 1; ``None`` if the file has no lines.
        source: The file's name for the message.
        facts: The values, by name.
    """

    def __init__(
        self,
        code: str,
        problem: str,
        remedy: str = "",
        /,
        *,
        line: int | None = None,
        source: str | None = None,
        **facts: Any,
    ) -> None:
        super().__init__(code, problem, remedy, **facts)
        self.line = line
        self.source = source

    @classmethod
    def unreadable(cls, source: object, error: Exception) -> Self:
        """Return the error for a file that cannot be read.

        Args:
            source: The file's name for the message.
            error: What the system reported: an ``OSError``, or a ``ValueError`` about a NUL.
        """
        place = str(source)
        if isinstance(error, FileNotFoundError | NotADirectoryError):
            return cls("no-such-file", "there is no such file", "check the name", source=place)
        if isinstance(error, IsADirectoryError):
            return cls("is-a-folder", "this is a folder", "choose a file in it", source=place)
        reason = getattr(error, "strerror", None) or str(error)
        remedy = "check the name" if isinstance(error, ValueError) else ""
        return cls("unreadable", "cannot be read: {reason}", remedy, reason=reason, source=place)

    @property
    def place(self) -> str:
        """``FILE:LINE``, as far as known."""
        if self.source is None and self.line is not None:
            return f"line {self.line}"
        return ":".join(shown(part) for part in (self.source, self.line) if part is not None)

    def __str__(self) -> str:
        return ": ".join(filter(None, (self.place, str(self.message))))


class NotAGrid(FormatError):
    """A file that does not begin like a ``.grid`` file; it may be a map of another program."""
