"""Read YAML as nodes with their lines; no values, tags or aliases are resolved.

Tables remember which keys a reader takes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from typing import NamedTuple

import yaml

from worldgen.domain import DECIMAL
from worldgen.errors import FormatError
from worldgen.interop.account import IsHarmless, Names, account_for

# The C parser is several times as fast, and is in every wheel of PyYAML.
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_MAX_DEPTH = 8
_LARGEST = 1e100
_NULL = ("", "~", "null", "none")
_TRUTH = {
    "0": False,
    "false": False,
    "no": False,
    "off": False,
    "1": True,
    "true": True,
    "yes": True,
    "on": True,
}


class _Entry(NamedTuple):
    """One value, with the line of its key."""

    node: yaml.Node
    line: int


class YamlTable:
    """A mapping of keys to words and numbers.

    Its methods raise an error with the line if a value has another form.

    Args:
        node: The mapping; an empty one if omitted.

    Raises:
        FormatError: If a key is given twice.
    """

    def __init__(self, node: yaml.MappingNode | None = None) -> None:
        self.line = 1 if node is None else node.start_mark.line + 1
        self._entries: dict[str, _Entry] = {}
        self._taken: set[str] = set()
        self._inner: dict[str, list[YamlTable]] = {}
        for key, value in () if node is None else node.value:
            line = key.start_mark.line + 1
            name = key.value if isinstance(key, yaml.ScalarNode) else "a list or mapping"
            if name in self._entries:
                raise FormatError(
                    "twice", "{name!q} is given twice", "keep one", name=name, line=line
                )
            self._entries[name] = _Entry(value, line)

    def __contains__(self, key: str) -> bool:
        return key in self._entries

    def _take(self, key: str) -> _Entry:
        self._taken.add(key)
        return self._entries[key]

    def pass_over(self) -> None:
        """State that nothing in here can be an obstacle, or that it is reported otherwise."""
        self._taken.update(self._entries)
        self._inner.clear()

    def left_over(self, path: Names, is_harmless: IsHarmless) -> Iterator[str]:
        """Yield a few words for each key that nobody took."""
        for key in self._entries:
            inner = (*path, key)
            if is_harmless(inner):
                continue
            if key not in self._taken:
                yield f"keys {key} in {path[-1]}" if path else f"keys {key}"
            for table in self._inner.get(key, ()):
                yield from table.left_over(inner, is_harmless)

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def line_of(self, key: str) -> int:
        """Return the line of a key, or the table's own if it lacks the key."""
        return self._entries[key].line if key in self._entries else self.line

    def lines(self, key: str) -> list[tuple[int, str]] | None:
        """Return the lines of a key's text with their numbers; None if it is a list or a table."""
        entry = self._take(key)
        if not isinstance(entry.node, yaml.ScalarNode):
            return None
        # The text of a block begins in the line after its key; a quoted one may be on one line.
        block = entry.node.style in ("|", ">")
        texts = str(entry.node.value).split("\n")
        return [(entry.line + (1 + index) * block, text) for index, text in enumerate(texts)]

    def word(self, key: str) -> str:
        """Return the single value of a key, as written.

        Raises:
            FormatError: If it is a list, a table, or empty.
        """
        node = self._take(key).node
        if not isinstance(node, yaml.ScalarNode) or not node.value:
            raise FormatError(
                "wrong-type",
                "{key} must be one value on its line, not a list and not empty",
                key=key,
                line=self.line_of(key),
            )
        return str(node.value)

    def number(self, key: str) -> float:
        """Return the finite number of a key.

        Raises:
            FormatError: If it isn't one.
        """
        word = self.word(key)
        value = _parse_number(word)
        if value is None:
            raise FormatError(
                "not-a-number",
                "{key} is {word!q}, which is not a finite number",
                "write one such as 0.05",
                key=key,
                word=word,
                line=self.line_of(key),
            )
        return value

    def truth(self, key: str) -> bool:
        """Return the Boolean of a key.

        Raises:
            FormatError: If it is neither.
        """
        word = self.word(key)
        if word.lower() not in _TRUTH:
            raise FormatError(
                "not-a-number",
                "{key} is {word!q}",
                "write 0 or 1",
                key=key,
                word=word,
                line=self.line_of(key),
            )
        return _TRUTH[word.lower()]

    def words(self, key: str) -> list[str] | None:
        """Return a key's list of single values as written; None if it is something else."""
        node = self._take(key).node
        items = node.value if isinstance(node, yaml.SequenceNode) else None
        if items is None or not all(isinstance(item, yaml.ScalarNode) for item in items):
            return None
        return [str(item.value) for item in items]

    def numbers(self, key: str) -> list[float] | None:
        """Return a key's list of finite numbers; None if it is something else."""
        numbers = [_parse_number(word) for word in self.words(key) or ("",)]
        return None if None in numbers else [number for number in numbers if number is not None]

    def is_null(self, key: str) -> bool:
        """Return True if a key has no value, or ``null``."""
        node = self._entries[key].node
        is_null = isinstance(node, yaml.ScalarNode) and node.value.lower() in _NULL
        if is_null:
            self._taken.add(key)
        return is_null

    def fraction(self, key: str) -> Fraction:
        """Return the number of a key, exactly as written.

        Raises:
            FormatError: If it isn't a number.
        """
        word = self.word(key)
        if not _is_exact(word):
            raise FormatError(
                "not-a-number",
                "{key} is {word!q}, which is not a number",
                "write one such as 0.05",
                key=key,
                word=word,
                line=self.line_of(key),
            )
        return Fraction(word)

    def rows(self, key: str) -> list[list[Fraction]]:
        """Return the lists of numbers of a key, exactly.

        A single list counts as one row, as does a list of one.

        Raises:
            FormatError: If it is something else.
        """
        node = self._take(key).node
        items = node.value if isinstance(node, yaml.SequenceNode) else [node]
        while len(items) == 1 and isinstance(items[0], yaml.SequenceNode):
            items = items[0].value
        nested = [item.value for item in items if isinstance(item, yaml.SequenceNode)]
        rows = nested if nested and len(nested) == len(items) else [items]
        words = [
            [item.value if isinstance(item, yaml.ScalarNode) else "" for item in row]
            for row in rows
        ]
        if not all(row and all(map(_is_exact, row)) for row in words):
            raise FormatError(
                "wrong-type",
                "{key} must be a list of numbers, [1.5, 2, 0], or a list of such lists",
                key=key,
                line=self.line_of(key),
            )
        return [[Fraction(word) for word in row] for row in words]

    def lists(self, key: str) -> list[list[str | YamlTable]]:
        """Return the lists of a key's list: their single values as written, and their tables.

        Raises:
            FormatError: If it is something else.
        """
        node = self._take(key).node
        items = node.value if isinstance(node, yaml.SequenceNode) else [node]
        if isinstance(node, yaml.ScalarNode) and node.value.lower() in _NULL:
            items = []
        if not all(isinstance(item, yaml.SequenceNode) for item in items):
            raise FormatError(
                "wrong-type", "{key} must be a list of lists", key=key, line=self.line_of(key)
            )
        found = [[_part(part) for part in item.value] for item in items]
        self._inner.setdefault(
            key, [part for row in found for part in row if isinstance(part, YamlTable)]
        )
        return found

    def tables(self, key: str) -> list[YamlTable]:
        """Return the tables of a key: one, or a list of them.

        Raises:
            FormatError: If it is something else.
        """
        node = self._take(key).node
        items = node.value if isinstance(node, yaml.SequenceNode) else [node]
        tables = [item for item in items if isinstance(item, yaml.MappingNode)]
        if len(tables) < len(items):
            raise FormatError(
                "wrong-type",
                "{key} must have keys of its own, `name: value`, indented below it",
                key=key,
                line=self.line_of(key),
            )
        # A key may be read again; what is taken from its tables counts together.
        if key not in self._inner:
            self._inner[key] = [YamlTable(item) for item in tables]
        return self._inner[key]


def read_yaml(text: bytes, example: str) -> YamlTable:
    """Parse the top level of a file.

    Args:
        text: The file.
        example: A typical line, for messages: "a ROS map has `image: map.pgm` and similar keys".

    Raises:
        FormatError: If it isn't YAML, isn't a table, or has anchors, aliases, or lists nested too
            deep.
    """
    root = _compose(text)
    if not isinstance(root, yaml.MappingNode):
        raise FormatError("empty", "holds no keys; {example}", example=example, line=1)
    return account_for(YamlTable(root))


def _part(node: yaml.Node) -> str | YamlTable:
    if isinstance(node, yaml.MappingNode):
        return YamlTable(node)
    return str(node.value) if isinstance(node, yaml.ScalarNode) else ""


def _is_exact(word: str) -> bool:
    """Return True if a word is a number that a float can hold with room for arithmetic."""
    return DECIMAL.fullmatch(word) is not None and abs(float(word)) < _LARGEST


def _parse_number(word: str) -> float | None:
    value = float(word) if DECIMAL.fullmatch(word) else math.nan
    return value if math.isfinite(value) else None


def _compose(text: bytes) -> yaml.Node | None:
    """Return the file as nodes only: no value is built, no tag obeyed."""
    try:
        decoded = text.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = text.count(b"\n", 0, error.start) + 1
        raise FormatError(
            "not-utf8", "is not UTF-8 text", "use the map's YAML file", line=line
        ) from error
    try:
        _refuse_tricks(decoded)
        return yaml.compose(decoded, Loader=_LOADER)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = 1 if mark is None else mark.line + 1
        raise FormatError(
            "not-yaml",
            "is not YAML: {reason}",
            "write `key: value` lines",
            reason=error.problem or error.context,
            line=line,
        ) from error
    except FormatError:
        raise
    # A forbidden character, raw or as an escape.
    except (yaml.YAMLError, ValueError, OverflowError) as error:
        line = decoded.count("\n", 0, getattr(error, "position", 0)) + 1
        raise FormatError(
            "forbidden-character", "has a character that YAML forbids", "remove it", line=line
        ) from error


def _refuse_tricks(text: str) -> None:
    """Reject anything that makes a small YAML file large or deep, before a tree is built."""
    depth = 0
    for event in yaml.parse(text, Loader=_LOADER):
        line = 1 if event.start_mark is None else event.start_mark.line + 1
        if isinstance(event, yaml.AliasEvent) or getattr(event, "anchor", None) is not None:
            raise FormatError(
                "unsupported",
                "anchors and aliases (& and *) are not supported",
                "write out the value",
                line=line,
            )
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(
            event, yaml.CollectionEndEvent
        )
        if depth > _MAX_DEPTH:
            raise FormatError(
                "nested-too-deep",
                "lists nested deeper than {most}",
                "flatten them",
                most=_MAX_DEPTH,
                line=line,
            )
