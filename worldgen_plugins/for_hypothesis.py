"""The Hypothesis plug-in.

``st.from_type(World)``, and ``@given`` from annotations, draw reachable worlds. Hypothesis calls
:func:`register` whenever it is imported. A type must exist to be registered, and ``worldgen.world``
imports NumPy, so the registration waits until a program imports that module itself.
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
    """Registers ``World`` now if its module is there, else as soon as it is."""
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
    """Lets others find the module, and registers when it has been executed.

    Who only looks for it changes nothing.
    """

    def __init__(self) -> None:
        self._asks_others = False

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """The specification that the other finders give, with a loader that reports."""
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
    """Another loader, which it puts back into the module before that is executed."""

    def __init__(self, loader: Loader, finder: _Awaited) -> None:
        self._loader = loader
        self._finder = finder

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        """As the other loader does."""
        return self._loader.create_module(spec)

    def exec_module(self, module: ModuleType) -> None:
        """Executes the module, then registers its type."""
        module.__loader__ = self._loader
        if module.__spec__ is not None:
            module.__spec__.loader = self._loader
        self._loader.exec_module(module)
        sys.meta_path.remove(self._finder)
        _register(module)
