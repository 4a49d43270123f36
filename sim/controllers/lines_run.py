"""Notice which lines of a user's Python controller have run in this process."""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any

from sim.clock.controller_time import count_lines
from sim.controllers.instances import origin_of
from worldgen.errors import WorldgenError
from worldgen.plugins.counted_code import LineWatch

# Compilers of Python functions, which would compile the counters.
_COMPILERS = ("numba", "taichi")

# The watch of this process, and the lines that it has reported, by the module's file.
_watches: list[LineWatch] = []
_reported: dict[str, set[int]] = {}


def watch_lines(controller: Any, known: frozenset[int] | None = None) -> LineWatch | None:
    """Watch which lines of a controller's file run from now on.

    Args:
        controller: The controller, made from a class of the user's.
        known: First lines of statements that need not be watched; if omitted, those that this
            process has reported.

    Returns:
        The watch; ``None`` for a controller without lines in Python, and for one that a compiler
        reads.
    """
    module = _module_of(controller)
    if module is None:
        return None
    wanted = frozenset(_reported.get(str(module.__file__), ())) if known is None else known
    watch = _watches[0] if _watches else None
    if watch is None or watch.module is not module or watch.known != wanted:
        if watch is not None:
            watch.stop()
            _watches.clear()
        try:
            watch = LineWatch(module, wanted)
        except WorldgenError:
            return None
        _watches.append(watch)
    watch.clear()
    return watch


def report_lines() -> None:
    """Count the lines that have run since they were watched."""
    for watch in _watches:
        ran = watch.ran()
        _reported.setdefault(str(watch.file), set()).update(ran)
        count_lines(ran)


def _module_of(controller: Any) -> ModuleType | None:
    origin = origin_of(controller)
    module = None if origin is None else sys.modules.get(type(controller).__module__)
    if module is None or not str(getattr(module, "__file__", "")).endswith(".py"):
        return None
    for value in vars(module).values():
        name = value.__name__ if isinstance(value, ModuleType) else getattr(value, "__module__", "")
        if str(name).partition(".")[0] in _COMPILERS:
            return None
    return module
