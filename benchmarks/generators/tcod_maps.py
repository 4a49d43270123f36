"""Caves of python-tcod's noise (BSD licence, 2 clauses; 21.2.2): ``pip install tcod==21.2.2``.

Cells are solid where the noise is above a level, the usual short recipe for a cave. It has no start
or target.
"""

from collections.abc import Iterator
from itertools import count
from typing import Any

import tcod.noise


def maps(
    seed: int, *, side: int = 60, scale: float = 0.15, level: float = 0.15, octaves: float = 4.0
) -> Iterator[tuple[Any, ...]]:
    """Yield turbulence, or simplex noise if ``octaves`` is 1, over ``side`` x ``side`` cells."""
    for number in count():
        noise = tcod.noise.Noise(
            dimensions=2,
            algorithm=tcod.noise.Algorithm.SIMPLEX,
            implementation=tcod.noise.Implementation.FBM
            if octaves > 1
            else tcod.noise.Implementation.SIMPLE,
            octaves=octaves,
            seed=(seed + number) % 2**31,
        )
        values = noise[tcod.noise.grid((side, side), scale=scale, origin=(0, 0))]
        yield f"noise-{number}", values > level
