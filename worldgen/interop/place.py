"""Choose a start and a target on a map that has none: far apart, clear, and connected.

The candidates are the multiples of half a cell at which the disc is clear, exactly. A step of half
a cell along an axis between two of them is clear as well (docs/explanation/reachability.md), so two
places joined by such steps are connected for the robot.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from worldgen.errors import InvalidWorld
from worldgen.lattice import (
    UNIT,
    exact,
    heading_from_lattice,
    heading_to_lattice,
    in_cells,
    lattice_to_metres,
    metres_to_lattice,
)
from worldgen.random_streams import RandomStream
from worldgen.reach.still.lattice_graph import build_graph
from worldgen.reach.still.walls import Walls, point_box_sq
from worldgen.support.arrays import Bools
from worldgen.support.grid_search import Floods

_HALF = UNIT // 2
# Radii of clearance around a chosen place, the widest first.
_ROOMY = (Fraction(2), Fraction(3, 2), Fraction(5, 4))
# A place with room to turn is chosen only if at least this share of its region is nearer.
_FAR = 0.5
# Share of the clear places below which the largest region deserves a warning.
_SCATTERED = 0.5
_Point = tuple[float, float]


class Placement(NamedTuple):
    """The chosen start and target, m, with remarks."""

    start: _Point
    target: _Point
    warnings: tuple[str, ...] = ()


def place(
    walls: Bools,
    cell_size: float,
    radius: float,
    seed: int,
    *,
    start: _Point | None = None,
    target: _Point | None = None,
) -> Placement:
    """Choose a start and a target with the longest path that two sweeps find; keep given ones.

    If neither is given, both are in the largest region that the disc can drive through; otherwise
    the missing one is as far as possible from the given one, in its region. A chosen place has room
    to turn if the map has such places far enough away: a disc of twice the radius is clear there,
    or one of 1.5 or 1.25 radii.

    Args:
        walls: (height, width) bool, row 0 the lowest y.
        cell_size: m.
        radius: Radius of the robot's disc, m.
        seed: Selects where in the region the sweeps begin.
        start: x and y, m; moved to the nearest point of the pose lattice.
        target: x and y, m; need not be clear itself.

    Raises:
        InvalidWorld: If a given point is outside, the start is not clear (the message names the
            wall, its distance, and the nearest clear place), or there is no room for the disc.
    """
    # Check what is given.
    for name, point in (("start", start), ("target", target)):
        if point is not None:
            _check_inside(name, point, walls, cell_size)
    if start is not None:
        start = _on_lattice(start, cell_size)
        _check_start(walls, cell_size, radius, start)
    if start is not None and target is not None:
        return Placement(start, target)
    # Choose the missing end as far as possible from the given one.
    places = _ClearPoints(walls, cell_size, radius)
    given = start if start is not None else target
    if given is not None:
        other = places.metres(places.farthest(places.near(given)))
        return Placement(given, other) if start is not None else Placement(other, given)
    # Choose both ends in the largest region, by two sweeps.
    region = places.largest_region()
    first = places.farthest(places.any_of(region, RandomStream(seed).child("import")))
    last = places.farthest(first)
    warnings = []
    if first == last:
        warnings.append("the largest region is a single place; start and target coincide")
    if region.share < _SCATTERED:
        warnings.append(
            f"for a disc of radius {radius:g} m there are {region.regions} separate regions; "
            f"start and target are in the largest, which has {100 * region.share:.0f} % of the free space; a "
            f"smaller radius may join them"
        )
    return Placement(places.metres(first), places.metres(last), tuple(warnings))


class _Region(NamedTuple):
    """The largest region: a place in it, its size, its share of all, and the number of regions."""

    root: int
    size: int
    share: float
    regions: int


class _ClearPoints:
    """The clear multiples of half a cell, as flat indices, and flood fills over them."""

    def __init__(self, walls: Bools, cell_size: float, radius: float) -> None:
        cells = in_cells(radius, cell_size)
        self._cell_size = cell_size
        self._radius = radius
        self._cells = cells
        self._grid = walls
        self._walls = Walls(walls, cells)
        self.clear = build_graph(walls, cells, 2).clear
        self._stride = int(self.clear.shape[1])
        self._floods = Floods(self.clear)
        self._wider: dict[Fraction, Bools] = {}

    def largest_region(self) -> _Region:
        found = self._floods.regions(0, self.clear.size)
        if found.largest == 0:
            raise InvalidWorld(
                "no-room",
                "a disc of radius {radius:g} m does not fit anywhere in the map",
                "use a smaller radius",
                radius=self._radius,
            )
        return _Region(found.root, found.largest, found.largest / found.places, found.regions)

    def any_of(self, region: _Region, rng: RandomStream) -> int:
        """Return one of a region's places, all equally likely."""
        self._floods.regions(region.root, region.root + 1)
        return int(self._floods.queue[rng.below(region.size)])

    def farthest(self, source: int) -> int:
        """Return the place with room to turn that is most steps away from ``source``.

        Ties go to the last place in flood order. A place without room to turn is chosen if all
        places with room are near, because a start next to its target would be no test.
        """
        size = self._floods.regions(source, source + 1).largest
        # Flood order is the order of the number of steps.
        nearest = math.ceil(_FAR * size)
        beyond = self._floods.queue[nearest:size].astype(np.int64)
        for times in _ROOMY:
            roomy = np.flatnonzero(self._clear_for(times)[beyond])
            if len(roomy):
                return int(beyond[roomy[-1]])
        return int(self._floods.queue[size - 1])

    def _clear_for(self, times: Fraction) -> Bools:
        """Return which places are clear for a disc of this many radii, flat."""
        if times not in self._wider:
            self._wider[times] = build_graph(self._grid, times * self._cells, 2).clear.ravel()
        return self._wider[times]

    def near(self, point: _Point) -> int:
        """Return a clear place the disc reaches straight from a point, or the nearest one."""
        x, y = (metres_to_lattice(value, self._cell_size) for value in point)
        found = []
        for j in range(y // _HALF - 1, y // _HALF + 3):
            for i in range(x // _HALF - 1, x // _HALF + 3):
                inside = 0 <= j < self.clear.shape[0] and 0 <= i < self._stride
                if inside and self.clear[j, i]:
                    straight = self._walls.is_clear((x, y), (i * _HALF, j * _HALF))
                    distance = (i * _HALF - x) ** 2 + (j * _HALF - y) ** 2
                    found.append((not straight, distance, j * self._stride + i))
        if not found:
            raise InvalidWorld(
                "no-room",
                "there is no room for a disc of radius {radius:g} m near ({x:g}, {y:g}) m, so the "
                "other end cannot be placed",
                "choose both start and target, or a smaller radius",
                radius=self._radius,
                x=point[0],
                y=point[1],
            )
        return min(found)[2]

    def nearest_to(self, point: _Point) -> _Point | None:
        """Return the clear place nearest to a point, m."""
        x, y = (metres_to_lattice(value, self._cell_size) / _HALF for value in point)
        # Search a window that grows until the nearest place is certainly inside it.
        reach = 8
        while True:
            low_j = max(0, math.floor(y) - reach)
            low_i = max(0, math.floor(x) - reach)
            window = self.clear[
                low_j : math.floor(y) + reach + 1, low_i : math.floor(x) + reach + 1
            ]
            j, i = np.nonzero(window)
            if len(j):
                distance = (i + low_i - x) ** 2 + (j + low_j - y) ** 2
                best = int(np.argmin(distance))
                if distance[best] <= reach * reach:
                    return self.metres((int(j[best]) + low_j) * self._stride + int(i[best]) + low_i)
            if reach > 2 * max(self.clear.shape):
                return None
            reach *= 2

    def metres(self, node: int) -> _Point:
        j, i = divmod(node, self._stride)
        return lattice_to_metres(i * _HALF, self._cell_size), lattice_to_metres(
            j * _HALF, self._cell_size
        )


def _check_inside(name: str, point: _Point, walls: Bools, cell_size: float) -> None:
    height, width = (side * cell_size for side in walls.shape)
    if not (0.0 <= point[0] <= width and 0.0 <= point[1] <= height):
        raise InvalidWorld(
            "outside-grid",
            "{name} ({x:g}, {y:g}) m is outside the map of {width:g} x {height:g} m",
            "use metres from its lower-left corner, x right, y up; --frame map uses the file's own "
            "coordinates",
            at_terminal=True,
            name=name,
            x=point[0],
            y=point[1],
            width=width,
            height=height,
        )


def _on_lattice(point: _Point, cell_size: float) -> _Point:
    x, y = (lattice_to_metres(metres_to_lattice(value, cell_size), cell_size) for value in point)
    return x, y


def is_clear(walls: Bools, cell_size: float, radius: float, point: _Point) -> bool:
    """Return True if a disc of ``radius`` m is clear at the lattice point nearest to a point."""
    solid = Walls(walls, in_cells(radius, cell_size))
    x, y = (metres_to_lattice(value, cell_size) for value in point)
    return _is_clear_of(solid, _nearest_wall(solid, (x, y))[0])


def _is_clear_of(solid: Walls, distance_sq: Fraction) -> bool:
    return distance_sq >= max(Fraction(1), solid.radius_sq)


def _check_start(walls: Bools, cell_size: float, radius: float, start: _Point) -> None:
    """Reject a start at which the disc overlaps a wall."""
    solid = Walls(walls, in_cells(radius, cell_size))
    x, y = (metres_to_lattice(value, cell_size) for value in start)
    distance_sq, cell = _nearest_wall(solid, (x, y))
    if _is_clear_of(solid, distance_sq):
        return
    height, width = walls.shape
    inside = 0 <= cell[0] < width and 0 <= cell[1] < height
    distance = math.sqrt(distance_sq) / UNIT * cell_size
    clear = _ClearPoints(walls, cell_size, radius).nearest_to(start)
    raise InvalidWorld(
        "not-clear",
        "start ({x:g}, {y:g}) m is "
        + ("in " if distance == 0 else "{distance:.3g} m from ")
        + ("the solid cell {cell}" if inside else "the map's edge")
        + "; the robot's radius is {radius:g} m",
        "it does not fit anywhere in the map"
        if clear is None
        else "the nearest clear place is {clear[0]!r},{clear[1]!r}",
        x=start[0],
        y=start[1],
        distance=distance,
        cell=cell,
        radius=radius,
        clear=clear,
    )


def _nearest_wall(solid: Walls, point: tuple[int, int]) -> tuple[Fraction, tuple[int, int]]:
    """Return the squared distance in lattice units to the nearest solid cell, and the cell."""
    reach = UNIT
    # The outside is solid, so this loop ends.
    while True:
        near = [
            (Fraction(point_box_sq(point, cell)), cell) for cell in solid.near(point, point, reach)
        ]
        if near and min(near)[0] <= reach * reach:
            return min(near)
        reach *= 2


def heading_towards(start: _Point, target: _Point) -> float:
    """Return the heading from start to target, on the heading lattice; 0 if they coincide."""
    angle = math.atan2(
        float(exact(target[1]) - exact(start[1])), float(exact(target[0]) - exact(start[0]))
    )
    return heading_from_lattice(heading_to_lattice(angle))
