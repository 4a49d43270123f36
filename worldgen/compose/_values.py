"""Parse and evaluate a recipe's values: constants, formulas, ranges and choices."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from worldgen.errors import InvalidParameter
from worldgen.random_streams import RandomStream

__all__ = [
    "Choice",
    "Formula",
    "Range",
    "Scalar",
    "Spec",
    "compute",
    "is_drawn",
    "parse_formula",
    "spec_of",
    "value_of",
]

Scalar: TypeAlias = bool | int | float | str

_LONGEST = 200  # characters of a formula
# Above this limit a float cannot represent every whole number.
_LARGEST = 2**53
_BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
}
_CALLS: dict[str, Callable[..., Any]] = {"min": min, "max": max}


@dataclass(frozen=True)
class Formula:
    """Compute a number from parameters, as in ``= size // 2 - 3``."""

    text: str
    tree: ast.expr


@dataclass(frozen=True)
class Range:
    """Draw a number between ``low`` and ``high``; whole numbers include both ends."""

    low: Spec
    high: Spec


@dataclass(frozen=True)
class Choice:
    """Draw one of several values with equal probability."""

    options: tuple[Spec, ...]


Spec: TypeAlias = "Scalar | Formula | Range | Choice | tuple[Spec, ...]"


def spec_of(raw: object, names: Sequence[str], depth: int = 0) -> Spec:
    """Parse a value of a recipe.

    Args:
        raw: The value from TOML: a scalar, a list, ``{from, to}`` or ``{any}``.
        names: Parameters that a formula may use.
        depth: Current nesting depth.

    Raises:
        InvalidParameter: If it is not one of these, or nested too deep.
    """
    # Nobody needs deeper nesting, and the limit keeps a hostile file from exhausting the stack.
    if depth > 4:
        raise InvalidParameter("nested-too-deep", "values are nested too deep", "flatten them")
    if isinstance(raw, str) and raw.lstrip().startswith("="):
        return parse_formula(raw.strip()[1:].strip(), names)
    if isinstance(raw, bool | int | float | str):
        return raw
    if isinstance(raw, list):
        return tuple(spec_of(item, names, depth + 1) for item in raw)
    if isinstance(raw, Mapping) and set(raw) == {"from", "to"}:
        return Range(spec_of(raw["from"], names, depth + 1), spec_of(raw["to"], names, depth + 1))
    if (
        isinstance(raw, Mapping)
        and set(raw) == {"any"}
        and isinstance(raw["any"], list)
        and raw["any"]
    ):
        return Choice(tuple(spec_of(item, names, depth + 1) for item in raw["any"]))
    shown = (
        "a table of " + ", ".join(map(str, raw))
        if isinstance(raw, Mapping)
        else f"a {type(raw).__name__}"
    )
    raise InvalidParameter(
        "wrong-type",
        "{value} is not a value",
        'give a value, "= a formula", {{ from = 1, to = 3 }} or {{ any = [...] }}',
        value=shown[:80],
    )


def parse_formula(text: str, names: Sequence[str]) -> Formula:
    """Parse a formula of numbers, parameters, + - * / // %, brackets, min() and max().

    Raises:
        InvalidParameter: If the text contains anything else, or is too long.
    """
    if len(text) > _LONGEST:
        raise InvalidParameter(
            "too-large",
            "a formula of {count} characters; the limit is {most}",
            "make it shorter",
            count=len(text),
            most=_LONGEST,
        )
    try:
        tree = ast.parse(text, mode="eval").body
    except (SyntaxError, ValueError, MemoryError, RecursionError):
        raise InvalidParameter(
            "not-a-formula", "{text!r} is not a formula", "write one like size // 2 - 3", text=text
        ) from None
    _check(tree, names, text)
    return Formula(text, tree)


def _check(node: ast.expr, names: Sequence[str], text: str) -> None:
    if isinstance(node, ast.BinOp) and type(node.op) in _BINARY:
        _check(node.left, names, text)
        _check(node.right, names, text)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        _check(node.operand, names, text)
    elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in _CALLS:
        if not node.args or node.keywords:
            raise InvalidParameter(
                "not-a-formula",
                "{text!r}: {function}() takes numbers between commas",
                "give some",
                text=text,
                function=node.func.id,
            )
        for item in node.args:
            _check(item, names, text)
    elif isinstance(node, ast.Name):
        if node.id not in names:
            raise InvalidParameter(
                "unknown-name",
                "{text!r}: no parameter is called {name!r}",
                "the recipe has {known!l}",
                text=text,
                name=node.id,
                known=list(names),
            )
    elif not (isinstance(node, ast.Constant) and type(node.value) in (int, float)):
        raise InvalidParameter(
            "not-a-formula",
            "{text!r}: a formula has numbers, parameters, + - * / // %, brackets, min and max",
            text=text,
        )


def compute(formula: Formula, params: Mapping[str, Scalar]) -> int | float:
    """Evaluate a formula.

    Raises:
        InvalidParameter: If it divides by zero, exceeds ``_LARGEST``, or uses a parameter that is
            not a number.
    """

    def at(node: ast.expr) -> int | float:
        if isinstance(node, ast.BinOp):
            value = _BINARY[type(node.op)](at(node.left), at(node.right))
        elif isinstance(node, ast.UnaryOp):
            value = -at(node.operand)
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            value = _CALLS[node.func.id]([at(item) for item in node.args])
        elif isinstance(node, ast.Name):
            value = params[node.id]
            if isinstance(value, str | bool):
                raise InvalidParameter(
                    "not-a-number",
                    "{text!r}: {name} is {value!r}, no number",
                    "leave it out",
                    text=formula.text,
                    name=node.id,
                    value=value,
                )
        else:
            value = node.value  # type: ignore[attr-defined]  # _check admits only constants here
        if not abs(value) < _LARGEST:
            raise InvalidParameter(
                "too-large",
                "{text!r} grows beyond {most}",
                "give smaller numbers",
                text=formula.text,
                most=_LARGEST,
            )
        return value  # type: ignore[no-any-return]  # _check admits only numbers

    try:
        return at(formula.tree)
    except ZeroDivisionError:
        raise InvalidParameter(
            "division-by-zero",
            "{text!r} divides by zero",
            "change it or its parameters",
            text=formula.text,
        ) from None


def value_of(spec: Spec, params: Mapping[str, Scalar], rng: RandomStream) -> Any:
    """Evaluate a value: compute a formula, draw from a range or a choice, return the rest.

    Nested values draw from child streams, so that editing one of them does not change the others.

    Raises:
        InvalidParameter: If a formula fails, or a range is empty or not numeric.
    """
    if isinstance(spec, Formula):
        return compute(spec, params)

    # The ends of a range may be formulas or drawn themselves, so they are checked only here.
    if isinstance(spec, Range):
        low, high = (
            value_of(end, params, rng.child(name))
            for name, end in (("from", spec.low), ("to", spec.high))
        )
        for end in (low, high):
            if isinstance(end, bool) or not isinstance(end, int | float) or not math.isfinite(end):
                raise InvalidParameter(
                    "not-a-number",
                    "from {low!r} to {high!r} is not a range of numbers",
                    "give two",
                    low=low,
                    high=high,
                )
        if low > high:
            raise InvalidParameter(
                "empty-range",
                "from {low} to {high} is empty",
                "give the smaller number first",
                low=low,
                high=high,
            )
        # Two whole ends give whole numbers, for which the stream has 63 bits.
        if isinstance(low, int) and isinstance(high, int):
            if high - low >= 2**63:
                raise InvalidParameter(
                    "too-large",
                    "from {low} to {high} has more than 63 bits",
                    "give numbers nearer to each other",
                    low=low,
                    high=high,
                )
            return rng.between(low, high)
        return rng.uniform(low, high)

    # The chosen option, and the items of a list, may be drawn too.
    if isinstance(spec, Choice):
        return value_of(rng.choice(spec.options), params, rng.child("any"))
    if isinstance(spec, tuple):
        return [value_of(item, params, rng.child(k)) for k, item in enumerate(spec)]
    return spec


def is_drawn(spec: Spec) -> bool:
    """Return True if evaluating the value draws a random number."""
    if isinstance(spec, tuple):
        return any(is_drawn(item) for item in spec)
    return isinstance(spec, Range | Choice)
