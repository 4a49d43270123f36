"""Parameters as functions declare them: keyword-only, with a plain default that gives the type."""

from __future__ import annotations

import contextlib
import inspect
import math
import re
import typing
from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Any

from worldgen.errors import InvalidParameter
from worldgen.world import Value

__all__ = [
    "Bounds",
    "Parameter",
    "argument_notes",
    "check_at_least",
    "check_between",
    "check_choice",
    "check_declared",
    "check_positive",
    "parameters_of",
]

_INT64 = 2**63  # a file holds no larger whole number
_PLAIN = (bool, int, float, str)
_SWITCH = {"on": True, "true": True, "yes": True, "1": True, "off": False, "false": False, "no": False, "0": False}


@dataclass(frozen=True)
class Bounds:
    """What a number may be, said where its parameter is declared: ``size: Annotated[int, Bounds(10, 2000, "cells")]``.

    Args:
        low: The least; None: any.
        high: The most; None: any.
        unit: Of both, for people.
        above: Whether ``low`` itself is too low.
        chosen: One number that is allowed too, such as -1 for "the family chooses".
    """

    low: float | None = None
    high: float | None = None
    unit: str = ""
    above: bool = False
    chosen: float | None = None

    @property
    def words(self) -> str:
        """As people read it: ``10 to 2000 cells, or -1``."""
        unit = f" {self.unit}" if self.unit else ""
        if self.low is None:
            said = "" if self.high is None else f"at most {_shown(self.high)}{unit}"
        elif self.above:
            said = f"above {_shown(self.low)}{unit}" + ("" if self.high is None else f", up to {_shown(self.high)}")
        elif self.high is None:
            said = f"at least {_shown(self.low)}{unit}"
        else:
            said = f"{_shown(self.low)} to {_shown(self.high)}{unit}"
        return said if self.chosen is None or not said else f"{said}, or {_shown(self.chosen)}"

    def check(self, name: str, value: float) -> None:
        """Refuses a number outside.

        Raises:
            InvalidParameter: Naming value, rule and way out.
        """
        if self.chosen is not None and value == self.chosen:
            return
        too_low = self.low is not None and not (value > self.low if self.above else value >= self.low)
        if not too_low and (self.high is None or value <= self.high):
            return
        facts: dict[str, Any] = {"name": name, "value": value, "low": self.low, "high": self.high, "unit": self.unit}
        or_chosen = "" if self.chosen is None else ", or {chosen!n}"
        if self.low is not None and self.high is not None and not self.above:
            raise InvalidParameter(
                "out-of-range",
                "{name}={value!n}{unit!u} is outside {low!n} to {high!n}{unit!u}",
                "give one between" + or_chosen,
                chosen=self.chosen,
                **facts,
            )
        if self.low is not None and self.high is None and not self.above:
            raise InvalidParameter(
                "below-minimum",
                "{name}={value!n}{unit!u} is below {low!n}{unit!u}",
                "give at least {low!n}" + or_chosen,
                chosen=self.chosen,
                **facts,
            )
        if self.low is not None and self.high is None:
            problem = "{name}={value!n}{unit!u} is not a finite number above {low!n}"
        else:
            problem = "{name}={value!n}{unit!u} is not {rule}"
        raise InvalidParameter("out-of-range", problem, "give one", rule=self.words, **facts)


@dataclass(frozen=True)
class Parameter:
    """One parameter of a family or a format, as its function declares it.

    Args:
        name: Name in Python; on the command line with dashes.
        default: Its type is the parameter's type: bool, int, float or str.
        choices: The words allowed, from a ``Literal`` annotation; empty if there is none.
        help: Its entry in the docstring's ``Args``, on one line.
        bounds: What a number may be, from ``Annotated``; None if only the function itself can say.
    """

    name: str
    default: bool | int | float | str
    choices: tuple[str, ...] = ()
    help: str = ""
    bounds: Bounds | None = None

    def accept(self, value: Value, owner: str) -> Value:
        """The value, as a float where the default is one.

        Raises:
            InvalidParameter: If it has another type than the default, is out of bounds, or none of the choices.
        """
        kind = type(self.default)
        if kind is float and type(value) is int:
            with contextlib.suppress(OverflowError):  # what no float holds is refused as it is
                value = float(value)
        if isinstance(value, int) and not -_INT64 <= value < _INT64:
            raise InvalidParameter(
                "too-large",
                "{owner}: {name} is a number of more than 64 bits",
                "give a smaller one",
                owner=owner,
                name=self.name,
            )
        if type(value) is not kind:
            raise InvalidParameter(
                "wrong-type",
                "{owner}: {name}={value!r} is a {kind}",
                "give a {expected}",
                owner=owner,
                name=self.name,
                value=value,
                kind=type(value).__name__,
                expected=kind.__name__,
            )
        if isinstance(value, float) and not math.isfinite(value):
            raise InvalidParameter(
                "not-finite",
                "{owner}: {name}={value} is not finite",
                "give a finite number",
                owner=owner,
                name=self.name,
                value=value,
            )
        if self.choices:
            check_choice(self.name, str(value), self.choices)
        if self.bounds is not None and isinstance(value, int | float):
            self.bounds.check(self.name, value)
        return value

    def parse(self, text: str | None, owner: str) -> Value:
        """The value that a word says: ``+mode=scale``, ``+negate`` or ``+negate=on``.

        Args:
            text: The word; None where nothing but the name was said.
            owner: What the parameter belongs to, for messages.

        Raises:
            InvalidParameter: If the word is no value of the parameter's type, or is missing.
        """
        kind = type(self.default)
        if kind is bool:
            if text is not None and text.lower() not in _SWITCH:
                raise InvalidParameter(
                    "unknown-name",
                    "{owner}: {name}={text!r} is neither on nor off",
                    "write one of these",
                    owner=owner,
                    name=self.name,
                    text=text[:40],
                )
            return text is None or _SWITCH[text.lower()]
        if not text:
            example = self.choices[-1] if self.choices else self.default
            raise InvalidParameter(
                "missing-value",
                "{owner}: {name} needs a value",
                "write {name}={example}",
                owner=owner,
                name=self.name,
                example=example,
            )
        try:
            return self.accept(kind(text), owner)
        except ValueError as error:
            if isinstance(error, InvalidParameter):
                raise
            number = "whole number" if kind is int else "number"
            raise InvalidParameter(
                "not-a-number",
                "{owner}: {name}={text!r} is no {expected}",
                "write one",
                owner=owner,
                name=self.name,
                text=text[:40],
                expected=number,
            ) from error


def parameters_of(function: Callable[..., Any], owner: str) -> tuple[Parameter, ...]:
    """The keyword-only parameters of a function, in order of declaration.

    Args:
        function: As :func:`check_declared` accepts it.
        owner: What it belongs to, for messages.

    Raises:
        InvalidParameter: If an annotation names what cannot be found at run time.
    """
    try:
        hints = typing.get_type_hints(function, include_extras=True)
    except NameError as error:
        raise InvalidParameter(
            "wrong-declaration",
            "{owner}: {reason}",
            "import what its annotations name outside TYPE_CHECKING",
            owner=owner,
            reason=str(error),
        ) from error
    notes = argument_notes(function.__doc__ or "")
    return tuple(
        Parameter(name, parameter.default, _choices(hints.get(name)), notes.get(name, ""), _bounds(hints.get(name)))
        for name, parameter in inspect.signature(function).parameters.items()
        if parameter.kind is inspect.Parameter.KEYWORD_ONLY
    )


def check_declared(
    function: Callable[..., Any], owner: str, taken: Collection[str] = (), *, positional: int = 1
) -> None:
    """Refuses a function whose parameters do not all stand after ``*`` with a plain default.

    Args:
        function: The function.
        owner: What it belongs to, for messages.
        taken: Names that mean something else.
        positional: How many parameters come before.

    Raises:
        InvalidParameter: Naming the first parameter at fault.
    """
    for parameter in list(inspect.signature(function).parameters.values())[positional:]:
        if parameter.kind is not inspect.Parameter.KEYWORD_ONLY or parameter.name in taken:
            but = f", and be called none of {', '.join(taken)}" if taken else ""
            raise InvalidParameter(
                "wrong-declaration",
                "{owner}: parameter {name!r} must stand after *{arguments}",
                owner=owner,
                name=parameter.name,
                arguments=but,
            )
        if type(parameter.default) not in _PLAIN:
            raise InvalidParameter(
                "wrong-declaration",
                "{owner}: parameter {name!r} needs a default that is a bool, int, float or str",
                owner=owner,
                name=parameter.name,
            )


def _choices(hint: Any) -> tuple[str, ...]:
    return typing.get_args(hint) if typing.get_origin(hint) is typing.Literal else ()


def _bounds(hint: Any) -> Bounds | None:
    return next((note for note in getattr(hint, "__metadata__", ()) if isinstance(note, Bounds)), None)


def argument_notes(docstring: str) -> dict[str, str]:
    """The entries of a docstring's ``Args`` section, Google style, each on one line."""
    section = re.search(r"^Args:\n((?:[ ]+.*\n?|\n)+)", inspect.cleandoc(docstring), re.MULTILINE)
    if section is None:
        return {}
    entries = re.split(r"^ {4}(\w+): ", section.group(1), flags=re.MULTILINE)[1:]
    return {name: " ".join(note.split()) for name, note in zip(entries[::2], entries[1::2], strict=True)}


def check_at_least(name: str, value: float, minimum: float, unit: str = "") -> None:
    """Refuses a parameter below its minimum.

    Raises:
        InvalidParameter: Naming value, rule and way out.
    """
    if not value >= minimum:
        raise InvalidParameter(
            "below-minimum",
            "{name}={value!n}{unit!u} is below {low!n}{unit!u}",
            "give at least {low!n}",
            name=name,
            value=value,
            low=minimum,
            unit=unit,
        )


def check_between(name: str, value: float, low: float, high: float, unit: str = "") -> None:
    """Refuses a parameter outside [low, high].

    Raises:
        InvalidParameter: Naming value, rule and way out.
    """
    if not low <= value <= high:
        raise InvalidParameter(
            "out-of-range",
            "{name}={value!n}{unit!u} is outside {low!n} to {high!n}{unit!u}",
            "give one between",
            name=name,
            value=value,
            low=low,
            high=high,
            unit=unit,
        )


def check_positive(name: str, value: float, unit: str = "") -> None:
    """Refuses zero, less than zero, and what is no finite number.

    Raises:
        InvalidParameter: Naming value and rule.
    """
    if not (math.isfinite(value) and value > 0.0):
        raise InvalidParameter(
            "not-positive",
            "{name}={value!n}{unit!u} is not a finite number above 0",
            "give one",
            name=name,
            value=value,
            unit=unit,
        )


def _shown(value: float, unit: str = "") -> str:
    number = str(value) if isinstance(value, int) else f"{value:g}"
    return f"{number} {unit}" if unit else number


def check_choice(name: str, value: str, choices: tuple[str, ...]) -> None:
    """Refuses a word that is not one of the choices.

    Raises:
        InvalidParameter: Naming value and choices.
    """
    if value not in choices:
        raise InvalidParameter(
            "unknown-name",
            "{name}={value!r} is not one of {choices!l}",
            "give one of these",
            name=name,
            value=value,
            choices=list(choices),
        )
