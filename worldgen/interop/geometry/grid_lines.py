"""Exact positions of the lines between cells in a file's frame."""

from __future__ import annotations

from fractions import Fraction

from worldgen.errors import InvalidWorld
from worldgen.interop.format import Destination
from worldgen.lattice import exact
from worldgen.world import World

__all__ = ["GridLines"]

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
                "give --origin 0,0",
                at_terminal=True,
                cell_size=world.cell_size,
                x=destination.origin[0],
                y=destination.origin[1],
                bits=bits,
            )
