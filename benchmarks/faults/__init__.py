"""Seeded faults: library controllers with one realistic fault each, to measure fault finding.

Contents:
    Fault: A controller with its fault, the verdict to expect, and the correct controller.
    FAULTS: All faults by name. Wherever you can name a controller, each is also available as
        ``fuzz.faults:NAME`` with underscores.
"""

from __future__ import annotations

from typing import Any

from . import by_sight, by_touch
from .planting import Fault

__all__ = ["FAULTS", "Fault"]

FAULTS: dict[str, Fault] = {
    value.name: value
    for module in (by_touch, by_sight)
    for _, value in sorted(vars(module).items())
    if isinstance(value, Fault)
}


def __dir__() -> list[str]:
    return sorted([*globals(), *(name.replace("-", "_") for name in FAULTS)])


def __getattr__(name: str) -> Any:
    try:
        return FAULTS[name.replace("_", "-")]
    except KeyError:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}") from None
