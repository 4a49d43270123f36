"""The rules of ``.grid`` files as data: keys, sections, words, limits.

``docs/reference/grid-format.md`` has the same in prose; a test keeps the two in agreement. This
module imports neither the reader nor the writer, which both follow it.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Final, NamedTuple

import numpy as np

from worldgen.robot import (
    ARRIVALS,
    CONTACTS,
    DEFAULT_ARRIVAL_SPEED,
    DEFAULT_ARRIVAL_TURN_RATE,
    DEFAULT_HEADING_TOLERANCE,
    DEFAULT_ROBOT_SPEED,
)
from worldgen.timeline import CellState

# One disc that turns on the spot and has to touch its target.
MAGIC: Final = "%worldgen-grid 1"
# Robots of any kind, each in a [[robot]] table.
TABLES_MAGIC: Final = "%worldgen-grid 2"
END: Final = "end"
# In this order; each occurs at most once.
SECTIONS: Final = ("cells", "timeline", "witness", "cut", END)

SOLID: Final = "#"
FREE: Final = "."
START: Final = "S"
TARGET: Final = "G"

STATES: Final = {state.word: state for state in CellState}
CERTIFICATE_KINDS: Final = ("witness", "cut")
DRIVES: Final = ("car",)

REQUIRED: Final = object()
"""Default of a key that must be there."""


class Key(NamedTuple):
    """A key of the header.

    Args:
        kind: What its value is: ``number``, ``length`` (above 0), ``pose``, ``disc`` (two
            or three numbers, the last of a disc above 0), ``corners`` (a list of pairs), ``tables``
            (a list of tables, whose keys its reader checks), ``flag``, ``text``, ``name`` (text that
            may name code), ``integer``, ``values`` (a table of any), ``metrics`` (a table of numbers),
            or ``any``, which its reader decides.
        example: A typical value.
        meaning: What it says, with its unit.
        default: Its value if it is missing.
    """

    kind: str
    example: str
    meaning: str
    default: object = REQUIRED


# Header keys in the order in which the writer puts them.
HEADER_KEYS: Final = {
    "cell_size": Key("length", "0.1", "side of a cell, m"),
    "robot_radius": Key("length", "0.25", "radius of the robot's disc, m"),
    "robot_speed": Key("length", "1.0", "top speed of the robot, m/s", DEFAULT_ROBOT_SPEED),
    # A mark in the cells takes the place of either.
    "start": Key("pose", "[0.35, 5.65, 0.0]", "x m, y m, heading rad"),
    "target": Key("disc", "[5.55, 0.45, 0.05]", "x m, y m, radius m"),
}
# Version 2 has these instead: one [[robot]] table for each robot.
TABLES_HEADER_KEYS: Final = {"cell_size": HEADER_KEYS["cell_size"]}
# Keys of a goal, after its place.
_GOAL_KEYS: Final = {
    "target_heading": Key("number", "1.5708", "heading that it must have there, rad", None),
    "heading_tolerance": Key(
        "number", "0.1", "largest difference from it, rad", DEFAULT_HEADING_TOLERANCE
    ),
    "arrival": Key("text", '"step"', f"what counts as arriving: {', '.join(ARRIVALS)}", "touch"),
    "arrival_speed": Key(
        "number", "0.02", "speed up to which it stands, m/s", DEFAULT_ARRIVAL_SPEED
    ),
    "arrival_turn_rate": Key(
        "number", "0.02", "turn rate up to which it stands, rad/s", DEFAULT_ARRIVAL_TURN_RATE
    ),
}
# Keys of each table in the list `waypoints`.
WAYPOINT_KEYS: Final = {"target": HEADER_KEYS["target"], **_GOAL_KEYS}
# Keys of a [[robot]] table in the order in which the writer puts them. It has either a radius or a
# footprint. The defaults are those of `worldgen.robot`.
ROBOT_KEYS: Final = {
    "start": HEADER_KEYS["start"],
    "target": HEADER_KEYS["target"],
    **_GOAL_KEYS,
    "contact": Key("text", '"fail"', f"what a wall does to a move: {', '.join(CONTACTS)}", None),
    "radius": HEADER_KEYS["robot_radius"]._replace(default=None),
    "footprint": Key(
        "corners",
        "[[0.45, -0.31], [0.45, 0.31], [-0.45, 0.31], [-0.45, -0.31]]",
        "corners of its convex body, m ahead of its axle and to its left",
        (),
    ),
    "speed": HEADER_KEYS["robot_speed"],
    "drive": Key("text", '"car"', "that it cannot turn on the spot", None),
    "turning_radius": Key("length", "0.5", "smallest radius of a car's arcs, m", 0.0),
    "reverse": Key("flag", "true", "whether a car may drive backwards", False),
    "steering_rate": Key(
        "number", "2.0", "largest change of a car's curvature, shares of the largest a second", 0.0
    ),
    "waypoints": Key(
        "tables",
        "[{ target = [1.5, 0.5, 0.05] }]",
        "goals that it must arrive at before the target, in order",
        (),
    ),
}
TABLE_KEYS: Final = {
    "provenance": {
        "family": Key("name", '"maze"', "what made the world"),
        "version": Key("integer", "1", "version of the family"),
        "seed": Key("integer", "7", "its seed"),
        "params": Key("values", "{ size = 60 }", "its options", {}),
        "metrics": Key("metrics", "{ detour = 1.5 }", "numbers measured in the world", {}),
    },
    "certificate": {
        "kind": Key("any", '"witness"', '"witness" or "cut"'),
        "clearance": Key("any", "0.1", "m"),
    },
    "failure": {
        "controller": Key("name", '"turn-right"', "the controller"),
        "motion": Key("text", '"swept"', "the motion model"),
        "seed": Key("integer", "1", "seed of the run"),
        "verdict": Key("text", '"loop"', "how the run ended"),
        "trace_digest": Key("text", '"1f2e"', "digest of every state"),
        "parameters": Key("values", "{ steps = 100 }", "options of the run", {}),
        "evidence": Key("values", "{ period = 8 }", "what proves the verdict", {}),
        "details": Key("values", "{ }", "anything else about the failure", {}),
    },
}
TABLES_TABLE_KEYS: Final = TABLE_KEYS | {
    "certificate": {
        "kind": TABLE_KEYS["certificate"]["kind"],
        "robot": Key("integer", "1", "number, from 1, of the robot that a cut stops", None),
        "waypoint": Key(
            "integer", "1", "number, from 1, of the waypoint that a cut separates", None
        ),
        "clearance": TABLE_KEYS["certificate"]["clearance"],
    }
}

# A header has a few pages at most; parsing TOML takes 100 times its size in memory.
MAX_HEADER_BYTES: Final = 1 << 20
# The largest world, 20000 x 20000, takes 382 MiB.
MAX_FILE_BYTES: Final = 512 << 20
# deflate can reach 1032; more than this is a decompression bomb, or an empty plain.
EXPANSION_RATIO: Final = 1000
# Bytes that any compressed file may expand to.
EXPANSION_FLOOR: Final = 64 << 20
# Brackets open at once, nested values, and parts of a dotted key.
MAX_DEPTH: Final = 32
# Seeds have 64 bits; reading a number's digits takes quadratic time.
MAX_INTEGER_BITS: Final = 1024
# Characters of a number or bare key in the header.
MAX_WORD: Final = 2000
# Digits of a decimal in a section, on either side of its point; float64 needs 309.
MAX_DIGITS: Final = 400

# Words of [failure] that commands print, count and look up. An unknown one is fine, since a newer
# version may know it, but it must be a word, without blanks, line ends or control characters.
WORD_KEYS: Final = {"motion": "swept", "verdict": "loop"}
WORD: Final = re.compile(r"[a-z][a-z0-9-]{0,63}\Z")

BARE_KEY: Final = re.compile(r"[A-Za-z0-9_-]{1,64}\Z")

_NUMBER = rb"[0-9]{1,%d}(?:\.[0-9]{1,%d})?(?:[eE][+-]?[0-9]{1,4})?" % (MAX_DIGITS, MAX_DIGITS)
_WHOLE = rb"[0-9]{1,19}"


class Field(NamedTuple):
    """One word of a line.

    Args:
        name: Its name in messages and in the documentation.
        pattern: Pattern that it must match.
        rule: The pattern in prose.
        read: Converts a matching word to a number.
        dtype: NumPy type of the numbers.
    """

    name: str
    pattern: bytes
    rule: str
    read: Callable[[bytes], float]
    dtype: type[np.generic]


class LineSection(NamedTuple):
    """A section of lines with a fixed number of words, separated by single spaces."""

    name: str
    fields: tuple[Field, ...]
    example: str

    @property
    def form(self) -> str:
        """The form of a line."""
        return " ".join(field.name for field in self.fields)


def _state(word: bytes) -> int:
    return int(STATES[word.decode("ascii")])


def _decimal(name: str, *, signed: bool = True) -> Field:
    rule = (
        "a decimal number, like 0.35 or -2e-05"
        if signed
        else "a decimal number, 0 or more, like 12.5"
    )
    return Field(name, b"-?" * signed + _NUMBER, rule, float, np.float64)


def _index(name: str, *, signed: bool) -> Field:
    rule = f"a whole number{'' if signed else ', 0 or more'}, of 64 bits"
    return Field(name, b"-?" * signed + _WHOLE, rule, int, np.int64)


TIMELINE: Final = LineSection(
    "timeline",
    (
        _decimal("time", signed=False),
        _index("ix", signed=False),
        _index("iy", signed=False),
        Field(
            "state",
            b"(?:%s)" % "|".join(STATES).encode(),
            f"one of {', '.join(STATES)}",
            _state,
            np.uint8,
        ),
    ),
    "12.5 8 3 burning",
)
WITNESS: Final = LineSection(
    "witness", tuple(_decimal(name) for name in ("time", "x", "y")), "0.0 0.35 5.65"
)
ROBOTS_WITNESS: Final = LineSection(
    "witness", (_index("robot", signed=False), *WITNESS.fields), "2 0.0 0.35 5.65"
)
HEADING_WITNESS: Final = LineSection(
    "witness", (*ROBOTS_WITNESS.fields, _decimal("heading")), "1 0.0 0.35 5.65 1.5708"
)
CUT: Final = LineSection("cut", tuple(_index(name, signed=True) for name in ("ix", "iy")), "8 3")
BODY_CUT: Final = LineSection(
    "cut",
    tuple(
        _index(name, signed=True) for name in ("heading", "span", "side", "y", "x_begin", "x_end")
    ),
    "8192 256 64 1024 2048 2560",
)
LINE_SECTIONS: Final = {section.name: section for section in (TIMELINE, WITNESS, CUT)}
