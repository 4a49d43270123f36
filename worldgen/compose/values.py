"""Parse and evaluate a recipe's values: constants, formulas, ranges and choices."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

from worldgen.errors import InvalidParameter
from worldgen.parameters.expressions import Language, Node, evaluate, parse_number, variables_in
from worldgen.random_streams import RandomStream

Scalar: TypeAlias = bool | int | float | str

# Above this limit a float cannot represent every whole number.
_LARGEST = 2**53


def _least(*values: float) -> float:
    return min(values)


def _largest(*values: float) -> float:
    return max(values)


_FORMULAS = Language(
    variables=(),
    noun="parameter",
    longest=200,
    example="size // 2 - 3",
    functions={"min": _least, "max": _largest},
)


@dataclass(frozen=True)
class Formula:
    """Compute a number from parameters, as in ``= size // 2 - 3``."""

    text: str
    number: Node


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
        InvalidParameter: If it is not one of these, or nested too deeply.
    """
    # Nobody needs deeper nesting, and the limit keeps a hostile file from exhausting the stack.
    if depth > 4:
        raise InvalidParameter("nested-too-deep", "values are nested too deeply", "flatten them")
    if isinstance(raw, str) and raw.lstrip().startswith("="):
        text = raw.strip()[1:].strip()
        return Formula(text, parse_number(text, replace(_FORMULAS, variables=tuple(names))))
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
        'write a value, "= a formula", {{ from = 1, to = 3 }} or {{ any = [...] }}',
        value=shown[:80],
    )


def compute(formula: Formula, params: Mapping[str, Scalar]) -> int | float:
    """Evaluate a formula.

    Raises:
        InvalidParameter: If it divides by zero, exceeds ``_LARGEST``, or uses a parameter that is
            not a number.
    """
    for name in variables_in(formula.number):
        value = params[name]
        if isinstance(value, str | bool):
            raise InvalidParameter(
                "not-a-number",
                "{text!r}: {name} is {value!r}, which is not a number",
                "leave it out",
                text=formula.text,
                name=name,
                value=value,
            )
    found: int | float = math.inf
    try:
        found = evaluate(formula.number, params)
    except ZeroDivisionError:
        raise InvalidParameter(
            "division-by-zero",
            "{text!r} divides by zero",
            "change the formula or its parameters",
            text=formula.text,
        ) from None
    except OverflowError:
        pass  # too large even for a float, and refused below
    if not abs(found) < _LARGEST:
        raise InvalidParameter(
            "too-large",
            "{text!r} grows beyond {most}",
            "write smaller numbers",
            text=formula.text,
            most=_LARGEST,
        )
    return found


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
                    "write two",
                    low=low,
                    high=high,
                )
        if low > high:
            raise InvalidParameter(
                "empty-range",
                "from {low} to {high} is empty",
                "write the smaller number first",
                low=low,
                high=high,
            )
        # If both ends are integers, so is the value, for which the stream has 63 bits.
        if isinstance(low, int) and isinstance(high, int):
            if high - low >= 2**63:
                raise InvalidParameter(
                    "too-large",
                    "from {low} to {high} has more than 63 bits",
                    "write numbers nearer to each other",
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
