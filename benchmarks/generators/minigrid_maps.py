"""Rooms of MiniGrid (MIT licence; 3.2.0): ``pip install minigrid==3.2.0``.

The start is the agent's, the target the goal. Walls and lava are solid; doors, keys and balls count
as free.
"""

from collections.abc import Iterator
from itertools import count
from typing import Any

import gymnasium
import minigrid
import numpy as np

_SOLID = ("wall", "lava")


def maps(
    seed: int, *, environment: str = "MiniGrid-SimpleCrossingS11N5-v0"
) -> Iterator[tuple[Any, ...]]:
    """Yield one map for each reset of an environment."""
    world: Any = gymnasium.make(
        f"{minigrid.__name__}:{environment}"
        # The import registers it.
    ).unwrapped
    for number in count():
        world.reset(seed=(seed + number) % 2**31)
        kinds = [None if thing is None else thing.type for thing in world.grid.grid]
        walls = np.array([kind in _SOLID for kind in kinds]).reshape(
            world.grid.height, world.grid.width
        )
        column, row = world.agent_pos
        goal = divmod(kinds.index("goal"), world.grid.width)
        yield f"{environment}-{number}", walls, (row, column), goal
