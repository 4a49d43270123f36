"""Grow mazes on a lattice of chambers, open some walls, and convert them to cells.

Contents:
    board: the meaning of the numbers on a growing board and in its links.
    grow: run the algorithms, which are in C (worldgen/core/making).
    shapes: masks, by name.
    openings: open second exits of dead ends, and rooms.
    cells: convert links to solid cells.
"""

from worldgen.families.parts.mazes.board import (
    CORNER,
    EAST,
    NORTH,
    ROCK,
    ROOT,
    Links,
    Mask,
    open_sides,
    ways_out,
)
from worldgen.families.parts.mazes.cells import cells_of, pitch
from worldgen.families.parts.mazes.grow import (
    FIT_ANY_SHAPE,
    METHODS,
    Algorithm,
    grow,
    spanning_tree,
)
from worldgen.families.parts.mazes.openings import braid_ends, carve_rooms
from worldgen.families.parts.mazes.shapes import Shape, shape_mask

__all__ = [
    "CORNER",
    "EAST",
    "FIT_ANY_SHAPE",
    "METHODS",
    "NORTH",
    "ROCK",
    "ROOT",
    "Algorithm",
    "Links",
    "Mask",
    "Shape",
    "braid_ends",
    "carve_rooms",
    "cells_of",
    "grow",
    "open_sides",
    "pitch",
    "shape_mask",
    "spanning_tree",
    "ways_out",
]
