"""Check independently that a shrunk world is 1-minimal, with plain loops and no shrinking pass."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from fuzz.shrink.edits import drop_lines, drop_robot, free_cells
from worldgen.world import World

__all__ = ["removable", "removed"]


def removable(world: World, still_fails: Callable[[World], World | None]) -> list[str]:
    """Return everything that could still be removed: a robot, a solid cell, a row, a column.

    Args:
        world: A shrunk world.
        still_fails: Returns the candidate with a certificate if it fails with the same verdict.

    Returns:
        A description of each part that can be removed; empty for a 1-minimal world.
    """
    return [name for name, _ in removed(world, still_fails)]


def removed(
    world: World, still_fails: Callable[[World], World | None]
) -> Iterator[tuple[str, World]]:
    """Yield each part that could still be removed, with the certified world that is left."""
    for name, candidate in _neighbours(world.bare):
        left = None if candidate is None else still_fails(candidate)
        if left is not None:
            yield name, left


def _neighbours(world: World) -> Iterator[tuple[str, World | None]]:
    if world.others:
        for index in range(len(world.robots)):
            yield f"robot {index + 1}", drop_robot(world, index)
    for iy, ix in np.argwhere(world.walls).tolist():
        yield f"cell ({ix}, {iy})", free_cells(world, [(ix, iy)])
    for axis, name in enumerate(("row", "column")):
        for line in range(world.walls.shape[axis]):
            yield f"{name} {line}", drop_lines(world, line, 1, axis)
