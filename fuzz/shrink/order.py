"""What "simpler" means, as a list of passes: each proposes simpler worlds, most daring first."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from fuzz.shrink.edits import drop_columns, drop_events, drop_rows, free_cells, with_start
from worldgen.lattice import lattice_to_metres, metres_to_lattice
from worldgen.world import World

__all__ = ["PASSES", "Edit", "Pass"]

Edit = Callable[[], "World | None"]
"""Makes one simpler world, or ``None`` where there is nothing to do."""

Pass = Callable[[World], Iterator[Edit]]
"""Proposes edits; called again with the simpler world whenever one is taken."""


def drop_many_rows(world: World) -> Iterator[Edit]:
    """Runs of rows: half of them, a quarter, ... one."""
    for count in _halves(world.height):
        for first in range(world.height - count, -1, -max(count // 2, 1)):
            yield partial(drop_rows, world, first, count)


def drop_many_columns(world: World) -> Iterator[Edit]:
    """Runs of columns, likewise."""
    for count in _halves(world.width):
        for first in range(world.width - count, -1, -max(count // 2, 1)):
            yield partial(drop_columns, world, first, count)


def free_the_border(world: World) -> Iterator[Edit]:
    """The whole ring of border cells at once: outside is solid anyway."""
    ring = [(ix, iy) for iy in range(world.height) for ix in range(world.width) if _on_border(world, ix, iy)]
    yield partial(free_cells, world, ring)


def free_blocks(world: World) -> Iterator[Edit]:
    """Square blocks of cells, from large to 2 x 2."""
    side = 1
    while side * 2 <= max(world.width, world.height):
        side *= 2
    while side > 1:
        for iy in range(0, world.height, side):
            for ix in range(0, world.width, side):
                if world.walls[iy : iy + side, ix : ix + side].any():
                    block = world.walls[iy : iy + side, ix : ix + side]
                    yield partial(free_cells, world, [(ix + int(j), iy + int(i)) for i, j in np.argwhere(block)])
        side //= 2


def free_single_cells(world: World) -> Iterator[Edit]:
    """One solid cell at a time."""
    for iy, ix in np.argwhere(world.walls).tolist():
        yield partial(free_cells, world, [(ix, iy)])


def drop_many_events(world: World) -> Iterator[Edit]:
    """Runs of events: all, half, ... one."""
    for count in [len(world.timeline), *_halves(len(world.timeline))]:
        for first in range(0, len(world.timeline), max(count, 1)):
            yield partial(drop_events, world, first, count)


def round_the_start(world: World) -> Iterator[Edit]:
    """The start at the centre of its cell, the heading a quarter or an eighth of a turn."""
    side = world.cell_size
    centre = [metres_to_lattice(v, side) // 1024 * 1024 + 512 for v in (world.start.x, world.start.y)]
    x, y = (lattice_to_metres(v, side) for v in centre)
    yield partial(with_start, world, replace(world.start, x=x, y=y))
    for part in (2, 4):
        step = math.pi / part
        heading = round(world.start.heading / step) * step
        if abs(world.start.heading / (math.pi / 2) % 1) > 1e-9 or part == 2:
            yield partial(with_start, world, replace(world.start, heading=heading))


PASSES: tuple[Pass, ...] = (
    drop_many_rows,
    drop_many_columns,
    free_blocks,
    free_the_border,
    drop_many_events,
    free_single_cells,
    round_the_start,
)


def _halves(count: int) -> list[int]:
    sizes = []
    while count > 1:
        count //= 2
        sizes.append(count)
    return sizes


def _on_border(world: World, ix: int, iy: int) -> bool:
    return ix in (0, world.width - 1) or iy in (0, world.height - 1)
