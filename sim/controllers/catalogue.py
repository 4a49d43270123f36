"""Finds a controller by name: a registered one, ``module:name``, ``./file.py:name``, or ``cmd:PROGRAM``."""

from __future__ import annotations

from typing import Any

from sim.controllers.base import CompiledController, Controller, check_senses
from sim.controllers.process import ProcessController, is_process_name
from worldgen.errors import InvalidParameter
from worldgen.registry import Registry

__all__ = ["CONTROLLERS"]


class _Controllers(Registry[Controller]):
    """A registry in which ``cmd:`` begins the command line of a program."""

    def get(self, name: str) -> Controller:
        if is_process_name(name):
            if name not in self._loaded:
                self._loaded[name] = ProcessController.of(name)
            return self._loaded[name]
        return super().get(name)

    def _unknown(self, name: str) -> str:
        return f"{super()._unknown(name)}, or 'cmd:./program --flag'"


def _accept(name: str, thing: Any) -> Controller:
    if isinstance(thing, CompiledController):
        return thing
    try:
        made = thing() if isinstance(thing, type) else thing
    except Exception as error:
        raise InvalidParameter(
            f"controller {name!r} cannot be made without arguments: {type(error).__name__}: {error}"
        ) from error
    act = "act_many" if hasattr(made, "act_many") else "act"
    missing = [method for method in ("reset", act) if not callable(getattr(made, method, None))]
    if missing:
        raise InvalidParameter(
            f"controller {name!r} has no {' and no '.join(missing)}; it needs reset() -> memory and "
            "act(observation, memory) -> (command, memory), or act_many for many robots, or be a CompiledController"
        )
    check_senses(name, tuple(getattr(made, "senses", ())))
    controller: Controller = made
    return controller


CONTROLLERS: Registry[Controller] = _Controllers("worldgen.controllers", "controller", _accept)
