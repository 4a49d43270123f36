"""The faults as numba compiles them, for what still runs in numba; goes when all of that is C."""

from __future__ import annotations

from typing import Any


def numba_fault(name: str) -> Any:
    """Return a fault's act by its name."""
    from fuzz.faults.interim import by_sight, by_touch

    attribute = name.replace("-", "_")
    return getattr(by_touch if hasattr(by_touch, attribute) else by_sight, attribute).act


def plain_fault(name: str) -> Any:
    """Return a fault's act as Python."""
    from fuzz.faults.interim import by_sight, by_touch

    return getattr(by_touch if hasattr(by_touch, name) else by_sight, name).plain
