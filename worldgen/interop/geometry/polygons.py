"""Walls as polygons with holes, in cells: what maps and plans are made of.

A corner is where an outline turns. Outlines run with solid cells on their left, from corner to
corner: sorted by
place, the n-th corner that is left eastwards is followed by the n-th that is entered eastwards, and
so in every direction, for the sides of one line never overlap.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from worldgen.interop.geometry.boxes import closing_boxes
from worldgen.world import World

__all__ = ["Polygon", "Ring", "border_cells", "cell_polygons"]

Ring: TypeAlias = list[tuple[int, int]]
Polygon: TypeAlias = list[Ring]

_EAST, _NORTH, _WEST, _SOUTH = range(4)
# Cells about a corner, lower left, lower right, upper left, upper right, as bits 1, 2, 4, 8: solid
# ones, and the direction in which the corner is entered and left. Diagonal cells are two corners.
_TURNS = (
    (8, _SOUTH, _EAST), (4, _EAST, _NORTH), (1, _NORTH, _WEST), (2, _WEST, _SOUTH),
    (9, _SOUTH, _EAST), (9, _NORTH, _WEST), (6, _EAST, _NORTH), (6, _WEST, _SOUTH),
    (7, _WEST, _NORTH), (11, _SOUTH, _WEST), (14, _EAST, _SOUTH), (13, _NORTH, _EAST),
)  # fmt: skip


def cell_polygons(solid: npt.NDArray[np.bool_], first: int = 0) -> list[Polygon]:
    """Return polygons that cover exactly the solid cells.

    Pieces that touch at a corner only are polygons of their own.

    Args:
        solid: (height, width) bool, row 0 the lowest y.
        first: Index, in x and y, of the first cell.

    Returns:
        Polygons in order of their first corners; each its outline, counter-clockwise, then its
        holes, clockwise; each ring from its lowest, of these its leftmost corner on, in cells,
        without that corner repeated at its end. No ring meets itself, and none crosses another.
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


def border_cells(world: World) -> npt.NDArray[np.bool_]:
    """Return the cells with a ring around them, solid if the border is open.

    The result has shape (height + 2, width + 2).
    """
    return np.pad(np.zeros_like(world.walls), 1, constant_values=len(closing_boxes(world)) > 0)


def _corners(solid: npt.NDArray[np.bool_]) -> tuple[npt.NDArray[np.int64], ...]:
    """Of every corner x, y, and the directions in which it is entered and left."""
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


def _links(
    x: npt.NDArray[np.int64],
    y: npt.NDArray[np.int64],
    entered: npt.NDArray[np.int64],
    left: npt.NDArray[np.int64],
) -> npt.NDArray[np.int64]:
    """Return the number of the corner that comes after each."""
    after = np.empty(len(x), np.int64)
    for direction in range(4):
        keys = (x, y) if direction in (_EAST, _WEST) else (y, x)
        by_place = np.lexsort(keys)
        after[by_place[left[by_place] == direction]] = by_place[entered[by_place] == direction]
    return after


def _rings(
    x: list[int], y: list[int], after: list[int]
) -> tuple[list[Ring], npt.NDArray[np.int64]]:
    """Return rings that do not touch themselves, and the ring of each corner's next side."""
    rings: list[Ring] = []
    owner = [-1] * len(x)
    for begin in range(len(x)):
        path: list[int] = []
        places: dict[tuple[int, int], int] = {}
        at = begin
        while owner[begin] < 0:
            place = (x[at], y[at])
            since = places.get(place)
            if since is not None:  # a ring closes here; another may go on from the same place
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
    """Return the ring from its lowest, of these its leftmost corner on."""
    first = min(range(len(ring)), key=lambda k: ring[k][::-1])
    return ring[first:] + ring[:first]


def _shells(
    solid: npt.NDArray[np.bool_],
    rings: list[Ring],
    eastward: tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]],
) -> list[int]:
    """Return the number of the outline that each ring belongs to: its own, if it is none of a hole.

    Below a hole's first corner is a solid cell; where the solid cells below that end there is a
    ring of the same piece, whose first corner is lower.

    Args:
        solid: The cells.
        rings: As :func:`_rings` gives them.
        eastward: Of the sides that run east, sorted, the place of their beginnings and their rings.
    """
    across = solid.shape[1] + 1
    keys, owners = eastward
    shells = list(range(len(rings)))
    for number in sorted(range(len(rings)), key=lambda number: rings[number][0][1]):
        (x, y), (_, second) = rings[number][:2]
        if (
            second == y
        ):  # an outline leaves its first corner eastwards, the ring of a hole northwards
            continue
        below = solid[:y, x][::-1]
        depth = y if below.all() else int(np.argmin(below))
        side = int(np.searchsorted(keys, (y - depth) * across + x, side="right")) - 1
        shells[number] = shells[int(owners[side])]
    return shells
