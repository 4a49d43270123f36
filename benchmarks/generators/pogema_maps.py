"""Random maps of POGEMA (MIT licence; 1.4.0): ``pip install pogema==1.4.0``.

The first agent's start and target are used; POGEMA draws them from one region of the grid.
"""

from collections.abc import Iterator
from itertools import count
from typing import Any

import numpy as np
from pogema import GridConfig
from pogema.grid import Grid


def maps(seed: int, *, side: int = 32, density: float = 0.3) -> Iterator[tuple[Any, ...]]:
    """Yield cells that are solid with probability ``density``, independently."""
    for number in count():
        config = GridConfig(
            size=side, density=density, num_agents=1, obs_radius=1, seed=(seed + number) % 2**31
        )
        # Adds a ring of solid cells, one wide, according to ``obs_radius``.
        grid = Grid(config)
        (start,), (target,) = grid.positions_xy, grid.finishes_xy
        yield f"pogema-{number}", np.array(grid.obstacles) != 0, start, target
