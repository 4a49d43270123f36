"""Limits of numbers, and the checks that reject values outside them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from worldgen.errors import InvalidParameter


@dataclass(frozen=True)
class Bounds:
    """Limits of a number, given where its parameter is declared.

    For example ``size: Annotated[int, Bounds(10, 2000, "cells")]``.

    Args:
        low: Smallest value; None for no limit.
        high: Largest value; None for no limit.
        unit: Unit of both, for people.
        above: True if the value must be above ``low``.
        chosen: The number that represents ``None`` in files, which lets the family choose. Python
            callers pass ``None``.
    """

    low: float | None = None
    high: float | None = None
    unit: str = ""
    above: bool = False
    chosen: float | None = None

    @property
    def words(self) -> str:
        """The limits as people read them: ``10 to 2000 cells, or -1``."""
        said = self.rule
        return said if self.chosen is None or not said else f"{said}, or {shown(self.chosen)}"

    @property
    def rule(self) -> str:
        """The same without the number that lets the family choose: ``10 to 2000 cells``."""
        unit = f" {self.unit}" if self.unit else ""
        if self.low is None:
            said = "" if self.high is None else f"at most {shown(self.high)}{unit}"
        elif self.above:
            said = f"above {shown(self.low)}{unit}" + (
                "" if self.high is None else f", up to {shown(self.high)}"
            )
        elif self.high is None:
            # ``cells`` has a singular, ``s`` and ``m/s`` have none.
            if self.low == 1 and unit.endswith("s") and not unit.endswith((" s", "/s")):
                unit = unit.removesuffix("s")
            said = f"at least {shown(self.low)}{unit}"
        else:
            said = f"{shown(self.low)} to {shown(self.high)}{unit}"
        return said

    def check(self, name: str, value: float) -> None:
        """Reject a number outside the limits.

        Raises:
            InvalidParameter: With value, rule and remedy.
        """
        # The number that represents None is always allowed.
        if self.chosen is not None and value == self.chosen:
            return
        too_low = self.low is not None and not (
            value > self.low if self.above else value >= self.low
        )
        if not too_low and (self.high is None or value <= self.high):
            return
        # Word the rule according to the limits.
        facts: dict[str, Any] = {
            "name": name,
            "value": value,
            "low": self.low,
            "high": self.high,
            "unit": self.unit,
        }
        or_chosen = "" if self.chosen is None else ", or omit it"
        if self.low is not None and self.high is not None and not self.above:
            raise InvalidParameter(
                "out-of-range",
                "{name}={value!n}{unit!u} is outside {low!n} to {high!n}{unit!u}",
                "use one between" + or_chosen,
                chosen=self.chosen,
                **facts,
            )
        if self.low is not None and self.high is None and not self.above:
            raise InvalidParameter(
                "below-minimum",
                "{name}={value!n}{unit!u} is below {low!n}{unit!u}",
                "use at least {low!n}" + or_chosen,
                chosen=self.chosen,
                **facts,
            )
        if self.low is not None and self.high is None:
            problem = "{name}={value!n}{unit!u} is not a finite number above {low!n}"
        else:
            problem = "{name}={value!n}{unit!u} is not {rule}"
        raise InvalidParameter("out-of-range", problem, "use one", rule=self.words, **facts)


def check_at_least(name: str, value: float, minimum: float, unit: str = "") -> None:
    """Reject a parameter below its minimum.

    Raises:
        InvalidParameter: With value, rule and remedy.
    """
    Bounds(minimum, unit=unit).check(name, value)


def check_between(name: str, value: float, low: float, high: float, unit: str = "") -> None:
    """Reject a parameter outside [low, high].

    Raises:
        InvalidParameter: With value, rule and remedy.
    """
    Bounds(low, high, unit).check(name, value)


def check_positive(name: str, value: float, unit: str = "") -> None:
    """Reject a number that isn't finite and above zero.

    Raises:
        InvalidParameter: With value and rule.
    """
    if not (math.isfinite(value) and value > 0.0):
        raise InvalidParameter(
            "not-positive",
            "{name}={value!n}{unit!u} is not a finite number above 0",
            "use one",
            name=name,
            value=value,
            unit=unit,
        )


def check_choice(name: str, value: str, choices: tuple[str, ...]) -> None:
    """Reject a word that isn't one of the choices.

    Raises:
        InvalidParameter: With value and choices.
    """
    if value not in choices:
        raise InvalidParameter(
            "unknown-name",
            "{name}={value!r} is not one of {choices!l}",
            "use one of these",
            name=name,
            value=value,
            choices=list(choices),
        )


def shown(value: float, unit: str = "") -> str:
    """Return a number as people read it, with its unit: ``0.5 m``."""
    number = str(value) if isinstance(value, int) else f"{value:g}"
    return f"{number} {unit}" if unit else number
