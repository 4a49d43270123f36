"""Mazes and caves of mazelib (MIT licence; 0.9.16): ``pip install mazelib==0.9.16``.

The start is the cell inside the entrance, the target the one inside the exit, as mazelib's own
solvers take them.
"""

import importlib
from collections.abc import Iterator
from itertools import count
from typing import Any

import numpy as np
from mazelib import Maze


def maps(seed: int, *, generator: str = "Prims", side: int = 20) -> Iterator[tuple[Any, ...]]:
    """Yield mazes of ``side`` x ``side`` chambers; ``generator``: a module of mazelib.generate."""
    kind = getattr(importlib.import_module(f"mazelib.generate.{generator}"), generator)
    for number in count():
        Maze.set_seed((seed + number) % 2**32)
        maze = Maze()
        maze.generator = kind(side, side)
        maze.generate()
        maze.generate_entrances()
        walls = np.array(maze.grid, np.bool_)
        yield f"{generator}-{number}", walls, _inside(maze.start, walls), _inside(maze.end, walls)


def _inside(cell: tuple[int, int], walls: Any) -> tuple[int, int]:
    """Return the cell of the maze next to a cell in its outer wall."""
    row, column = (
        min(max(index, 1), side - 2) for index, side in zip(cell, walls.shape, strict=True)
    )
    return row, column
