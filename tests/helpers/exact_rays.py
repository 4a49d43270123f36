"""Range beams through a world.

They match the simulator's own sensor, for comparison with clients.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tests.helpers.core_parts import heading_table, ray_distance
from tests.reference.sim.layout import TURN, UNIT
from worldgen.timeline import CellState

_HEADINGS = heading_table()


class Beam(NamedTuple):
    """A beam's origin, its direction as a unit vector, and its length at each requested time.

    M, file's frame.
    """

    x: float
    y: float
    along: float
    across: float
    lengths: list[float]


def solid_at(world, time):
    """(height, width) bool: cells that are solid at a time; fire is not."""
    solid = world.walls.copy()
    for when, ix, iy, state in world.timeline:
        if when <= time:
            solid[iy, ix] = state == CellState.SOLID
    return solid


def beams(world, count, *, times=(0.0,), origin=(0.0, 0.0)):
    """Beams from the middles of cells that are never solid, in all directions.

    Headings are odd multiples of the lattice's, so that no beam runs along a face.
    """
    random = np.random.Generator(np.random.PCG64(count))
    never = ~world.walls
    for _, ix, iy, state in world.timeline:
        never[iy, ix] &= state != CellState.SOLID
    cells = [solid_at(world, time).astype(np.uint8) for time in times]
    places = np.argwhere(never)
    found = []
    for iy, ix in places[random.integers(len(places), size=count)].tolist():
        heading = 2 * int(random.integers(TURN // 2)) + 1
        x, y = ix * UNIT + UNIT // 2, iy * UNIT + UNIT // 2
        lengths = [
            ray_distance(at, _HEADINGS, x, y, heading, 1e9) / UNIT * world.cell_size for at in cells
        ]
        place = (x / UNIT * world.cell_size + origin[0], y / UNIT * world.cell_size + origin[1])
        found.append(Beam(*place, _cosine(heading), _cosine(heading - TURN // 4), lengths))
    return found


def _cosine(heading):
    """As in the sensor."""
    return float(_HEADINGS[heading % TURN]) / (1 << 30) + float(
        _HEADINGS[TURN + heading % TURN]
    ) / (1 << 60)
