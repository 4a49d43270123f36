"""Describe the walls that a robot touches, goes around or is enclosed by.

These facts do not change if the world is mirrored, turned or shifted. Everything is computed in
cells, from the recorded path alone. Everything outside the grid is solid, so a world with a thicker
border has the same contacts.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from sim.clock.stopping import check_time
from sim.trace import Trace
from worldgen.support.arrays import Bools, Floats, Ints
from worldgen.timeline import CellState
from worldgen.world import World

KINDS = ("nook", "end", "post", "corner", "wall")
"""Kinds of contact, the most specific first.

Two walls at once, the end of a wall, a single cell, a corner that sticks out, and the face of a
wall.
"""

_ENCLOSURES = ("open", "side", "bend", "passage", "pocket", "closed")

_SLACK = 0.02  # cells: a wall at most this much further away than the nearest one is touched too
_SAME_SIDE = 0.7  # smallest cosine between the normals of one wall; 45 degrees
_ALONG = 0.08  # largest sine between an axis and the normal of a face
_LOOK = 4  # cells within which a wall encloses a place, in each of the four directions
_ROUNDING = 1e-6  # cells: a place this close to the line between two cells is in both
_AT_ONCE = 4096  # steps: places examined between two looks at the clock


@dataclass(frozen=True)
class Contact:
    """A place where the robot touches walls.

    Args:
        kind: One of :data:`KINDS`.
        cells: The solid cells touched, (ix, iy); they may be outside the grid.
    """

    kind: str
    cells: frozenset[tuple[int, int]]


def contacts(world: World, trace: Trace, first: int, last: int) -> list[Contact]:
    """Return one contact for each time that the robot begins to touch a wall in a range of steps.

    The range is treated as a period that repeats: a touch that lasts from its end into its
    beginning counts once.

    Args:
        world: World of the run; walls count as they are after the last event.
        trace: The recording.
        first: First step of the range.
        last: Last step of the range.
    """
    # A touch begins in a step with a bump that follows a step without.
    bump = trace.bump[first : last + 1]
    begins = np.flatnonzero(bump & ~np.roll(bump, 1)) if not bump.all() else np.array([0], np.int64)
    # Contacts at the same place are equal, so compute each only once.
    solid = _Solid(world)
    seen: dict[tuple[float, float], Contact] = {}
    found = []
    for step in (begins + first).tolist():
        place = _first_place(world, trace, step)
        if place not in seen:
            seen[place] = solid.contact(*place)
        found.append(seen[place])
    return found


def winding_number(x: Floats, y: Floats, cells: Iterable[tuple[int, int]]) -> int:
    """Return the highest winding number, without sign, of a closed path around any of the cells.

    Args:
        x: (n,) cells; the last place equals the first.
        y: (n,) cells.
        cells: (ix, iy); the path is counted around their centres.

    Source: signed crossings of a half-line; Dan Sunday, "Inclusion of a point in a polygon", 2001.
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


class WallBearings:
    """Where the walls are that a robot touches, relative to its heading.

    Args:
        world: World of the run; walls count as they are after the last event.
        trace: The recording.
        at_once: True if the robot turns at the end of the step in which it touches a wall, so that
            the heading before that turn counts.
    """

    def __init__(self, world: World, trace: Trace, *, at_once: bool = False) -> None:
        self.at_once = at_once
        self._walls = walls_at_the_end(world)
        self._cell_size = world.cell_size
        self._touched = world.robot_radius / world.cell_size + _SLACK
        self._trace = trace

    def __call__(self, steps: Ints) -> Floats:
        """Return the bearing of the wall that the robot touches after each of some steps.

        Of several walls, the one ahead of it counts, because it stops the robot.

        Args:
            steps: (n,) the steps.

        Returns:
            (n,) rad, from -pi to pi; 0 is ahead, and positive on the left. 0 if no wall is near
            enough, because the motion model looked beyond the robot's position.

        Raises:
            OutOfTime: If there is no more time.
        """
        found = np.zeros(len(steps))
        for first in range(0, len(steps), _AT_ONCE):
            check_time()
            found[first : first + _AT_ONCE] = self._of(steps[first : first + _AT_ONCE])
        return found

    def _of(self, steps: Ints) -> Floats:
        x = self._trace.x[steps] / self._cell_size
        y = self._trace.y[steps] / self._cell_size
        heading = self._trace.heading[np.maximum(steps - self.at_once, 0)]
        best = np.full(len(steps), np.inf)
        for solid, dx, dy in _walls_around(self._walls, x, y, self._touched):
            counts = solid & (np.hypot(dx, dy) <= self._touched)
            bearing = np.arctan2(dy, dx) - heading
            bearing -= math.tau * np.round(bearing / math.tau)
            # Of two walls at the same angle, the one on the right counts.
            ahead = np.abs(bearing) < np.abs(best)
            ahead |= (np.abs(bearing) == np.abs(best)) & (bearing < best)
            best = np.where(counts & ahead, bearing, best)
        return np.where(np.isinf(best), 0.0, best)


def nearest_walls(world: World, trace: Trace, steps: Ints, within: float) -> tuple[Floats, Floats]:
    """Return the distance and the direction of the wall nearest to a robot's centre.

    Args:
        world: World of the run; walls count as they are after the last event.
        trace: The recording.
        steps: (n,) the steps after which the robot is looked at.
        within: Distance within which walls are found, m.

    Returns:
        (n,) the distance, m, infinite if no wall is near enough; and (n,) the direction, rad, in
        the world's frame.

    Raises:
        OutOfTime: If there is no more time.
    """
    walls = walls_at_the_end(world)
    reach = within / world.cell_size
    nearest = np.full(len(steps), np.inf)
    direction = np.zeros(len(steps))
    for first in range(0, len(steps), _AT_ONCE):
        check_time()
        part = slice(first, first + _AT_ONCE)
        x = trace.x[steps[part]] / world.cell_size
        y = trace.y[steps[part]] / world.cell_size
        for solid, dx, dy in _walls_around(walls, x, y, reach):
            far = np.hypot(dx, dy)
            nearer = solid & (far <= reach) & (far < nearest[part])
            nearest[part] = np.where(nearer, far, nearest[part])
            direction[part] = np.where(nearer, np.arctan2(dy, dx), direction[part])
    return nearest * world.cell_size, direction


def _walls_around(
    walls: Bools, x: Floats, y: Floats, reach: float
) -> Iterator[tuple[Bools, Floats, Floats]]:
    """Yield, for one cell near each place after the other, if it is solid and the way to it.

    Args:
        walls: (height, width) solid cells.
        x: (n,) places, cells.
        y: (n,) places, cells.
        reach: Distance within which no cell is missed, cells.
    """
    column = np.floor(x).astype(np.int64)
    row = np.floor(y).astype(np.int64)
    height, width = walls.shape
    most = math.floor(reach) + 1
    # Examine the cells around all places at once, one offset after the other.
    for down, across in itertools.product(range(-most, most + 1), repeat=2):
        ix = column + across
        iy = row + down
        inside = (ix >= 0) & (ix < width) & (iy >= 0) & (iy < height)
        solid = ~inside | walls[iy.clip(0, height - 1), ix.clip(0, width - 1)]
        yield solid, np.clip(x, ix, ix + 1) - x, np.clip(y, iy, iy + 1) - y


def walls_at_the_end(world: World) -> Bools:
    """Return the (height, width) solid cells as they are after the last event."""
    ended: Bools = world.cells_at(math.inf) == CellState.SOLID
    return ended


def enclosure(world: World, places: Iterable[tuple[float, float]]) -> str:
    """Return how enclosed a place is, judging by the directions with a wall within four cells.

    Args:
        world: The world.
        places: x and y, cells. Of several places, the most enclosed one counts. A place on the
            line between cells is in both.

    Returns:
        ``open``, ``side``, ``bend``, ``passage`` (two opposite directions), ``pocket`` or
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
    """Return what a solid cell is part of, judging by its solid neighbours across edges.

    One of ``post``, ``end``, ``wall`` and ``block``.
    """
    return ("post", "end", "wall", "block", "block")[_Solid(world).neighbours(ix, iy)]


def _first_place(world: World, trace: Trace, step: int) -> tuple[float, float]:
    """Return where the path of a step first ended or bent, in cells; touched walls are nearby."""
    point = int(np.searchsorted(trace.path_step, step))
    x = trace.x[step]
    y = trace.y[step]
    if point < len(trace.path_step) and trace.path_step[point] == step:
        x = trace.path_x[point]
        y = trace.path_y[point]
    return float(x) / world.cell_size, float(y) / world.cell_size


class _Solid:
    """A world's solid cells, including everything outside the grid."""

    def __init__(self, world: World) -> None:
        self._walls = walls_at_the_end(world)
        self._reach = math.ceil(world.robot_radius / world.cell_size) + 1

    def __call__(self, ix: int, iy: int) -> bool:
        height, width = self._walls.shape
        return not (0 <= ix < width and 0 <= iy < height) or bool(self._walls[iy, ix])

    def neighbours(self, ix: int, iy: int) -> int:
        return sum(self(ix + dx, iy + dy) for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)))

    def enclosure(self, ix: int, iy: int) -> str:
        """Return how enclosed a cell is, one of ``_ENCLOSURES``."""
        east, north, west, south = (
            any(self(ix + k * dx, iy + k * dy) for k in range(_LOOK + 1))
            for dx, dy in ((1, 0), (0, 1), (-1, 0), (0, -1))
        )
        count = east + north + west + south
        if count == 2:
            return "passage" if east == west else "bend"
        return {0: "open", 1: "side", 3: "pocket", 4: "closed"}[count]

    def contact(self, x: float, y: float) -> Contact:
        """Return the contact of a robot at a place with the walls nearest to it."""
        near = self.near(x, y)
        gap = min(near)[0]
        # Nearly equal distances count as one touch, so that a mirrored run gives the same kind.
        touched = [entry for entry in near if entry[0] <= gap + _SLACK]
        nearest = [cell for distance, cell, _ in touched if distance <= gap + 1e-6]
        kind = _kind(
            [normal for _, _, normal in touched], min(self.neighbours(*cell) for cell in nearest)
        )
        return Contact(kind, frozenset(cell for _, cell, _ in touched))

    def near(self, x: float, y: float) -> list[tuple[float, tuple[int, int], tuple[float, float]]]:
        """Return solid cells near a place, at least the nearest, with distances and normals."""
        reach = self._reach
        column = math.floor(x)
        row = math.floor(y)
        # Widen the search until the nearest solid cell is certainly among those found.
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
    """Return the kind of a contact from its normals and the nearest cell's solid neighbours."""
    pairs = ((one, two) for k, one in enumerate(normals) for two in normals[:k])
    if any(one[0] * two[0] + one[1] * two[1] < _SAME_SIDE for one, two in pairs):
        return "nook"
    if neighbours <= 1:
        return ("post", "end")[neighbours]
    across = min(min(abs(x), abs(y)) for x, y in normals)
    return "wall" if across <= _ALONG else "corner"
