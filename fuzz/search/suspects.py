"""Tell early which runs will hardly arrive, without claiming that they don't."""

from __future__ import annotations

from collections import deque
from enum import IntEnum

import numpy as np

from fuzz.triage.behaviour import behaviour_of
from sim.episode import Episode
from sim.trace import Trace
from worldgen.support.arrays import Ints
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
    """Return (steps + 1,) the cells of the shortest way to the target along edges, at the start.

    The robot's size is ignored: the number only tells whether it gets closer.
    """
    walls = world.walls
    rows, columns = walls.shape
    side = world.cell_size
    left = np.full(walls.shape, walls.size, np.int64)
    target = (
        min(int(world.target.y / side), rows - 1),
        min(int(world.target.x / side), columns - 1),
    )
    left[target] = 0
    queue = deque([target])
    while queue:
        row, column = queue.popleft()
        for near in ((row + 1, column), (row - 1, column), (row, column + 1), (row, column - 1)):
            inside = 0 <= near[0] < rows and 0 <= near[1] < columns
            if inside and not walls[near] and left[near] == walls.size:
                left[near] = left[row, column] + 1
                queue.append(near)
    at_rows = np.clip((trace.y / side).astype(np.int64), 0, rows - 1)
    at_columns = np.clip((trace.x / side).astype(np.int64), 0, columns - 1)
    found: Ints = left[at_rows, at_columns]
    return found
