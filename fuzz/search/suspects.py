"""Tell early which runs will hardly arrive, without claiming that they don't."""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from fuzz.triage.behaviour import behaviour_of
from sim.episode import Episode
from sim.trace import Trace
from worldgen.reach.still.grid_search import steps_from
from worldgen.support.arrays import Floats, Ints
from worldgen.world import World

# Words of a state that are its pose.
_POSE = 3
# Robot radii. A robot that has stayed in a smaller box for half of its run goes nowhere.
_CONFINED = 4.0
# Cells by which a robot must get closer to its target in the second half of its run.
_CLOSER = 1


class Symptom(IntEnum):
    """Why a run is suspect, the most reliable first."""

    RECURS = 0
    """It is back at a pose of the second half of its run, or repeats its moves from nearly there."""
    CONFINED = 1
    """It stays in a small box."""
    NO_PROGRESS = 2
    """It gets no closer to the target on the way that is left to drive."""


def symptom_of(world: World, episode: Episode) -> Symptom | None:
    """Return why an unfinished run is suspect; ``None`` if it still gets closer to its target.

    Args:
        world: World of the run.
        episode: The part of the run so far, recorded.
    """
    trace = episode.trace
    seen = behaviour_of(world, episode)
    if trace is None or seen is None:
        return None
    half = slice(trace.steps // 2, None)
    poses = trace.states[half, :_POSE]
    if seen.recurs or (poses[:-1] == poses[-1]).all(axis=1).any():
        return Symptom.RECURS
    extent = max(float(np.ptp(trace.x[half])), float(np.ptp(trace.y[half])))
    if extent <= _CONFINED * world.robot_radius:
        return Symptom.CONFINED
    left = _cells_left(world, trace)
    middle = len(left) // 2
    is_closer = left[middle:].min() + _CLOSER <= left[:middle].min()
    return None if is_closer else Symptom.NO_PROGRESS


def _cells_left(world: World, trace: Trace) -> Ints:
    """Return (steps + 1,) the number of cells from each pose to the target, in steps along edges.

    The walls are those at the start. The robot's size is ignored: the number only tells whether it
    gets closer.
    """
    rows, columns = world.walls.shape
    side = world.cell_size

    def cell(along: Floats, most: int) -> Ints:
        return np.clip((along / side).astype(np.int64), 0, most - 1)

    # The search takes a rim that cannot be entered.
    free = np.pad(~world.walls, 1)
    row = int(cell(np.array(world.target.y), rows)) + 1
    column = int(cell(np.array(world.target.x), columns)) + 1
    free[row, column] = True
    left = steps_from(free, row * free.shape[1] + column)[0].reshape(free.shape)
    found: Ints = left[cell(trace.y, rows) + 1, cell(trace.x, columns) + 1].astype(np.int64)
    return np.where(found < 0, world.walls.size, found)
