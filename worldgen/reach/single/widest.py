"""The largest disc that could get from the start to the target."""

from __future__ import annotations

from worldgen.domain import RADII
from worldgen.errors import InvalidParameter
from worldgen.reach.decision import REACHABLE
from worldgen.reach.single.prove import decide
from worldgen.world import World


def widest_disc(world: World) -> float:
    """Return the largest radius, m, with which a disc can get from the start to the target.

    It is 0 if no robot's disc can. It is found by bisection, since a smaller disc can go wherever a
    larger one can. The answer is right to the last bit: the next larger float is too large.

    Args:
        world: A static world.

    Raises:
        InvalidParameter: If the world changes.
    """
    if world.is_dynamic:
        raise InvalidParameter(
            "world-changes",
            "the world changes, but the largest disc that could pass is defined only for static "
            "worlds",
        )
    low = 0.0
    high = min(world.width, world.height) * world.cell_size
    while True:
        middle = low + (high - low) / 2
        if middle in (low, high) or middle < RADII[0] * world.cell_size:
            return low
        if decide(world, radius=middle, certificate=False).result == REACHABLE:
            low = middle
        else:
            high = middle
