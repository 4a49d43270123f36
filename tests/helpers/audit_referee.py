"""A slow second opinion on trajectories: every move against every cell, by shapely."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import shapely

from worldgen.timeline import CellState

FAR = 100.0  # m; extent of the outside


@dataclass
class Opinion:
    """Clearance and depths in m.

    Return the moves, from 0, whose centre line is inside a wall or outside the grid.
    """

    clearance: float = math.inf
    depth: dict = field(default_factory=lambda: {"overlap": 0.0, "burned": 0.0})
    inside: set = field(default_factory=set)
    beyond: set = field(default_factory=set)


def states_of(world, ix, iy):
    """Return when a cell is solid or burning: (since, until, state)."""
    state, since = CellState.SOLID if world.walls[iy, ix] else CellState.FREE, -math.inf
    for event in [*world.timeline, None]:
        if event is None or (event.ix, event.iy) == (ix, iy):
            until = math.inf if event is None else event.time
            if state != CellState.FREE and since < until:
                yield since, until, state
            since, state = until, state if event is None else event.state


def obstacles(world):
    """Every cell and side of the outside, with its time: (box, since, until, state)."""
    side = world.cell_size
    width, height = world.width * side, world.height * side
    for corners in (
        (-FAR, -FAR, 0, height + FAR), (width, -FAR, width + FAR, height + FAR),
        (-FAR, -FAR, width + FAR, 0), (-FAR, height, width + FAR, height + FAR),
    ):  # fmt: skip
        yield shapely.box(*corners), -math.inf, math.inf, None
    for iy in range(world.height):
        for ix in range(world.width):
            for since, until, state in states_of(world, ix, iy):
                yield (
                    shapely.box(ix * side, iy * side, (ix + 1) * side, (iy + 1) * side),
                    since,
                    until,
                    state,
                )


def driven(trajectory, move, since, until):
    """Return the part of a move driven in [since, until), as a shape; ``None`` if there is none."""
    begin, end = trajectory.times[move : move + 2]
    if since > end or until <= begin:
        return None
    a, b = (np.array([trajectory.x[k], trajectory.y[k]]) for k in (move, move + 1))
    low, high = (
        (0.0, 1.0)
        if end == begin
        else np.clip((np.array([since, until]) - begin) / (end - begin), 0.0, 1.0)
    )
    p, q = a + low * (b - a), a + high * (b - a)
    return shapely.LineString([p, q]) if np.abs(p - q).max() > 1e-12 else shapely.Point(p)


def second_opinion(world, trajectory):
    """Shapely's judgement of a trajectory.

    The inside of a cell begins 1e-7 of a cell behind its face.
    """
    found = Opinion()
    for box, since, until, state in obstacles(world):
        core = box.buffer(-1e-7 * world.cell_size, join_style="mitre")
        for move in range(len(trajectory.times) - 1):
            part = driven(trajectory, move, since, until)
            if part is None:
                continue
            distance = float(part.distance(box))
            found.clearance = min(found.clearance, distance)
            kind = "burned" if state == CellState.BURNING else "overlap"
            found.depth[kind] = max(found.depth[kind], world.robot_radius - distance)
            if state != CellState.BURNING and part.intersects(core):
                (found.beyond if state is None else found.inside).add(move)
    return found
