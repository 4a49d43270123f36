"""The Gymnasium environments; ``import worldgen.gym`` registers them.

Contents, each imported when it is first used:
    NavigateEnv: The single environment.
    NavigateVectorEnv: The vector environment.
    Interface: Sensors and actions; they turn a trained policy into a controller.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from worldgen_plugins.for_gymnasium.interface import Interface
    from worldgen_plugins.for_gymnasium.single import NavigateEnv
    from worldgen_plugins.for_gymnasium.vector import NavigateVectorEnv

__all__ = ["Interface", "NavigateEnv", "NavigateVectorEnv"]

_HOME = {"Interface": "interface", "NavigateEnv": "single", "NavigateVectorEnv": "vector"}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'worldgen_plugins.for_gymnasium' has no attribute {name!r}")
    return getattr(importlib.import_module(f"worldgen_plugins.for_gymnasium.{_HOME[name]}"), name)
