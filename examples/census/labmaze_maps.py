"""Rooms and mazes of labmaze (Apache licence 2.0; 1.0.6): ``pip install labmaze==1.0.6``.

The first spawn point is the start, and the first object is the target, as for agents in such mazes.
"""

from collections.abc import Iterator
from itertools import count
from typing import Any

import labmaze
import numpy as np


def maps(
    seed: int, *, side: int = 31, rooms: int = 6, extra: float = 0.0
) -> Iterator[tuple[Any, ...]]:
    """Yield mazes of ``side`` x ``side`` cells (odd) with at most ``rooms`` rooms.

    ``extra`` is the probability of further connections.
    """
    for number in count():
        maze = labmaze.RandomMaze(
            side,
            side,
            max_rooms=rooms,
            extra_connection_probability=extra,
            spawns_per_room=1,
            objects_per_room=1,
            random_seed=(seed + number) % 2**31,
        )
        drawn = np.array(maze.entity_layer)
        walls = drawn == "*"
        start, target = (tuple(map(int, np.argwhere(drawn == letter)[0])) for letter in "PG")
        yield f"labmaze-{number}", walls, start, target
