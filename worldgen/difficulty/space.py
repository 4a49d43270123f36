"""The parameters of a family as a search space.

A family declares types, defaults and choices, and refuses values that are out of range. So a value
is varied according to its type and default, and values that the family refuses are dropped.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

from worldgen.family import MARGIN, Family, Parameter
from worldgen.random_streams import RandomStream
from worldgen.world import Value

KEPT = frozenset({"robot_radius", "robot_speed", MARGIN})
"""Never varied, because they belong to the robot."""

# Factors of the default: how small and how large worlds may become.
_SIZE = (0.5, 2.0)
# Value of a number that the family chooses itself.
_CHOSEN = -1


def free_parameters(family: Family, given: Collection[str]) -> tuple[Parameter, ...]:
    """Return the parameters that a search may vary.

    These are the ones not given, except the robot's and texts without choices.
    """
    return tuple(
        known
        for known in family.parameters
        if known.name not in given
        and known.name not in KEPT
        and (known.choices or not isinstance(known.default, str))
    )


def drawn(free: Collection[Parameter], rng: RandomStream, share: float) -> dict[str, Value]:
    """Return random values for a share of the parameters; the others keep their defaults."""
    return {known.name: _any_value(known, rng) for known in free if rng.random() < share}


def varied(
    free: Collection[Parameter], values: Mapping[str, Value], rng: RandomStream
) -> dict[str, Value]:
    """Return the values with one or two of them changed.

    A change is a step up or down, another choice, or a return to the default.
    """
    found = dict(values)
    choices = list(free)
    for _ in range(1 + rng.below(2)):
        if choices:
            known = rng.choice(choices)
            found[known.name] = _next_value(known, found.get(known.name, known.default), rng)
    return {name: value for name, value in found.items() if value != _default(free, name)}


def mixed(
    one: Mapping[str, Value], other: Mapping[str, Value], rng: RandomStream
) -> dict[str, Value]:
    """Take each value from one of two parents."""
    names = [*one, *(name for name in other if name not in one)]
    chosen = {name: (one if rng.below(2) else other).get(name) for name in names}
    return {name: value for name, value in chosen.items() if value is not None}


def _default(free: Collection[Parameter], name: str) -> Value:
    found: Value = next(known.default for known in free if known.name == name)
    return found


def _any_value(known: Parameter, rng: RandomStream) -> Value:
    default: Value = known.default
    if known.choices:
        return rng.choice(known.choices)
    if isinstance(default, bool):
        return rng.below(2) == 1
    if known.name == "size" and isinstance(default, int):
        return rng.between(round(_SIZE[0] * default), round(_SIZE[1] * default))
    if isinstance(default, int):
        low = _CHOSEN if default == _CHOSEN else 0
        return max(
            low,
            int(rng.uniform(1.0, 4.0) ** rng.uniform(0.0, 2.5)) - (rng.below(2) if low < 1 else 0),
        )
    if known.name == "cell_size" and isinstance(default, float):
        return _rounded(rng.uniform(0.6, 1.5) * default)
    if isinstance(default, float):
        return _rounded(
            rng.random()
            if 0.0 <= default <= 1.0 or default == _CHOSEN
            else default * _factor(rng, 4.0)
        )
    return default


def _next_value(known: Parameter, value: Value, rng: RandomStream) -> Value:
    """Return a value near another one, or, once in four times, any value."""
    # Now and then start from anywhere, to leave a local minimum.
    if known.choices or isinstance(value, bool | str) or rng.below(4) == 0:
        return _any_value(known, rng)
    if rng.below(8) == 0:
        default: Value = known.default
        return default
    if isinstance(value, int):
        step = max(1, round(abs(value) * rng.uniform(0.0, 0.5)))
        return value + (step if rng.below(2) else -step)
    if isinstance(value, float):
        if known.name == "cell_size":
            return _rounded(value * _factor(rng, 1.15))
        if 0.0 <= value <= 1.0:
            return _rounded(min(1.0, max(0.0, value + rng.uniform(-0.3, 0.3))))
        return _rounded(value * _factor(rng, 1.5))
    return value


def _factor(rng: RandomStream, most: float) -> float:
    return rng.uniform(1.0, most) if rng.below(2) else 1.0 / rng.uniform(1.0, most)


def _rounded(value: float) -> float:
    """Round to three decimals, so that the command that makes the world again is readable."""
    return round(value, 3)
