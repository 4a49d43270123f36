"""Families: named, versioned generators of worlds."""

from __future__ import annotations

import functools
import importlib
import inspect
import math
import re
import typing
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from worldgen.errors import InvalidParameter
from worldgen.random_streams import RandomStream
from worldgen.registry import Registry
from worldgen.world import Value, World

__all__ = [
    "FAMILIES",
    "MARGIN",
    "RECIPE",
    "Family",
    "FamilyRegistry",
    "Parameter",
    "check_at_least",
    "check_between",
    "check_choice",
    "check_positive",
    "family",
    "stream_for",
]

Build = Callable[..., World]

MARGIN = "margin"  # of every parameter so called: seconds by which the witness may begin later
# parameters of generate(), and options of every family's command
_TAKEN = (
    "name",
    "seed",
    "count",
    "out",
    "force",
    "json",
    "as_json",
    "help",
    "metrics",
    "where",
    "difficulty",
    "tries",
    "workers",
)
_INT64 = 2**63  # a file holds no larger whole number


@dataclass(frozen=True)
class Parameter:
    """One parameter of a family, as its function declares it.

    Args:
        name: Name in Python; on the command line with dashes.
        default: Its type is the parameter's type: bool, int, float or str.
        choices: The words allowed, from a ``Literal`` annotation; empty if there is none.
        help: Its entry in the docstring's ``Args``, on one line.
    """

    name: str
    default: bool | int | float | str
    choices: tuple[str, ...] = ()
    help: str = ""

    def accept(self, value: Value, family_name: str) -> Value:
        """The value, as a float where the default is one.

        Raises:
            InvalidParameter: If it has another type than the default, or is none of the choices.
        """
        kind = type(self.default)
        if kind is float and type(value) is int:
            value = float(value)
        if type(value) is not kind:
            raise InvalidParameter(
                f"{family_name}: {self.name}={value!r} is a {type(value).__name__}; give a {kind.__name__}"
            )
        if isinstance(value, int) and not -_INT64 <= value < _INT64:
            raise InvalidParameter(f"{family_name}: {self.name} is a number of more than 64 bits; give a smaller one")
        if isinstance(value, float) and not math.isfinite(value):
            raise InvalidParameter(f"{family_name}: {self.name}={value} is not finite; give a finite number")
        if self.choices:
            check_choice(self.name, str(value), self.choices)
        return value


@dataclass(frozen=True)
class Family:
    """A generator of worlds; :func:`worldgen.generation.generate` runs it and proves what it makes.

    Args:
        name: The world's noun, as on the command line.
        version: Goes up whenever some seed yields another world than before.
        build: ``build(rng, **params) -> World``, all parameters keyword-only with defaults.
        changes: Whether its worlds change with time, so that no other family can change them.
        constants: What beside the parameters makes its worlds what they are, such as the text of a recipe; it goes
            with them into provenance and, from there, back to ``generate``, which refuses any other.
    """

    name: str
    version: int
    build: Build
    changes: bool = False
    constants: Mapping[str, Value] = field(default_factory=dict)

    @functools.cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """What can be set, in order of declaration.

        Raises:
            InvalidParameter: If an annotation names what cannot be found at run time.
        """
        try:
            hints = typing.get_type_hints(self.build)
        except NameError as error:
            raise InvalidParameter(
                f"family {self.name!r}: {error}; import what its annotations name outside TYPE_CHECKING"
            ) from error
        notes = _argument_notes(self.build.__doc__ or "")
        return tuple(
            Parameter(name, parameter.default, _choices(hints.get(name)), notes.get(name, ""))
            for name, parameter in list(inspect.signature(self.build).parameters.items())[1:]
        )

    @property
    def description(self) -> str:
        """The docstring up to its first section."""
        text = inspect.cleandoc(self.build.__doc__ or "")
        return re.split(r"^(?:Args|Returns|Raises|Source):", text, maxsplit=1, flags=re.MULTILINE)[0].strip()

    def defaults(self) -> dict[str, Value]:
        """Every parameter with its default, in order of declaration."""
        return {parameter.name: parameter.default for parameter in self.parameters}

    def options(self, params: Mapping[str, Value]) -> list[str]:
        """What to type after the family's name for these parameters; those that are defaults are left out."""
        words: list[str] = []
        for parameter in self.parameters:
            value, flag = params.get(parameter.name, parameter.default), parameter.name.replace("_", "-")
            if value == parameter.default:
                continue
            if isinstance(value, bool):
                words.append(f"--{flag}" if value else f"--no-{flag}")
            else:
                words += [f"--{flag}", str(value)]
        return words

    def complete(self, params: Mapping[str, Value]) -> dict[str, Value]:
        """The parameters with defaults filled in.

        Raises:
            InvalidParameter: If a name is unknown, or a value has another type than the default.
        """
        known = {parameter.name: parameter for parameter in self.parameters}
        for name in params:
            if name in self.constants:
                self._check_constant(name, params[name])
            elif name not in known:
                raise InvalidParameter(f"{self.name} has no parameter {name!r}; it has {', '.join(known)}")
        complete = {
            name: parameter.accept(params.get(name, parameter.default), self.name) for name, parameter in known.items()
        }
        return {**complete, **self.constants}

    def _check_constant(self, name: str, value: Value) -> None:
        if value != self.constants[name]:
            raise InvalidParameter(
                f"{self.name}: {name} is {str(value)[:60]!r}, here it is {str(self.constants[name])[:60]!r}; this "
                "version makes other worlds: take the one that the world was made with"
            )


def _choices(hint: Any) -> tuple[str, ...]:
    return typing.get_args(hint) if typing.get_origin(hint) is typing.Literal else ()


def _argument_notes(docstring: str) -> dict[str, str]:
    """The entries of a Google-style ``Args`` section, each on one line."""
    section = re.search(r"^Args:\n((?:[ ]+.*\n?|\n)+)", inspect.cleandoc(docstring), re.MULTILINE)
    if section is None:
        return {}
    entries = re.split(r"^ {4}(\w+): ", section.group(1), flags=re.MULTILINE)[1:]
    return {name: " ".join(note.split()) for name, note in zip(entries[::2], entries[1::2], strict=True)}


def _check_signature(name: str, build: Build) -> None:
    for parameter in list(inspect.signature(build).parameters.values())[1:]:
        if parameter.kind is not inspect.Parameter.KEYWORD_ONLY or parameter.name in _TAKEN:
            raise InvalidParameter(
                f"family {name!r}: parameter {parameter.name!r} must stand after *, "
                f"and be called none of {', '.join(_TAKEN)}"
            )
        if type(parameter.default) not in (bool, int, float, str):
            raise InvalidParameter(
                f"family {name!r}: parameter {parameter.name!r} needs a default that is a bool, int, float or str"
            )
        if parameter.name == MARGIN and type(parameter.default) is not float:
            raise InvalidParameter(
                f"family {name!r}: {MARGIN} is the margin in seconds that the witness gets; give it a default that is "
                "a float, or call the parameter something else"
            )


def family(name: str, *, version: int, changes: bool = False) -> Callable[[Build], Family]:
    """Makes a family of a function ``(rng, *, size=..., ...) -> World``; register it as an entry point.

    A parameter called ``margin`` has a meaning of its own: so many seconds later than at once may the robot set out
    on the witness that the world gets, and still arrive.

    Args:
        name: The world's noun.
        version: Of what seeds yield.
        changes: Whether its worlds change with time.

    Raises:
        InvalidParameter: If a parameter is positional, has no plain default, or is called name or seed, or
            ``margin`` is no float.
    """

    def decorate(build: Build) -> Family:
        _check_signature(name, build)
        made = Family(name, version, build, changes)
        object.__setattr__(made, "__doc__", build.__doc__)
        return made

    return decorate


def _accept(name: str, thing: Any) -> Family:
    if not isinstance(thing, Family):
        raise InvalidParameter(f"family {name!r} is {thing!r}, not a Family; decorate its function with @family")
    return thing


class FamilyRegistry(Registry[Family]):
    """Families by entry point, as ``package.module:name``, ``./file.py:name`` or ``./recipe.toml``."""

    _last: tuple[tuple[object, ...], Family | None] = ((), None)

    def get(self, name: str) -> Family:
        """The family called ``name``; a recipe is read afresh each time.

        Raises:
            InvalidParameter: If nothing is called so, or what is found is no family.
            FormatError: If it is a recipe with a fault.
        """
        if name.endswith(".toml"):
            return self._from_recipe(name)
        return super().get(name)

    def find(self, name: str, params: Mapping[str, Value]) -> Family:
        """The family that provenance names; of a recipe's world the text is among the parameters.

        Raises:
            InvalidParameter: If there is no such family, or the recipe is another's.
            FormatError: If the recipe has a fault.
        """
        text, files = params.get("recipe"), params.get("files", {})
        if not ((name.startswith(RECIPE) or name.endswith(".toml")) and isinstance(text, str)):
            return self.get(name)
        if not isinstance(files, dict) or not all(isinstance(file, str) for file in files.values()):
            raise InvalidParameter(f"{name}: files is no table of texts; take it as it stands in a world's provenance")
        folder = Path(name).parent if name.endswith(".toml") else None
        key = (text, folder, *sorted((file, str(content)) for file, content in files.items()))
        if key != self._last[0]:  # a set asks for the same one again and again
            self._last = (key, self._from_recipe(text, files=files, folder=folder))
        made_by = self._last[1]
        if made_by is None or (made_by.name != name and name.startswith(RECIPE)):
            other = made_by.name if made_by else "none"
            raise InvalidParameter(f"{name}: its recipe is that of {other}; name that, or give the other recipe")
        return made_by

    def _from_recipe(self, recipe: str, **options: Any) -> Family:
        module = importlib.import_module("worldgen.compose.recipe")  # it builds on families, so it comes late
        made_by: Family = module.family_from_recipe(recipe, **options)
        return made_by


RECIPE = "recipe:"  # begins the name of every family that a recipe makes
FAMILIES = FamilyRegistry("worldgen.families", "family", _accept)


def check_at_least(name: str, value: float, minimum: float, unit: str = "") -> None:
    """Refuses a parameter below its minimum.

    Raises:
        InvalidParameter: Naming value, rule and way out.
    """
    if not value >= minimum:
        raise InvalidParameter(
            f"{name}={_shown(value, unit)} is below {_shown(minimum, unit)}; give at least {_shown(minimum)}"
        )


def check_between(name: str, value: float, low: float, high: float, unit: str = "") -> None:
    """Refuses a parameter outside [low, high].

    Raises:
        InvalidParameter: Naming value, rule and way out.
    """
    if not low <= value <= high:
        raise InvalidParameter(
            f"{name}={_shown(value, unit)} is outside {_shown(low)} to {_shown(high, unit)}; give one between"
        )


def check_positive(name: str, value: float, unit: str = "") -> None:
    """Refuses zero, less than zero, and what is no finite number.

    Raises:
        InvalidParameter: Naming value and rule.
    """
    if not (math.isfinite(value) and value > 0.0):
        raise InvalidParameter(f"{name}={_shown(value, unit)} is not a finite number above 0; give one")


def _shown(value: float, unit: str = "") -> str:
    number = str(value) if isinstance(value, int) else f"{value:g}"
    return f"{number} {unit}" if unit else number


def check_choice(name: str, value: str, choices: tuple[str, ...]) -> None:
    """Refuses a word that is not one of the choices.

    Raises:
        InvalidParameter: Naming value and choices.
    """
    if value not in choices:
        raise InvalidParameter(f"{name}={value!r} is not one of {', '.join(choices)}; give one of these")


def stream_for(seed: int, family_name: str, attempt: int) -> RandomStream:
    """The stream that one attempt of one family draws from."""
    return RandomStream(seed).child(family_name, attempt)
