"""Rooms and mazes of labmaze (Apache licence 2.0; 1.0.6): ``pip install labmaze==1.0.6``.

The first spawn point is the start, the first object the target: the task of an agent in such a
maze.
"""

from collections.abc import Iterator
from itertools import count
from typing import Any

import labmaze
import numpy as np


def maps(
    seed: int, *, side: int = 31, rooms: int = 6, extra: float = 0.0
) -> Iterator[tuple[Any, ...]]:
    """Yield mazes of ``side`` x ``side`` cells (odd) with up to ``rooms`` rooms.

    ``extra`` is the probability that a link is opened.
    """
    for number in count():
        maze = labmaze.RandomMaze(
            side, side, max_rooms=rooms, extra_connection_probability=extra, spawns_per_room=1, objects_per_room=1,
            random_seed=(seed + number) % 2**31,
        )  # fmt: skip
        drawn = np.array(maze.entity_layer)
        walls = drawn == "*"
        start, target = (tuple(map(int, np.argwhere(drawn == letter)[0])) for letter in "PG")
        yield f"labmaze-{number}", walls, start, target
