"""The places of a map where a disc is clear, their regions.

The places are the multiples of half a cell. A step of half a cell along an axis between two clear
ones is clear as well (docs/explanation/reachability.md), so two places joined by such steps are
connected for the robot.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from worldgen.errors import InvalidWorld
from worldgen.interop.largest_disc import Fit, Point, largest_disc, no_room
from worldgen.lattice import UNIT, exact, in_cells, lattice_to_metres, metres_to_lattice
from worldgen.random_streams import RandomStream
from worldgen.reach.still.grid_search import Floods
from worldgen.reach.still.lattice_graph import build_graph
from worldgen.reach.still.walls import Walls
from worldgen.support.arrays import Bools

_HALF = UNIT // 2
# Radii of clearance around a chosen place, the widest first.
_ROOMY = (Fraction(2), Fraction(3, 2), Fraction(5, 4))
# A place with room to turn is chosen only if at least this share of its region is nearer.
_FAR = 0.5
# Share of the largest region from which one that does not reach the border is taken instead, and
# from which the one with the map's origin is.
_SMALL = 0.05
_TINY = 0.01
# Radii to suggest for a robot that does not fit at the map's origin, as shares of its own.
_SMALLER = (Fraction(3, 4), Fraction(1, 2), Fraction(1, 4), Fraction(1, 8))
LARGEST = "the largest region"
_Labels: TypeAlias = npt.NDArray[np.signedinteger[Any]]


class Region(NamedTuple):
    """A region: a place in it, its size, its share of all, and the number of regions.

    Then its name, and why it may be the wrong one; empty if nothing speaks against it.
    """

    root: int
    size: int
    share: float
    regions: int
    name: str
    warning: str = ""


class ClearPoints:
    """The clear multiples of half a cell, as flat indices, and flood fills over them.

    Args:
        walls: (height, width) bool, row 0 the lowest y.
        cell_size: m.
        radius: Radius of the robot's disc, m.
        clearance: Distance, m, that chosen places must have to the walls; the radius if that is
            more.
        body: Where the disc is, for messages, if it stands for a footprint: ``in the body of
            1 x 0.5 m``.
    """

    def __init__(
        self, walls: Bools, cell_size: float, radius: float, clearance: float = 0.0, body: str = ""
    ) -> None:
        cells = in_cells(radius, cell_size)
        self._cell_size = cell_size
        self._radius = radius
        self.body = f" ({body})" if body else ""
        self.smaller = "a smaller footprint" if body else "a smaller radius"
        self._cells = cells
        self._grid = walls
        self._walls = Walls(walls, cells)
        self._wanted = max(clearance, radius)
        self.clear = build_graph(walls, cells, 2).clear
        self._stride = int(self.clear.shape[1])
        self._floods = Floods(self.clear)
        self._wider = {exact(radius): self.clear.ravel()}

    def largest_region(self) -> Region:
        """Return the region with the most places.

        Raises:
            InvalidWorld: If no place is clear; it names the largest disc that fits.
        """
        found = self._floods.regions(0, self.clear.size)
        if found.largest == 0:
            raise no_room(self._grid, self._cell_size, self._radius)
        share = found.largest / found.places
        return Region(found.root, found.largest, share, found.regions, LARGEST)

    def region_of_picture(self, origin: Point) -> Region:
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
                region = Region(root, size, size / places, largest.regions, name)
        elif at_border[used] and others[best] >= _SMALL * largest.size:
            used = best
            size = int(sizes[best])
            node = int(np.argmax(labels.ravel() == best))
            name = "the largest region that does not reach the picture's border"
            region = Region(node, size, size / places, largest.regions, name)
        return region._replace(warning=self._doubt(labels, sizes, used, root, origin))

    def _doubt(
        self, labels: _Labels, sizes: _Labels, used: int, root: int | None, origin: Point
    ) -> str:
        """Return why a region may be the wrong one; empty if nothing speaks against it."""
        # A solid frame hides that a region is the outside.
        rings = min(self._grid.shape) // 2
        frame = next((n for n in range(rings) if not self._is_solid_ring(n)), rings)
        outside = self._at_border(labels, frame)
        where = "a region that reaches the picture's border" if outside[used] else "a region"
        if root is not None and labels.ravel()[root] != used:
            fits = None if self.body else self._radius_at(origin)
            smaller = self.smaller if fits is None else f"a radius of {fits:g} m, which is not"
            return (
                f"start and target are in {where}, and the map's origin, where its robot mostly began, "
                f"is not in it: the region there is too small for a disc of radius {self._radius:g} m"
                f"{self.body}; use {smaller}, or choose --start and --target"
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

    def _radius_at(self, origin: Point) -> float | None:
        """Return a smaller radius with which a robot can leave the map's origin; None if there is none."""
        for share in _SMALLER:
            radius = float(f"{float(share * exact(self._radius)):.3g}")
            smaller = ClearPoints(self._grid, self._cell_size, radius)
            root = smaller._node_of_origin(origin)
            largest = smaller.largest_region().size
            if (
                root is not None
                and smaller._floods.regions(root, root + 1).largest >= _TINY * largest
            ):
                return radius
        return None

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

    def _node_of_origin(self, origin: Point) -> int | None:
        """Return a clear place at the origin of the map's coordinates; None if it is elsewhere."""
        height, width = (side * self._cell_size for side in self._grid.shape)
        if not (0.0 < origin[0] < width and 0.0 < origin[1] < height):
            return None
        near = self.nearest_to(origin)
        reach = 2.0 * self._radius + 2.0 * self._cell_size
        return None if near is None or math.dist(near, origin) > reach else self._node(near)

    def _node(self, point: Point) -> int:
        i, j = (metres_to_lattice(value, self._cell_size) // _HALF for value in point)
        return j * self._stride + i

    def any_of(self, region: Region, rng: RandomStream) -> int:
        """Return one of a region's places, all equally likely."""
        self._floods.regions(region.root, region.root + 1)
        return int(self._floods.queue[rng.below(region.size)])

    def farthest(self, source: int) -> int:
        """Return the place with room to turn that is most steps away from ``source``.

        Ties go to the last place in flood order. A place without room to turn is chosen if all
        places with room are near, because a start next to its target would be no test.

        Raises:
            InvalidWorld: If no place that ``source`` reaches has the clearance.
        """
        size = self._floods.regions(source, source + 1).largest
        # Flood order is the order of the number of steps.
        nearest = math.ceil(_FAR * size)
        reached = self._floods.queue[:size].astype(np.int64)
        for times in _ROOMY:
            if times * exact(self._radius) >= exact(self._wanted):
                roomy = np.flatnonzero(self._clear_for(times * exact(self._radius))[reached])
                if len(roomy) and roomy[-1] >= nearest:
                    return int(reached[roomy[-1]])
        wide = np.flatnonzero(self._clear_for(exact(self._wanted))[reached])
        if not len(wide):
            raise self._no_clearance(reached)
        return int(reached[wide[-1]])

    def nearest_reached(self, point: Point, source: int | None) -> int:
        """Return the place with the clearance that is nearest to a point.

        Args:
            point: x and y, m.
            source: A place from which it must be reached; None for any.

        Raises:
            InvalidWorld: If there is none.
        """
        allowed = self._clear_for(exact(self._wanted)).copy()
        if source is not None:
            size = self._floods.regions(source, source + 1).largest
            reached = self._floods.queue[:size].astype(np.int64)
            inside = np.zeros(allowed.shape, np.bool_)
            inside[reached] = True
            allowed &= inside
        found = self.nearest_to(point, allowed.reshape(self.clear.shape))
        if found is None:
            everywhere = np.flatnonzero(self.clear) if source is None else reached
            if not len(everywhere):
                raise no_room(self._grid, self._cell_size, self._radius)
            raise self._no_clearance(everywhere)
        return self._node(found)

    def _clear_for(self, radius: Fraction) -> Bools:
        """Return which places are clear for a disc of this radius, m, flat."""
        if radius not in self._wider:
            cells = radius / exact(self._cell_size)
            self._wider[radius] = build_graph(self._grid, cells, 2).clear.ravel()
        return self._wider[radius]

    def _no_clearance(self, reached: npt.NDArray[np.int64]) -> InvalidWorld:
        among = np.zeros(self.clear.shape, np.bool_)
        among.ravel()[reached] = True
        fit = largest_disc(self._grid, self._cell_size, among)
        return InvalidWorld(
            "no-room",
            "no place that can be reached is {clearance:g} m from the nearest wall",
            "use a smaller clearance"
            if fit is None
            else "use a clearance of up to {fits:g} m, which there is at {clear[0]!r},{clear[1]!r}",
            clearance=self._wanted,
            **({} if fit is None else {"fits": fit.radius, "clear": fit.centre}),
        )

    def near(self, point: Point) -> int:
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
            fit = self._largest_near(point)
            raise InvalidWorld(
                "no-room",
                "there is no room for a disc of radius {radius:g} m{body} near ({x:g}, {y:g}) m, so "
                "the other end cannot be placed",
                "choose both start and target, or {smaller}"
                + ("" if fit is None else "; a radius of up to {fits:g} m fits"),
                radius=self._radius,
                body=self.body,
                smaller=self.smaller,
                x=point[0],
                y=point[1],
                **({} if fit is None else {"fits": fit.radius}),
            )
        return min(found)[2]

    def _largest_near(self, point: Point) -> Fit | None:
        """Return the largest disc that fits within a cell of a point."""
        x, y = (metres_to_lattice(value, self._cell_size) // _HALF for value in point)
        among = np.zeros(self.clear.shape, np.bool_)
        among[max(y - 1, 0) : y + 3, max(x - 1, 0) : x + 3] = True
        return largest_disc(self._grid, self._cell_size, among)

    def nearest_to(self, point: Point, among: Bools | None = None) -> Point | None:
        """Return the clear place nearest to a point, m; None if there is none.

        Args:
            point: x and y, m.
            among: The places to consider, in two dimensions; all clear ones if omitted.
        """
        among = self.clear if among is None else among
        x, y = (metres_to_lattice(value, self._cell_size) / _HALF for value in point)
        # Search a window that grows until the nearest place is certainly inside it.
        reach = 8
        while True:
            low_j = max(0, math.floor(y) - reach)
            low_i = max(0, math.floor(x) - reach)
            window = among[low_j : math.floor(y) + reach + 1, low_i : math.floor(x) + reach + 1]
            j, i = np.nonzero(window)
            if len(j):
                distance = (i + low_i - x) ** 2 + (j + low_j - y) ** 2
                best = int(np.argmin(distance))
                if distance[best] <= reach * reach:
                    return self.metres((int(j[best]) + low_j) * self._stride + int(i[best]) + low_i)
            if reach > 2 * max(self.clear.shape):
                return None
            reach *= 2

    def metres(self, node: int) -> Point:
        """Return x and y, m, of a place."""
        j, i = divmod(node, self._stride)
        return lattice_to_metres(i * _HALF, self._cell_size), lattice_to_metres(
            j * _HALF, self._cell_size
        )
