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

# The watch of this process, and the lines that it has reported, by the module's file. A process of a
# cluster may serve several campaigns, so lines are only reported where one is known to begin.
_watches: list[LineWatch] = []
_reported: dict[str, set[int]] = {}
_serves_one_campaign = [False]


def watch_lines(controller: Any, known: frozenset[int] | None = None) -> LineWatch | None:
    """Watch which lines of a controller's file run from now on.

    Args:
        controller: The controller, made from a class of the user's.
        known: First lines of statements that need not be watched; if omitted, those that this
            process has reported since :func:`begin_lines`. Before that, nothing is watched.

    Returns:
        The watch; ``None`` for a controller without lines in Python, and for one that a compiler
        reads.
    """
    module = _module_of(controller)
    watch = _watches[0] if _watches else None
    wanted = known
    if wanted is None and module is not None and _serves_one_campaign[0]:
        wanted = frozenset(_reported.get(str(module.__file__), ()))
    # What another controller does must not count.
    if watch is not None and (watch.module is not module or watch.known != wanted):
        watch.stop()
        _watches.clear()
        watch = None
    if module is None or wanted is None:
        return None
    if watch is None:
        try:
            watch = LineWatch(module, wanted)
        except WorldgenError:
            return None
        _watches.append(watch)
    watch.clear()
    return watch


def begin_lines() -> None:
    """Watch all lines again: a campaign begins, the only one that this process serves for now."""
    _serves_one_campaign[0] = True
    for watch in _watches:
        watch.stop()
    _watches.clear()
    _reported.clear()


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
