"""Variations of a user's own map: a window in which something has changed.

A door is closed, so that the robot has to go round; a box or a person is in the way; or a piece of
the walls has moved. Lengths and places are in nodes, as in :mod:`fuzz.layouts.map_windows`.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field

import numpy as np

from fuzz.layouts.map_windows import Box, Ends, Kind, Windows
from fuzz.layouts.narrow_places import NarrowPlace
from worldgen.files.grid import world_digest
from worldgen.random_streams import RandomStream
from worldgen.reach.still.grid_search import components
from worldgen.support.arrays import Bools, Floats, Ints
from worldgen.world import World

# A gap that is longer than this many times its width, in the direction of the nearest wall, is not
# a door.
_DOOR = 2.5
# Thickness of a closed door, m.
_LEAF = 0.1
# Sides of a box, m, from a crate to the end of a table.
_BOX_SIDES = (0.3, 0.4, 0.5, 0.6, 0.8)
# Radii of a person, m: half the width of shoulders, and of somebody with a bag.
_PERSON_RADII = (0.25, 0.3)
# The longer side of a piece that somebody could have moved, m: a smaller one is a speck of noise, a
# larger one a wall.
_PIECE_SIDES = (0.2, 2.5)
# How far a piece moves along each axis at most, m.
_FARTHEST_MOVE = 0.6
# The way round a closed door is sought this many windows around it, or radii if that is more; a
# longer one costs a slow controller too much.
_WINDOWS_AROUND = 4.0
_RADII_AROUND = 30.0
# A way round is at least this many times as long as the way through the door can be.
_LONGER = 2.0
# Tries to make a variation, before a plain window takes its place.
_TRIES = 4


@dataclass(frozen=True)
class _Key:
    """A map by its digest: workers get a copy with each unit, and examine it once."""

    digest: str
    step: float
    world: World = field(compare=False, repr=False)


def variations_of(world: World, step: float) -> MapVariations:
    """Return the variations of a map, which is examined once in each process.

    Args:
        world: The map, with one robot; it must not change over time.
        step: Length of the robot's step, m.
    """
    return _examined(_Key(world_digest(world), step, world))


@functools.lru_cache(maxsize=4)
def _examined(key: _Key) -> MapVariations:
    return MapVariations(Windows(key.world, key.step))


class MapVariations:
    """Draws windows and variations of a map.

    Args:
        windows: Cuts windows out of the map.
    """

    def __init__(self, windows: Windows) -> None:
        self._windows = windows
        self._makers = {
            Kind.DOOR: self._closed_door,
            Kind.BOX: self._obstacle,
            Kind.PERSON: self._obstacle,
            Kind.PIECE: self._moved_piece,
            Kind.POSE: self._pose,
        }

    def draw(self, kind: Kind, rng: RandomStream) -> World | None:
        """Return a world of a kind, or failing that a plain window; ``None`` if the map has none.

        Args:
            kind: The kind. ``POSE`` needs no narrow place, and fits on a map that is too small for
                a window.
            rng: The source of randomness.
        """
        maker = self._makers.get(kind, self._window)
        for make, as_kind in ((maker, kind), (self._window, Kind.WINDOW)):
            for _ in range(_TRIES):
                world = make(as_kind, rng)
                if world is not None:
                    return world
        return None

    def _window(self, kind: Kind, rng: RandomStream) -> World | None:
        place = self._narrow_place(rng)
        ends = None if place is None else self._windows.ends_at(place, rng)
        if place is None or ends is None:
            return None
        return self._windows.world(kind, self._windows.around_place(place), ends, rng)

    def _pose(self, kind: Kind, rng: RandomStream) -> World | None:
        """Return a window around open floor, or a start and a target anywhere."""
        windows = self._windows
        place = windows.open_place(windows.part, windows.ground, rng)
        if place is None:
            return None
        ends = windows.ends_at(place, rng)
        if ends is not None:
            return windows.world(kind, windows.around_place(place), ends, rng)
        target = windows.open_place(windows.part, windows.ground, rng)
        if target is None or (target.row, target.column) == (place.row, place.column):
            return None
        return windows.world(kind, windows.part, Ends(place.nodes[0], target.nodes[0]), rng)

    def _narrow_place(self, rng: RandomStream) -> NarrowPlace | None:
        places = self._windows.places
        return rng.choice(places) if places else None

    def _closed_door(self, kind: Kind, rng: RandomStream) -> World | None:
        """Return a world in which a door is closed, so that the robot has to go round."""
        windows = self._windows
        place = self._narrow_place(rng)
        if place is None:
            return None
        walls = self._with_closed_door(place)
        ends = windows.ends_at(place, rng)
        if walls is None or ends is None:
            return None
        # Look for the way round, and keep everything around it.
        far = max(_WINDOWS_AROUND * 2.0 * windows.reach, _RADII_AROUND * windows.radius)
        path = windows.path(windows.around(place.nodes, far), ends, walls)
        if len(path) < _LONGER * 2.0 * windows.reach:
            return None
        box = windows.around(path).joined(windows.around_place(place))
        words = f"door closed at {windows.describe(place.row, place.column)}"
        return windows.world(kind, box, ends, rng, walls, words)

    def _with_closed_door(self, place: NarrowPlace) -> Bools | None:
        """Return the walls with the gap at a place closed; ``None`` if it is too wide for a door."""
        # The leaf goes from the nearest wall through the place to the wall on the other side.
        solid = self._windows.ground.squared == 0
        here = place.nodes[0] - self._windows.part.corner
        near = math.ceil(place.clearance)
        first = np.maximum(here - near, 0)
        row, column = here.tolist()
        around = solid[first[0] : row + near + 1, first[1] : column + near + 1]
        to_walls = np.argwhere(around) + first - here
        y, x = (to_walls[np.argmin((to_walls**2).sum(axis=1))] / place.clearance).tolist()
        length = 0.0
        while not solid[round(row - length * y), round(column - length * x)]:
            length += 0.5
            if length > _DOOR * place.clearance:
                return None
        # Its cells are those near the line between the two walls. Half a diagonal makes a chain of
        # cells that touch at their sides, which lets nothing through.
        thick = max(math.sqrt(2.0), _LEAF / self._windows.cell)
        half = 0.5 * (place.clearance + length)
        middle = place.nodes[0] + 0.5 * (place.clearance - length) * np.array((y, x))
        cells = self._cells_near(middle, half + thick)
        dy, dx = (2.0 * cells + 1.0 - middle).T
        is_leaf = (abs(dy * y + dx * x) <= half + 1.0) & (abs(dx * y - dy * x) <= thick)
        return self._with(cells[is_leaf])

    def _obstacle(self, kind: Kind, rng: RandomStream) -> World | None:
        """Return a world with a box or a person near the robot's path, in a gap or on open floor."""
        windows = self._windows
        place = self._narrow_place(rng) if rng.below(2) else None
        place = place or windows.open_place(windows.part, windows.ground, rng)
        ends = None if place is None else windows.ends_at(place, rng)
        if place is None or ends is None:
            return None
        # Put it near the middle half of the path, so that start and target are mostly free.
        box = windows.around_place(place)
        path = windows.path(box, ends)
        if not len(path):
            return None
        middle = path[len(path) // 4 + rng.below(len(path) // 2 + 1)] + np.array(
            [rng.uniform(-windows.radius, windows.radius) for _ in range(2)]
        )
        cells, words = self._person(middle, rng) if kind is Kind.PERSON else self._box(middle, rng)
        # Cells can be larger than a person.
        if not len(cells):
            cells = np.floor(0.5 * middle).astype(np.int64)[None]
        walls = self._with(cells)
        words = f"{words} at {windows.describe(*middle)}"
        return None if walls is None else windows.world(kind, box, ends, rng, walls, words)

    def _person(self, middle: Floats, rng: RandomStream) -> tuple[Ints, str]:
        """Return the cells of a person, and words for it."""
        radius = rng.choice(_PERSON_RADII)
        reach = 2.0 * radius / self._windows.cell
        cells = self._cells_near(middle, reach)
        is_inside = ((2.0 * cells + 1.0 - middle) ** 2).sum(axis=1) <= reach * reach
        return cells[is_inside], f"person of radius {radius:g} m"

    def _box(self, middle: Floats, rng: RandomStream) -> tuple[Ints, str]:
        """Return the cells of a box, and words for it."""
        height = rng.choice(_BOX_SIDES)
        width = rng.choice(_BOX_SIDES)
        half = np.array((height, width)) / self._windows.cell
        cells = self._cells_near(middle, float(half.max()))
        is_inside = (abs(2.0 * cells + 1.0 - middle) <= half).all(axis=1)
        return cells[is_inside], f"box of {width:g} x {height:g} m"

    def _cells_near(self, middle: Floats, far: float) -> Ints:
        """Return the cells (row, column) of the map in a square around a node."""
        low = np.maximum(np.floor(0.5 * (middle - far)).astype(np.int64), 0)
        high = np.ceil(0.5 * (middle + far)).astype(np.int64)
        high = np.minimum(high, self._windows.walls.shape)
        rows, columns = np.mgrid[low[0] : high[0], low[1] : high[1]]
        return np.stack((rows.ravel(), columns.ravel()), axis=1)

    def _with(self, cells: Ints) -> Bools | None:
        """Return the walls with more solid cells; ``None`` if all of them are solid anyway."""
        walls = self._windows.walls.copy()
        rows, columns = cells.T
        if walls[rows, columns].all():
            return None
        walls[rows, columns] = True
        return walls

    @functools.cached_property
    def _pieces(self) -> tuple[Ints, list[tuple[int, Box]]]:
        """Pieces of the walls that could have been moved.

        Returns:
            The number of the piece at each cell of the part that is examined; and the numbers of
            those that are neither noise nor walls, with the boxes around them.
        """
        windows = self._windows
        padded = np.pad(windows.walls[windows.part.cells], 1)
        numbers, count = components(padded)
        owner = numbers.astype(np.int64).reshape(padded.shape)[1:-1, 1:-1]
        cells = np.argwhere(owner >= 0)
        low = np.full((count, 2), np.iinfo(np.int64).max)
        high = np.full((count, 2), -1)
        np.minimum.at(low, owner[owner >= 0], cells)
        np.maximum.at(high, owner[owner >= 0], cells)
        # What touches the rim continues outside.
        is_inside = (low > 0).all(axis=1) & (high < np.array(owner.shape) - 1).all(axis=1)
        sides = (high - low + 1).max(axis=1) * windows.cell
        chosen = is_inside & (sides >= _PIECE_SIDES[0]) & (sides <= _PIECE_SIDES[1])
        corner = np.array(windows.part[:2])
        boxes = np.concatenate((low + corner, high + corner + 1), axis=1)
        return owner, [(int(n), Box(*boxes[n].tolist())) for n in np.flatnonzero(chosen)]

    def _moved_piece(self, kind: Kind, rng: RandomStream) -> World | None:
        """Return a world in which a piece of the walls has moved."""
        windows = self._windows
        owner, pieces = self._pieces
        most = max(1, int(_FARTHEST_MOVE / windows.cell))
        up = rng.between(-most, most)
        right = rng.between(-most, most)
        if not pieces or up == right == 0:
            return None
        # Move its cells; those that would leave the map are lost.
        number, box = rng.choice(pieces)
        part = np.array(windows.part[:2])
        own = owner[
            box.top - part[0] : box.bottom - part[0], box.left - part[1] : box.right - part[1]
        ]
        cells = np.argwhere(own == number) + np.array(box[:2])
        walls = windows.walls.copy()
        walls[cells[:, 0], cells[:, 1]] = False
        moved = cells + np.array((up, right))
        moved = moved[(moved >= 0).all(axis=1) & (moved < walls.shape).all(axis=1)]
        if not len(moved):
            return None
        walls[moved[:, 0], moved[:, 1]] = True
        # Start and target are on two sides of it.
        around = windows.around(2 * moved, 2.0 * windows.radius)
        place = windows.open_place(around, windows.ground_in(around, walls), rng)
        middle = (moved.min(axis=0) + moved.max(axis=0) + 1).astype(np.float64)
        ends = None if place is None else windows.ends_at(place, rng, walls, middle)
        if place is None or ends is None:
            return None
        cell = windows.cell
        words = (
            f"piece of the walls of {(box.right - box.left) * cell:.4g} x "
            f"{(box.bottom - box.top) * cell:.4g} m at {windows.describe(2 * box.top, 2 * box.left)}"
            f" moved by ({right * cell:.4g}, {up * cell:.4g}) m"
        )
        return windows.world(kind, windows.around_place(place), ends, rng, walls, words)
