"""Asking an oracle: its name and number as the command line writes them, and its answer, checked."""

from __future__ import annotations

import inspect
import math
import re
import reprlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fuzz.evidence_checks import EVIDENCE_CHECKS
from fuzz.oracles.trial import Trial
from sim.verdict import BY_THE_CONTROLLER
from worldgen.errors import InvalidParameter, WorldgenError
from worldgen.plugins.registry import Registry, user_code
from worldgen.world import Value

__all__ = ["ORACLES", "Asked", "objection_in_words"]

Oracle = Callable[..., Any]

_DEEPEST = 16  # tables and lists in one another
_WRITTEN = re.compile(r"(?P<name>.+?)(?:=(?P<number>[^=:/\\]*))?", re.DOTALL)
_TAKEN = (*EVIDENCE_CHECKS, *BY_THE_CONTROLLER, "breach")


def _accept(name: str, thing: Any) -> Oracle:
    """Whatever can be called with a trial, or with a trial and a number.

    Raises:
        InvalidParameter: If it cannot be called so.
    """
    if not callable(thing):
        raise InvalidParameter(
            "not-a-function", "oracle {name!r} is no function but {kind}", _HOW, name=name, kind=type(thing).__name__
        )
    if not 1 <= len(_places(thing)) <= 2:
        raise InvalidParameter(
            "wrong-signature", "oracle {name!r} takes {signature}", _HOW, name=name, signature=inspect.signature(thing)
        )
    found: Oracle = thing
    return found


_HOW = "write a function of a trial, or of a trial and a number; docs/oracles.md has one"

ORACLES: Registry[Oracle] = Registry("worldgen.oracles", "oracle", _accept)


def _places(oracle: Oracle) -> list[inspect.Parameter]:
    """The parameters that may be given by place."""
    kinds = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    return [one for one in inspect.signature(oracle).parameters.values() if one.kind in kinds]


@dataclass(frozen=True)
class Asked:
    """An oracle and its number.

    Args:
        text: As it was written: ``detour=5``.
        oracle: The function.
        numbers: What it gets beside the trial: nothing, or one number.
    """

    text: str
    oracle: Oracle = field(repr=False)
    numbers: tuple[float, ...] = ()

    @classmethod
    def parse(cls, text: str) -> Asked:
        """Reads ``NAME`` or ``NAME=NUMBER``.

        Raises:
            InvalidParameter: If there is no such oracle, or it wants a number, or none.
        """
        parts = _WRITTEN.fullmatch(text.strip())
        if parts is None:
            raise InvalidParameter(
                "empty-name", "an empty text names no oracle", "give one of {oracles!l}", oracles=list(ORACLES)
            )
        name, number = parts["name"], parts["number"]
        oracle = ORACLES.get(name)
        if _plain(name) in _TAKEN:
            raise InvalidParameter(
                "name-is-a-verdict", "oracle {name!r} is called like a verdict", "give it another name", name=name
            )
        second = _places(oracle)[1:]
        if number is None:
            if second and second[0].default is inspect.Parameter.empty:
                raise InvalidParameter(
                    "needs-a-number",
                    "oracle {name!r} needs a number, {number}",
                    "write {name}=5",
                    name=name,
                    number=second[0].name,
                )
            return cls(text.strip(), oracle)
        if not second:
            raise InvalidParameter(
                "takes-no-number",
                "oracle {name!r} takes no number",
                "write --oracle {name}",
                at_terminal=True,
                name=name,
            )
        return cls(text.strip(), oracle, (_number(text, number),))

    @property
    def name(self) -> str:
        """What it was written with, without its number."""
        return self.text.rpartition("=")[0] if self.numbers else self.text

    def kind(self, objection: Mapping[str, Value]) -> str:
        """The class of a failure that it found: its name, and the objection's ``kind``, fit for a file name."""
        words = [self.text.partition("=")[0] if ":" not in self.text else self.text, str(objection.get("kind", ""))]
        return "-".join(plain for plain in map(_plain, words) if plain)

    def objection(self, trial: Trial) -> dict[str, Value] | None:
        """What the oracle has against a run; ``None`` if nothing.

        Raises:
            InvalidParameter: If the oracle fails, or its answer is no table that a file could hold.
        """
        try:
            with user_code(f"oracle {self.text!r}"):
                answer = self.oracle(trial, *self.numbers)
        except InvalidParameter as error:
            if isinstance(error.__cause__, WorldgenError):
                raise error.__cause__ from None
            raise
        if answer is None:
            return None
        if not isinstance(answer, Mapping) or not answer or not _fits(answer):
            raise InvalidParameter(
                "wrong-oracle-answer",
                "oracle {text!r} answers {answer}",
                "return None, or a table of evidence: names with booleans, finite numbers, "
                "texts, lists and tables, at most {most} in one another",
                text=self.text,
                answer=reprlib.repr(answer),
                most=_DEEPEST,
            )
        return {name: _plain_value(one) for name, one in answer.items()}


def objection_in_words(oracle: str | None, objection: Mapping[str, Value]) -> str:
    """The oracle's objection, to stand behind a failure's verdict; empty without an oracle."""
    if oracle is None:
        return ""
    words = ", ".join(f"{name} {value}" for name, value in objection.items() if name not in ("kind", "repeatable"))
    return f", but oracle {oracle} objects: {words or 'it does'}"


def _plain(name: str) -> str:
    """A name without its place and number, of letters, digits, ``_`` and ``-``."""
    last = name.rpartition(":")[2].partition("=")[0]
    return re.sub(r"[^A-Za-z0-9_]+", "-", last).strip("-")


def _number(text: str, number: str) -> float:
    try:
        value = float(number)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InvalidParameter(
            "not-a-number",
            "oracle {text!r}: {number!r} is no number",
            "write one, such as 5 or 1.5",
            text=text,
            number=number,
        )
    return value


def _fits(value: object, depth: int = 0) -> bool:
    """Whether a `.grid` file can hold it."""
    if isinstance(value, Mapping | list | tuple):
        parts = value.values() if isinstance(value, Mapping) else value
        named = not isinstance(value, Mapping) or all(isinstance(name, str) for name in value)
        return named and depth < _DEEPEST and all(_fits(one, depth + 1) for one in parts)
    if isinstance(value, float | np.floating):
        return math.isfinite(value)
    return isinstance(value, bool | int | str | np.integer | np.bool_)


def _plain_value(value: Any) -> Any:
    """Tables as dicts, lists and tuples as lists, numbers of NumPy as Python's."""
    if isinstance(value, Mapping):
        return {name: _plain_value(one) for name, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain_value(one) for one in value]
    if isinstance(value, np.integer | np.bool_):
        return value.item()
    return float(value) if isinstance(value, float | np.floating) else value
