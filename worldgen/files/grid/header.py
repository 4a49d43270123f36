"""The TOML header: parsed after a check of its limits, with the line of every key.

``tomllib`` gives no positions, recurses for every bracket and takes quadratic time for long dotted
keys. So a linear scan checks the text first; a second scan finds a key's line when an error needs
it.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from typing import Any, NoReturn

from worldgen.errors import FormatError, Message
from worldgen.files.grid.schema import MAX_DEPTH, MAX_WORD

_TOKEN = re.compile(
    r"""
      (?P<comment> \# [^\n]* )
    | (?P<long_text> "{3} (?: [^"\\] | \\. | "{1,2}(?!") )*+ "{3,5}
                   | '{3} (?: [^'] | '{1,2}(?!') )*+ '{3,5} )
    | (?P<unclosed_long> "{3} | '{3} )
    | (?P<text> " (?: [^"\\\n] | \\. )*+ " | ' [^'\n]*+ ' )
    | (?P<unclosed> ["'] )
    | (?P<newline> \n )
    | (?P<open> [\[{] )
    | (?P<close> [\]}] )
    | (?P<mark> [=,.] )
    | (?P<space> [ \t]+ )
    | (?P<word> [^][{}="',.\#\s]+ | . )
    """,
    re.VERBOSE | re.DOTALL,
)
_PLACE = re.compile(r" \(at (?:line (\d+), column (\d+)|end of document)\)\Z")


class Header:
    """The parsed header.

    Args:
        text: The TOML, in whole lines, without the first line of the file.
        line: Line of the file in which ``text`` begins.
        source: The file's name for messages.
        noun: Name of the text in messages.

    Raises:
        FormatError: If the text isn't TOML, or exceeds the format's limits.
    """

    def __init__(self, text: str, line: int, source: str | None, noun: str = "the header") -> None:
        # As tomllib does.
        text = text.replace("\r\n", "\n")
        self._text = text
        self._line = line
        self.source = source
        self._noun = noun
        self._last_line = self._line_at(len(text))
        self._guard()
        try:
            self.data: dict[str, Any] = tomllib.loads(text)
        # Either TOMLDecodeError, or int() refuses to read thousands of digits.
        except ValueError as error:
            self._fail_toml(str(error))

    def line_of(self, *path: str) -> int:
        """Return the line of the file that sets a key, or the nearest one around it."""
        best = 0
        found = self._line
        for offset, statement in self._statement_paths():
            if statement[: len(path)] == path:
                return self._line_at(offset)
            if best < len(statement) <= len(path) and path[: len(statement)] == statement:
                best = len(statement)
                found = self._line_at(offset)
        return found

    def line_in_item(self, name: str, index: int, *path: str) -> int:
        """Return the line of a key in the ``[[name]]`` table number ``index`` of an array, from 0.

        It is the line of the table itself if the key is missing or none is requested.
        """
        statements = self.statements()
        begins = [k for k, (_, found) in enumerate(statements) if found == (name,)]
        # The tables may be written as one inline list, which has no [[name]] lines.
        if index >= len(begins):
            return self.line_of(name)
        until = begins[index + 1] if index + 1 < len(begins) else len(statements)
        for line, found in statements[begins[index] : until]:
            if found[0] == name and found[1 : 1 + len(path)] == path and path:
                return line
        return statements[begins[index]][0]

    def statements(self) -> list[tuple[int, tuple[str, ...]]]:
        """Return the line and full key path of each table line and ``key = value``, in order."""
        return [(self._line_at(offset), path) for offset, path in self._statement_paths()]

    def at(self, *path: str, table: str = "", index: int | None = None) -> dict[str, Any]:
        """Return the place of a key, as :class:`FormatError` takes it.

        Args:
            path: The key, after the tables that it is in.
            table: Name of the array of tables that has it, if ``index`` is given.
            index: Number of the table in that array, from 0.
        """
        line = self.line_of(*path) if index is None else self.line_in_item(table, index, *path)
        return {"line": line, "source": self.source}

    def at_the_end(self) -> dict[str, Any]:
        """Return the end of the header, for errors about something missing in it."""
        return {"line": self._line_at(len(self._text)), "source": self.source}

    def _line_at(self, offset: int) -> int:
        return self._line + self._text.count("\n", 0, offset)

    def _fail_toml(self, message: str) -> NoReturn:
        place = _PLACE.search(message)
        # An unclosed bracket is noticed at the end, and reported where it opens.
        line = self._last_line
        column = None
        if place is not None and place[1] is not None:
            line = self._line + int(place[1]) - 1
            column = int(place[2])
        raise FormatError(
            "not-toml",
            "{noun} is not TOML: {reason}"
            if column is None
            else "{noun} is not TOML, column {column}: {reason}",
            "write `key = value`, text in quotes, [table]",
            noun=self._noun,
            column=column,
            reason=_PLACE.sub("", message),
            line=line,
            source=self.source,
        )

    def _guard(self) -> None:
        """Reject what would make tomllib take too long or recurse too deeply."""
        depth = dots = 0
        for token in _TOKEN.finditer(self._text):
            kind = token.lastgroup
            # tomllib reports the fault and stops reading.
            if kind in ("unclosed", "unclosed_long"):
                self._last_line = self._line_at(token.start())
                return
            if kind == "open":
                depth += 1
            elif kind == "close":
                depth -= 1
            dots = (
                dots + 1 if token[0] == "." else 0 if kind in ("newline", "open", "mark") else dots
            )
            if depth > MAX_DEPTH or dots > MAX_DEPTH:
                deep = Message(
                    "nested-too-deep",
                    "nesting deeper than {most} levels",
                    "flatten it",
                    most=MAX_DEPTH,
                )
                self._refuse(token.start(), deep)
            if kind == "word" and len(token[0]) > MAX_WORD:
                long = Message(
                    "too-large",
                    "a word of {characters} characters; the limit is {most}",
                    "shorten it",
                    characters=len(token[0]),
                    most=MAX_WORD,
                )
                self._refuse(token.start(), long)

    def _refuse(self, offset: int, message: Message) -> NoReturn:
        said = message.behind("{noun} has ", noun=self._noun)
        raise FormatError.of(said, line=self._line_at(offset), source=self.source)

    def _statement_paths(self) -> Iterator[tuple[int, tuple[str, ...]]]:
        """Yield the offset and full key path of each table line and ``key = value``, in order."""
        table: tuple[str, ...] = ()
        for offset, text in _statements(self._text):
            path = _key_path(text)
            if text.startswith("["):
                table = path
                yield offset, table
            else:
                yield offset, table + path


def _statements(text: str) -> Iterator[tuple[int, str]]:
    """Yield the offset and key part of every statement: ``[table]``, or the text before ``=``."""
    depth = 0
    begin = -1
    key_done = False
    # A statement begins with the first token that is not blank, and ends with its line.
    for token in _TOKEN.finditer(text):
        kind = token.lastgroup
        if begin < 0 and kind not in ("comment", "newline", "space"):
            begin = token.start()
            key_done = False
        depth += (kind == "open") - (kind == "close")
        # An equals sign outside brackets ends its key.
        if token[0] == "=" and depth == 0 and not key_done:
            yield begin, text[begin : token.start()]
            key_done = True
        if kind in ("newline", "comment") and depth == 0 and begin >= 0:
            if not key_done:
                yield begin, text[begin : token.start()]
            begin = -1


def _key_path(text: str) -> tuple[str, ...]:
    """Return the parts of a key or a table line, which tomllib has already accepted."""
    node: Any = tomllib.loads(text if text.startswith("[") else f"{text}=0")
    path: list[str] = []
    while node and isinstance(node, dict | list):
        if isinstance(node, list):
            node = node[0]
        else:
            name = next(iter(node))
            path.append(name)
            node = node[name]
    return tuple(path)
