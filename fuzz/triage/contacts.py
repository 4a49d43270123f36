"""What kinds of wall a robot touches, goes round or is shut in by.

Facts that no mirror, turn or shift changes. Everything is worked out in cells, from the recorded
path alone. What lies outside the grid is solid, so that a world within a thicker border has the
same contacts.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sim.trace import Trace
from worldgen.world import World

__all__ = ["KINDS", "Contact", "contacts", "enclosure", "part_of", "times_round"]

KINDS = ("nook", "end", "post", "corner", "wall")
"""Kinds of contact, the one that says most first.

Two walls at once, a wall's end, a cell that stands alone, a corner
that sticks out, and the face of a wall."""

_ENCLOSURES = ("open", "side", "bend", "passage", "pocket", "closed")

_SLACK = 0.02  # cells: walls that are no further away than the nearest one and this are touched too
_SAME_SIDE = 0.7  # least cosine between the normals of one wall; 45 degrees
_ALONG = 0.08  # greatest sine between an axis and the normal of a face
_LOOK = 4  # cells, in each of the four directions, in which a wall shuts a place in
_ROUNDING = 1e-6  # cells: a place so near to a line between cells is in both

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Contact:
    """A place where the robot touches walls.

    Args:
        kind: One of :data:`KINDS`.
        cells: The solid cells touched, (ix, iy); they may lie outside the grid.
    """

    kind: str
    cells: frozenset[tuple[int, int]]


def contacts(world: World, trace: Trace, first: int, last: int) -> list[Contact]:
    """Where the robot begins to touch a wall in the steps from ``first`` to ``last``, one for each beginning.

    A touch that goes on from step ``last`` to ``first`` begins once, as in a period that repeats.

    Args:
        world: Where the run was; the walls count as they are when the world has come to rest.
        trace: The recording.
        first: Step.
        last: Step.
    """
    bump = trace.bump[first : last + 1]
    begins = np.flatnonzero(bump & ~np.roll(bump, 1)) if not bump.all() else np.array([0], np.int64)
    solid = _Solid(world)
    seen: dict[tuple[float, float], Contact] = {}
    found = []
    for step in (begins + first).tolist():
        place = _first_place(world, trace, step)
        if place not in seen:
            seen[place] = solid.contact(*place)
        found.append(seen[place])
    return found


def times_round(x: Floats, y: Floats, cells: Iterable[tuple[int, int]]) -> int:
    """How often a closed path goes round the centre of one of the cells, the most often, without sign.

    Args:
        x: (n,) cells; the last place is the first again.
        y: (n,) cells.
        cells: (ix, iy).

    Source: crossings of a half-line, signed; Dan Sunday, "Inclusion of a point in a polygon", 2001.
    """
    most = 0
    for ix, iy in cells:
        cx = ix + 0.5
        cy = iy + 0.5
        side = (x[1:] - x[:-1]) * (cy - y[:-1]) - (cx - x[:-1]) * (y[1:] - y[:-1])
        up = (y[:-1] <= cy) & (y[1:] > cy) & (side > 0)
        down = (y[:-1] > cy) & (y[1:] <= cy) & (side < 0)
        most = max(most, abs(int(np.count_nonzero(up)) - int(np.count_nonzero(down))))
    return most


def enclosure(world: World, places: Iterable[tuple[float, float]]) -> str:
    """How a place is shut in: in how many of the four directions a wall stands within four cells.

    Args:
        world: Where.
        places: Of which the one counts that is shut in most; x and y, cells. What lies on the line
            between cells is in both.

    Returns:
        ``open``, ``side``, ``bend``, ``passage`` (two directions, opposite), ``pocket`` or
        ``closed``.
    """
    cells = {
        (math.floor(x + dx), math.floor(y + dy))
        for x, y in places
        for dx in (-_ROUNDING, _ROUNDING)
        for dy in (-_ROUNDING, _ROUNDING)
    }
    solid = _Solid(world)
    return max((solid.enclosure(ix, iy) for ix, iy in cells), key=_ENCLOSURES.index)


def part_of(world: World, ix: int, iy: int) -> str:
    """What a solid cell is part of, by its solid neighbours across edges.

    ``post``, ``end``, ``wall`` or ``block``.
    """
    return ("post", "end", "wall", "block", "block")[_Solid(world).neighbours(ix, iy)]


def _first_place(world: World, trace: Trace, step: int) -> tuple[float, float]:
    """Where the path of a step first ended or bent, cells; a wall that is touched is near there."""
    point = int(np.searchsorted(trace.path_step, step))
    x = trace.x[step]
    y = trace.y[step]
    if point < len(trace.path_step) and trace.path_step[point] == step:
        x = trace.path_x[point]
        y = trace.path_y[point]
    return float(x) / world.cell_size, float(y) / world.cell_size


class _Solid:
    """A world's solid cells, those outside included."""

    def __init__(self, world: World) -> None:
        walls = world.walls.copy()
        for event in world.timeline:
            walls[event.iy, event.ix] = event.state.word == "solid"
        self._walls = walls
        self._reach = math.ceil(world.robot_radius / world.cell_size) + 1

    def __call__(self, ix: int, iy: int) -> bool:
        height, width = self._walls.shape
        return not (0 <= ix < width and 0 <= iy < height) or bool(self._walls[iy, ix])

    def neighbours(self, ix: int, iy: int) -> int:
        return sum(self(ix + dx, iy + dy) for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)))

    def enclosure(self, ix: int, iy: int) -> str:
        """How a cell is shut in, one of ``_ENCLOSURES``."""
        east, north, west, south = (
            any(self(ix + k * dx, iy + k * dy) for k in range(_LOOK + 1))
            for dx, dy in ((1, 0), (0, 1), (-1, 0), (0, -1))
        )
        count = east + north + west + south
        if count == 2:
            return "passage" if east == west else "bend"
        return {0: "open", 1: "side", 3: "pocket", 4: "closed"}[count]

    def contact(self, x: float, y: float) -> Contact:
        """The contact of a robot at a place, with the walls nearest to it."""
        near = self._near(x, y)
        gap = min(near)[0]
        touched = [entry for entry in near if entry[0] <= gap + _SLACK]
        nearest = [cell for distance, cell, _ in touched if distance <= gap + 1e-6]
        kind = _kind(
            [normal for _, _, normal in touched], min(self.neighbours(*cell) for cell in nearest)
        )
        return Contact(kind, frozenset(cell for _, cell, _ in touched))

    def _near(self, x: float, y: float) -> list[tuple[float, tuple[int, int], tuple[float, float]]]:
        """Solid cells within reach of a place: distance, cell, normal; the nearest at least."""
        reach = self._reach
        column = math.floor(x)
        row = math.floor(y)
        while True:
            found = []
            for iy in range(row - reach, row + reach + 1):
                for ix in range(column - reach, column + reach + 1):
                    if self(ix, iy):
                        dx = x - min(max(x, ix), ix + 1)
                        dy = y - min(max(y, iy), iy + 1)
                        distance = math.sqrt(dx * dx + dy * dy)
                        normal = (dx / distance, dy / distance) if distance > 0.0 else (0.0, 0.0)
                        found.append((distance, (ix, iy), normal))
            if found and min(found)[0] <= reach:
                return found
            reach *= 2


def _kind(normals: list[tuple[float, float]], neighbours: int) -> str:
    """The kind of a contact with such normals, where the nearest cell has so many solid neighbours."""
    pairs = ((one, two) for k, one in enumerate(normals) for two in normals[:k])
    if any(one[0] * two[0] + one[1] * two[1] < _SAME_SIDE for one, two in pairs):
        return "nook"
    if neighbours <= 1:
        return ("post", "end")[neighbours]
    across = min(min(abs(x), abs(y)) for x, y in normals)
    return "wall" if across <= _ALONG else "corner"
