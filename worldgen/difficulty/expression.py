"""Constraints on metrics, such as ``detour > 3 and bottleneck < 1.2r``.

Python's own parser reads the text, which is never run as code. Grammar, loosest first: ``or``,
``and``, ``not``, comparisons (``<  <=  >  >=  ==  !=``, also chained), ``+ -``, ``* /``, signs,
parentheses, names of metrics, numbers. A number may carry a unit: ``m``, ``s``, or ``r``, the
robot's radius.
"""

from __future__ import annotations

import ast
import difflib
import math
import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final, NamedTuple, NoReturn

from worldgen.difficulty.metrics import METRICS
from worldgen.errors import InvalidParameter, Message

__all__ = ["Expression", "parse"]

UNITS: Final = ("m", "s", "r")
MOST_CHARACTERS: Final = 2000
MOST_NESTED: Final = 50
# Most levels of the syntax tree; Python allows a thousand nested calls.
_DEEPEST: Final = 250
# Violation of a comparison with a metric that the world lacks: larger than any other.
_EMPTY: Final = 2.0

_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(?P<unit>[A-Za-z_]\w*)?|(?P<word>[A-Za-z_]\w*)"
    r"|(?P<mark><=|>=|==|!=|[<>+\-*/()])|(?P<end>\Z)|(?P<wrong>.))",
    re.DOTALL | re.ASCII,
)
_BEGINNERS = frozenset(
    {"(", "and", "or", "not", "+", "-", "*", "/", "<", "<=", ">", ">=", "==", "!="}
)
_BETWEEN = _BEGINNERS - {"(", "not"}
_CONDITION_NEXT = frozenset({"(", "and", "or", "not"})
_MARKS: Final[dict[type[ast.AST], str]] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=",
    ast.Eq: "==", ast.NotEq: "!=",
}  # fmt: skip
_OPPOSITE = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}
_HOLDS: Final[dict[str, Callable[[float, float], bool]]] = {
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge, "==": operator.eq, "!=": operator.ne,
}  # fmt: skip

Values = Mapping[str, float]


class _Number(NamedTuple):
    """A number or an arithmetic expression: its value, nan if a metric is missing."""

    value: Callable[[Values, float], float]


class _Wish(NamedTuple):
    """A condition: how far a world is from it, exactly 0 if it holds; and its negation."""

    violation: Callable[[Values, float], float]
    opposite: Callable[[], _Wish]


@dataclass(frozen=True)
class Expression:
    """A parsed constraint.

    Args:
        text: The text as written.
        names: The metrics that it uses.
    """

    text: str
    names: frozenset[str]
    _wish: _Wish

    def violation(self, metrics: Values, robot_radius: float) -> float:
        """Return how far a world is from satisfying it: 0 if it does, more the farther it is.

        A missing metric satisfies nothing.
        """
        return self._wish.violation(metrics, robot_radius)

    def holds(self, metrics: Values, robot_radius: float) -> bool:
        """Return True if the constraint is satisfied."""
        return self.violation(metrics, robot_radius) == 0.0


def parse(text: str) -> Expression:
    """Parse a constraint.

    Raises:
        InvalidParameter: If it cannot be parsed; the message marks the place.
    """
    if len(text) > MOST_CHARACTERS:
        raise InvalidParameter(
            "too-large",
            "the wish has {characters} characters",
            "give at most {most}",
            characters=len(text),
            most=MOST_CHARACTERS,
        )
    scan = _Scan(text)
    try:
        tree = ast.parse(f"({scan.structure})", mode="eval").body
    except (SyntaxError, MemoryError, RecursionError):
        # After the scan, nothing is left to refuse except endless signs.
        tree = None
    if tree is None or _levels(tree) > _DEEPEST:
        scan.fail(_too_deep(_DEEPEST), 0)
    return Expression(
        text, frozenset(scan.names), _Meaning(scan).wish(tree, len(text) - len(text.lstrip()))
    )


class _Scan:
    """The words of a text, checked from left to right.

    Attributes:
        operands: The meaning of each number and metric, by the position where it begins.
        structure: The text with a name of the same length for each of them, which Python's own
            parser can read.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        self.names: set[str] = set()
        self.operands: dict[int, _Number] = {}
        self.structure = ""
        open_brackets = 0
        # Parse the whole as if it were in parentheses.
        before = "("
        for token in _TOKEN.finditer(text):
            kind = "number" if token["number"] is not None else str(token.lastgroup)
            word = token[kind]
            at = token.start(kind)
            if open_brackets > MOST_NESTED:
                self.fail(_too_deep(MOST_NESTED), at)
            if kind == "wrong":
                self.fail(Message("wrong-form", "{word!r} has no meaning here", word=word), at)

            # Operands and operators alternate, so the previous word determines what may come next.
            begins = before in _BEGINNERS
            is_operand = kind == "number" or (kind == "word" and word not in ("and", "or", "not"))
            if begins:
                fits = (
                    is_operand
                    or word in ("(", "+", "-")
                    or (word == "not" and before in _CONDITION_NEXT)
                )
            elif open_brackets:
                fits = word in _BETWEEN or word == ")"
            else:
                fits = word in _BETWEEN or kind == "end"
            if not fits:
                self.fail(
                    _misplaced("the end" if kind == "end" else repr(word), begins, open_brackets),
                    at,
                )

            # Numbers and metrics get their meaning here; signs and brackets are left to the parser.
            if is_operand:
                self.operands[at] = (
                    self._constant(token, at) if kind == "number" else self._metric(word, at)
                )
                word = "_" * (token.end() - at)
            open_brackets += {"(": 1, ")": -1}.get(word, 0)
            self.structure += " " * (at - token.start()) + word
            before = "" if is_operand else word
            if kind == "end":
                break

    def fail(self, message: Message, place: int) -> NoReturn:
        """Raise the error with a mark under the place."""
        line = "".join(c if c.isprintable() else " " for c in self.text)
        first = max(0, place - 60)
        piece = line[first : first + 100]
        marked = message.before(
            "\n  {line}\n  {mark:>{column}}", line=piece, mark="^", column=place - first + 1
        )
        raise InvalidParameter.of(marked)

    def _constant(self, token: re.Match[str], at: int) -> _Number:
        value = float(token["number"])
        unit = token["unit"]
        if not math.isfinite(value):
            self.fail(
                Message(
                    "too-large",
                    "this number is beyond the range of a float64",
                    "give a smaller one",
                ),
                at,
            )
        if unit is not None and unit not in UNITS:
            self.fail(
                Message(
                    "unknown-name",
                    "{name!r} is not a unit",
                    "write m, s, or r for the robot's radius",
                    name=unit,
                ),
                token.start("unit"),
            )
        return _Number(lambda _, radius: value * radius if unit == "r" else value)

    def _metric(self, name: str, at: int) -> _Number:
        if name not in METRICS:
            near = "".join(difflib.get_close_matches(name, METRICS, n=1))
            message = Message(
                "unknown-name",
                "no metric is called {name!r}",
                "did you mean {near}? known: {known!l}" if near else "known: {known!l}",
                name=name[:40],
                near=near,
                known=list(METRICS),
            )
            self.fail(message, at)
        self.names.add(name)
        return _Number(lambda metrics, _: metrics.get(name, math.nan))


def _misplaced(came: str, begins: bool, open_brackets: int) -> Message:
    """Describe what is wrong with a word that does not fit what precedes it."""
    if begins:
        return Message("wrong-form", "{came} where a metric or a number belongs", came=came)
    if open_brackets:
        return Message("wrong-form", "{came} where a closing parenthesis belongs", came=came)
    return Message("wrong-form", "{came} is too much here", "join wishes with and, or", came=came)


def _too_deep(most: int) -> Message:
    return Message(
        "nested-too-deep",
        "nested deeper than {most} levels",
        "take parentheses and signs away",
        most=most,
    )


class _Meaning:
    """The meaning of a syntax tree's nodes; ``at`` is the position in the text where a node begins."""

    def __init__(self, scan: _Scan) -> None:
        self._scan = scan

    def wish(self, node: ast.expr, at: int) -> _Wish:
        """Return a condition; reject a number in its place."""
        if isinstance(node, ast.Compare):
            return self._comparison(node, at)
        if isinstance(node, ast.BoolOp):
            join = _and if isinstance(node.op, ast.And) else _or
            found = self.wish(node.values[0], at)
            # More than two operands are joined from the left.
            for value in node.values[1:]:
                found = join(found, self.wish(value, _place(value)))
            return found
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            return self.wish(node.operand, _place(node.operand)).opposite()
        message = Message(
            "wrong-form", "this is a number, not a condition", "compare it, as in detour > 3"
        )
        self._scan.fail(message, at)

    def number(self, node: ast.expr, at: int) -> _Number:
        """Return a number; reject a condition in its place."""
        if isinstance(node, ast.Name):
            return self._scan.operands[_place(node)]
        if isinstance(node, ast.BinOp):
            left = self.number(node.left, at)
            right = self.number(node.right, _place(node.right))
            return _reckon(_MARKS[type(node.op)], left, right)
        if isinstance(node, ast.UnaryOp) and not isinstance(node.op, ast.Not):
            value = self.number(node.operand, _place(node.operand)).value
            return _Number(
                (lambda metrics, radius: -value(metrics, radius))
                if isinstance(node.op, ast.USub)
                else value
            )
        message = Message(
            "wrong-form",
            "this is a condition, not a number; it cannot be compared or calculated with",
        )
        self._scan.fail(message, at)

    def _comparison(self, node: ast.Compare, at: int) -> _Wish:
        left = self.number(node.left, at)
        found: _Wish | None = None
        for mark, other in zip(node.ops, node.comparators, strict=True):
            right = self.number(other, _place(other))
            part = _compare(_MARKS[type(mark)], left, right)
            found = part if found is None else _and(found, part)
            left = right
        assert found is not None, "a comparison has a right side"
        return found


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


def _reckon(mark: str, one: _Number, other: _Number) -> _Number:
    def value(metrics: Values, radius: float) -> float:
        a = one.value(metrics, radius)
        b = other.value(metrics, radius)
        if mark == "/":
            return a / b if b else math.nan
        return a + b if mark == "+" else a - b if mark == "-" else a * b

    return _Number(value)


def _compare(mark: str, one: _Number, other: _Number) -> _Wish:
    def violation(metrics: Values, radius: float) -> float:
        a = one.value(metrics, radius)
        b = other.value(metrics, radius)
        if not (math.isfinite(a) and math.isfinite(b)):
            return _EMPTY
        if _HOLDS[mark](a, b):
            return 0.0
        size = abs(a) + abs(b)
        # It is never 0 here, not even if the values are equal and should not be.
        return max(abs(a - b) / size if 0.0 < size < math.inf else 0.0, 1e-9)

    return _Wish(violation, lambda: _compare(_OPPOSITE[mark], one, other))


def _and(one: _Wish, other: _Wish) -> _Wish:
    return _Wish(
        lambda metrics, radius: one.violation(metrics, radius) + other.violation(metrics, radius),
        lambda: _or(one.opposite(), other.opposite()),
    )


def _or(one: _Wish, other: _Wish) -> _Wish:
    return _Wish(
        lambda metrics, radius: min(
            one.violation(metrics, radius), other.violation(metrics, radius)
        ),
        lambda: _and(one.opposite(), other.opposite()),
    )
