"""Find the narrow places of a map: doors, bends, and gaps next to pillars.

Everything is measured at the *nodes* of a map, the multiples of half a cell. A part of the map is
narrow if the robot fits there but a wider disc does not. Where such a part joins two parts with
room for the wider disc, its narrowest point on the widest path between them is a narrow place.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from worldgen.reach.still.grid_search import components, squared_distances
from worldgen.reach.still.lattice_graph import clear_from
from worldgen.support.arrays import Bools, Ints

# Radii of the wider discs, in radii of the robot. From both sides of a thin wall, a disc of w radii
# covers the middle of gaps of more than 2 * sqrt(2 * w - 1) radii, so these show gaps of up to 2.8,
# 3.5, 4.5 and 6 radii. A room must have space for the disc, so the smaller ones are needed, too.
_WIDER = (1.5, 2.0, 3.0, 5.0)
# Limit on the narrow nodes that are examined one by one for a wider disc; this many take about a
# second. The largest narrow parts, which are long corridors, are left out first.
_MOST_NODES = 250_000
# Limit on the places, because a campaign rarely draws as many.
_MOST_PLACES = 500


@dataclass(frozen=True)
class NarrowPlace:
    """A narrow place.

    Args:
        row: Row of its node.
        column: Column of its node.
        clearance: Distance to the nearest wall, half cells.
    """

    row: int
    column: int
    clearance: float

    @property
    def nodes(self) -> Ints:
        """Its node, (1, 2)."""
        return np.array(((self.row, self.column),))


@dataclass(frozen=True)
class Ground:
    """The nodes of a grid, as a disc meets them.

    Args:
        squared: (2 * height + 1, 2 * width + 1) int32, squared distance to the nearest solid cell,
            in half cells; exact.
        clear: Same shape; True where the disc fits.
    """

    squared: Ints
    clear: Bools

    @functools.cached_property
    def floor(self) -> Ints:
        """The flat indices of the nodes where the disc fits."""
        return np.flatnonzero(self.clear)

    @classmethod
    def of(cls, walls: Bools, radius: Fraction) -> Ground:
        """Return the nodes of a grid for a disc of ``radius`` cells."""
        squared = squared_distances(_solid_nodes(walls))
        return cls(squared, squared >= clear_from(radius, 2))


def _solid_nodes(walls: Bools) -> Bools:
    """Return which nodes are in or on a solid cell, or on the rim of the grid."""
    height, width = walls.shape
    solid = np.ones((2 * height + 1, 2 * width + 1), np.bool_)
    solid[1:-1, 1:-1] = False
    for row in range(3):
        for column in range(3):
            rows = slice(row, row + 2 * height - 1, 2)
            solid[rows, column : column + 2 * width - 1 : 2] |= walls
    return solid


def narrow_places(ground: Ground, radius: float) -> tuple[NarrowPlace, ...]:
    """Return the narrow places of a map, the narrowest first.

    Args:
        ground: The map's nodes.
        radius: Radius of the disc, cells.
    """
    # Two places that are closer to each other than this many half cells may be the same door.
    apart = max(4.0 * radius, 4.0)
    found: dict[tuple[int, int], NarrowPlace] = {}
    for share in _WIDER:
        narrow, rim = _narrow_parts(ground, 2.0 * radius, 2.0 * radius * share)
        for place in _joints(ground, narrow, rim):
            row = int(place.row // apart)
            column = int(place.column // apart)
            near = [
                found[at]
                for at in itertools.product(range(row - 1, row + 2), range(column - 1, column + 2))
                if at in found
            ]
            if all(
                (one.row - place.row) ** 2 + (one.column - place.column) ** 2 >= apart * apart
                for one in near
            ):
                found[row, column] = place
    ordered = sorted(found.values(), key=lambda one: (one.clearance, one.row, one.column))
    # Of many, keep some of every width.
    return tuple(ordered[:: max(1, math.ceil(len(ordered) / _MOST_PLACES))])


def _narrow_parts(ground: Ground, radius: float, wider: float) -> tuple[Bools, Bools]:
    """Return the nodes that a wider disc never covers, and the rim around them.

    Args:
        ground: The map's nodes.
        radius: Radius of the disc, half cells.
        wider: Radius of the wider disc, half cells.
    """
    roomy = ground.squared >= wider * wider
    # Nodes between the lattice's are missing, so a node within a half cell of it is near, too.
    reach = wider - radius + 1.0
    near = squared_distances(roomy, math.ceil(reach * reach) + 1) <= reach * reach
    narrow = ground.clear & ~near
    # Two nodes wide, so that it holds together where walls are oblique.
    rim = ground.clear & near & (squared_distances(narrow, 5) <= 4)
    return narrow, rim


def _joints(ground: Ground, narrow: Bools, rim: Bools) -> Iterable[NarrowPlace]:
    """Yield the nodes at which narrow parts join two wide ones, in order of the parts."""
    if not narrow.any() or not rim.any():
        return
    stride = narrow.shape[1]
    part = components(narrow)[0]
    side = components(rim)[0]
    cells = np.flatnonzero(narrow)
    steps = np.array([1, -1, stride, -stride])

    # Parts with a single side are corners and niches.
    around = side[cells[:, None] + steps]
    pairs = np.unique(
        np.stack((np.repeat(part[cells], 4), around.ravel()), axis=1)[around.ravel() >= 0], axis=0
    )
    sizes = np.bincount(part[cells])
    joining = np.flatnonzero(np.bincount(pairs[:, 0], minlength=len(sizes)) >= 2)
    joining = joining[np.argsort(sizes[joining], kind="stable")]
    joining = joining[np.cumsum(sizes[joining]) <= _MOST_NODES]
    cells = cells[np.isin(part[cells], joining)]

    # In each part, widest nodes first, so that the first node to join two sides is the narrowest of
    # the widest path between them. In a corridor of one width that is its middle.
    away = squared_distances(rim).ravel()[cells]
    order = np.lexsort((cells, away, -ground.squared.ravel()[cells], part[cells]))
    cells = cells[order]
    begins = np.flatnonzero(np.diff(part[cells], prepend=-1))
    for own in np.split(cells, begins[1:]):
        for node in _joining_nodes(own.tolist(), side[own[:, None] + steps].tolist(), stride):
            row, column = divmod(node, stride)
            yield NarrowPlace(row, column, math.sqrt(ground.squared[row, column]))


def _joining_nodes(nodes: list[int], sides: list[list[int]], stride: int) -> list[int]:
    """Return the nodes of a part that join two of its sides, if nodes are added in turn.

    Args:
        nodes: The part's nodes.
        sides: For each, the numbers of the sides at its four neighbours; -1 for none.
        stride: Nodes per row.
    """
    # The keys are nodes and, below 0, sides. A set knows whether it has a side.
    parent: dict[int, int] = {}
    has_side: dict[int, bool] = {}

    def root(key: int) -> int:
        while parent[key] != key:
            parent[key] = parent[parent[key]]
            key = parent[key]
        return key

    found = []
    for node, around in zip(nodes, sides, strict=True):
        parent[node] = node
        has_side[node] = False
        for number in around:
            if number >= 0:
                parent.setdefault(-1 - number, -1 - number)
                has_side.setdefault(-1 - number, True)
        joins = False
        near = (node + 1, node - 1, node + stride, node - stride)
        for key in (*(-1 - number for number in around if number >= 0), *near):
            if key not in parent:
                continue
            one = root(node)
            other = root(key)
            if one != other:
                joins |= has_side[one] and has_side[other]
                has_side[other] |= has_side[one]
                parent[one] = other
        if joins:
            found.append(node)
    return found
