"""Examples for the default tier; the gate uses all values."""

from collections.abc import Iterable

import pytest


def some(values: Iterable[object], count: int = 1) -> list[object]:
    """Pass values to ``parametrize``.

    The first ones are unchanged, the others are marked for the gate.
    """
    return [value if k < count else _in_the_gate(value) for k, value in enumerate(values)]


def _in_the_gate(value: object) -> object:
    return pytest.param(*(value if isinstance(value, tuple) else (value,)), marks=pytest.mark.gate)
