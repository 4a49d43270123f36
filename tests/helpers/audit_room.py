"""A small empty room, and trajectories in it, for audits."""

from dataclasses import replace

import numpy as np

from sim.audit import Trajectory
from tests.helpers.drawn_worlds import drawn
from worldgen.timeline import Event, Timeline

ROOM = drawn(
    "......... ......... ......... ...S.G... ......... ......... .........",
    radius=0.3,
    cell_size=1.0,
)


def path(*samples):
    """A trajectory of samples (t, x, y)."""
    return Trajectory(*np.array(samples, float).T)


def room(*events, walls=(), **changes):
    """Return the room of 9 x 7 cells of 1 m, with a disc of 0.3 m, and some walls and events."""
    solid = ROOM.walls.copy()
    for ix, iy in walls:
        solid[iy, ix] = True
    return replace(
        ROOM, walls=solid, timeline=Timeline.of([Event(*event) for event in events]), **changes
    )
