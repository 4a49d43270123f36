"""Crossings of NAVIX, a port of MiniGrid to JAX (Apache licence 2.0): ``pip install navix``.

The start is the player's, the target the goal. Walls and lava are solid; doors, keys and balls
count as free.
"""

from collections.abc import Iterator
from itertools import count
from typing import Any

import jax
import navix
import numpy as np


def maps(
    seed: int, *, environment: str = "Navix-SimpleCrossingS11N5-v0"
) -> Iterator[tuple[Any, ...]]:
    """Yield one map for each reset of an environment."""
    world = navix.make(environment)
    reset = jax.jit(world.reset)
    for number in count():
        state = reset(jax.random.PRNGKey((seed + number) % 2**31)).state
        walls = np.array(state.grid) != 0
        # Lava ends an episode, so it counts as a wall here; unused objects are at row -1.
        for kind in ("wall", "lava"):
            for row, column in np.array(
                getattr(state.entities.get(kind), "position", np.empty((0, 2))), int
            ):
                if row >= 0:
                    walls[row, column] = True
        start = tuple(map(int, np.array(state.get_player().position)))
        goal = tuple(map(int, np.array(state.get_goals().position)[0]))
        yield f"{environment}-{number}", walls, start, goal
