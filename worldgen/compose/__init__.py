"""Compose worlds from pieces: rectangles of cells that are placed on each other.

Contents:
    Piece: cells, marks and timeline, with the operations on them.
    of_family, of_world, of_cells, read, drawn, rectangle: create a piece.

``docs/howto/compose.md`` has examples, and shows how to make a family of a composition.
"""

from worldgen.compose.piece import Piece
from worldgen.compose.sources import drawn, of_cells, of_family, of_world, read, rectangle

__all__ = ["Piece", "drawn", "of_cells", "of_family", "of_world", "read", "rectangle"]
