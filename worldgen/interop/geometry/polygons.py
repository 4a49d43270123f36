"""Turn walls into polygons with holes, in cells, for maps and plans.

A corner is a point where an outline turns. Outlines keep solid cells on their left, from corner to
corner. Sorted by position, the n-th corner that is left eastwards is followed by the n-th that is
entered eastwards, and the same in every direction, because sides on one line never overlap.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from worldgen.interop.geometry.boxes import closing_boxes
from worldgen.support.arrays import Bools, Ints
from worldgen.world import World

Ring: TypeAlias = list[tuple[int, int]]
Polygon: TypeAlias = list[Ring]

_EAST, _NORTH, _WEST, _SOUTH = range(4)
# The four cells around a corner, lower left, lower right, upper left and upper right, as bits 1, 2,
# 4, 8: which are solid, and the direction in which the corner is entered and left. Diagonal cells
# make two corners.
_TURNS = (
    (8, _SOUTH, _EAST), (4, _EAST, _NORTH), (1, _NORTH, _WEST), (2, _WEST, _SOUTH),
    (9, _SOUTH, _EAST), (9, _NORTH, _WEST), (6, _EAST, _NORTH), (6, _WEST, _SOUTH),
    (7, _WEST, _NORTH), (11, _SOUTH, _WEST), (14, _EAST, _SOUTH), (13, _NORTH, _EAST),
)  # fmt: skip


def cell_polygons(solid: Bools, first: int = 0) -> list[Polygon]:
    """Return polygons that cover exactly the solid cells.

    Pieces that touch only at a corner are separate polygons.

    Args:
        solid: (height, width) bool, row 0 the lowest y.
        first: Index, in x and y, of the first cell.

    Returns:
        Polygons in order of their first corners. Each is its outline, counter-clockwise, then its
        holes, clockwise. Each ring starts at its lowest corner, the leftmost if there are several,
        in cells, and does not repeat it at the end. No ring touches itself, and none crosses
        another.
    """
    x, y, entered, left = _corners(solid)
    after = _links(x, y, entered, left)
    rings, owner = _rings(x.tolist(), y.tolist(), after.tolist())
    places = y * (solid.shape[1] + 1) + x
    east = np.nonzero(left == _EAST)[0]
    east = east[np.argsort(places[east])]
    shells = _shells(solid, rings, (places[east], owner[east]))
    polygons: dict[int, Polygon] = {}
    for number in sorted(
        range(len(rings)), key=lambda number: (shells[number] != number, rings[number])
    ):
        ring = [(ix + first, iy + first) for ix, iy in rings[number]]
        polygons.setdefault(shells[number], []).append(ring)
    return sorted(polygons.values())


def border_cells(world: World) -> Bools:
    """Return the cells with a ring around them, solid if the border is open.

    The result has shape (height + 2, width + 2).
    """
    return np.pad(np.zeros_like(world.walls), 1, constant_values=len(closing_boxes(world)) > 0)


def _corners(solid: Bools) -> tuple[Ints, ...]:
    """Return x and y of every corner, and the directions in which it is entered and left."""
    cells = np.pad(solid, 1).astype(np.uint8)
    about = cells[:-1, :-1] | cells[:-1, 1:] << 1 | cells[1:, :-1] << 2 | cells[1:, 1:] << 3
    found = [np.nonzero(about == pattern) for pattern, _, _ in _TURNS]
    y, x = (
        np.concatenate([corners[axis] for corners in found]).astype(np.int64) for axis in (0, 1)
    )
    counts = [len(rows) for rows, _ in found]
    entered, left = (
        np.repeat([turn[part] for turn in _TURNS], counts).astype(np.int64) for part in (1, 2)
    )
    return x, y, entered, left


def _links(x: Ints, y: Ints, entered: Ints, left: Ints) -> Ints:
    """Return the number of the corner that follows each corner."""
    after = np.empty(len(x), np.int64)
    for direction in range(4):
        keys = (x, y) if direction in (_EAST, _WEST) else (y, x)
        by_place = np.lexsort(keys)
        after[by_place[left[by_place] == direction]] = by_place[entered[by_place] == direction]
    return after


def _rings(x: list[int], y: list[int], after: list[int]) -> tuple[list[Ring], Ints]:
    """Return rings that do not touch themselves, and the ring of each corner's next side."""
    # Follow the corners from every one that has no ring yet.
    rings: list[Ring] = []
    owner = [-1] * len(x)
    for begin in range(len(x)):
        path: list[int] = []
        places: dict[tuple[int, int], int] = {}
        at = begin
        while owner[begin] < 0:
            place = (x[at], y[at])
            since = places.get(place)
            # A ring closes here; another may continue from the same place.
            if since is not None:
                for corner in path[since:]:
                    owner[corner] = len(rings)
                    del places[x[corner], y[corner]]
                rings.append(_begun([(x[corner], y[corner]) for corner in path[since:]]))
                del path[since:]
            if owner[at] < 0:
                places[place] = len(path)
                path.append(at)
                at = after[at]
    return rings, np.array(owner, np.int64)


def _begun(ring: Ring) -> Ring:
    """Rotate the ring to start at its lowest corner, the leftmost if there are several."""
    first = min(range(len(ring)), key=lambda k: ring[k][::-1])
    return ring[first:] + ring[:first]


def _shells(solid: Bools, rings: list[Ring], eastward: tuple[Ints, Ints]) -> list[int]:
    """Return the number of each ring's outline; an outline's is its own.

    Below a hole's first corner is a solid cell. Where the run of solid cells below it ends, there
    is a ring of the same piece with a lower first corner.

    Args:
        solid: The cells.
        rings: As :func:`_rings` gives them.
        eastward: For the sides that run east, sorted, the place where they begin and their rings.
    """
    across = solid.shape[1] + 1
    keys, owners = eastward
    shells = list(range(len(rings)))
    for number in sorted(range(len(rings)), key=lambda number: rings[number][0][1]):
        (x, y), (_, second) = rings[number][:2]
        # An outline leaves its first corner eastwards, a hole's ring northwards.
        if second == y:
            continue
        below = solid[:y, x][::-1]
        depth = y if below.all() else int(np.argmin(below))
        side = int(np.searchsorted(keys, (y - depth) * across + x, side="right")) - 1
        shells[number] = shells[int(owners[side])]
    return shells
