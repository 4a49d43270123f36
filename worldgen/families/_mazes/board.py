"""The board that every maze grows on, and what its numbers mean.

A maze joins the chambers of a lattice. While it grows, the chambers lie in one flat array with a ring of
``OUTSIDE`` round them: the neighbour of ``at`` in a direction is at ``at + 1``, ``at + stride``, ``at - 1`` or
``at - stride``, and nothing asks whether there is one. A direction is a number of quarter turns from +x.

What is grown is ``links``: a small number of bits a chamber. Both arrays take one byte a chamber: a quarter
byte a cell, where passages and walls are one cell wide.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

__all__ = [
    "AT", "CORNER", "EAST", "FREE", "LEFT", "NORTH", "OUTSIDE", "ROCK", "ROOT", "STATE_SIZE", "USED",
    "Links", "Mask", "blank_board", "inner", "links_of_parents", "open_sides", "ways_out",
]  # fmt: skip

Links: TypeAlias = npt.NDArray[np.int8]
"""(rows, columns): the bits EAST, NORTH, CORNER and ROCK of each chamber."""
Mask: TypeAlias = npt.NDArray[np.bool_]
"""(rows, columns): True where there is a chamber."""

# A growing board: 0 to 3, the direction to the parent, in the maze; FREE and more, not yet in it.
ROOT = 4  # in the maze, and leads nowhere
OUTSIDE = 5  # no chamber
FREE = 8  # Wilson's walk adds the direction that it left by

# links
EAST, NORTH = 1, 2  # open to the neighbour in +x, +y
CORNER = 4  # the pillar between this chamber and the three to its north and east is gone
ROCK = 8  # no chamber

# state: what a kernel keeps between two calls. From AT on, each kernel has its own.
LEFT = 0  # chambers still to be joined; 0: done
USED = 1  # draws, or words, used of those at hand
AT = 2  # where it stands on the board
STATE_SIZE = 8


def blank_board(mask: Mask) -> tuple[npt.NDArray[np.int8], int]:
    """A board with every chamber free, flat, and its stride."""
    rows, columns = mask.shape
    board = np.full((rows + 2, columns + 2), OUTSIDE, dtype=np.int8)
    np.add(mask * np.int8(FREE - OUTSIDE), np.int8(OUTSIDE), out=board[1:-1, 1:-1])
    return board.ravel(), columns + 2


def inner(board: Any, stride: int) -> npt.NDArray[np.int8]:
    """The chambers of a flat board, without the ring."""
    return np.frombuffer(board, np.int8).reshape(-1, stride)[1:-1, 1:-1]


def links_of_parents(tree: npt.NDArray[np.int8]) -> Links:
    """Links of a tree whose chambers name their parents."""
    links = np.zeros(tree.shape, dtype=np.int8)
    links[:, :-1] = (tree[:, :-1] == 0) | (tree[:, 1:] == 2)
    links[:-1] |= ((tree[:-1] == 1) | (tree[1:] == 3)).view(np.int8) << 1
    return links


def open_sides(links: Links) -> npt.NDArray[np.bool_]:
    """Which neighbours each chamber is open to: (rows, columns, 4), the last axis in quarter turns."""
    sides = np.zeros((*links.shape, 4), dtype=np.bool_)
    sides[:, :-1, 0] = sides[:, 1:, 2] = links[:, :-1] & EAST
    sides[:-1, :, 1] = sides[1:, :, 3] = links[:-1] & NORTH
    return sides


def ways_out(links: Links, column: int, row: int) -> list[int]:
    """Directions that one chamber is open to, rising."""
    below, left = row > 0 and links[row - 1, column], column > 0 and links[row, column - 1]
    here = links[row, column]
    return [way for way, is_open in enumerate((here & EAST, here & NORTH, left & EAST, below & NORTH)) if is_open]
