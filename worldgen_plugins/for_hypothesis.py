"""The Hypothesis plug-in: draw reachable worlds from ``st.from_type(World)`` and annotations.

Hypothesis calls :func:`register` whenever it is imported. A type must exist to be registered, but
``worldgen.world`` imports NumPy, so the registration waits until a program imports that module
itself.
"""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

__all__ = ["register"]

_HOME = "worldgen.world"


def register() -> None:
    """Register ``World`` now if its module is loaded, else as soon as it is."""
    module = sys.modules.get(_HOME)
    if hasattr(module, "World"):
        _register(module)
    else:
        sys.meta_path.insert(0, _Awaited())


def _register(module: Any) -> None:
    from hypothesis import strategies as st

    st.register_type_strategy(module.World, _worlds)


def _worlds(_: object) -> Any:
    from fuzz.strategies import worlds

    return worlds()


class _Awaited(MetaPathFinder):
    """A finder that waits for the module: it lets others find it, and watches its execution.

    A program that only looks for the module changes nothing.
    """

    def __init__(self) -> None:
        self._asks_others = False

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return the specification of the other finders, with a loader that reports execution."""
        if fullname != _HOME or self._asks_others:
            return None
        self._asks_others = True
        try:
            spec = importlib.util.find_spec(fullname)
        finally:
            self._asks_others = False
        if spec is not None and spec.loader is not None:
            spec.loader = _Reporting(spec.loader, self)
        return spec


class _Reporting(Loader):
    """Wraps another loader, which it puts back into the module before running it."""

    def __init__(self, loader: Loader, finder: _Awaited) -> None:
        self._loader = loader
        self._finder = finder

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        """Create the module as the other loader does."""
        return self._loader.create_module(spec)

    def exec_module(self, module: ModuleType) -> None:
        """Execute the module, then register its type."""
        module.__loader__ = self._loader
        if module.__spec__ is not None:
            module.__spec__.loader = self._loader
        self._loader.exec_module(module)
        sys.meta_path.remove(self._finder)
        _register(module)
