"""Find places on open ground that are connected or far apart, and tunnels that join the rest.

A place is the first cell of a square window that contains the robot; a step moves the window by one
cell. This is coarse but safe: where the window fits, the robot's disc fits too. The searches are in
C (worldgen/core/making/ground.c).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from worldgen import _core
from worldgen.families.parts.disjoint_sets import joining
from worldgen.families.parts.layout import STEPS
from worldgen.random_streams import RandomStream
from worldgen.reach.still.grid_search import free_windows, steps_from
from worldgen.support.arrays import Bools, Bytes
from worldgen.support.ccall import check, writable

Numbers: TypeAlias = npt.NDArray[np.int32]

# Minimum distance from start to target, as a fraction of the longest path from the start. The
# second one is used if the first gives no target out of sight.
FAR = (4, 5)
LESS_FAR = (1, 2)
# Number of targets to draw until one is out of sight; then this many more, closer to the start.
_TRIES = 24


@dataclass(frozen=True)
class Dug:
    """Hold the result of :func:`dig_from`, one entry per place.

    Args:
        owner: (n,) owner of each place; -1 if none reached it.
        came: (n,) the place that each was reached from; a starting place has itself.
        depth: (n,) number of rounds until each was reached.
    """

    owner: Numbers
    came: Numbers
    depth: Numbers

    def way_back(self, place: int) -> list[int]:
        """Return the path from a place back to the starting place it was reached from."""
        way = [place]
        while self.came[way[-1]] != way[-1]:
            way.append(int(self.came[way[-1]]))
        return way


def dig_from(owner: Numbers, hard: Bytes) -> Dug:
    """Grow all owners' areas over the remaining places, at the speed at which these can be dug.

    Args:
        owner: (n,) owner of each place; -1 if it has none.
        hard: (rows, columns) rounds that it takes to dig a place; 0 where digging is forbidden, as
            on the rim.
    """
    ffi = _core.ffi
    lib = _core.lib
    owner = owner.copy()
    came = np.empty(owner.size, dtype=np.int32)
    depth = np.empty(owner.size, dtype=np.int32)
    queue = np.empty(owner.size, dtype=np.int32)
    waits = hard.copy()
    found = [writable(ffi, array, np.int32) for array in (owner, came, depth, queue)]
    check(lib.wg_dig(writable(ffi, waits, np.uint8), waits.size, hard.shape[1], *found))
    return Dug(owner, came, depth)


def easiest_joints(dug: Dug, stride: int, owners: int) -> list[tuple[int, int]]:
    """Return the pairs of neighbouring places where tunnels join all owners with least digging.

    Args:
        dug: Result of :func:`dig_from`.
        stride: Places per row.
        owners: Number of owners.
    """
    # List all neighbours with different owners, those with the least digging first.
    pairs = []
    for step in (1, stride):
        one = np.arange(dug.owner.size - step)
        a = dug.owner[:-step]
        b = dug.owner[step:]
        met = (a >= 0) & (b >= 0) & (a != b)
        pairs.append(np.stack([one[met], one[met] + step], axis=1))
    table = np.concatenate(pairs)
    table = table[np.argsort(dug.depth[table].sum(axis=1), kind="stable")]

    # Keep the easiest meeting of each two owners, then a minimum spanning tree of these.
    met_by = np.sort(dug.owner[table].astype(np.int64), axis=1)
    _, first = np.unique(met_by[:, 0] * owners + met_by[:, 1], return_index=True)
    first.sort()
    tree = joining([(int(a), int(b)) for a, b in met_by[first]], owners)
    return [(int(a), int(b)) for a, b in table[first[tree]]]


def covered(windows: Bools, side: int) -> Bools:
    """Return the cells that any window covers: bool, shaped like ``windows``.

    Args:
        windows: (rows, columns) bool, True at the first cell of each window.
        side: Cells per side of a window.
    """
    rows, columns = windows.shape
    padded = np.zeros((rows + side - 1, columns + side - 1), dtype=np.bool_)
    padded[side - 1 :, side - 1 :] = windows
    return ~free_windows(padded, side, side)[:rows, :columns]


@dataclass(frozen=True)
class Poses:
    """Hold start and target, in half cells, and the start's heading in quarter turns."""

    start: tuple[int, int]
    target: tuple[int, int]
    quarter: int


def far_poses(
    rng: RandomStream,
    walls: Bools,
    side: int,
    begin: int,
    *,
    start_in: Bools | None = None,
    target_in: Bools | None = None,
) -> Poses:
    """Draw a start and a target with a long path between them.

    If possible, a wall hides the target from the start.

    Args:
        rng: The only source of randomness.
        walls: (rows, columns) bool, True is solid.
        side: Cells per side of the robot's window.
        begin: Any place of the component to use, flat.
        start_in: (rows, columns) bool, allowed places of the start's window; all if omitted.
        target_in: (rows, columns) bool, allowed places of the target's window; all if omitted.
    """
    # Start far from an arbitrary place, so that the longest path from the start is long.
    windows = free_windows(walls, side, side)
    columns = windows.shape[1]
    start = _far(rng, windows, begin, start_in, [FAR])[0]
    candidates = _far(rng, windows, start, target_in, [FAR] * _TRIES + [LESS_FAR] * _TRIES)
    middle = _middle(start, columns, side)
    hidden = (
        place for place in candidates if not in_sight(walls, middle, _middle(place, columns, side))
    )
    target = next(hidden, candidates[0])

    # Face a direction that the robot can move in, if there is one.
    ways = [way for way, (dx, dy) in enumerate(STEPS) if windows.ravel()[start + dx + dy * columns]]
    return Poses(middle, _middle(target, columns, side), rng.choice(ways or [0, 1, 2, 3]))


def _far(
    rng: RandomStream,
    windows: Bools,
    begin: int,
    within: Bools | None,
    shares: list[tuple[int, int]],
) -> list[int]:
    """Draw one place per share from those far enough from a given place.

    Args:
        rng: The only source of randomness.
        windows: (rows, columns) bool, free places.
        begin: The place to measure from, flat.
        within: (rows, columns) bool, allowed places; ignored if none can be reached.
        shares: Minimum distances, as fractions of the longest path from ``begin``.
    """
    steps, order = steps_from(windows, begin)
    if within is not None:
        allowed = order[within.ravel()[order]]
        order = allowed if len(allowed) else order
    limits = [int(steps[order[-1]]) * over // under for over, under in shares]
    firsts = np.searchsorted(steps[order], limits).tolist()
    return [int(order[rng.between(first, len(order) - 1)]) for first in firsts]


def _middle(place: int, columns: int, side: int) -> tuple[int, int]:
    return 2 * (place % columns) + side, 2 * (place // columns) + side


def in_sight(walls: Bools, here: tuple[int, int], there: tuple[int, int]) -> bool:
    """Return True if no wall is on the straight line between two points.

    The test is exact. A line along walls on one side, or between two cells that touch only at a
    corner, counts as free.

    Args:
        walls: (rows, columns) bool, True is solid.
        here: One point, in half cells.
        there: The other point, in half cells.
    """
    # Swap the axes if needed, so that the line rises by at most one cell per column.
    if abs(there[1] - here[1]) > abs(there[0] - here[0]):
        return in_sight(walls.T, here[::-1], there[::-1])
    (ax, ay), (bx, by) = sorted((here, there))
    if ax == bx:
        return True
    rise = by - ay
    run = bx - ax

    # Check the cells that the line crosses in each column.
    for column in range(ax // 2, -(-bx // 2)):
        left = max(2 * column, ax)
        right = min(2 * column + 2, bx)
        # Heights are multiplied by ``run`` to stay whole numbers.
        ends = sorted(ay * run + (x - ax) * rise for x in (left, right))
        low = ends[0] // (2 * run)
        high = -(-ends[1] // (2 * run))
        # A line along the border of two rows is blocked only if both of its neighbours are solid.
        if low == high:
            if walls[low - 1 : low + 1, column].all():
                return False
        elif walls[low:high, column].any():
            return False
    return True
