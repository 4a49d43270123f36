"""Choose a start and a target on a map that has none: far apart, clear, and connected.

The candidates are the multiples of half a cell at which the disc is clear, exactly. A step of half
a cell along an axis between two of them is clear as well (docs/explanation/reachability.md), so two
places joined by such steps are connected for the robot.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

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
from worldgen.reach.still.grid_search import Floods
from worldgen.reach.still.lattice_graph import build_graph
from worldgen.reach.still.walls import Walls, point_box_sq
from worldgen.support.arrays import Bools

_HALF = UNIT // 2
# Radii of clearance around a chosen place, the widest first.
_ROOMY = (Fraction(2), Fraction(3, 2), Fraction(5, 4))
# A place with room to turn is chosen only if at least this share of its region is nearer.
_FAR = 0.5
# Share of the clear places below which the largest region deserves a warning.
_SCATTERED = 0.5
# Share of the largest region from which one that does not reach the border is taken instead, and
# from which the one with the map's origin is.
_SMALL = 0.05
_TINY = 0.01
_LARGEST = "the largest"
_Point = tuple[float, float]
_Labels: TypeAlias = npt.NDArray[np.signedinteger[Any]]


class Placement(NamedTuple):
    """The chosen start and target, m, with remarks."""

    start: _Point
    target: _Point
    warnings: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


def place(
    walls: Bools,
    cell_size: float,
    radius: float,
    seed: int,
    *,
    start: _Point | None = None,
    target: _Point | None = None,
    origin: _Point | None = None,
) -> Placement:
    """Choose a start and a target with the longest path that two sweeps find; keep given ones.

    If neither is given, both are in the largest region that the disc can drive through. On a
    picture that shows its surroundings too, such as a race track's, they are rather in the region
    with the map's origin, or, if the largest reaches the picture's border, in the largest one that
    does not. Otherwise the missing one is as far as possible from the given one, in its region. A chosen place has room
    to turn if the map has such places far enough away: a disc of twice the radius is clear there,
    or one of 1.5 or 1.25 radii.

    Args:
        walls: (height, width) bool, row 0 the lowest y.
        cell_size: m.
        radius: Radius of the robot's disc, m.
        seed: Selects where in the region the sweeps begin.
        start: x and y, m; moved to the nearest point of the pose lattice.
        target: x and y, m; need not be clear itself.
        origin: For a picture, x and y, m, of the point (0, 0) of the map's own coordinates.

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
    # Choose both ends in one region, by two sweeps.
    region = places.largest_region() if origin is None else places.region_of_picture(origin)
    first = places.farthest(places.any_of(region, RandomStream(seed).child("import")))
    last = places.farthest(first)
    warnings = []
    if first == last:
        warnings.append("the largest region is a single place; start and target coincide")
    if region.share < _SCATTERED:
        warnings.append(
            f"for a disc of radius {radius:g} m there are {region.regions} separate regions; "
            f"start and target are in {region.name}, which has {100 * region.share:.0f} % of the free space; a "
            f"smaller radius may join them"
        )
    if region.warning:
        warnings.append(region.warning)
    notes = () if region.name == _LARGEST else (f"start and target are in {region.name}",)
    return Placement(places.metres(first), places.metres(last), tuple(warnings), notes)


class _Region(NamedTuple):
    """A region: a place in it, its size, its share of all, and the number of regions.

    Then its name, and why it may be the wrong one; empty if nothing speaks against it.
    """

    root: int
    size: int
    share: float
    regions: int
    name: str
    warning: str = ""


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
        share = found.largest / found.places
        return _Region(found.root, found.largest, share, found.regions, _LARGEST)

    def region_of_picture(self, origin: _Point) -> _Region:
        """Return the region to use on a picture, which may show its surroundings too."""
        largest = self.largest_region()
        root = self._node_of_origin(origin)
        size = 0 if root is None else int(self._floods.regions(root, root + 1).largest)
        labels, sizes = self._labelled()
        places = int(sizes.sum())
        used = int(labels.ravel()[largest.root])

        # A map's origin is mostly where its robot began. Without one, the largest region is the
        # surroundings if it reaches the border, and another one does not.
        at_border = self._at_border(labels, frame=0)
        others = np.where(at_border, 0, sizes)
        best = int(np.argmax(others))
        region = largest
        if root is not None and size >= _TINY * largest.size:
            used = int(labels.ravel()[root])
            if used != labels.ravel()[largest.root]:
                name = "the region with the map's origin"
                region = _Region(root, size, size / places, largest.regions, name)
        elif at_border[used] and others[best] >= _SMALL * largest.size:
            used = best
            size = int(sizes[best])
            node = int(np.argmax(labels.ravel() == best))
            name = "the largest region that does not reach the picture's border"
            region = _Region(node, size, size / places, largest.regions, name)
        return region._replace(warning=self._doubt(labels, sizes, used, root))

    def _doubt(self, labels: _Labels, sizes: _Labels, used: int, root: int | None) -> str:
        """Return why a region may be the wrong one; empty if nothing speaks against it."""
        # A solid frame hides that a region is the outside.
        rings = min(self._grid.shape) // 2
        frame = next((n for n in range(rings) if not self._is_solid_ring(n)), rings)
        outside = self._at_border(labels, frame)
        where = "a region that reaches the picture's border" if outside[used] else "a region"
        if root is not None and labels.ravel()[root] != used:
            return (
                f"start and target are in {where}, and the map's origin, where its robot mostly began, "
                f"is not in it: the region there is too small for a disc of radius {self._radius:g} m; use "
                f"a smaller radius, or choose --start and --target"
            )
        if self._at_border(labels, frame=0)[used]:
            return (
                f"start and target are in {where}, so they may be outside of what the map shows; if so, "
                f"choose --start and --target"
            )
        inner = int(np.max(np.where(outside, 0, sizes)))
        if root is None and frame and outside[used] and inner >= _SMALL * sizes[used]:
            return (
                f"start and target are in {where}, along its frame; another one, with "
                f"{100 * inner / sizes.sum():.0f} % of the free space, does not reach it; if the map shows "
                f"that one, choose --start and --target"
            )
        return ""

    def _is_solid_ring(self, number: int) -> bool:
        rows, columns = self._grid.shape
        ring = self._grid[number : rows - number, number : columns - number]
        return bool(ring[0].all() and ring[-1].all() and ring[:, 0].all() and ring[:, -1].all())

    def _labelled(self) -> tuple[_Labels, _Labels]:
        """Return the number of each place's region, from 1, and the regions' sizes."""
        from scipy.ndimage import label  # noqa: PLC0415 - takes a while to import

        labels: _Labels = label(self.clear)[0]
        sizes = np.bincount(labels.ravel())
        sizes[0] = 0
        return labels, sizes

    def _at_border(self, labels: _Labels, frame: int) -> Bools:
        """Return, by number, which regions have a place as near to the border as a disc can be.

        Args:
            labels: The number of each place's region.
            frame: Cells around the picture that do not count.
        """
        rim = math.ceil(2 * (self._cells + frame)) + 1
        found = np.zeros(int(labels.max()) + 1, np.bool_)
        for part in (labels[:rim], labels[-rim:], labels[:, :rim], labels[:, -rim:]):
            found[np.unique(part)] = True
        return found

    def _node_of_origin(self, origin: _Point) -> int | None:
        """Return a clear place at the origin of the map's coordinates; None if it is elsewhere."""
        height, width = (side * self._cell_size for side in self._grid.shape)
        if not (0.0 < origin[0] < width and 0.0 < origin[1] < height):
            return None
        near = self.nearest_to(origin)
        reach = 2.0 * self._radius + 2.0 * self._cell_size
        return None if near is None or math.dist(near, origin) > reach else self._node(near)

    def _node(self, point: _Point) -> int:
        i, j = (metres_to_lattice(value, self._cell_size) // _HALF for value in point)
        return j * self._stride + i

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
