"""Place walls as boxes in the coordinates of a file, and write them.

Meshes, stages and the worlds of simulators are built from them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from worldgen.domain import CELL_SIZES
from worldgen.errors import InvalidWorld
from worldgen.interop.format import Destination, Exported
from worldgen.interop.geometry.boxes import always_solid, closing_boxes, merged_boxes
from worldgen.lattice import exact
from worldgen.parameters.bounds import check_between
from worldgen.support.arrays import Ints
from worldgen.world import World

BOX_CORNERS = tuple((k & 1, k >> 1 & 1, k >> 2) for k in range(8))
"""Corners of a box: 0 for the low end, 1 for the high end, of x, y and z."""

BOX_QUADS = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
"""Faces of a box as corner numbers, counter-clockwise seen from outside.

-z, +z, -y, +y, -x, +x.
"""

BOX_TRIANGLES = tuple((quad[0], *pair) for quad in BOX_QUADS for pair in (quad[1:3], quad[2:4]))
"""The same faces as twelve triangles."""


# Rounding may move a wall by at most this part of a cell.
_FINEST = Fraction(1, 1000)


class GridLines:
    """Exact coordinates, m, of the lines between cells, in a file's frame.

    They reach from -1 to one cell beyond the grid.

    Args:
        world: The world with the grid.
        destination: Gives the frame of the coordinates.
        bits: Bits of a coordinate's significand in the file or in the programs that read it; 24 for
            float32.

    Raises:
        InvalidWorld: If cells are so far from the frame's origin that rounding moves a line by more
            than a thousandth of a cell.
    """

    def __init__(self, world: World, destination: Destination, *, bits: int = 53) -> None:
        cell = exact(world.cell_size)
        x, y = (exact(value) for value in destination.origin)
        self.x = {ix: ix * cell + x for ix in range(-1, world.width + 2)}
        self.y = {iy: iy * cell + y for iy in range(-1, world.height + 2)}
        furthest = max(
            abs(end) for axis in (self.x, self.y) for end in (axis[-1], max(axis.values()))
        )
        if furthest / 2**bits > _FINEST * cell:
            raise InvalidWorld(
                "too-many-digits",
                "cells of {cell_size:g} m around ({x:g}, {y:g}) m need more than the "
                "{bits} bits that a coordinate has here",
                "use --origin 0,0",
                at_terminal=True,
                cell_size=world.cell_size,
                x=destination.origin[0],
                y=destination.origin[1],
                bits=bits,
            )


@dataclass(frozen=True)
class PlacedBox:
    """A box with sides parallel to the axes.

    Args:
        name: A unique name such as ``wall_1``, ``border_1`` or ``floor``.
        low: x, y and z, m, of its lowest corner.
        high: x, y and z, m, of its highest corner.
    """

    name: str
    low: tuple[Fraction, Fraction, Fraction]
    high: tuple[Fraction, Fraction, Fraction]

    @property
    def size(self) -> tuple[Fraction, Fraction, Fraction]:
        """Lengths of the sides, m."""
        ax, ay, az = self.low
        bx, by, bz = self.high
        return bx - ax, by - ay, bz - az

    @property
    def centre(self) -> tuple[Fraction, Fraction, Fraction]:
        """x, y and z, m, of the middle."""
        ax, ay, az = self.low
        bx, by, bz = self.high
        return (ax + bx) / 2, (ay + by) / 2, (az + bz) / 2


def solid_boxes(
    world: World, destination: Destination, *, height: float, floor: bool, bits: int = 53
) -> list[PlacedBox]:
    """Return boxes for the walls, for a ring around an open border and, on request, for a floor.

    Args:
        world: The world; only cells that are solid at all times count.
        destination: Gives the frame of the coordinates; z is 0 at the foot of the walls.
        height: Height of the walls, m.
        floor: True to add a box one cell thick below everything.
        bits: Bits of a coordinate, as in :class:`GridLines`.

    Raises:
        InvalidParameter: If the height is below 1e-6 or above 1e6 m.
        InvalidWorld: If :class:`GridLines` raises it.
    """
    check_between("height", height, *CELL_SIZES, "m")
    lines = GridLines(world, destination, bits=bits)
    ring = closing_boxes(world)
    top = exact(height)
    boxes = [
        *_named("wall", merged_boxes(always_solid(world)), lines, top),
        *_named("border", ring, lines, top),
    ]
    if floor:
        more = 1 if len(ring) else 0
        low = (lines.x[-more], lines.y[-more], -exact(world.cell_size))
        boxes.append(
            PlacedBox(
                "floor",
                low,
                (lines.x[world.width + more], lines.y[world.height + more], Fraction(0)),
            )
        )
    return boxes


def box_writer(
    contents: Callable[[World, Destination, list[PlacedBox]], bytes], *, bits: int = 53
) -> Callable[..., Exported]:
    """Return the writer of a format that has nothing but boxes.

    Args:
        contents: Function that returns the file with these boxes.
        bits: Bits of a coordinate in the file, as for :func:`solid_boxes`.
    """

    def write(
        world: World, destination: Destination, *, height: float = 1.0, floor: bool = False
    ) -> Exported:
        """Return the file, in metres, z up.

        Args:
            world: A static world.
            destination: Where the file is written.
            height: Height of the walls, m.
            floor: Whether to add a floor, a box one cell thick below z = 0.

        Raises:
            InvalidParameter: If the height isn't a valid length.
            InvalidWorld: If the coordinates need more bits than they have.
        """
        boxes = solid_boxes(world, destination, height=height, floor=floor, bits=bits)
        return Exported({destination.name: contents(world, destination, boxes)})

    return write


def box_mesh(boxes: Sequence[PlacedBox]) -> Any:
    """Return one mesh of all boxes in the given order, eight vertices and twelve triangles each."""
    import trimesh

    ends = np.array(
        [[*map(float, box.low), *map(float, box.high)] for box in boxes], np.float64
    ).reshape(-1, 2, 3)
    corners = np.stack([ends[:, pick, range(3)] for pick in BOX_CORNERS], axis=1)
    faces = np.array(BOX_TRIANGLES, np.int64) + 8 * np.arange(len(boxes))[:, None, None]
    return trimesh.Trimesh(
        corners.reshape(-1, 3), faces.reshape(-1, 3), process=False, validate=False
    )


def placed_box(name: str, cells: Sequence[int], lines: GridLines, top: Fraction) -> PlacedBox:
    """Return a box on the floor.

    Args:
        name: Name of the box.
        cells: Four numbers, as in a row of :func:`~worldgen.interop.geometry.boxes.merged_boxes`.
        lines: Positions of the lines between cells.
        top: z of its upper side, m.
    """
    left, bottom, right, upper = cells
    return PlacedBox(
        name, (lines.x[left], lines.y[bottom], Fraction(0)), (lines.x[right], lines.y[upper], top)
    )


def _named(kind: str, cells: Ints, lines: GridLines, top: Fraction) -> list[PlacedBox]:
    return [
        placed_box(f"{kind}_{number}", row, lines, top)
        for number, row in enumerate(cells.tolist(), 1)
    ]
