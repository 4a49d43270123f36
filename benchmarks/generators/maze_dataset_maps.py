"""Mazes of maze-dataset (its repository says MIT; 1.4.2).

``pip install maze-dataset==1.4.2 "muutils<0.9"``. The library's own tasks run between two cells of
its lattice; here they run from the first corner to the last.
"""

import random
from collections.abc import Iterator
from itertools import count
from typing import Any

import numpy as np
from maze_dataset.generation import LatticeMazeGenerators


def maps(
    seed: int, *, generator: str = "gen_dfs", side: int = 20, p: float = -1.0
) -> Iterator[tuple[Any, ...]]:
    """Yield mazes of ``side`` x ``side`` chambers; ``p`` is passed to generators that percolate."""
    make = getattr(LatticeMazeGenerators, generator)
    options = {"p": p} if p >= 0 else {}
    for number in count():
        random.seed(seed + number)
        np.random.seed((seed + number) % 2**32)
        maze = make(np.array([side, side]), **options)
        walls = np.ones((2 * side + 1, 2 * side + 1), np.bool_)
        walls[1::2, 1::2] = False
        # Links to the cell below, and to the cell on the right.
        down, across = maze.connection_list
        walls[2::2, 1::2] = ~down
        walls[1::2, 2::2] = ~across
        yield f"{generator}-{number}", walls, (1, 1), (2 * side - 1, 2 * side - 1)
