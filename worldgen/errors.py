"""Errors that a user can cause, as data.

A code, the facts, and templates that put them into words.
"""

from __future__ import annotations

import string
from collections.abc import Mapping
from pathlib import PurePath
from typing import Any, Self

from worldgen.support.plain_text import quote

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


_MOST_BYTES = 1000  # of a fact; a message quotes far fewer


class _Listed(str):
    """Items between commas; the format specification is what an empty list reads as."""

    def __format__(self, if_empty: str) -> str:
        return str(self) or if_empty


class _Words(string.Formatter):
    """``str.format`` with conversions for messages.

    ``{name!q}`` quotes text that came from outside; ``{names!l:none}`` puts commas between the
    items of a list, and reads ``none`` if there are no items; ``{size!n}`` is a number with six
    digits, or all of a whole one's; ``{unit!u}`` puts a space before a unit, if there is one.
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


def _plain(value: Any) -> Any:
    """Return a fact as JSON has it.

    A path as text, bytes as the text they begin with, a NumPy number as a number.
    """
    if isinstance(value, PurePath):
        return str(value)
    if isinstance(value, bytes | bytearray):
        return bytes(value[:_MOST_BYTES]).decode("utf-8", "backslashreplace")
    if type(value) in (list, tuple):
        return type(value)(map(_plain, value))
    # Asked by name, because importing NumPy would slow down `worldgen --help`.
    return value.tolist() if type(value).__module__ == "numpy" else value


class Message:
    """What a program has to tell its user: a code and facts, and how they read.

    Programs and tests compare ``code`` and ``facts``; neither changes when the wording does. A
    front end that has other means than the command line, such as the studio's page, words the
    remedy itself, by the code.

    Args:
        code: Names the rule, in lower case with dashes: ``door-too-narrow``.
        problem: Template of what came and the rule:
            ``"door_width={door_width:g} m is less than {least:g} m"``. A field is a fact, as in
            ``str.format``; ``{name!q}`` quotes text from outside, ``{names!l:none}`` lists,
            ``{size!n}{unit!u}`` is a number and its unit.
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
        """What came and the rule it breaks, in words."""
        return self.word(self._problem)

    @property
    def remedy(self) -> str:
        """The way out, in the command line's words; empty if there is none to give."""
        return self.word(self._remedy)

    def behind(self, prefix: str, /, **facts: Any) -> Message:
        """Return the message with a prefix before its problem, such as a place the caller knows.

        Args:
            prefix: Template, with what separates it: ``"{file}: "``.
            facts: The values in it; if one has the name of a fact of the message, the message's
                stays.
        """
        words, more = self._beside(prefix, facts)
        return self._copy(words + self._problem, self._remedy, more)

    def before(self, suffix: str, /, **facts: Any) -> Message:
        """Return the same message with words after its last, such as the line that it is about.

        Args:
            suffix: Template, with what separates it: ``", in {file}"``.
            facts: The values in it.
        """
        words, more = self._beside(suffix, facts)
        if self._remedy:
            return self._copy(self._problem, self._remedy + words, more)
        return self._copy(self._problem + words, "", more)

    def with_remedy(self, remedy: str, /, **facts: Any) -> Message:
        """Return the same message with another way out, such as that of an outer caller."""
        return self._copy(self._problem, remedy, facts)

    def replaced(self, facts: Mapping[str, Any]) -> Message:
        """Return the message with other facts, such as shorter paths for this reader."""
        return self._copy(self._problem, self._remedy, facts)

    @property
    def templates(self) -> tuple[str, str]:
        """The templates of problem and remedy, to store the message and word it later."""
        return self._problem, self._remedy

    def _beside(self, template: str, facts: dict[str, Any]) -> tuple[str, dict[str, Any]]:
        """Return a template to put next to this message's, and facts to put next to its own."""
        if facts.keys().isdisjoint(self.facts):
            return template, facts
        return Message("", template, **facts).problem.replace("{", "{{").replace("}", "}}"), {}

    def _copy(self, problem: str, remedy: str, facts: Mapping[str, Any]) -> Message:
        """Return the message with other templates, and with these facts over its own."""
        return Message(
            self.code, problem, remedy, at_terminal=self.at_terminal, **{**self.facts, **facts}
        )

    def word(self, template: str) -> str:
        """Fill a template with the facts, such as a front end's own remedy for this code."""
        return _Words().vformat(template, (), self.facts)

    def __str__(self) -> str:
        return "; ".join(filter(None, (self.problem, self.remedy)))


class Note(str):
    """A sentence worth knowing that is no error.

    ``message`` has the code and facts that it was made of.

    Args:
        code: As in `Message`, and so are the others.
        problem: Template of what is worth knowing.
        remedy: Template of what can be done about it.
        facts: The values, by name.
    """

    message: Message

    def __new__(cls, code: str, problem: str, remedy: str = "", /, **facts: Any) -> Self:
        """Return word a message."""
        message = Message(code, problem, remedy, **facts)
        note = super().__new__(cls, str(message))
        note.message = message
        return note


class WorldgenError(Exception):
    """Base of every error that the input causes, not the program.

    The command line prints the error and exits with 2. ``str(error)`` is the whole sentence.

    Args:
        code: As in `Message`, and so are the others.
        problem: Template of what came and the rule.
        remedy: Template of the way out.
        facts: The values, by name.
    """

    def __init__(self, code: str, problem: str, remedy: str = "", /, **facts: Any) -> None:
        super().__init__(code)
        self.message = Message(code, problem, remedy, **facts)

    @classmethod
    def of(cls, message: Message, **more: Any) -> Self:
        """Return the error that says a message, such as another error's.

        Args:
            message: What it says.
            more: Other arguments of the class: ``line`` and ``source`` of a `FormatError`.
        """
        error = cls(message.code, message._problem, message._remedy, **more)
        error.message = message
        return error

    @property
    def code(self) -> str:
        """The rule that was broken, in lower case with dashes.

        It stays when the wording changes.
        """
        return self.message.code

    @property
    def facts(self) -> dict[str, Any]:
        """The values that the message is about, by name."""
        return self.message.facts

    def __str__(self) -> str:
        return str(self.message)

    def __reduce__(self) -> tuple[Any, ...]:
        # An exception is pickled by its arguments, which have no room for keywords.
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
        code: As in `Message`, and so are the others.
        problem: Template of what came and the rule.
        remedy: Template of the way out.
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

    @property
    def place(self) -> str:
        """``FILE:LINE``, as far as known."""
        if self.source is None and self.line is not None:
            return f"line {self.line}"
        return ":".join(str(part) for part in (self.source, self.line) if part is not None)

    def __str__(self) -> str:
        return ": ".join(filter(None, (self.place, str(self.message))))


class NotAGrid(FormatError):
    """A file that does not begin as a ``.grid`` file does; it may be a map of another program."""
