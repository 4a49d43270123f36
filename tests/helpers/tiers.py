"""Examples for the default tier of what the gate does with all."""

from collections.abc import Iterable

import pytest


def some(values: Iterable[object], count: int = 1) -> list[object]:
    """Give values to ``parametrize``.

    The first ones as they are, the others marked for the gate.
    """
    return [value if k < count else _in_the_gate(value) for k, value in enumerate(values)]


def _in_the_gate(value: object) -> object:
    return pytest.param(*(value if isinstance(value, tuple) else (value,)), marks=pytest.mark.gate)
