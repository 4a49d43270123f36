"""Read the nodes of a Webots world as a tree that remembers what a reader takes.

Source: the Webots Reference Manual, "Nodes and Functions"; ISO/IEC 14772-1:1997 (VRML97), 4.2 and
    annex A.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any, NoReturn

from worldgen.domain import DECIMAL
from worldgen.errors import FormatError
from worldgen.interop.account import NamedParts, account_for
from worldgen.interop.format.foreign_map import read_bounded

MAX_BYTES = 16 << 20
# Limits on nodes, each as often as it is used, and on words; a detailed apartment has 5000 nodes.
_MOST_NODES = 100_000
_MOST_WORDS = 4_000_000
_MOST_DEPTH = 64
# Beyond this, a float cannot tell cells apart.
_FURTHEST = 10**9

_HEADER = re.compile(r"\ufeff?#VRML_SIM[ \t]+(?:R(\d{4})|V\d)")
_WORD = re.compile(
    r"""(?s)(?:[\s,]++|\#[^\n]*+)*+(?:("(?:[^"\\]|\\.)*+")|([{}\[\]])|([^\s,{}\[\]"\#]++)|\Z)"""
)
_NAME = re.compile(r"[A-Za-z_][\w.+-]*", re.ASCII)
_NUMBER = re.compile(r"[+-]?\.?[0-9]")
_LITERALS = ("TRUE", "FALSE", "NULL")


class WebotsNode(NamedParts):
    """A node; each field is a list of nodes, or of words and strings, which keep their quotes.

    Attributes:
        kind: Name of its type, or of its PROTO.
        line: Line where it begins.
        count: Number of nodes in it, with itself.
        depth: Levels of nodes in it, with itself.
    """

    def __init__(self, kind: str, line: int) -> None:
        super().__init__()
        self.kind = kind
        self.line = line
        self.count = 1
        self.depth = 1

    def __bool__(self) -> bool:
        # A node without fields is an element too.
        return True

    def add(self, name: str, values: list[Any]) -> None:
        """Add a field."""
        self[name] = values
        for node in values:
            if isinstance(node, WebotsNode):
                self.count += node.count
                self.depth = max(self.depth, 1 + node.depth)

    def copied(self) -> WebotsNode:
        """Return a copy of which nothing is taken, for a place where it is used again."""
        copy = WebotsNode(self.kind, self.line)
        for name, values in self.items():
            of_nodes = bool(values) and isinstance(values[0], WebotsNode)
            copy.add(name, [node.copied() for node in values] if of_nodes else values)
        return copy

    def nodes(self, name: str) -> list[WebotsNode]:
        """Take the nodes in a field.

        Raises:
            FormatError: If it has something else.
        """
        values: list[Any] = self.get(name, [])
        if any(not isinstance(value, WebotsNode) for value in values):
            self._refuse(name, values, "nodes")
        return values

    def text(self, name: str) -> str:
        """Take a field with one word or string; empty if it is missing."""
        values = self.get(name, [])
        if len(values) > 1 or any(isinstance(value, WebotsNode) for value in values):
            self._refuse(name, values, "one word")
        return values[0].strip('"') if values else ""

    def numbers(self, name: str, count: int) -> list[Fraction] | None:
        """Take a field with this many numbers; None if it is missing.

        Raises:
            FormatError: If there are more or fewer, or one is not a number of a usual size.
        """
        if name not in self:
            return None
        values = self.get(name)
        if len(values) != count or not all(
            isinstance(value, str) and DECIMAL.fullmatch(value) for value in values
        ):
            self._refuse(name, values, f"{count} numbers" if count > 1 else "one number")
        found = [Fraction(value) for value in values]
        if any(abs(value) > _FURTHEST for value in found):
            self._refuse(name, values, f"numbers of at most {_FURTHEST:g}")
        return found

    def _refuse(self, name: str, values: list[Any], rule: str) -> NoReturn:
        words = [value if isinstance(value, str) else value.kind for value in values[:6]]
        raise FormatError(
            "wrong-type",
            "{name} of {kind} is {text!q}; it has {rule}",
            name=name,
            kind=self.kind[:40],
            text=" ".join(words)[:60],
            rule=rule,
            line=self.line,
        )


@dataclass
class WebotsFile:
    """A world.

    Args:
        year: That of the release that wrote it, such as 2023; 0 for those before 2018.
        nodes: Its nodes.
        protos: Addresses of the PROTOs that it declares, by name.
    """

    year: int
    nodes: list[WebotsNode] = field(default_factory=list)
    protos: dict[str, str] = field(default_factory=dict)


def read_webots(path: Path) -> WebotsFile:
    """Return the nodes of a file.

    Raises:
        FormatError: If it breaks a rule of the syntax, or exceeds a limit.
    """
    try:
        text = read_bounded(path, MAX_BYTES).decode()
    except UnicodeDecodeError:
        raise FormatError("not-text", "is not text in UTF-8", "save it from Webots") from None
    header = _HEADER.match(text)
    if header is None:
        raise FormatError(
            "wrong-header",
            "does not begin with a header of Webots, such as #VRML_SIM R2025a utf8",
            "open it in Webots and save it",
            line=1,
        )
    return _Parser(text).file(int(header[1] or 0))


class _Parser:
    def __init__(self, text: str) -> None:
        self._words = self._split(text)
        self._line = 1
        self._next = next(self._words, "")
        self._known: dict[str, WebotsNode] = {}
        self._left = _MOST_NODES

    def file(self, year: int) -> WebotsFile:
        """Return the whole file."""
        found = WebotsFile(year)
        while self._next:
            word = self._take()
            if word == "EXTERNPROTO":
                address = self._take().strip('"')
                found.protos[address.rpartition("/")[2].removesuffix(".proto")] = address
            elif word == "PROTO":
                self._refuse("unsupported", "defines a PROTO", "import a world, a .wbt file")
            elif word != "IMPORTABLE":
                found.nodes.append(account_for(self._node(word, 1)))
        return found

    def _split(self, text: str) -> Iterator[str]:
        at = 0
        for _ in range(_MOST_WORDS):
            match = _WORD.match(text, at)
            if match is None:
                self._line += text.count("\n", 0, at)
                self._refuse("unterminated", "has a string without an end", 'add the missing "')
            self._line += text.count("\n", at, match.end())
            at = match.end()
            word = match[1] or match[2] or match[3]
            if word is None:
                return
            yield word
        self._refuse("too-large", f"has more than {_MOST_WORDS} words", "remove its meshes")

    def _take(self) -> str:
        word = self._next
        if not word:
            self._refuse("cut-off", "ends inside a node", "add the missing } or ]")
        self._next = next(self._words, "")
        return word

    def _node(self, word: str, depth: int) -> WebotsNode:
        if depth > _MOST_DEPTH:
            self._refuse(
                "nested-too-deep", f"nests nodes more than {_MOST_DEPTH} deep", "flatten it"
            )
        if word == "USE":
            return self._used(self._take(), depth)
        name = self._take() if word == "DEF" else ""
        kind = self._take() if name else word
        if not _NAME.fullmatch(kind) or self._next != "{":
            self._refuse(
                "wrong-form", f"has {kind[:40]!r} where a node begins", "a node is Name { ... }"
            )
        self._take()
        node = WebotsNode(kind, self._line)
        self._count(1)
        while (key := self._take()) != "}":
            if key == "hidden" and _NAME.fullmatch(self._next):
                continue
            if not _NAME.fullmatch(key) or self._next == "IS":
                self._refuse(
                    "wrong-form", f"has {key[:40]!r} where a field of {kind[:40]} begins",
                    "a field is a name and a value",
                )  # fmt: skip
            if key in node:
                self._refuse("twice", f"gives {key[:40]} of {kind[:40]} twice", "keep one")
            node.add(key, self._values(key, depth))
        if name:
            self._known[name] = node
        return node

    def _used(self, name: str, depth: int) -> WebotsNode:
        node = self._known.get(name)
        if node is None:
            self._refuse(
                "unknown-name", f"uses {name[:40]!r} before DEF has defined it", "define it above"
            )
        if depth + node.depth - 1 > _MOST_DEPTH:
            self._refuse(
                "nested-too-deep", f"nests nodes more than {_MOST_DEPTH} deep", "flatten it"
            )
        self._count(node.count)
        return node.copied()

    def _count(self, nodes: int) -> None:
        self._left -= nodes
        if self._left < 0:
            self._refuse("too-large", f"has more than {_MOST_NODES} nodes", "remove some of them")

    def _values(self, name: str, depth: int) -> list[Any]:
        """Return a field's values; NULL, which stands for no node, is left out."""
        if self._next != "[":
            if not self._is_scalar(self._next):
                return [self._item(name, depth)]
            words = []
            while self._is_scalar(self._next):
                words.append(self._take())
            return [word for word in words if word != "NULL"]
        self._take()
        items = []
        while self._next != "]":
            items.append(self._item(name, depth))
        self._take()
        if len({isinstance(item, WebotsNode) for item in items}) > 1:
            self._refuse("wrong-type", f"mixes nodes and values in {name[:40]}", "keep one kind")
        return items

    def _item(self, name: str, depth: int) -> Any:
        word = self._take()
        if self._is_scalar(word):
            return word
        if not word[0].isupper():
            self._refuse(
                "wrong-form", f"has {word[:40]!r} as the value of {name[:40]}",
                "a value is a number, a string, TRUE, FALSE, a node, or a list of them",
            )  # fmt: skip
        return self._node(word, depth + 1)

    @staticmethod
    def _is_scalar(word: str) -> bool:
        return word[:1] == '"' or word in _LITERALS or _NUMBER.match(word) is not None

    def _refuse(self, code: str, what: str, remedy: str) -> NoReturn:
        raise FormatError(code, "{what}", "{remedy}", what=what, remedy=remedy, line=self._line)
