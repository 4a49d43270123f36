"""Constraints on metrics, such as ``detour > 3 and bottleneck < 1.2r``.

Python's own parser reads the text, which is never run as code. Grammar, loosest first: ``or``,
``and``, ``not``, comparisons (``<  <=  >  >=  ==  !=``, also chained), ``+ -``, ``* / // %``,
signs, parentheses, metrics, numbers. A number may carry a unit: ``m``, ``s``, or ``r``, the robot's
radius.
"""

from __future__ import annotations

import ast
import functools
import itertools
import math
import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final, NoReturn, TypeAlias

from worldgen.difficulty.metrics import METRICS
from worldgen.errors import InvalidParameter, Message
from worldgen.parameters.known_names import unknown_name

# Name of the robot's radius among the values; no metric has it.
_RADIUS: Final = "robot_radius"
_UNITS: Final = {"m": None, "s": None, "r": _RADIUS}
_LONGEST = 2000
_EXAMPLE = "write it like detour > 3"
_MOST_NESTED = 50
# Limit on the levels of the syntax tree; Python allows a thousand nested ones.
_DEEPEST = 250
# Violation of a comparison with a metric that the world lacks: larger than any other.
_EMPTY: Final = 2.0

_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(?P<unit>[A-Za-z_]\w*)?|(?P<word>[A-Za-z_]\w*)"
    r"|(?P<mark><=|>=|==|!=|//|[<>+\-*/%(),])|(?P<end>\Z)|(?P<wrong>.))",
    re.DOTALL | re.ASCII,
)
_ARITHMETIC: Final[dict[type[ast.operator], Callable[..., Any]]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul,
    ast.Div: operator.truediv, ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod,
}  # fmt: skip
# Each comparison, and the one that holds where it does not.
_COMPARISONS: Final[dict[type[ast.cmpop], tuple[Callable[[float, float], bool], ...]]] = {
    ast.Lt: (operator.lt, operator.ge), ast.GtE: (operator.ge, operator.lt),
    ast.Gt: (operator.gt, operator.le), ast.LtE: (operator.le, operator.gt),
    ast.Eq: (operator.eq, operator.ne), ast.NotEq: (operator.ne, operator.eq),
}  # fmt: skip
_BETWEEN = frozenset(["and", "or", "+", "-", "*", "/", "//", "%", "<", "<=", ">", ">=", "==", "!="])
# After these an operand is needed; after the second ones a condition is possible.
_BEGINNERS = _BETWEEN | {"(", "not"}
_CONDITION_NEXT = frozenset({"(", "and", "or", "not"})

Values: TypeAlias = Mapping[str, float]
# A number of some values, and how far they are from satisfying a condition, or its negation.
_Number: TypeAlias = Callable[[Values], Any]
_Condition: TypeAlias = Callable[[Values, bool], float]


@dataclass(frozen=True)
class Expression:
    """A parsed constraint.

    Args:
        text: The text as written.
        names: The metrics that it uses.
        needs_all: Whether no world without one of them satisfies it, because nothing in it is
            joined with ``or`` or negated.
    """

    text: str
    names: frozenset[str]
    needs_all: bool
    _condition: _Condition = field(compare=False, repr=False)

    def __reduce__(self) -> tuple[Callable[[str], Expression], tuple[str]]:
        return parse, (self.text,)

    def violation(self, metrics: Values, robot_radius: float) -> float:
        """Return how far a world is from satisfying it: 0 if it does, more the farther it is.

        A missing metric satisfies nothing.
        """
        return self._condition({**metrics, _RADIUS: robot_radius}, True)

    def holds(self, metrics: Values, robot_radius: float) -> bool:
        """Return True if the constraint is satisfied."""
        return self.violation(metrics, robot_radius) == 0.0


def parse(text: str) -> Expression:
    """Parse a constraint.

    Raises:
        InvalidParameter: If it cannot be parsed; the message marks the place.
    """
    if len(text) > _LONGEST:
        raise InvalidParameter(
            "too-large",
            "an expression of {characters} characters",
            f"use at most {_LONGEST}",
            characters=len(text),
        )
    return _Reader(text).expression()


class _Reader:
    """Checks the words of a text from left to right, then gives its syntax tree a meaning."""

    def __init__(self, text: str) -> None:
        self._text = text
        # By the place of each number and metric: its factor, and the value that it multiplies.
        self._operands: dict[int, tuple[float, str | None]] = {}

    def expression(self) -> Expression:
        """Return the constraint."""
        structure = self._scan()
        try:
            tree = ast.parse(f"({structure})", mode="eval").body
        except (SyntaxError, MemoryError, RecursionError):
            # After the scan, the only thing left to refuse is too many signs.
            tree = None
        if tree is None or _levels(tree) > _DEEPEST:
            self._fail(_too_deep(_DEEPEST), 0)
        condition = self._condition(tree, len(self._text) - len(self._text.lstrip()))
        names = {name for _, name in self._operands.values() if name is not None}
        needs_all = not any(isinstance(node, ast.Or | ast.Not) for node in ast.walk(tree))
        return Expression(self._text, frozenset(names - {_RADIUS}), needs_all, condition)

    def _scan(self) -> str:
        """Return the text with a name of the same length for each number and metric.

        Operands and operators alternate, so the previous word determines what may come next.
        """
        structure = ""
        brackets = 0
        before = "("  # parse the whole as if it were in parentheses
        for token in _TOKEN.finditer(self._text):
            kind = "number" if token["number"] is not None else str(token.lastgroup)
            word = token[kind]
            at = token.start(kind)
            if brackets > _MOST_NESTED:
                self._fail(_too_deep(_MOST_NESTED), at)
            # Check that it fits after the previous word.
            if kind == "word" and word in ("and", "or", "not"):
                kind = "mark"
            rule = _broken_rule(kind, word, before, brackets)
            if rule:
                given = "the end" if kind == "end" else repr(word)
                self._fail(Message("wrong-form", rule, _EXAMPLE, given=given), at)

            # Numbers and metrics get their meaning here; the parser only sees a place.
            if kind in ("number", "word"):
                self._operands[at] = self._number_at(token) if kind == "number" else (1, word)
                if kind == "word" and word not in METRICS:
                    problem = "no metric is called {name!r}"
                    remedy = "known: {known!l:none}"
                    self._fail(unknown_name(problem, word[:40], list(METRICS), remedy), at)
                word = "_" * (token.end() - at)
            brackets += {"(": 1, ")": -1}.get(word, 0)
            structure += " " * (at - token.start()) + word
            before = word if kind == "mark" else kind
            if kind == "end":
                break
        return structure

    def _number_at(self, token: re.Match[str]) -> tuple[float, str | None]:
        digits = token["number"]
        unit = token["unit"]
        if not math.isfinite(float(digits)):
            problem = "this number is beyond the range of a float64"
            self._fail(Message("too-large", problem, "use a smaller one"), token.start("number"))
        if unit is not None and unit not in _UNITS:
            remedy = "write m, s, or r for the robot's radius"
            problem = "{name!r} is not a unit"
            message = Message("unknown-name", problem, remedy, name=unit)
            self._fail(message, token.start("unit"))
        value = int(digits) if digits.isdigit() else float(digits)
        return value, None if unit is None else _UNITS[unit]

    def _fail(self, message: Message, place: int) -> NoReturn:
        """Raise the error with a mark under the place."""
        line = "".join(c if c.isprintable() else " " for c in self._text)
        first = max(0, place - 60)
        marked = message.before(
            "\n  {text}\n  {mark:>{column}}",
            text=line[first : first + 100],
            mark="^",
            column=place - first + 1,
        )
        raise InvalidParameter.of(marked)

    def _condition(self, node: ast.expr, at: int) -> _Condition:
        """Return the meaning of a node that begins at a position; refuse a number."""
        if isinstance(node, ast.Compare):
            sides = [self._number(node.left, at), *map(self._inner, node.comparators)]
            pairs = zip(node.ops, itertools.pairwise(sides), strict=True)
            parts = [_comparison(type(mark), *pair) for mark, pair in pairs]
            return parts[0] if len(parts) == 1 else _joined(parts, is_and=True)
        if isinstance(node, ast.BoolOp):
            places = [at, *map(_place, node.values[1:])]
            parts = list(map(self._condition, node.values, places))
            return _joined(parts, is_and=isinstance(node.op, ast.And))
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            part = self._condition(node.operand, _place(node.operand))
            return lambda values, holds: part(values, not holds)
        remedy = "compare it, as in detour > 3"
        self._fail(Message("wrong-form", "this is a number, not a condition", remedy), at)

    def _number(self, node: ast.expr, at: int) -> _Number:
        """Return the meaning of a node that begins at a position; refuse a condition."""
        if isinstance(node, ast.Name):
            factor, name = self._operands[_place(node)]
            return lambda values: factor if name is None else factor * values[name]
        if isinstance(node, ast.BinOp):
            compute = _ARITHMETIC[type(node.op)]
            left, right = self._number(node.left, at), self._inner(node.right)
            return lambda values: compute(left(values), right(values))
        if isinstance(node, ast.UnaryOp) and not isinstance(node.op, ast.Not):
            inner = self._inner(node.operand)
            return inner if isinstance(node.op, ast.UAdd) else lambda values: -inner(values)
        remedy = "conditions can be joined with and, or, not"
        self._fail(Message("wrong-form", "this is a condition, not a number", remedy), at)

    def _inner(self, node: ast.expr) -> _Number:
        return self._number(node, _place(node))


def _joined(parts: list[_Condition], *, is_and: bool) -> _Condition:
    def violation(values: Values, holds: bool) -> float:
        found = [part(values, holds) for part in parts]
        # Not sum(), which rounds differently from Python 3.12 on.
        return functools.reduce(operator.add, found) if is_and is holds else min(found)

    return violation


def _comparison(mark: type[ast.cmpop], left: _Number, right: _Number) -> _Condition:
    def violation(values: Values, holds: bool) -> float:
        try:
            one, other = float(left(values)), float(right(values))
        except (KeyError, ArithmeticError):
            return _EMPTY
        if not (math.isfinite(one) and math.isfinite(other)):
            return _EMPTY
        if _COMPARISONS[mark][0 if holds else 1](one, other):
            return 0.0
        size = abs(one) + abs(other)
        # It is never 0 here, not even if the values are equal and should not be.
        return max(abs(one - other) / size if 0.0 < size < math.inf else 0.0, 1e-9)

    return violation


def _broken_rule(kind: str, word: str, before: str, brackets: int) -> str:
    """Return the rule that a word breaks after the one before it; empty if it fits."""
    if kind == "wrong":
        return "{given} has no meaning here"
    if before in _BEGINNERS:
        begins = kind in ("number", "word") or word in ("(", "+", "-")
        if begins or (word == "not" and before in _CONDITION_NEXT):
            return ""
        return "{given} in place of a metric or a number"
    if brackets:
        return (
            "" if word == ")" or word in _BETWEEN else "{given} in place of a closing parenthesis"
        )
    return "" if word in _BETWEEN or kind == "end" else "{given} is not expected here"


def _too_deep(most: int) -> Message:
    problem = "nested deeper than {most} levels"
    return Message("nested-too-deep", problem, "remove some parentheses or signs", most=most)


def _levels(tree: ast.expr) -> int:
    """Return the depth of a syntax tree."""
    levels = 0
    nodes: list[ast.AST] = [tree]
    while nodes:
        nodes = [child for node in nodes for child in ast.iter_child_nodes(node)]
        levels += 1
    return levels


def _place(node: ast.expr) -> int:
    """Return where a node begins in the text; the parser sees an extra parenthesis before it."""
    return node.col_offset - 1
