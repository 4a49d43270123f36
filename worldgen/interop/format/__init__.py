"""What a format is, and what its reader returns.

Contents:
    FORMATS, Format: The formats by name, and the definition of one.
    Destination, Exported: What a writer gets and returns.
    ForeignMap, UsualRobot, THESIS_ROBOT: What a reader returns (``foreign_map``).
    HELD, PAIRS, LENGTHS, KINDS, ROBOT_FACTS, PLAIN_FACTS, fact_numbers: Facts that a file may be
        unable to store.
    held_values, robot_values, robot_kinds, held_lines: Their values in a world.
    decimal, decimal_text, degrees_text, radians: Exact numbers as text.
"""

from worldgen.interop.format.definition import (
    FORMATS,
    HELD,
    KINDS,
    LENGTHS,
    PAIRS,
    PLAIN_FACTS,
    ROBOT_FACTS,
    Destination,
    Exported,
    Format,
    decimal,
    decimal_text,
    degrees_text,
    fact_numbers,
    held_lines,
    held_values,
    radians,
    robot_kinds,
    robot_values,
)
from worldgen.interop.format.foreign_map import THESIS_ROBOT, ForeignMap, UsualRobot

__all__ = [
    "FORMATS",
    "HELD",
    "KINDS",
    "LENGTHS",
    "PAIRS",
    "PLAIN_FACTS",
    "ROBOT_FACTS",
    "THESIS_ROBOT",
    "Destination",
    "Exported",
    "ForeignMap",
    "Format",
    "UsualRobot",
    "decimal",
    "decimal_text",
    "degrees_text",
    "fact_numbers",
    "held_lines",
    "held_values",
    "radians",
    "robot_kinds",
    "robot_values",
]
