"""Find the walls that a robot entered: which cells, when, and where.

The player on web pages marks the same cells.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from sim.episode import Episode
from sim.evidence import BurnedEvidence, ContactEvidence, WallEvidence
from sim.trace import Trace
from worldgen.render import WallPenetration
from worldgen.support.arrays import Bools, Floats, Ints
from worldgen.timeline import CellState
from worldgen.world import World

# Cells. No motion model reports a shallower cut of the disc.
_TOLERANCE = 0.1

# Cells. For a larger robot, only the cells that its centre enters are checked.
_FURTHEST = 6

# Distance in cells between two checked places of a path.
_FINENESS = 0.125


def penetrated_cells(episode: Episode, world: World) -> list[WallPenetration]:
    """Return the wall cells that the robot cut into, in order of time, or the cell that did it harm.

    The cell that the verdict names is among them.

    Args:
        episode: A recorded run.
        world: The world that it drove in.
    """
    trace = episode.trace
    evidence = episode.evidence
    if trace is not None and isinstance(evidence, BurnedEvidence | ContactEvidence):
        step = min(evidence.step, trace.steps)
        broken_in = _broken_in(trace, world, step, *evidence.cell)
        return [WallPenetration(*evidence.cell, step * trace.time_step, broken_in, False)]
    if trace is None or not episode.went_into_a_wall:
        return []

    # Find the first step in which each cell was cut; the verdict's own step takes precedence.
    first: dict[tuple[int, int], int] = {}
    for step, ix, iy in _cut_into(trace, world):
        first[ix, iy] = min(step, first.get((ix, iy), step))
    named: tuple[int, int] | None = None
    if isinstance(evidence, WallEvidence):
        named = evidence.cell
        first[named] = min(evidence.step, trace.steps)
    found = []
    for cell, step in sorted(first.items(), key=lambda item: (item[1], item[0])):
        place = _broken_in(trace, world, step, *cell) if cell == named else None
        found.append(WallPenetration(*cell, step * trace.time_step, place))
    return found


def _cut_into(trace: Trace, world: World) -> Iterator[tuple[int, int, int]]:
    """Yield steps and cells that the robot cuts into; a cell may occur more than once."""
    side = world.cell_size
    # Of a body, the largest disc about its axle is sure to be in what it covers.
    radius = world.robots[0].inner_radius
    steps = trace.path_step
    times = steps * trace.time_step
    x = trace.path_x / side
    y = trace.path_y / side

    # Between two events the cells stay the same, so handle each such stretch of the path together.
    changes = np.searchsorted(times, [event.time for event in world.timeline], side="left")
    bounds = np.unique(np.concatenate(([0], changes, [len(steps)])))
    for begin, end in zip(bounds[:-1].tolist(), bounds[1:].tolist(), strict=True):
        cells = world.cells_at(float(times[begin]))
        solid = np.pad(cells == CellState.SOLID, 1, constant_values=True)
        yield from _discs(solid, steps[begin:end], x[begin:end], y[begin:end], radius / side)
        # Include the last point before this stretch, where its first segment begins.
        before = max(0, begin - 1)
        yield from _centres(solid, steps[before:end], x[before:end], y[before:end])


def _discs(
    solid: Bools, steps: Ints, x: Floats, y: Floats, radius: float
) -> Iterator[tuple[int, int, int]]:
    """Yield walls that the disc cuts into beyond the tolerance, or that its centre is in."""
    reach = 0 if radius > _FURTHEST else math.ceil(radius)
    most = max(0.0, radius - _TOLERANCE)
    for di in range(-reach, reach + 1):
        for dj in range(-reach, reach + 1):
            ix = np.floor(x).astype(np.int64) + di
            iy = np.floor(y).astype(np.int64) + dj
            across = np.maximum(np.maximum(ix - x, x - ix - 1.0), 0.0)
            up = np.maximum(np.maximum(iy - y, y - iy - 1.0), 0.0)
            near = (across * across + up * up < most * most) & _is_solid(solid, ix, iy)
            yield from _firsts(steps[near], ix[near], iy[near])


def _centres(solid: Bools, steps: Ints, x: Floats, y: Floats) -> Iterator[tuple[int, int, int]]:
    """Yield walls that the centre passes through between two points of its path."""
    lengths = np.hypot(np.diff(x), np.diff(y))
    for k in np.flatnonzero(lengths > _FINENESS).tolist():
        share = np.arange(1, math.ceil(lengths[k] / _FINENESS)) / math.ceil(lengths[k] / _FINENESS)
        ix = np.floor(x[k] + (x[k + 1] - x[k]) * share).astype(np.int64)
        iy = np.floor(y[k] + (y[k + 1] - y[k]) * share).astype(np.int64)
        hit = _is_solid(solid, ix, iy)
        yield from _firsts(np.full(int(hit.sum()), steps[k + 1]), ix[hit], iy[hit])


def _is_solid(solid: Bools, ix: Ints, iy: Ints) -> Bools:
    """Return where cells of the grid, or of the solid border around it, are walls."""
    found: Bools = solid[
        np.clip(iy + 1, 0, solid.shape[0] - 1), np.clip(ix + 1, 0, solid.shape[1] - 1)
    ]
    return found


def _firsts(steps: Ints, ix: Ints, iy: Ints) -> Iterator[tuple[int, int, int]]:
    """Yield each cell once, with its first step; the steps must be ascending."""
    cells, first = np.unique(np.column_stack((ix, iy)), axis=0, return_index=True)
    for (i, j), at in zip(cells.tolist(), first.tolist(), strict=True):
        yield int(steps[at]), i, j


def _broken_in(trace: Trace, world: World, step: int, ix: int, iy: int) -> tuple[float, float]:
    """Return where the centre first entered a cell during a step, or came nearest to it, m."""
    side = world.cell_size
    share = np.linspace(0.0, 1.0, 65)
    before = max(0, step - 1)
    x = (trace.x[before] + (trace.x[step] - trace.x[before]) * share) / side
    y = (trace.y[before] + (trace.y[step] - trace.y[before]) * share) / side
    near_x = np.clip(x, ix, ix + 1)
    near_y = np.clip(y, iy, iy + 1)
    k = int(np.argmin(np.round(np.hypot(near_x - x, near_y - y), 9)))
    return float(near_x[k] * side), float(near_y[k] * side)
