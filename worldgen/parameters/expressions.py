"""Conditions on named numbers, as in ``detour > 3 and bottleneck < 1.2r``.

Python's own parser reads the text, which is never run as code. Grammar, loosest first: ``or``,
``and``, ``not``, comparisons (``<  <=  >  >=  ==  !=``, also chained), ``+ -``, ``* / // %``,
signs, parentheses, names, numbers. The caller decides which names and units there are.
"""

from __future__ import annotations

import ast
import itertools
import math
import operator
import re
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Final, NoReturn, TypeAlias

from worldgen.errors import InvalidParameter, Message
from worldgen.parameters.known_names import unknown_name

MOST_NESTED: Final = 50
# Limit on the levels of the syntax tree; Python allows a thousand nested ones.
_DEEPEST: Final = 250

_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(?P<unit>[A-Za-z_]\w*)?|(?P<word>[A-Za-z_]\w*)"
    r"|(?P<mark><=|>=|==|!=|//|[<>+\-*/%(),])|(?P<end>\Z)|(?P<wrong>.))",
    re.DOTALL | re.ASCII,
)
_ARITHMETIC: Final[dict[type[ast.operator], str]] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.FloorDiv: "//", ast.Mod: "%",
}  # fmt: skip
_COMPARISONS: Final[dict[type[ast.cmpop], str]] = {
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
}  # fmt: skip
_BETWEEN = frozenset({"and", "or", *_ARITHMETIC.values(), *_COMPARISONS.values()})
# After these an operand is needed; after the second ones a condition is possible.
_BEGINNERS = _BETWEEN | {"(", "not"}
_CONDITION_NEXT = frozenset({"(", "and", "or", "not"})
_COMPUTE: Final[dict[str, Callable[..., Any]]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv,
    "//": operator.floordiv, "%": operator.mod,
}  # fmt: skip


@dataclass(frozen=True)
class Language:
    """The contents that expressions of one kind may have besides numbers and operators.

    Args:
        variables: Names of the numbers that are known when an expression is evaluated.
        noun: What a variable is called in messages, such as ``metric``.
        longest: Limit on the characters of an expression.
        example: A condition in this language, for messages.
        units: Suffixes of a number, each with the variable that it is then multiplied by, or None.
        unit_words: These units, for messages.
    """

    variables: Collection[str]
    noun: str
    longest: int
    example: str
    units: Mapping[str, str | None] = field(default_factory=dict)
    unit_words: str = ""


@dataclass(frozen=True)
class Constant:
    """A number; one without a point or an exponent is an ``int``."""

    value: int | float


@dataclass(frozen=True)
class Variable:
    """The number with a name."""

    name: str


@dataclass(frozen=True)
class Operation:
    """An operator with its operands.

    Args:
        mark: The operator as written. A chain of comparisons is an ``and``
            of comparisons with two operands each.
        operands: One or two; any number for ``and`` and ``or``.
        compute: The function that gives its value; None for comparisons and for ``and``, ``or``,
            ``not``.
    """

    mark: str
    operands: tuple[Node, ...]
    compute: Callable[..., Any] | None = None


Node: TypeAlias = Constant | Variable | Operation


def evaluate(node: Node, values: Mapping[str, Any]) -> Any:
    """Return the value of a number.

    Raises:
        KeyError: If a variable has no value.
        ArithmeticError: If it divides by zero or overflows.
    """
    if isinstance(node, Constant):
        return node.value
    if isinstance(node, Variable):
        return values[node.name]
    assert node.compute is not None, "a condition has no value"
    return node.compute(*(evaluate(operand, values) for operand in node.operands))


def variables_in(node: Node) -> Iterator[str]:
    """Yield the names of the variables in an expression, each as often as it occurs."""
    if isinstance(node, Variable):
        yield node.name
    elif isinstance(node, Operation):
        for operand in node.operands:
            yield from variables_in(operand)


def parse_condition(text: str, language: Language) -> Node:
    """Parse an expression that is a condition.

    Raises:
        InvalidParameter: If it cannot be parsed; the message marks the place.
    """
    reader = _Reader(text, language)
    return reader.condition(reader.tree, reader.begins)


class _Reader:
    """Checks the words of a text from left to right, then gives its syntax tree a meaning.

    Attributes:
        tree: What Python's parser makes of the text, with names of the same length in place of
            numbers and variables.
        begins: Position of the first word.
    """

    def __init__(self, text: str, language: Language) -> None:
        if len(text) > language.longest:
            raise InvalidParameter(
                "too-large",
                "an expression of {characters} characters",
                "use at most {most}",
                characters=len(text),
                most=language.longest,
            )
        self._text = text
        self._language = language
        self._operands: dict[int, Node] = {}
        self.begins = len(text) - len(text.lstrip())
        structure = self._scan()
        try:
            tree = ast.parse(f"({structure})", mode="eval").body
        except (SyntaxError, MemoryError, RecursionError):
            # After the scan, the only thing left to refuse is too many signs.
            tree = None
        if tree is None or _levels(tree) > _DEEPEST:
            self._fail(_too_deep(_DEEPEST), 0)
        self.tree: ast.expr = tree

    def _scan(self) -> str:
        """Return the text with a name of the same length for each number and variable.

        Operands and operators alternate, so the previous word determines what may come next.
        """
        structure = ""
        brackets = 0
        before = "("  # parse the whole as if it were in parentheses
        for token in _TOKEN.finditer(self._text):
            kind = "number" if token["number"] is not None else str(token.lastgroup)
            word = token[kind]
            at = token.start(kind)
            if brackets > MOST_NESTED:
                self._fail(_too_deep(MOST_NESTED), at)
            if kind == "wrong":
                self._fail(self._misplaced(repr(word), "{came} has no meaning here"), at)

            # Check that it fits after the previous word.
            if kind == "word" and word in ("and", "or", "not"):
                kind = "mark"
            rule = _broken_rule(kind, word, before, brackets)
            if rule:
                came = "the end" if kind == "end" else repr(word)
                self._fail(self._misplaced(came, rule), at)

            # Numbers and variables get their meaning here; the parser only sees a place.
            if kind in ("number", "word"):
                self._operands[at] = (
                    self._number(token, at) if kind == "number" else self._variable(word, at)
                )
                word = "_" * (token.end() - at)
            if word == "(":
                brackets += 1
            elif word == ")":
                brackets -= 1
            structure += " " * (at - token.start()) + word
            before = word if kind == "mark" else kind
            if kind == "end":
                break
        return structure

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

    def _misplaced(self, came: str, rule: str) -> Message:
        """Return the message about a word that does not fit what precedes it."""
        noun = self._language.noun
        example = self._language.example
        return Message(
            "wrong-form", rule, "write it like {example}", came=came, noun=noun, example=example
        )

    def _number(self, token: re.Match[str], at: int) -> Node:
        digits = token["number"]
        unit = token["unit"]
        if not math.isfinite(float(digits)):
            self._fail(
                Message(
                    "too-large", "this number is beyond the range of a float64", "use a smaller one"
                ),
                at,
            )
        units = self._language.units
        if unit is not None and unit not in units:
            self._fail(
                Message(
                    "unknown-name",
                    "{name!r} is not a unit",
                    "write {known}" if units else "leave it out",
                    name=unit,
                    known=self._language.unit_words or ", ".join(units),
                ),
                token.start("unit"),
            )
        value = Constant(int(digits) if digits.isdigit() else float(digits))
        factor = None if unit is None else units[unit]
        if factor is None:
            return value
        return Operation("*", (value, Variable(factor)), _COMPUTE["*"])

    def _variable(self, name: str, at: int) -> Node:
        known = list(self._language.variables)
        if name not in known:
            remedy = "known: {known!l:none}"
            noun = self._language.noun
            message = unknown_name(
                "no {noun} is called {name!r}", name[:40], known, remedy, noun=noun
            )
            self._fail(message, at)
        return Variable(name)

    def condition(self, node: ast.expr, at: int) -> Node:
        """Return the meaning of a node that begins at a position; refuse a number."""
        if isinstance(node, ast.Compare):
            return self._comparison(node, at)
        if isinstance(node, ast.BoolOp):
            mark = "and" if isinstance(node.op, ast.And) else "or"
            places = [at, *map(_place, node.values[1:])]
            return Operation(mark, tuple(map(self.condition, node.values, places)))
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            return Operation("not", (self.condition(node.operand, _place(node.operand)),))
        message = Message(
            "wrong-form",
            "this is a number, not a condition",
            "compare it, as in {example}",
            example=self._language.example,
        )
        self._fail(message, at)

    def number(self, node: ast.expr, at: int) -> Node:
        """Return the meaning of a node that begins at a position; refuse a condition."""
        if isinstance(node, ast.Name):
            return self._operands[_place(node)]
        if isinstance(node, ast.BinOp):
            mark = _ARITHMETIC[type(node.op)]
            left = self.number(node.left, at)
            return Operation(mark, (left, self._inner(node.right)), _COMPUTE[mark])
        if isinstance(node, ast.UnaryOp) and not isinstance(node.op, ast.Not):
            inner = self._inner(node.operand)
            return (
                inner if isinstance(node.op, ast.UAdd) else Operation("-", (inner,), operator.neg)
            )
        way_out = "conditions can be joined with and, or, not"
        self._fail(Message("wrong-form", "this is a condition, not a number", way_out), at)

    def _inner(self, node: ast.expr) -> Node:
        return self.number(node, _place(node))

    def _comparison(self, node: ast.Compare, at: int) -> Node:
        sides = [self.number(node.left, at), *map(self._inner, node.comparators)]
        marks = [_COMPARISONS[type(mark)] for mark in node.ops]
        parts = [
            Operation(mark, pair)
            for mark, pair in zip(marks, itertools.pairwise(sides), strict=True)
        ]
        return parts[0] if len(parts) == 1 else Operation("and", tuple(parts))


def _broken_rule(kind: str, word: str, before: str, brackets: int) -> str:
    """Return the rule that a word breaks after the one before it; empty if it fits."""
    if before in _BEGINNERS:
        begins = kind in ("number", "word") or word in ("(", "+", "-")
        if begins or (word == "not" and before in _CONDITION_NEXT):
            return ""
        return "{came} in place of a {noun} or a number"
    if brackets:
        return "" if word == ")" or word in _BETWEEN else "{came} in place of a closing parenthesis"
    return "" if word in _BETWEEN or kind == "end" else "{came} is not expected here"


def _too_deep(most: int) -> Message:
    return Message(
        "nested-too-deep",
        "nested deeper than {most} levels",
        "remove some parentheses or signs",
        most=most,
    )


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
