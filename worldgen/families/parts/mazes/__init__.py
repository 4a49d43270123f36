"""Grow mazes on a lattice of chambers, open some walls, and convert them to cells.

Contents:
    board: the meaning of the numbers on a growing board and in its links.
    grow: run the algorithms, which are in C (worldgen/core/making), and convert links to cells.
    shapes: masks, by name.
    openings: open second exits of dead ends, and rooms.
"""

from worldgen.families.parts.mazes.board import (
    CORNER,
    EAST,
    NORTH,
    ROCK,
    ROOT,
    Links,
    open_sides,
    ways_out,
)
from worldgen.families.parts.mazes.grow import (
    FIT_ANY_SHAPE,
    METHODS,
    Algorithm,
    cells_of,
    grow,
    pitch,
    winding_tree,
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
    "Shape",
    "braid_ends",
    "carve_rooms",
    "cells_of",
    "grow",
    "open_sides",
    "pitch",
    "shape_mask",
    "ways_out",
    "winding_tree",
]
