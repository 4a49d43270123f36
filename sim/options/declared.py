"""Sets of named options: checked when made, stored where they are not at their default, read from text."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, ClassVar, Self

import numpy as np

from worldgen.errors import InvalidParameter
from worldgen.world import Value

__all__ = ["Switches"]

_WORDS = {int: "whole number", float: "number", str: "word", tuple: "list of numbers"}


@dataclass(frozen=True)
class Switches:
    """Base of option sets: dataclasses of booleans, numbers, words and tuples of numbers, each with a default."""

    RANGES: ClassVar[Mapping[str, tuple[float, float, str]]] = {}
    """Least and greatest value of each number, and its unit, to be put behind it."""
    CHOICES: ClassVar[Mapping[str, tuple[str, ...]]] = {}
    """The words that each option may be."""
    EXAMPLES: ClassVar[Mapping[str, str]] = {}
    """Texts that show how an option is written, where its default does not."""
    TOGETHER: ClassVar[Mapping[str, tuple[str, ...]]] = {}
    """Names that switch on several options."""
    GROUPS: ClassVar[Mapping[str, tuple[str, ...]]] = {}
    """Headings under which a form shows the options; each option stands under one."""

    def __post_init__(self) -> None:
        for name, (low, high, unit) in self.RANGES.items():
            value, kind = getattr(self, name), type(getattr(type(self), name))
            if not _is_number(value, kind):
                raise InvalidParameter(
                    "not-a-number",
                    "{name}={value!r} is no {kind}",
                    "give one from {low:g} to {high:g}",
                    name=name,
                    value=value,
                    kind=_WORDS[kind],
                    low=low,
                    high=high,
                )
            if not (math.isfinite(value) and low <= value <= high):
                raise InvalidParameter(
                    "out-of-range",
                    "{name}={value:g} is outside {low:g} to {high:g}{unit}",
                    "give one between",
                    name=name,
                    value=value,
                    low=low,
                    high=high,
                    unit=unit,
                )
        for name, choices in self.CHOICES.items():
            if getattr(self, name) not in choices:
                raise InvalidParameter(
                    "unknown-name",
                    "{name}={value!r} is not one of {known!l}",
                    name=name,
                    value=getattr(self, name),
                    known=list(choices),
                )

    def changed(self) -> dict[str, Value]:
        """The options that are not at their default, in order of declaration."""
        values = {f.name: getattr(self, f.name) for f in fields(self) if getattr(self, f.name) != f.default}
        return {name: list(value) if isinstance(value, tuple) else value for name, value in values.items()}

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """The options' names."""
        return tuple(f.name for f in fields(cls))

    @classmethod
    def of(cls, values: Mapping[str, Value]) -> Self:
        """Options from names and values of the right types.

        Raises:
            InvalidParameter: If a name is unknown or a value has the wrong type.
        """
        known = {f.name: f.default for f in fields(cls)}
        for name, value in values.items():
            if name not in known:
                raise InvalidParameter(
                    "unknown-name", "option {name!r} is unknown", "known: {known!l}", name=name, known=list(known)
                )
            default = known[name]
            if isinstance(default, tuple):
                if not isinstance(value, list | tuple) or not all(_is_plain_number(number) for number in value):
                    raise InvalidParameter(
                        "wrong-type",
                        "option {name}={value!r} must be a list or tuple of numbers",
                        name=name,
                        value=value,
                    )
            elif type(value) is not type(default) and not (isinstance(default, float) and type(value) is int):
                raise InvalidParameter(
                    "wrong-type",
                    "option {name}={value!r} must be a {kind}",
                    name=name,
                    value=value,
                    kind=type(default).__name__,
                )
        return cls(**{name: _as_type(known[name], value) for name, value in values.items()})

    @classmethod
    def parse(cls, name: str, text: str | None) -> dict[str, Value]:
        """One option as it is written on the command line.

        Args:
            name: Of the option, with dashes or underscores, or of several that are switched on together.
            text: Its value; ``None`` for a flag.

        Raises:
            InvalidParameter: If the option is unknown, or the text is no value for it.
        """
        name = name.replace("-", "_")
        if name in cls.TOGETHER and text in (None, "true"):
            return dict.fromkeys(cls.TOGETHER[name], True)
        known: dict[str, Any] = {f.name: f.default for f in fields(cls)}
        if name not in known:
            names = ["motion", "time_step", *cls.TOGETHER, *known]
            close = difflib.get_close_matches(name, names, n=1)
            hint = f"did you mean {close[0]!r}? " if close else ""
            raise InvalidParameter(
                "unknown-name",
                "option {name!r} is unknown",
                "{hint}known: {known!l}",
                name=name,
                hint=hint,
                known=list(names),
            )
        kind = type(known[name])
        if kind is bool:
            words = {None: True, "true": True, "false": False}
            if text not in words:
                raise InvalidParameter(
                    "not-a-truth-value",
                    "option {name}={text!r} is neither true nor false",
                    "write +{name} to switch it on",
                    name=name,
                    text=text,
                )
            return {name: words[text]}
        example = cls.EXAMPLES.get(name, known[name])
        if text is None:
            raise InvalidParameter(
                "option-needs-value",
                "option {name!r} needs a value",
                "write +{name}={example}",
                name=name,
                example=example,
            )
        try:
            return {name: [float(word) for word in text.split(":")] if kind is tuple else kind(text)}
        except ValueError:
            raise InvalidParameter(
                "not-a-number",
                "option {name}={text!r} is no {kind}",
                "write one like {example}",
                name=name,
                text=text,
                kind=_WORDS[kind],
                example=example,
            ) from None


def _is_number(value: object, kind: type) -> bool:
    return isinstance(value, int | float | np.integer | np.floating) and not (kind is int and value % 1)


def _is_plain_number(value: Any) -> bool:
    return _is_number(value, float) and not isinstance(value, bool)


def _as_type(default: Any, value: Any) -> Any:
    if isinstance(default, tuple):
        return tuple(map(float, value))
    return float(value) if isinstance(default, float) else value
