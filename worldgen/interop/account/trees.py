"""Account for every element of a map's file: read, harmless or unread.

Parsers build their trees from parts that remember what a reader takes from them, and register them
here. When the reader returns, everything in them that nobody took is unread, unless the format
lists its name as harmless, because it cannot be an obstacle. A new reader need not do anything for
that, and cannot skip an element in silence.

Parsers without a tree report what they pass over themselves, or refuse the file.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, Protocol, TypeVar

from worldgen.errors import FormatError

# Kinds of unread elements that are named one by one; the others are only counted.
_MOST_NAMED = 20

Names = tuple[str, ...]
IsHarmless = Callable[[Names], bool]


class Tree(Protocol):
    """A parsed file, or a part of one."""

    def left_over(self, path: Names, is_harmless: IsHarmless) -> Iterator[str]:
        """Yield a few words for each part that nobody took."""


_Tree = TypeVar("_Tree", bound=Tree)


class Account:
    """The trees of the files that one reader parses, and what parsers report as unread."""

    def __init__(self) -> None:
        self.trees: list[tuple[Tree, Collection[str] | None]] = []
        self.unread: Counter[str] = Counter()

    def total(self, harmless: Collection[str]) -> tuple[str, ...]:
        """Return the unread elements, counted, such as ``"2 objects in layers"``.

        Args:
            harmless: Names of elements, such as ``"color"`` or ``"layers/color"``, that cannot be
                obstacles, in trees that were registered without any.
        """
        found = Counter(self.unread)
        for tree, own in self.trees:
            found.update(tree.left_over((), _listed_in(harmless if own is None else own)))
        named = [_counted(count, what) for what, count in sorted(found.items())]
        rest = sum(count for _, count in sorted(found.items())[_MOST_NAMED:])
        return (*named[:_MOST_NAMED], *([f"{rest} other elements"] if rest else []))


def _listed_in(harmless: Collection[str]) -> IsHarmless:
    return lambda path: any("/".join(path[at:]) in harmless for at in range(len(path)))


_OPEN: ContextVar[Account | None] = ContextVar("_OPEN", default=None)


@contextmanager
def accounting() -> Iterator[Account]:
    """Collect what is parsed and reported inside."""
    account = Account()
    token = _OPEN.set(account)
    try:
        yield account
    finally:
        _OPEN.reset(token)


def account_for(tree: _Tree, harmless: Collection[str] | None = None) -> _Tree:
    """Register a parsed file, and return it.

    Args:
        tree: The file.
        harmless: Names of its elements that cannot be obstacles, if files of other formats may
            name it; by default those of the format that is read.
    """
    account = _OPEN.get()
    if account is not None:
        account.trees.append((tree, harmless))
    return tree


def report_unread(what: str, count: int = 1) -> None:
    """Report elements that a reader does not read.

    Args:
        what: A few words in the plural whose first word ends in s, such as ``"shapes of <mesh>"``.
        count: Their number; 0 reports nothing.
    """
    account = _OPEN.get()
    if account is not None and count:
        account.unread[what] += count


def _counted(count: int, what: str) -> str:
    """Return a number of elements in words; the first word of ``what`` is in the plural."""
    first, blank, rest = what.partition(" ")
    if count == 1:
        for plural, singular in (("bodies", "body"), ("boxes", "box"), ("meshes", "mesh")):
            first = singular if first == plural else first
        first = first.removesuffix("s") if not first.endswith(("ss", ">")) else first
    return f"{count} {first}{blank}{rest}"


class NamedParts(dict[str, Any]):
    """The named parts of an element, which remember what a reader takes.

    ``part["name"]`` and ``part.get("name")`` take; ``in``, iteration and :meth:`peek` do not.
    """

    def __init__(self, pairs: Iterable[tuple[str, Any]] = ()) -> None:
        super().__init__(pairs)
        self._taken: set[str] = set()
        self._is_passed_over = False

    def __getitem__(self, name: str) -> Any:
        self._taken.add(name)
        return super().__getitem__(name)

    def get(self, name: str, default: Any = None) -> Any:
        """Take a part; return the default if it is missing."""
        self._taken.add(name)
        return super().get(name, default)

    def peek(self, name: str, default: Any = None) -> Any:
        """Return a part without taking it."""
        return super().get(name, default)

    def pass_over(self) -> None:
        """State that nothing in here can be an obstacle, or that it is reported otherwise."""
        self._is_passed_over = True

    @property
    def is_untouched(self) -> bool:
        """True if nobody took anything from it."""
        return not self._taken and not self._is_passed_over

    def untaken(self) -> Iterator[str]:
        """Yield the names of the parts that nobody took, and that have a value."""
        if not self._is_passed_over:
            yield from (name for name, value in self.items() if value and name not in self._taken)

    def left_over(self, path: Names, is_harmless: IsHarmless) -> Iterator[str]:
        """Yield a few words for each part that nobody took."""
        where = f" in {path[-1]}" if path else ""
        for name in self.untaken():
            if not is_harmless((*path, name)):
                value = self.peek(name)
                plural = isinstance(value, list) and name.endswith("s")
                words = f"{name}{where}" if plural else f"values of {name}{where}"
                yield from [words] * (len(value) if isinstance(value, list) else 1)
        for name in () if self._is_passed_over else self._taken & self.keys():
            if not is_harmless((*path, name)):
                yield from _left_in(self.peek(name), (*path, name), is_harmless)


def _left_in(value: Any, path: Names, is_harmless: IsHarmless) -> Iterator[str]:
    if isinstance(value, NamedParts):
        yield from value.left_over(path, is_harmless)
    elif isinstance(value, list):
        # A list of numbers, which may have millions, was taken as a whole.
        items = [item for item in value if isinstance(item, NamedParts | list)]
        for item in items:
            # An item of which nobody took anything is one element, not as many as it has keys.
            if isinstance(item, NamedParts) and item.is_untouched and item:
                yield f"{path[-1]} in {path[-2]}" if path[1:] else path[-1]
            else:
                yield from _left_in(item, path, is_harmless)


def parse_json(text: bytes | str, harmless: Collection[str] | None = None) -> Any:
    """Parse JSON whose objects are :class:`NamedParts`, and register it as by :func:`account_for`.

    Raises:
        FormatError: If an object has a key twice.
        ValueError, RecursionError: As ``json.loads``.
    """
    parsed = json.loads(text, object_pairs_hook=_parts)
    if isinstance(parsed, NamedParts):
        account_for(parsed, harmless)
    return parsed


def damage(error: Exception) -> str:
    """Describe the error of a reader in a damaged file as what is wrong with the file."""
    if isinstance(error, KeyError):
        return f"{error.args[0]!r} is missing"[:80]
    if isinstance(error, IndexError):
        return "a number refers to something that is not in the file"
    if isinstance(error, ValueError | OverflowError):
        return " ".join(str(error).split())[:80]
    # What readers stumble over is a null where a list should be, a text where a number should be.
    return "a part of it is missing or of another kind"


def _parts(pairs: list[tuple[str, Any]]) -> NamedParts:
    parts = NamedParts(pairs)
    if len(parts) < len(pairs):
        names = Counter(name for name, _ in pairs)
        raise FormatError(
            "twice", "the key {name!q} is given twice", "keep one", name=names.most_common(1)[0][0]
        )
    return parts
