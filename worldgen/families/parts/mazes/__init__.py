"""Mazes on a lattice of chambers: how they grow, their shapes, what is opened afterwards, how they become cells.

Contents:
    board: what the numbers on a growing board and in its links mean.
    grow: runs the algorithms, which are in C (worldgen/core/making).
    shapes: masks with a name.
    openings: second ways out of dead ends, open rooms.
    cells: links to solid cells.
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
