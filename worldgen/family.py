"""Families: named, versioned generators of worlds."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from worldgen.errors import InvalidParameter
from worldgen.random_streams import RandomStream
from worldgen.registry import Registry
from worldgen.world import Value, World

__all__ = ["FAMILIES", "Family", "check_at_least", "check_between", "check_choice", "family"]

Build = Callable[..., World]


@dataclass(frozen=True)
class Family:
    """A generator of worlds; :func:`worldgen.generation.generate` runs it and proves what it makes.

    Args:
        name: The world's noun, as on the command line.
        version: Goes up whenever some seed yields another world than before.
        build: ``build(rng, **params) -> World``, all parameters keyword-only with defaults.
    """

    name: str
    version: int
    build: Build

    def defaults(self) -> dict[str, Value]:
        """Every parameter with its default, in order of declaration."""
        parameters = list(inspect.signature(self.build).parameters.values())[1:]
        return {parameter.name: parameter.default for parameter in parameters}

    def complete(self, params: Mapping[str, Value]) -> dict[str, Value]:
        """The parameters with defaults filled in.

        Raises:
            InvalidParameter: If a name is unknown, or a value has another type than the default.
        """
        defaults = self.defaults()
        for name, value in params.items():
            if name not in defaults:
                raise InvalidParameter(f"{self.name} has no parameter {name!r}; it has {', '.join(defaults)}")
            default = defaults[name]
            fits = type(value) is type(default) or (isinstance(default, float) and type(value) is int)
            if not fits:
                raise InvalidParameter(f"{self.name}: {name}={value!r} must be a {type(default).__name__}")
        merged = {**defaults, **params}
        return {name: float(value) if isinstance(defaults[name], float) else value for name, value in merged.items()}  # type: ignore[arg-type]


def family(name: str, *, version: int) -> Callable[[Build], Family]:
    """Makes a family of a function ``(rng, *, size=..., ...) -> World``; register it as an entry point."""

    def decorate(build: Build) -> Family:
        made = Family(name, version, build)
        object.__setattr__(made, "__doc__", build.__doc__)
        return made

    return decorate


def _accept(name: str, thing: Any) -> Family:
    if not isinstance(thing, Family):
        raise InvalidParameter(f"family {name!r} is {thing!r}, not a Family; decorate its function with @family")
    return thing


FAMILIES: Registry[Family] = Registry("worldgen.families", "family", _accept)


def check_at_least(name: str, value: float, minimum: float, unit: str = "") -> None:
    """Refuses a parameter below its minimum.

    Raises:
        InvalidParameter: Naming value, rule and way out.
    """
    if not value >= minimum:
        unit = f" {unit}" if unit else ""
        raise InvalidParameter(f"{name}={value:g}{unit} is below {minimum:g}{unit}; give at least {minimum:g}")


def check_between(name: str, value: float, low: float, high: float, unit: str = "") -> None:
    """Refuses a parameter outside [low, high].

    Raises:
        InvalidParameter: Naming value, rule and way out.
    """
    if not low <= value <= high:
        unit = f" {unit}" if unit else ""
        raise InvalidParameter(f"{name}={value:g}{unit} is outside {low:g} to {high:g}{unit}")


def check_choice(name: str, value: str, choices: tuple[str, ...]) -> None:
    """Refuses a word that is not one of the choices.

    Raises:
        InvalidParameter: Naming value and choices.
    """
    if value not in choices:
        raise InvalidParameter(f"{name}={value!r} is not one of {', '.join(choices)}")


def stream_for(seed: int, family_name: str, attempt: int) -> RandomStream:
    """The stream that one attempt of one family draws from."""
    return RandomStream(seed).child(family_name, attempt)
