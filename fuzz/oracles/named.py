"""Oracles chosen by ``--oracle``: a function, an optional number, and a check of its answers."""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fuzz.oracles.oracle import Oracle
from fuzz.oracles.trial import Trial
from fuzz.violation import Violation
from sim.verdict import Verdict
from worldgen.errors import InvalidParameter, WorldgenError
from worldgen.plugins.registry import Registry, user_code
from worldgen.support.plain_text import quote
from worldgen.world import Value

OracleFunction = Callable[..., Any]

_DEEPEST = 16  # levels of nested tables and lists
_WRITTEN = re.compile(r"(?P<name>.+?)(?:=(?P<number>[^=:/\\]*))?", re.DOTALL)
_TAKEN = (*Verdict, "breach")


def _accept(name: str, thing: Any) -> OracleFunction:
    """Return a function that can be called with a trial, or with a trial and a number.

    Raises:
        InvalidParameter: If it cannot be called that way.
    """
    if not callable(thing):
        raise InvalidParameter(
            "not-a-function",
            "oracle {name!r} is not a function but {kind}",
            _HOW,
            name=name,
            kind=type(thing).__name__,
        )
    if not 1 <= len(_places(thing)) <= 2:
        raise InvalidParameter(
            "wrong-signature",
            "oracle {name!r} has the signature {signature}",
            _HOW,
            name=name,
            signature=inspect.signature(thing),
        )
    found: OracleFunction = thing
    return found


_HOW = (
    "write a function of a trial, or of a trial and a number; docs/reference/verdicts.md shows one"
)

ORACLES: Registry[OracleFunction] = Registry("worldgen.oracles", "oracle", _accept)


def _places(function: OracleFunction) -> list[inspect.Parameter]:
    """Return the parameters that can be passed by position."""
    kinds = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    return [one for one in inspect.signature(function).parameters.values() if one.kind in kinds]


@dataclass(frozen=True)
class NamedOracle(Oracle):
    """An oracle that a user chose: a function, and possibly a number.

    Args:
        text: The option as written: ``detour=5``.
        function: Called with the trial and the numbers; returns its finding, or ``None``.
        numbers: Empty, or one number.
    """

    by_verdict = False

    text: str
    function: OracleFunction = field(repr=False)
    numbers: tuple[float, ...] = ()

    @classmethod
    def parse(cls, text: str) -> NamedOracle:
        """Read ``NAME`` or ``NAME=NUMBER``.

        Raises:
            InvalidParameter: If there is no such oracle, or if a number is missing or not allowed.
        """
        # Split off the number. A name may contain "=" in a path, so it is only the last part.
        parts = _WRITTEN.fullmatch(text.strip())
        if parts is None:
            raise InvalidParameter(
                "empty-name",
                "an empty text does not name an oracle",
                "use one of {oracles!l}",
                oracles=list(ORACLES),
            )
        name = parts["name"]
        number = parts["number"]
        function = ORACLES.get(name)
        # Buckets begin with the name, so a verdict in its place would be misleading.
        if _plain(name) in _TAKEN:
            raise InvalidParameter(
                "name-is-a-verdict",
                "oracle {name!r} has the name of a verdict",
                "rename it",
                name=name,
            )
        # The function decides whether a number is required, optional or not allowed.
        second = _places(function)[1:]
        if number is None:
            if second and second[0].default is inspect.Parameter.empty:
                raise InvalidParameter(
                    "needs-a-number",
                    "oracle {name!r} needs a number, {number}",
                    "write {name}=5",
                    name=name,
                    number=second[0].name,
                )
            return cls(text.strip(), function)
        if not second:
            raise InvalidParameter(
                "takes-no-number",
                "oracle {name!r} takes no number",
                "write --oracle {name}",
                at_terminal=True,
                name=name,
            )
        return cls(text.strip(), function, (_number(text, number),))

    @property
    def name(self) -> str:
        """The option as written, without the number."""
        return self.text.rpartition("=")[0] if self.numbers else self.text

    def bucket_of(self, facts: Mapping[str, Value]) -> str:
        """Return the bucket of a violation, usable as a file name.

        It consists of the oracle's name and, if present, the fact ``kind``.
        """
        own_name = self.text.partition("=")[0] if ":" not in self.text else self.text
        words = [own_name, str(facts.get("kind", ""))]
        return "-".join(plain for plain in map(_plain, words) if plain)

    def check(self, trial: Trial) -> Violation | None:
        """Return the function's finding in a run; ``None`` if it finds nothing.

        Raises:
            InvalidParameter: If the function fails, or returns something other than ``None`` or a
                table that a file can hold.
        """
        facts = self._facts(trial)
        if facts is None:
            return None
        return Violation(self.bucket_of(facts), trial.episode.evidence, self.text, facts)

    def _facts(self, trial: Trial) -> dict[str, Value] | None:
        try:
            with user_code(f"oracle {self.text!r}"):
                answer = self.function(trial, *self.numbers)
        except InvalidParameter as error:
            # If the oracle itself refuses its number, for example, its code has not failed.
            if isinstance(error.__cause__, WorldgenError):
                raise error.__cause__ from None
            raise
        if answer is None:
            return None
        if not isinstance(answer, Mapping) or not answer or not _fits(answer):
            raise InvalidParameter(
                "wrong-oracle-answer",
                "oracle {text!r} returned {answer}",
                "return None, or a table of evidence: names with booleans, finite numbers, "
                "texts, lists and tables, nested at most {most} deep",
                text=self.text,
                answer=quote(answer),
                most=_DEEPEST,
            )
        return {name: _plain_value(one) for name, one in answer.items()}


def _plain(name: str) -> str:
    """Return the last part of a name, without its path and number, with ``-`` for other signs."""
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
            "oracle {text!r}: {number!r} is not a number",
            "write a number, such as 5 or 1.5",
            text=text,
            number=number,
        )
    return value


def _fits(value: object, depth: int = 0) -> bool:
    """Return True if a `.grid` file can hold this value."""
    if isinstance(value, Mapping | list | tuple):
        parts = value.values() if isinstance(value, Mapping) else value
        named = not isinstance(value, Mapping) or all(isinstance(name, str) for name in value)
        return named and depth < _DEEPEST and all(_fits(one, depth + 1) for one in parts)
    if isinstance(value, float | np.floating):
        return math.isfinite(value)
    return isinstance(value, bool | int | str | np.integer | np.bool_)


def _plain_value(value: Any) -> Any:
    """Return tables as dicts, lists and tuples as lists, NumPy numbers as Python numbers."""
    if isinstance(value, Mapping):
        return {name: _plain_value(one) for name, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain_value(one) for one in value]
    if isinstance(value, np.integer | np.bool_):
        return value.item()
    return float(value) if isinstance(value, float | np.floating) else value
