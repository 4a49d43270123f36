"""Define the numbers in a grown maze.

A maze joins the chambers of a lattice. It is stored either as ``links``, a few bits per chamber, or
as a tree in which each chamber names its parent. A direction is a number of quarter turns from +x.
Both arrays take one byte per chamber: a quarter byte per cell if passages and walls are one cell
wide.

The numbers come from ``worldgen/core/wg_making.h``, which also describes the board.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from worldgen import _core
from worldgen.support.arrays import Bools

Links: TypeAlias = npt.NDArray[np.int8]
"""(rows, columns): the bits EAST, NORTH, CORNER and ROCK of each chamber."""

_lib = _core.lib

# Directions in a tree are 0 to 3, and this one for a chamber without a parent.
ROOT: int = _lib.WG_ROOT

# Bits of a chamber's links.
EAST: int = _lib.WG_EAST  # open to the neighbour in +x
NORTH: int = _lib.WG_NORTH  # open to the neighbour in +y
# There is no pillar between this chamber and the three to its north and east.
CORNER: int = _lib.WG_CORNER
ROCK: int = _lib.WG_ROCK  # no chamber


def links_of_parents(tree: npt.NDArray[np.int8]) -> Links:
    """Convert a tree, in which each chamber names its parent, to links."""
    links = np.zeros(tree.shape, dtype=np.int8)
    links[:, :-1] = (tree[:, :-1] == 0) | (tree[:, 1:] == 2)
    links[:-1] |= ((tree[:-1] == 1) | (tree[1:] == 3)).view(np.int8) << 1
    return links


def open_sides(links: Links) -> Bools:
    """Return which neighbours each chamber is open to.

    Returns:
        (rows, columns, 4) bool; the last axis is the direction in quarter turns.
    """
    sides = np.zeros((*links.shape, 4), dtype=np.bool_)
    sides[:, :-1, 0] = sides[:, 1:, 2] = links[:, :-1] & EAST
    sides[:-1, :, 1] = sides[1:, :, 3] = links[:-1] & NORTH
    return sides


def ways_out(links: Links, column: int, row: int) -> list[int]:
    """Return the directions that one chamber is open to, in ascending order."""
    below = row > 0 and links[row - 1, column]
    left = column > 0 and links[row, column - 1]
    here = links[row, column]
    return [
        way
        for way, is_open in enumerate((here & EAST, here & NORTH, left & EAST, below & NORTH))
        if is_open
    ]
