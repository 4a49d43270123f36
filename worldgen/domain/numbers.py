"""Limits on the numbers of a world.

The limits are far beyond any robot's, and small enough that a length in 1/1024 cell, its square and
a time in microseconds fit into 64 bits. So no other code has to handle numbers that are too large
or too small.
"""

from __future__ import annotations

import math
import re
from typing import Final

from worldgen.errors import Message

MASK64: Final = (1 << 64) - 1
"""All bits of a 64-bit word, and the largest seed."""

MAX_SIDE: Final = 20_000
"""Limit on the cells in a row or a column."""

MAX_ROBOTS: Final = 1000
"""Limit on the robots of a world; each is compared with every other."""

CELL_SIZES: Final = (1e-6, 1e6)
"""Side of a cell, m."""

RADII: Final = (1e-6, float(MAX_SIDE))
"""Radius of the robot's disc, and of the target's, in cells."""

SPEEDS: Final = (1e-6, 1e9)
"""Top speed, in cells a second."""

LATEST: Final = 1e9
"""Latest time of a change, s; 31 years."""

DECIMAL: Final = re.compile(
    r"[+-]?(?:[0-9]{1,700}\.?[0-9]{0,700}|\.[0-9]{1,700})(?:[eE][+-]?[0-9]{1,3})?"
)
"""A decimal number in a text; it has room for the sum of any two float64, written in full."""


def radius_fault(name: str, radius: float, cell_size: float) -> Message | None:
    """Describe what is wrong with a radius in m.

    Return None if it suits a robot or a target.
    """
    return number_fault(name, radius, (RADII[0] * cell_size, RADII[1] * cell_size), "m")


def speed_fault(name: str, speed: float, cell_size: float) -> Message | None:
    """Describe what is wrong with a speed in m/s; return None if it suits a robot."""
    return number_fault(name, speed, (SPEEDS[0] * cell_size, SPEEDS[1] * cell_size), "m/s")


def number_fault(name: str, value: float, limits: tuple[float, float], unit: str) -> Message | None:
    """Describe what is wrong with a number that must be above 0 and within two limits.

    Return None if nothing is wrong.
    """
    if not (math.isfinite(value) and value > 0.0):
        return Message(
            "not-positive",
            "{name}={value}: must be a finite number above 0",
            name=name,
            value=value,
        )
    low, high = limits
    if low <= value <= high:
        return None
    return Message(
        "out-of-range",
        "{name}={value!n}{unit!u} is outside {low!n} to {high!n}{unit!u}",
        "use one between",
        name=name,
        value=value,
        low=low,
        high=high,
        unit=unit,
    )
