"""Steps that the families of several robots share."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, TypeAlias

import numpy as np

from worldgen.domain import MAX_ROBOTS
from worldgen.families.parts.layout import Arena
from worldgen.family import Bounds
from worldgen.random_streams import RandomStream
from worldgen.support.arrays import Bools
from worldgen.world import World

if TYPE_CHECKING:
    from worldgen.reach.joint.placing import Box

Robots: TypeAlias = Annotated[int, Bounds(1, MAX_ROBOTS)]


def turned(
    walls: Bools, boxes: list[tuple[Box, Box]], quarters: int
) -> tuple[Bools, list[tuple[Box, Box]]]:
    """Turn a layout by quarter turns counter-clockwise.

    Args:
        walls: (size, size) bool.
        boxes: Where each robot starts and must go.
        quarters: Number of quarter turns.
    """
    size = len(walls)
    for _ in range(quarters):
        # (x, y) goes to (size - 1 - y, x).
        walls = np.ascontiguousarray(walls[::-1].T)
        boxes = [(_turned_box(one, size), _turned_box(other, size)) for one, other in boxes]
    return walls, boxes


def _turned_box(box: Box, size: int) -> Box:
    x0, y0, x1, y1 = box
    return (size - 1 - y1, x0, size - 1 - y0, x1)


def fleet_world(
    arena: Arena, walls: Bools, rng: RandomStream, boxes: list[tuple[Box, Box]], owner: str
) -> World:
    """Build a world whose robots go from box to box, after turning it at random.

    Args:
        arena: The arena.
        walls: (size, size) bool.
        rng: The only source of randomness.
        boxes: Where each robot starts and must go.
        owner: Name of the family, for error messages.
    """
    from worldgen.reach.joint.placing import place_in_boxes  # noqa: PLC0415 - few worlds need it

    walls, boxes = turned(walls, boxes, rng.child("turn").below(4))
    middle = (arena.size, arena.size)
    blank = arena.world(walls, middle, middle, 0)
    return place_in_boxes(blank, rng.child("robots"), boxes, owner)
