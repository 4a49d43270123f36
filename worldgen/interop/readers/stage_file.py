"""Parse Stage's world files.

The grammar is ``name value``, ``name [ ... ]``, ``name ( ... )``, ``define name base ( ... )``. A
file is untrusted: its size is limited, and so is the size that its definitions expand to. Source:
rtv/Stage 4.3, ``worldfile.cc``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from typing import NamedTuple

from worldgen.errors import FormatError

_TOKEN = re.compile(
    r"(?P<space>[ \t]+|#[^\r\n]*)|(?P<end>\r\n|\n\r?|\r)|(?P<word>[A-Za-z][A-Za-z0-9._\-\[\]]*)"
    r'|(?P<number>[+\-.0-9]+)|"(?P<text>[^"\r\n]*)"|(?P<mark>[()\[\]])'
)
_NUMBER = re.compile(r"[+-]?([0-9]{1,400}\.?[0-9]{0,400}|\.[0-9]{1,400})")
# Nested parts, and definitions that build on definitions.
_MOST_DEPTH = 16
# Limit on the tokens, counting a definition's tokens again wherever it is used; Stage's
# hospital.world has 498,236.
_MOST_TOKENS = 700_000


class _Token(NamedTuple):
    kind: str
    text: str
    line: int
    source: str


class _Value(NamedTuple):
    items: tuple[_Token, ...]
    line: int
    source: str


@dataclass
class Entity:
    """An entity with its properties, including those of its definition.

    Args:
        kind: Its base kind, ``model`` or ``position``, or a name that the file does not define.
        line: Line where it begins.
        source: The file that contains it, for messages.
        names: The definitions it builds on, starting with its own word.
        properties: Properties by name.
        parts: The entities inside its brackets.
    """

    kind: str
    line: int
    source: str
    names: tuple[str, ...] = ()
    properties: dict[str, _Value] = field(default_factory=dict)
    parts: list[Entity] = field(default_factory=list)

    def __contains__(self, key: str) -> bool:
        return key in self.properties

    def place(self, key: str) -> _Value | Entity:
        """Return what a property's errors refer to: its value, or the entity if it is missing."""
        return self.properties.get(key, self)

    def text(self, key: str, default: str = "") -> str:
        """Return the string of a property."""
        value = self.properties.get(key)
        return value.items[0].text if value is not None and value.items else default

    def numbers(self, key: str) -> list[Fraction]:
        """Return the exact numbers of a property; none if it is missing.

        Raises:
            FormatError: If one isn't a number.
        """
        items = self.properties[key].items if key in self.properties else ()
        for item in items:
            if not _NUMBER.fullmatch(item.text):
                raise FormatError(
                    "not-a-number",
                    "{key} has {text!q}, which is not a number",
                    "write one such as 0.05, without exponent",
                    key=key,
                    text=item.text,
                    line=self.place(key).line,
                    source=self.place(key).source,
                )
        return [Fraction(item.text) for item in items]


@dataclass
class _StageReader:
    """Walks along the tokens, and remembers the definitions so far."""

    tokens: list[_Token]
    at: int = 0
    spent: int = 0
    defined: dict[str, tuple[str, int, int]] = field(default_factory=dict)

    def fill(self, entity: Entity, depth: int, end: int) -> None:
        """Read an entity's brackets, or the file, up to a token."""
        while self.at < end:
            token = self.tokens[self.at]
            self._spend(1, token)
            if token.kind == "word" and token.text == "define":
                self._define()
            elif token.kind == "word":
                self._named(entity, depth)
            else:
                raise FormatError(
                    "wrong-form",
                    "{came!q} is where a name belongs",
                    came=token.text,
                    line=token.line,
                    source=token.source,
                )

    def _spend(self, count: int, token: _Token) -> None:
        self.spent += count
        if self.spent > _MOST_TOKENS:
            raise FormatError(
                "too-large",
                "definitions grow to more than {most} words",
                "take some out",
                most=_MOST_TOKENS,
                line=token.line,
                source=token.source,
            )

    def _define(self) -> None:
        words = self.tokens[self.at + 1 : self.at + 3]
        if len(words) < 2 or any(word.kind != "word" for word in words):
            raise FormatError(
                "wrong-form",
                "define needs a name and a base",
                "write `define wall model ( ... )`",
                line=self.tokens[self.at].line,
                source=self.tokens[self.at].source,
            )
        begin = self.at + 3
        self.at = begin
        self.defined[words[0].text] = (words[1].text, begin + 1, self._skip())

    def _skip(self) -> int:
        """Move past the bracket that closes the current one, and return its position."""
        begin = self.at
        first = self.tokens[self.at] if self.at < len(self.tokens) else self.tokens[-1]
        depth = 0
        # Count the brackets until the first one is closed.
        while self.at < len(self.tokens):
            text = self.tokens[self.at].text if self.tokens[self.at].kind == "mark" else ""
            depth += (text == "(") - (text == ")")
            self.at += 1
            if depth == 0:
                break
        self._spend(self.at - begin, first)
        if depth or self.tokens[self.at - 1].text != ")":
            raise FormatError(
                "wrong-form",
                "a bracket ( is missing or not closed",
                "write `name ( ... )`",
                line=first.line,
                source=first.source,
            )
        return self.at - 1

    def _named(self, entity: Entity, depth: int) -> None:
        name = self.tokens[self.at]
        after = self.tokens[self.at + 1] if self.at + 1 < len(self.tokens) else None
        if after is not None and after.text == "(" and after.kind == "mark":
            self.at += 1
            begin = self.at + 1
            end = self._skip()
            entity.parts.append(self._entity(name, begin, end, depth))
            return
        self.at += 2
        if after is not None and after.kind in ("number", "text"):
            entity.properties[name.text] = _Value((after,), name.line, name.source)
        elif after is not None and after.kind == "mark" and after.text == "[":
            entity.properties[name.text] = _Value(tuple(self._list(after)), name.line, name.source)
        else:
            raise FormatError(
                "missing-value",
                '{name!q} has no value; a name is followed by a number, a "word", [ or (',
                name=name.text,
                line=name.line,
                source=name.source,
            )

    def _list(self, first: _Token) -> Iterator[_Token]:
        while self.at < len(self.tokens):
            token = self.tokens[self.at]
            self.at += 1
            self._spend(1, token)
            if token.kind == "mark" and token.text == "]":
                return
            if token.kind not in ("number", "text"):
                break
            yield token
        raise FormatError(
            "wrong-form",
            'a list [ lacks a number or a "word"',
            "close it with ]",
            line=first.line,
            source=first.source,
        )

    def _entity(self, name: _Token, begin: int, end: int, depth: int) -> Entity:
        """Return the entity between two tokens, on top of its definition."""
        if depth > _MOST_DEPTH:
            raise FormatError(
                "nested-too-deep",
                "entities are nested deeper than {most} levels",
                "flatten them",
                most=_MOST_DEPTH,
                line=name.line,
                source=name.source,
            )
        after = self.at
        if name.text in self.defined:
            base, first, last = self.defined[name.text]
            entity = self._entity(name._replace(text=base), first, last, depth + 1)
            entity.names = (name.text, *entity.names)
            entity.line = name.line
            entity.source = name.source
        else:
            entity = Entity(name.text, name.line, name.source, (name.text,))
        self.at = begin
        self.fill(entity, depth + 1, end)
        self.at = after
        return entity


def read_stage_file(
    text: str, source: str, include: Callable[[str, int], tuple[str, str] | None]
) -> Entity:
    """Return the whole file as one entity without a kind.

    Args:
        text: The file.
        source: Name of the file for messages.
        include: Takes a name and its line; returns the text and source of an included file, or None
            to skip it.

    Raises:
        FormatError: If it isn't a Stage world file, with the line.
    """
    tokens = list(_tokens(text, source, include, 0))
    world = Entity("", 1, source)
    _StageReader(tokens).fill(world, 0, len(tokens))
    return world


def _tokens(
    text: str, source: str, include: Callable[[str, int], tuple[str, str] | None], depth: int
) -> Iterator[_Token]:
    """Yield the tokens, including tokens of included files in place."""
    # Read token by token, and follow includes.
    at = 0
    line = 1
    including = False
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            raise FormatError(
                "wrong-form",
                "{came!q} is not Stage's; is a \" missing?",
                came=text[at : at + 20],
                line=line,
                source=source,
            )
        at = match.end()
        kind = str(match.lastgroup)
        line += kind == "end"
        if kind in ("space", "end"):
            continue
        # A file's name follows the word include.
        token = _Token(kind, match[kind], line, source)
        if including:
            if kind != "text":
                raise FormatError(
                    "wrong-form",
                    "include needs a file's name in quotes",
                    line=token.line,
                    source=token.source,
                )
            if depth >= _MOST_DEPTH:
                raise FormatError(
                    "nested-too-deep",
                    "files are included more than {most} levels deep",
                    "does one include itself?",
                    most=_MOST_DEPTH,
                    line=token.line,
                    source=token.source,
                )
            found = include(token.text, line)
            if found is not None:
                yield from _tokens(*found, include, depth + 1)
        elif kind != "word" or token.text != "include":
            yield token
        including = kind == "word" and token.text == "include"
