"""Marks: named places of a piece, in cells, exactly."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from types import MappingProxyType
from typing import TypeAlias

from worldgen.errors import InvalidParameter
from worldgen.lattice import TURN, exact, heading_from_lattice, heading_to_lattice, in_cells
from worldgen.world import Pose, Target, World

__all__ = [
    "HALF",
    "START",
    "TARGET",
    "Mark",
    "Marks",
    "frozen",
    "mark_at",
    "marks_of",
    "moved",
    "pose_of",
    "target_of",
]

START = "start"
TARGET = "target"
HALF = Fraction(1, 2)

Marks: TypeAlias = Mapping[str, "Mark"]
Place: TypeAlias = Callable[[Fraction, Fraction], tuple[Fraction, Fraction]]


@dataclass(frozen=True)
class Mark:
    """A named place.

    Args:
        x: Cells from the piece's left side.
        y: Cells from its lower side.
        heading: In 1/65536 turns, counter-clockwise from +x; ``None`` where the mark has none.
        radius: In cells, of the target's disc; ``None`` elsewhere.
    """

    x: Fraction
    y: Fraction
    heading: int | None = None
    radius: Fraction | None = None


def frozen(marks: Marks) -> Marks:
    """The marks as a mapping that nobody can change, in order of their names."""
    return MappingProxyType(dict(sorted(marks.items())))


def mark_at(x: float, y: float, degrees: float | None = None, radius: float | None = None) -> Mark:
    """A mark from numbers as people give them; each means its shortest decimal.

    Raises:
        InvalidParameter: If one is no finite number.
    """
    numbers: list[Fraction | None] = []
    for value in (x, y, degrees, radius):
        if value is None:
            numbers.append(None)
            continue
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e9:
            raise InvalidParameter(
                "not-a-number",
                "{value!r} is no place in cells or degrees",
                "give a number below 1e9",
                value=value,
            )
        numbers.append(exact(value))
    place_x, place_y, angle, disc = numbers
    if disc is not None and disc <= 0:
        raise InvalidParameter(
            "not-positive",
            "radius={radius!r} of a target must be above 0 cells",
            "give 0.5 for half a cell",
            radius=radius,
        )
    heading = None if angle is None else math.floor(angle / 360 * TURN + HALF) % TURN
    return Mark(place_x or Fraction(0), place_y or Fraction(0), heading, disc)


def marks_of(world: World) -> Marks:
    """Start and target of a world."""
    start = world.start
    target = world.target
    side = world.cell_size
    return frozen(
        {
            START: Mark(
                in_cells(start.x, side), in_cells(start.y, side), heading_to_lattice(start.heading)
            ),
            TARGET: Mark(
                in_cells(target.x, side),
                in_cells(target.y, side),
                radius=in_cells(target.radius, side),
            ),
        }
    )


def moved(
    marks: Marks, place: Place, width: int, height: int, turn: int = 0, sign: int = 1
) -> Marks:
    """Marks where a change of the piece puts them; those that then lie outside are left out.

    Args:
        marks: In the old frame.
        place: From a place in the old frame to one in the new.
        width: Cells of the new frame in x.
        height: In y.
        turn: Added to headings, in 1/65536 turns.
        sign: Headings are multiplied by it first; -1 for a mirror.
    """
    new = {}
    for name, mark in marks.items():
        x, y = place(mark.x, mark.y)
        if 0 <= x <= width and 0 <= y <= height:
            heading = None if mark.heading is None else (sign * mark.heading + turn) % TURN
            new[name] = replace(mark, x=x, y=y, heading=heading)
    return frozen(new)


def pose_of(start: Mark, target: Mark, cell_size: float) -> Pose:
    """The start as a world has it.

    Without a heading of its own it looks towards the target, to a quarter turn.
    """
    heading = start.heading
    if heading is None:
        dx = target.x - start.x
        dy = target.y - start.y
        quarters = (0 if dx >= 0 else 2) if abs(dx) >= abs(dy) else (1 if dy > 0 else 3)
        heading = quarters * TURN // 4
    side = exact(cell_size)
    return Pose(float(start.x * side), float(start.y * side), heading_from_lattice(heading))


def target_of(target: Mark, cell_size: float) -> Target:
    """The target as a world has it; its disc is half a cell where the mark does not say."""
    side = exact(cell_size)
    return Target(
        float(target.x * side), float(target.y * side), float((target.radius or HALF) * side)
    )
