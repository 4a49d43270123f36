"""The inputs of a census: maps, pairs of start and target, and radii."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np

from worldgen.errors import InvalidParameter
from worldgen.family import check_between
from worldgen.interop.formats.text import cell_centre
from worldgen.lattice import UNIT, exact, in_cells, lattice_to_metres
from worldgen.random_streams import RandomStream
from worldgen.reach.still.lattice_graph import build_graph
from worldgen.support.arrays import Bools
from worldgen.world import DEFAULT_CELL_SIZE, Pose, Target, Value

_FORM = re.compile(r"([0-9]{1,40}\.?[0-9]{0,40}(?:[eE][+-]?[0-9]{1,3})?)\s*(m|c|cells?)?")


@dataclass(frozen=True)
class Radius:
    """A radius, as in ``--radius``.

    Args:
        value: The number.
        cells: True if it counts cells rather than m.
    """

    value: float
    cells: bool = False

    @classmethod
    def parse(cls, text: str) -> Radius:
        """Parse a radius: ``0.3`` or ``0.3m`` is in m, ``0.7c`` in cells.

        Raises:
            InvalidParameter: If the text is neither, or out of range.
        """
        found = _FORM.fullmatch(text.strip())
        if found is None:
            raise InvalidParameter(
                "wrong-form",
                "radius={text!r} is not a radius",
                "write 0.3 for metres, or 0.7c for cells",
                text=text[:40],
            )
        radius = cls(float(found[1]), (found[2] or "m").startswith("c"))
        check_between("radius", radius.value, 1e-9, 1e9, "cells" if radius.cells else "m")
        return radius

    def metres(self, cell_size: float) -> float:
        """Return the radius in m, on a map with cells of ``cell_size`` m."""
        return float(exact(self.value) * exact(cell_size)) if self.cells else self.value

    def in_cells(self, cell_size: float) -> Fraction:
        """Return exactly the radius of :meth:`metres`, in cells."""
        return in_cells(self.metres(cell_size), cell_size)

    def __str__(self) -> str:
        return f"{self.value:g} cells" if self.cells else f"{self.value:g} m"


DEFAULT_RADII = (Radius(0.45, True), Radius(0.7, True), Radius(1.0, True))


@dataclass(frozen=True)
class Ends:
    """A start and a target.

    Args:
        start: Pose of the robot's centre.
        target: Disc that the centre has to enter.
        named: True if the map names them; False if they were drawn.
    """

    start: Pose
    target: Target
    named: bool = True


@dataclass(frozen=True, eq=False)
class CensusMap:
    """A map to judge.

    Args:
        name: Part of the seed of drawn ends; a census adds a number to a repeated name.
        walls: (height, width) bool, True is solid; row 0 is the lowest y.
        cell_size: Side of a cell, m.
        ends: Starts and targets that the map names; if it names none, they are drawn.
        params: Facts about the source, for the provenance of worlds that are kept.
        notes: Sentences worth knowing.
    """

    name: str
    walls: Bools
    cell_size: float = DEFAULT_CELL_SIZE
    ends: tuple[Ends, ...] = ()
    params: Mapping[str, Value] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Refused:
    """A map that could not be judged: its name, and a sentence that gives the reason."""

    name: str
    reason: str


def cell_ends(
    start: tuple[int, int], target: tuple[int, int], cell_size: float, *, named: bool = True
) -> Ends:
    """Return ends from the centre of one cell to the disc inscribed in another.

    Args:
        start: Column and row; row 0 is the lowest.
        target: Same as above.
        cell_size: m.
        named: True if the map names them.
    """
    half = lattice_to_metres(UNIT // 2, cell_size)
    at = cell_centre(*start, cell_size)
    to = cell_centre(*target, cell_size)
    return Ends(Pose(*at), Target(*to, half), named)


def cell_at(walls: Bools, cell_size: float, x: float, y: float) -> tuple[int, int]:
    """Return the row and column of the cell that holds a point.

    Args:
        walls: (height, width) bool, row 0 the lowest y.
        cell_size: m.
        x: x of the point, m; a point on the map's far sides belongs to the last cell.
        y: y of the point, m.
    """
    column, row = (math.floor(in_cells(value, cell_size)) for value in (x, y))
    height, width = walls.shape
    return min(row, height - 1), min(column, width - 1)


def draw_ends(
    case: CensusMap, pairs: int, rng: RandomStream, clear_for: Fraction | None
) -> tuple[Ends, ...]:
    """Draw pairs of different free cells, all equally likely.

    Args:
        case: The map.
        pairs: Number of pairs to draw.
        rng: The only source of randomness.
        clear_for: Radius, cells, of a disc that must be clear at the centres of both cells, if any.

    Raises:
        InvalidParameter: If there are no two such cells.
    """
    # Ends are free cells, with room for the disc if requested.
    free = ~case.walls
    if clear_for is not None:
        free &= _clear_centres(case.walls, clear_for)
    places = np.flatnonzero(free)
    if len(places) < 2:
        disc = (
            "" if clear_for is None else f" in which a disc of {float(clear_for):g} cells has room"
        )
        raise InvalidParameter(
            "no-room", "the map does not have two free cells{disc} for start and target", disc=disc
        )
    # Draw two different cells for each pair, without bias.
    drawn = []
    for _ in range(pairs):
        first = rng.below(len(places))
        second = rng.below(len(places) - 1)
        second += second >= first
        ends = []
        for index in (first, second):
            row, column = divmod(int(places[index]), free.shape[1])
            ends.append((column, row))
        drawn.append(cell_ends(ends[0], ends[1], case.cell_size, named=False))
    return tuple(drawn)


def _clear_centres(walls: Bools, radius: Fraction) -> Bools:
    # The disc is wider than the map, so no centre is clear.
    if 2 * radius > max(walls.shape):
        return np.zeros_like(walls)
    return build_graph(walls, radius, 2).clear[1::2, 1::2]
