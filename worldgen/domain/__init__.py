"""What a world can be: limits on its numbers, and rules for its robots.

Contents:
    MASK64, MAX_SIDE, MAX_ROBOTS, CELL_SIZES, RADII, SPEEDS, LATEST: The limits (``numbers``).
    DECIMAL: Pattern of a decimal number.
    number_fault, radius_fault, speed_fault: What is wrong with a number.

What is wrong with a pair of robots is in ``robot_pairs``, which only a fleet needs.
"""

from worldgen.domain.numbers import (
    CELL_SIZES,
    DECIMAL,
    LATEST,
    MASK64,
    MAX_ROBOTS,
    MAX_SIDE,
    RADII,
    SPEEDS,
    number_fault,
    radius_fault,
    speed_fault,
)

__all__ = [
    "CELL_SIZES",
    "DECIMAL",
    "LATEST",
    "MASK64",
    "MAX_ROBOTS",
    "MAX_SIDE",
    "RADII",
    "SPEEDS",
    "number_fault",
    "radius_fault",
    "speed_fault",
]
