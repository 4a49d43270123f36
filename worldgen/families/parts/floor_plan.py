"""Floor plans: divide a square into corridors and rooms, and list the walls between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from worldgen.errors import InvalidParameter
from worldgen.families.parts.layout import CHOSEN, Arena
from worldgen.random_streams import RandomStream
from worldgen.support.arrays import Ints

Style: TypeAlias = Literal["wings", "spine", "suite"]
Box: TypeAlias = tuple[int, int, int, int]

# Largest side to draw for a room, as a multiple of the least possible side.
LARGEST = 4
# Boxes whose sides exceed this multiple of a room's least side are always divided.
ROOMY = 3
# Probability, as a fraction, that a smaller box stays whole although it could be divided.
_STOP = (1, 3)


@dataclass(frozen=True)
class Sizes:
    """Hold the lengths of a floor plan.

    Args:
        room: Minimum inner side of a room, cells.
        corridor: Width of corridors, cells.
        door: Width of doors, cells.
        wall: Thickness of walls, cells.
    """

    room: int
    corridor: int
    door: int
    wall: int


@dataclass(frozen=True)
class FloorPlan:
    """The boxes of a plan, which are one wall's thickness apart.

    Args:
        boxes: (n, 4) int64, x0, y0, x1, y1 in cells; corridors come first.
        corridors: Number of boxes that are corridors.
        owner: (size, size) int32, the box that each cell is in; -1 for walls.
    """

    boxes: Ints
    corridors: int
    owner: npt.NDArray[np.int32]


@dataclass(frozen=True)
class Joints:
    """The stretches of wall between two boxes, where a door can be; one row each.

    Args:
        pairs: (n, 2) the boxes on both sides.
        across: (n,) axis across the wall: 0 if the boxes are neighbours in x, 1 in y.
        place: (n,) first cell of the wall along that axis.
        low: (n,) first cell of the stretch along the wall.
        length: (n,) length of the stretch, cells.
    """

    pairs: Ints
    across: Ints
    place: Ints
    low: Ints
    length: Ints

    def opening(self, joint: int, first: int, width: int, wall: int) -> tuple[slice, slice]:
        """Return the rows and columns of an opening.

        Args:
            joint: Index of the stretch.
            first: First cell of the opening, counted from the stretch's first cell.
            width: Width of the opening, cells.
            wall: Thickness of the wall, cells.
        """
        along = slice(int(self.low[joint]) + first, int(self.low[joint]) + first + width)
        through = slice(int(self.place[joint]), int(self.place[joint]) + wall)
        return (through, along) if self.across[joint] else (along, through)


def fit_sizes(
    rng: RandomStream, arena: Arena, style: Style, sizes: Sizes, *, spacious: int = 0
) -> Sizes:
    """Check that two rooms and a corridor fit into the square, and draw the rooms' side if needed.

    Args:
        rng: The only source of randomness.
        arena: The square.
        style: Style of the plan; ``suite`` has no corridors.
        sizes: The requested sizes; the rooms' side may be ``CHOSEN``.
        spacious: Cells to add to the least side before drawing, if there is room.

    Raises:
        InvalidParameter: If the sizes do not fit, or a door is wider than a room.
    """
    # Limits of a room's side: doors and the robot from below, the square from above.
    beside = sizes.wall if style == "suite" else sizes.corridor + 2 * sizes.wall
    most = (arena.inside - beside) // 2
    least = max(arena.narrowest, sizes.door)
    asked = least if sizes.room == CHOSEN else sizes.room
    if asked < least:
        name = "door" if sizes.door > arena.narrowest else "robot"
        raise InvalidParameter(
            "below-minimum",
            "room={room} is narrower than the {name}, {least} cells",
            "use at least {least}, or omit it to draw one",
            room=asked,
            name=name,
            least=least,
        )
    if asked > most:
        raise InvalidParameter(
            "no-room",
            "two rooms of {room} cells and the {between} cells between them are more than the "
            "{inside} cells inside size={size}",
            "use a size of at least {least}, or smaller rooms, walls or corridors",
            room=asked,
            between=beside,
            inside=arena.inside,
            size=arena.size,
            least=2 * asked + beside + 2,
        )
    if sizes.room == CHOSEN:
        low = min(most, least + max(1, spacious))
        asked = rng.between(low, max(low, min(most, LARGEST * least, arena.inside // 5)))
    return Sizes(asked, sizes.corridor, sizes.door, sizes.wall)


def divide(rng: RandomStream, arena: Arena, style: Style, sizes: Sizes) -> FloorPlan:
    """Divide the square into corridors and rooms.

    The boxes on both sides of a cut begin at the same line, so they share at least a room's least
    side. Every box can therefore be joined to the rest.

    Args:
        rng: The only source of randomness.
        arena: The square.
        style: ``wings`` lets corridors branch off corridors until every room is near one,
            ``spine`` has one corridor across the square, and ``suite`` has no corridors.
        sizes: Lengths from :func:`fit_sizes`.
    """
    whole = (1, 1, arena.size - 1, arena.size - 1)
    corridors: list[Box] = []
    blocks = [whole]
    if style != "suite":
        blocks, corridors = _corridors(
            rng.child("corridors"), whole, sizes, most=1 if style == "spine" else None
        )
    rooms = _rooms(rng.child("rooms"), blocks, sizes)
    boxes = np.array([*corridors, *rooms], dtype=np.int64)
    owner = np.full((arena.size, arena.size), -1, dtype=np.int32)
    for number, (x0, y0, x1, y1) in enumerate([*corridors, *rooms]):
        owner[y0:y1, x0:x1] = number
    return FloorPlan(boxes, len(corridors), owner)


def _corridors(
    rng: RandomStream, whole: Box, sizes: Sizes, most: int | None
) -> tuple[list[Box], list[Box]]:
    """Return blocks for rooms, and the corridors between them.

    Every corridor but the first ends at another one.
    """
    # The first cut needs only room for two rooms; later ones leave blocks uncut
    # if they are small enough; the limit is drawn.
    least = sizes.corridor + 2 * sizes.wall + 2 * sizes.room
    enough = max(least, sizes.corridor + 2 * sizes.wall + rng.between(2, 2 * ROOMY) * sizes.room)
    first_axis = rng.below(2)
    pending: list[tuple[Box, int]] = [(whole, 0)]
    blocks: list[Box] = []
    corridors: list[Box] = []
    while pending:
        box, level = pending.pop()
        sides = (box[2] - box[0], box[3] - box[1])
        # The first two corridors cross; later ones divide the longer side.
        axis = (first_axis + level) % 2 if level < 2 else int(sides[1] > sides[0])
        if sides[axis] < (least if not corridors else enough) or (
            most is not None and len(corridors) >= most
        ):
            blocks.append(box)
            continue

        # Cut in the middle half of the spare length, so that the blocks are not too uneven.
        spare = sides[axis] - least
        at = box[axis] + sizes.room + spare // 4 + rng.between(0, spare - 2 * (spare // 4))
        near, corridor, far = _split(box, axis, at, at + 2 * sizes.wall + sizes.corridor)
        corridors.append(_inner(corridor, axis, sizes.wall))
        pending += [(near, level + 1), (far, level + 1)]
    return blocks, corridors


def _split(box: Box, axis: int, low: int, high: int) -> tuple[Box, Box, Box]:
    """Split a box along an axis into the parts before ``low``, up to ``high`` and after it."""
    x0, y0, x1, y1 = box
    if axis == 0:
        return (x0, y0, low, y1), (low, y0, high, y1), (high, y0, x1, y1)
    return (x0, y0, x1, low), (x0, low, x1, high), (x0, high, x1, y1)


def _inner(box: Box, axis: int, wall: int) -> Box:
    x0, y0, x1, y1 = box
    return (x0 + wall, y0, x1 - wall, y1) if axis == 0 else (x0, y0 + wall, x1, y1 - wall)


def _rooms(rng: RandomStream, blocks: list[Box], sizes: Sizes) -> list[Box]:
    """Cut blocks in two repeatedly until they are rooms."""
    least = 2 * sizes.room + sizes.wall
    pending = blocks[::-1]
    rooms: list[Box] = []
    while pending:
        box = pending.pop()
        sides = (box[2] - box[0], box[3] - box[1])
        if max(sides) < least or (
            max(sides) <= ROOMY * sizes.room + sizes.wall
            and len(rooms) + len(pending)
            and rng.below(_STOP[1]) < _STOP[0]
        ):
            rooms.append(box)
            continue
        # Cut the longer side, or either one if the box is nearly square.
        axis = int(sides[1] > sides[0])
        if min(sides) >= least and 2 * max(sides) < 3 * min(sides):
            axis = rng.below(2)
        at = box[axis] + sizes.room + rng.between(0, sides[axis] - least)
        near, _, far = _split(box, axis, at, at + sizes.wall)
        pending += [far, near]
    return rooms


def joined(plan: FloorPlan, sizes: Sizes) -> Joints:
    """Return every stretch of wall between two boxes that a door fits into."""
    found = [_side_by_side(plan.owner, sizes.wall), _side_by_side(plan.owner.T, sizes.wall)]
    across = np.repeat([0, 1], [len(rows) for rows in found])
    table = np.concatenate(found)
    kept = table[:, 4] >= sizes.door
    table = table[kept]
    across = across[kept]
    return Joints(table[:, :2], across, table[:, 2], table[:, 3], table[:, 4])


def _side_by_side(owner: npt.NDArray[np.int32], wall: int) -> Ints:
    """List the boxes that are neighbours in x.

    Args:
        owner: (rows, columns) the box that each cell is in; -1 for walls.
        wall: Thickness of walls, cells.

    Returns:
        (n, 5) rows: left box, right box, first column of the wall, first shared row, number of
        shared rows.
    """
    left = owner[:, : -wall - 1].astype(np.int64)
    right = owner[:, wall + 1 :].astype(np.int64)
    # ``nonzero`` lists rows in ascending order, so the first hit of a pair is its lowest row.
    rows, columns = np.nonzero((left >= 0) & (right >= 0) & (left != right))
    a = left[rows, columns]
    b = right[rows, columns]
    _, first, count = np.unique(a * (owner.max() + 1) + b, return_index=True, return_counts=True)
    return np.stack([a[first], b[first], columns[first] + 1, rows[first], count], axis=1)
