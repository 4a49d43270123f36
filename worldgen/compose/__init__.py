"""Compose worlds from pieces: rectangles of cells that are placed on each other.

Contents:
    Piece: cells, marks and timeline, with the operations on them.
    of_family, of_world, of_cells, read, drawn, rectangle: create a piece.
    beside, above: join pieces into a row or a column.
    first_solvable: redraw a random composition until the robot can reach the target.

``docs/howto/compose.md`` has examples, and shows how to write the same as a TOML recipe.
"""

from worldgen.compose.piece import Piece
from worldgen.compose.sources import (
    above,
    beside,
    drawn,
    first_solvable,
    of_cells,
    of_family,
    of_world,
    read,
    rectangle,
)

__all__ = [
    "Piece",
    "above",
    "beside",
    "drawn",
    "first_solvable",
    "of_cells",
    "of_family",
    "of_world",
    "read",
    "rectangle",
]
