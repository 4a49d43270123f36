"""Worlds made of parts: pieces of cells, put on each other.

Contents:
    Piece: cells, marks and changes, with the operations on them.
    of_family, of_world, of_cells, read, drawn, rectangle: where pieces come from.
    beside, above: pieces in a row.
    first_solvable: a composition with drawn parts, tried until the robot gets through.

``docs/howto/compose.md`` shows them, and how the same is written as a TOML recipe.
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
