"""Constraints on metrics, such as ``detour > 3 and bottleneck < 1.2r``.

They are conditions in the language of :mod:`worldgen.parameters.expressions`. A number may carry a
unit: ``m``, ``s``, or ``r``, the robot's radius.
"""

from __future__ import annotations

import functools
import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from worldgen.difficulty.metrics import METRICS
from worldgen.parameters.expressions import (
    Language,
    Node,
    Operation,
    evaluate,
    parse_condition,
    variables_in,
)

# Name of the robot's radius among the values; no metric has it.
_RADIUS: Final = "robot_radius"
_LANGUAGE = Language(
    METRICS,
    noun="metric",
    longest=2000,
    example="detour > 3",
    units={"m": None, "s": None, "r": _RADIUS},
    unit_words="m, s, or r for the robot's radius",
)
# Violation of a comparison with a metric that the world lacks: larger than any other.
_EMPTY: Final = 2.0
_OPPOSITE = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}
_HOLDS: Final[dict[str, Callable[[float, float], bool]]] = {
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge, "==": operator.eq, "!=": operator.ne,
}  # fmt: skip

Values = Mapping[str, float]


@dataclass(frozen=True)
class Expression:
    """A parsed constraint.

    Args:
        text: The text as written.
        names: The metrics that it uses.
    """

    text: str
    names: frozenset[str]
    _condition: Node

    def violation(self, metrics: Values, robot_radius: float) -> float:
        """Return how far a world is from satisfying it: 0 if it does, more the farther it is.

        A missing metric satisfies nothing.
        """
        return _violation(self._condition, {**metrics, _RADIUS: robot_radius}, holds=True)

    def holds(self, metrics: Values, robot_radius: float) -> bool:
        """Return True if the constraint is satisfied."""
        return self.violation(metrics, robot_radius) == 0.0


def parse(text: str) -> Expression:
    """Parse a constraint.

    Raises:
        InvalidParameter: If it cannot be parsed; the message marks the place.
    """
    condition = parse_condition(text, _LANGUAGE)
    return Expression(text, frozenset(variables_in(condition)) - {_RADIUS}, condition)


def _violation(condition: Node, values: Values, *, holds: bool) -> float:
    """Return how far the values are from satisfying a condition, or its negation."""
    assert isinstance(condition, Operation), "a number is not a condition"
    mark = condition.mark
    if mark == "not":
        return _violation(condition.operands[0], values, holds=not holds)
    if mark in ("and", "or"):
        parts = [_violation(part, values, holds=holds) for part in condition.operands]
        # Not sum(), which rounds differently from Python 3.12 on.
        return functools.reduce(operator.add, parts) if (mark == "and") is holds else min(parts)
    try:
        one, other = (float(evaluate(side, values)) for side in condition.operands)
    except (KeyError, ArithmeticError):
        return _EMPTY
    return _distance(mark if holds else _OPPOSITE[mark], one, other)


def _distance(mark: str, one: float, other: float) -> float:
    """Return how far two numbers are from satisfying a comparison."""
    if not (math.isfinite(one) and math.isfinite(other)):
        return _EMPTY
    if _HOLDS[mark](one, other):
        return 0.0
    size = abs(one) + abs(other)
    # It is never 0 here, not even if the values are equal and should not be.
    return max(abs(one - other) / size if 0.0 < size < math.inf else 0.0, 1e-9)
