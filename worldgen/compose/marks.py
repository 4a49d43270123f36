"""Marks: named places of a piece, in exact fractions of a cell."""

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

START = "start"
TARGET = "target"
HALF = Fraction(1, 2)

Marks: TypeAlias = Mapping[str, "Mark"]
MovePoint: TypeAlias = Callable[[Fraction, Fraction], tuple[Fraction, Fraction]]


@dataclass(frozen=True)
class Mark:
    """Name a place of a piece.

    Args:
        x: Cells from the piece's left side.
        y: Cells from its lower side.
        heading: In 1/65536 turns, counter-clockwise from +x; ``None`` if the mark has no heading. At
            the target, the robot must have it when it arrives.
        radius: Radius of the target's disc, cells; ``None`` for other marks.
    """

    x: Fraction
    y: Fraction
    heading: int | None = None
    radius: Fraction | None = None


def frozen(marks: Marks) -> Marks:
    """Return the marks as a read-only mapping, sorted by name."""
    return MappingProxyType(dict(sorted(marks.items())))


def mark_at(x: float, y: float, degrees: float | None = None, radius: float | None = None) -> Mark:
    """Create a mark from a user's numbers.

    Each float means its shortest decimal: 0.1 becomes exactly 1/10.

    Args:
        x: Cells from the piece's left side.
        y: Cells from its lower side.
        degrees: Heading, counter-clockwise from +x.
        radius: Radius of the target's disc, cells.

    Raises:
        InvalidParameter: If a number is not finite, or the radius is not positive.
    """
    numbers: list[Fraction | None] = []
    for value in (x, y, degrees, radius):
        if value is None:
            numbers.append(None)
            continue
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e9:
            raise InvalidParameter(
                "not-a-number",
                "{value!r} is not a place in cells or degrees",
                "use a number below 1e9",
                value=value,
            )
        numbers.append(exact(value))
    place_x, place_y, angle, disc = numbers
    if disc is not None and disc <= 0:
        raise InvalidParameter(
            "not-positive",
            "radius={radius!r} of a target must be above 0 cells",
            "use 0.5 for half a cell",
            radius=radius,
        )
    heading = None if angle is None else math.floor(angle / 360 * TURN + HALF) % TURN
    return Mark(place_x or Fraction(0), place_y or Fraction(0), heading, disc)


def marks_of(world: World) -> Marks:
    """Return the start and the target of a world as marks."""
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
                None if target.heading is None else heading_to_lattice(target.heading),
                in_cells(target.radius, side),
            ),
        }
    )


def moved(
    marks: Marks, place: MovePoint, width: int, height: int, turn: int = 0, sign: int = 1
) -> Marks:
    """Map marks into a new frame, and drop those that end up outside.

    Args:
        marks: Marks in the old frame.
        place: Maps a place in the old frame to the new frame.
        width: Width of the new frame, cells.
        height: Height of the new frame, cells.
        turn: Angle to add to headings, in 1/65536 turns.
        sign: Factor that headings are multiplied by first; -1 for a mirror image.
    """
    new = {}
    for name, mark in marks.items():
        x, y = place(mark.x, mark.y)
        if 0 <= x <= width and 0 <= y <= height:
            heading = None if mark.heading is None else (sign * mark.heading + turn) % TURN
            new[name] = replace(mark, x=x, y=y, heading=heading)
    return frozen(new)


def pose_of(start: Mark, target: Mark, cell_size: float) -> Pose:
    """Convert a start mark to a world's start pose.

    A start without a heading faces the target, rounded to a quarter turn.
    """
    heading = start.heading
    if heading is None:
        dx = target.x - start.x
        dy = target.y - start.y
        quarters = (0 if dx >= 0 else 2) if abs(dx) >= abs(dy) else (1 if dy > 0 else 3)
        heading = quarters * TURN // 4
    side = exact(cell_size)
    return Pose(float(start.x * side), float(start.y * side), heading_from_lattice(heading))


def target_of(target: Mark, cell_size: float, goal: Target) -> Target:
    """Convert a target mark to a world's target; the radius defaults to half a cell.

    Args:
        target: The mark.
        cell_size: Side of a cell, m.
        goal: What else counts as arriving; its place, radius and heading are replaced.
    """
    side = exact(cell_size)
    return replace(
        goal,
        x=float(target.x * side),
        y=float(target.y * side),
        radius=float((target.radius or HALF) * side),
        heading=None if target.heading is None else heading_from_lattice(target.heading),
    )
