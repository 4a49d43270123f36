"""What the values of options name: controllers, families, motion models, oracles and formats.

Shell completion lists these names, and the answer to a wrong command looks for them among its
words. Nothing is imported for that: names come from entry points, and the classes of a Python file
from its syntax tree.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import click

from worldgen.plugins.entry_points import points_of

if TYPE_CHECKING:
    import ast

MOTIONS = ("endpoint", "stepped", "swept")
"""The motion models; a test compares them with the simulator's."""

# Largest Python file whose classes are looked up, bytes.
_LARGEST = 1 << 20


def without_options(text: str) -> str:
    """Return a value's name, without what varies it: ``bug2+speed=1``, ``detour=3``."""
    return re.split("[+=]", text, maxsplit=1)[0]


def _registered(group: str) -> list[str]:
    return sorted(point.name for point in points_of(group))


class NameKind(NamedTuple):
    """What an option's value names.

    Args:
        noun: The word for it in messages.
        names: Return the names that exist everywhere.
        methods: A class with one of these methods is one, too, if it is in the user's file.
        maker: So is a function with this decorator, or what a call of this name makes.
        takes_files: Whether ``./file.py:name`` is one, too.
    """

    noun: str
    names: Callable[[], Iterable[str]]
    methods: frozenset[str] = frozenset()
    maker: str = ""
    takes_files: bool = True

    def is_named_by(self, text: str) -> bool:
        """Return True if a word looks like the name of one, perhaps with options after it."""
        name = without_options(text)
        if name in self.names():
            return True
        file, _, attribute = name.rpartition(":")
        if self.takes_files and (file.endswith(".py") or (attribute.endswith(".py") and not file)):
            return True
        return bool(self.methods) and name.startswith(("cmd:", "lib:", "learned:", "behaviours:"))

    def in_file(self, file: Path) -> list[str]:
        """Return the names of those that a Python file defines, without running it."""
        import ast

        if not self.takes_files:
            return []
        try:
            if file.stat().st_size > _LARGEST:
                return []
            tree = ast.parse(file.read_bytes())
        except (OSError, ValueError, SyntaxError, RecursionError, MemoryError):
            return []
        return [name for node in tree.body for name in self._defined_by(node)]

    def _defined_by(self, node: ast.stmt) -> list[str]:
        import ast

        if isinstance(node, ast.ClassDef):
            methods = {getattr(part, "name", "") for part in node.body}
            return [] if self.methods.isdisjoint(methods) else [node.name]
        if isinstance(node, ast.FunctionDef):
            is_made = any(self._is_maker(one) for one in node.decorator_list)
            is_any = not (self.maker or self.methods or node.name.startswith("_"))
            return [node.name] if is_made or is_any else []
        if isinstance(node, ast.Assign) and self._is_maker(node.value):
            return [target.id for target in node.targets if isinstance(target, ast.Name)]
        return []

    def _is_maker(self, node: ast.expr) -> bool:
        import ast

        called = node.func if isinstance(node, ast.Call) else node
        name = called.attr if isinstance(called, ast.Attribute) else getattr(called, "id", "")
        return bool(self.maker) and name == self.maker


CONTROLLER = NameKind(
    "controller", lambda: _registered("worldgen.controllers"), frozenset({"act", "act_many"})
)
_FAMILY = NameKind("family", lambda: _registered("worldgen.families"), maker="family")
_FORMAT = NameKind("format", lambda: _registered("worldgen.formats"), maker="Format")

_BY_FLAG = {
    "--controller": CONTROLLER,
    "--family": _FAMILY,
    "--motion": NameKind("motion model", lambda: MOTIONS, takes_files=False),
    "--oracle": NameKind("oracle", lambda: _registered("worldgen.oracles")),
    "--to": _FORMAT,
    "--from": _FORMAT,
}
_BY_ARGUMENT = {
    ("behaviours", "controller"): CONTROLLER,
    ("controllers", "name"): CONTROLLER,
    ("check-family", "name"): _FAMILY,
    ("formats", "name"): _FORMAT,
}


def kind_of(command: click.Command, parameter: click.Parameter) -> NameKind | None:
    """Return what a parameter's value names; None if it is not the name of anything."""
    # `find --from` takes a file.
    if isinstance(parameter.type, click.Path):
        return None
    if isinstance(parameter, click.Argument):
        return _BY_ARGUMENT.get((command.name or "", parameter.name or ""))
    return next((_BY_FLAG[flag] for flag in parameter.opts if flag in _BY_FLAG), None)


def names_in_one(command: click.Command, parameter: click.Parameter, text: str) -> list[str]:
    """Return the names in a value such as ``maze,trap``, of an option that takes one at a time.

    Empty if the value is anything else.
    """
    kind = kind_of(command, parameter)
    # `compare` and `corpus` take several controllers in one value.
    if kind is None or kind is CONTROLLER or not parameter.multiple or "," not in text:
        return []
    parts = [part.strip() for part in text.split(",") if part.strip()]
    return parts if all(map(kind.is_named_by, parts)) else []
