"""Finds a controller by name (registered, ``module:name``, ``./file.py:name``, ``cmd:PROGRAM``) and checks it."""

from __future__ import annotations

from typing import Any

from sim.controllers.base import DEFAULT_SENSES, CompiledController, Controller, check_declared
from sim.controllers.process import ProcessController, is_process_name
from sim.robot_options import RobotOptions
from worldgen.errors import InvalidParameter
from worldgen.registry import Registry, check_code, user_code

__all__ = ["CONTROLLERS", "called", "controller_of"]


class _Controllers(Registry[Controller]):
    """A registry in which ``cmd:`` begins the command line of a program."""

    def get(self, name: str) -> Controller:
        if is_process_name(name):
            if name not in self._loaded:
                check_code(name)
                self._loaded[name] = ProcessController.of(name)
            return self._loaded[name]
        return super().get(name)

    def _unknown(self, name: str) -> str:
        return f"{super()._unknown(name)}, or 'cmd:./program --flag'"


def _accept(name: str, thing: Any) -> Controller:
    if isinstance(thing, type):
        with user_code(f"controller {name!r}: making it without arguments"):
            thing = thing()
    if isinstance(thing, CompiledController):
        return thing
    with user_code(f"controller {name!r}: looking at its attributes"):
        act = "act_many" if hasattr(thing, "act_many") else "act"
        missing = [method for method in ("reset", act) if not callable(getattr(thing, method, None))]
        senses, needs = getattr(thing, "senses", DEFAULT_SENSES), getattr(thing, "needs", RobotOptions())
    if missing:
        raise InvalidParameter(
            f"controller {name!r} has no {' and no '.join(missing)}; it needs reset() -> memory and "
            "act(observation, memory) -> (command, memory), or act_many for many robots, or be a CompiledController"
        )
    check_declared(name, senses, needs)
    controller: Controller = thing
    return controller


CONTROLLERS: Registry[Controller] = _Controllers("worldgen.controllers", "controller", _accept)


def controller_of(given: str | Controller | type) -> Controller:
    """The controller of that name, or the thing itself: a controller, or a class that makes one without arguments.

    Raises:
        InvalidParameter: If nothing is called so, it is no controller, or it raises when it is made.
    """
    return CONTROLLERS.get(given) if isinstance(given, str) else _accept(called(given), given)


def called(given: object) -> str:
    """What a controller is called in messages and tables."""
    if isinstance(given, str):
        return given
    kind = type(given).__name__
    with user_code(f"controller {kind!r}: looking at its name"):
        names = [getattr(given, "name", None), getattr(given, "__name__", None), kind]
    return next(name for name in names if isinstance(name, str))
