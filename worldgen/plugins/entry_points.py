"""Read the entry points of installed packages, and cache them.

Reading them takes as long as importing a large library.
"""

from __future__ import annotations

import functools
import sys
from importlib.metadata import EntryPoint, entry_points
from typing import Any


def points_of(group: str) -> tuple[EntryPoint, ...]:
    """Return the entry points of a group, such as ``worldgen.families``.

    The cache is per ``sys.path``, so a changed path is read again.
    """
    return _points(group, tuple(sys.path))


@functools.cache
def _points(group: str, path: tuple[str, ...]) -> tuple[EntryPoint, ...]:
    return tuple(_all(path).select(group=group))


@functools.cache
def _all(_path: tuple[str, ...]) -> Any:
    return entry_points()
