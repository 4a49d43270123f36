"""Perlin maps of IR-SIM (MIT licence; 2.12.0): ``pip install ir-sim==2.12.0``.

A simulator's obstacle maps, with its own defaults; it has no start or target for them.
"""

from collections.abc import Iterator
from itertools import count
from typing import Any

from irsim.world.map.perlin_map_generator import PerlinGridGenerator


def maps(
    seed: int, *, side: int = 100, fill: float = 0.38, complexity: float = 0.142857
) -> Iterator[tuple[Any, ...]]:
    """Yield maps of ``side`` x ``side`` cells; values above 50 are obstacles, as in IR-SIM."""
    for number in count():
        made = PerlinGridGenerator(
            side, side, complexity=complexity, fill=fill, seed=(seed + number) % 2**31
        )
        made.generate()
        yield f"perlin-{number}", made.grid > 50
