"""What the numbers of a grown maze mean.

A maze joins the chambers of a lattice. What is grown is ``links``, some bits a chamber, or a tree
in which each chamber names its parent. A direction is a number of quarter turns from +x. Both
arrays take one byte a chamber: a quarter byte a cell, where passages and walls are one cell wide.

The numbers are those of ``worldgen/core/wg_making.h``, which also says what a maze grows on.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from worldgen import _core

__all__ = [
    "CORNER",
    "EAST",
    "NORTH",
    "ROCK",
    "ROOT",
    "Links",
    "Mask",
    "links_of_parents",
    "open_sides",
    "ways_out",
]

Links: TypeAlias = npt.NDArray[np.int8]
"""(rows, columns): the bits EAST, NORTH, CORNER and ROCK of each chamber."""
Mask: TypeAlias = npt.NDArray[np.bool_]
"""(rows, columns): True where there is a chamber."""

_lib = _core.lib

# directions of a tree, beyond 0 to 3
ROOT: int = _lib.WG_ROOT  # leads nowhere

# links
EAST: int = _lib.WG_EAST  # open to the neighbour in +x
NORTH: int = _lib.WG_NORTH  # open to the neighbour in +y
CORNER: int = (
    _lib.WG_CORNER
)  # the pillar between this chamber and the three to its north and east is gone
ROCK: int = _lib.WG_ROCK  # no chamber


def links_of_parents(tree: npt.NDArray[np.int8]) -> Links:
    """Return the links of a tree whose chambers name their parents."""
    links = np.zeros(tree.shape, dtype=np.int8)
    links[:, :-1] = (tree[:, :-1] == 0) | (tree[:, 1:] == 2)
    links[:-1] |= ((tree[:-1] == 1) | (tree[1:] == 3)).view(np.int8) << 1
    return links


def open_sides(links: Links) -> npt.NDArray[np.bool_]:
    """Return which neighbours each chamber is open to: (rows, columns, 4), the last axis in quarter turns."""
    sides = np.zeros((*links.shape, 4), dtype=np.bool_)
    sides[:, :-1, 0] = sides[:, 1:, 2] = links[:, :-1] & EAST
    sides[:-1, :, 1] = sides[1:, :, 3] = links[:-1] & NORTH
    return sides


def ways_out(links: Links, column: int, row: int) -> list[int]:
    """Return the directions that one chamber is open to, rising."""
    below = row > 0 and links[row - 1, column]
    left = column > 0 and links[row, column - 1]
    here = links[row, column]
    return [
        way
        for way, is_open in enumerate((here & EAST, here & NORTH, left & EAST, below & NORTH))
        if is_open
    ]
