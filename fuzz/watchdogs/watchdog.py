"""What a watchdog is, and the registered ones."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from sim.controllers.base import Observation
from sim.controllers.fields import with_fields
from sim.controllers.instances import instance_of
from worldgen.errors import InvalidParameter
from worldgen.parameters import split_options
from worldgen.plugins.registry import Registry


class Watchdog(Protocol):
    """Code next to a controller that raises an alarm when the robot no longer makes progress.

    A class attribute or an argument of ``__init__`` that is a number, bool or str is an option of its
    name: ``./mine.py:Progress+allowance=5``. ``needs = RobotOptions(beams=24)`` gives it beams.
    """

    def reset(self) -> None:
        """Begin a run."""

    def step(self, observation: Observation) -> bool:
        """Return True to raise the alarm: the robot will not arrive.

        Args:
            observation: What a robot can know after a step, without noise: pose, contact, target,
                time, speed limit, and beams if the watchdog needs them. The rest is ``nan``.
        """


_HOW = "write a class with reset() and step(observation) -> bool; docs/howto/watchdog.md shows one"


def _accept(name: str, thing: Any) -> type:
    """Return a class that makes watchdogs.

    Raises:
        InvalidParameter: If it is not a class, or lacks a method.
    """
    if not isinstance(thing, type):
        raise InvalidParameter(
            "not-a-watchdog",
            "watchdog {name!r} is not a class but {kind}",
            _HOW,
            name=name,
            kind=type(thing).__name__,
        )
    lacking = [method for method in ("reset", "step") if not callable(getattr(thing, method, None))]
    if lacking:
        raise InvalidParameter(
            "not-a-watchdog",
            "watchdog {name!r} has no method {lacking!l}",
            _HOW,
            name=name,
            lacking=lacking,
        )
    return thing


WATCHDOGS: Registry[type] = Registry("worldgen.watchdogs", "watchdog", _accept)


def watchdog_named(name: str) -> Watchdog:
    """Return a watchdog by its name, which may set its fields.

    Args:
        name: ``simple-progress``, ``./mine.py:Progress`` or ``simple-progress+allowance=5``.

    Raises:
        InvalidParameter: If nothing has this name, it is not a watchdog, or a field is wrong.
    """
    base, words = split_options(name, "simple-progress+allowance=5") if "+" in name else (name, {})
    kind = WATCHDOGS.get(base)
    made: Callable[[], Watchdog] = lambda: instance_of(kind, f"watchdog {base!r}")  # noqa: E731
    watchdog: Watchdog = with_fields(made(), kind, words, base) if words else made()
    return watchdog
