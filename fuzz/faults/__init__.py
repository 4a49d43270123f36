"""Seeded faults: controllers of the library with one realistic fault each, to measure fault finding by.

Contents:
    Fault: a controller that says what is wrong with it, what to expect of it, and which one is
        right.
    FAULTS: all of them, by name; each is also ``fuzz.faults:NAME`` with underscores, wherever a
        controller is named.
"""

from __future__ import annotations

from typing import Any

from fuzz.faults import by_sight, by_touch
from fuzz.faults.planting import Fault

__all__ = ["FAULTS", "Fault"]

FAULTS: dict[str, Fault] = {
    getattr(module, name).name: getattr(module, name)
    for module in (by_touch, by_sight)
    for name in module.__all__
}


def __dir__() -> list[str]:
    return sorted([*globals(), *(name.replace("-", "_") for name in FAULTS)])


def __getattr__(name: str) -> Any:
    try:
        return FAULTS[name.replace("_", "-")]
    except KeyError:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}") from None
