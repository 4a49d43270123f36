"""Open ground: which places hang together, which lie far apart, and what must be dug to join them.

A place is the first cell of a square window that holds the robot; a step moves the window by one
cell. It is coarse, but where the window fits, the disc does. The searches are in C
(worldgen/core/making/ground.c).
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
from worldgen.support.ccall import check, writable
from worldgen.support.grid_search import free_windows, steps_from

__all__ = [
    "FAR",
    "Dug",
    "Poses",
    "covered",
    "dig_from",
    "easiest_joints",
    "far_poses",
    "in_sight",
]

Grid: TypeAlias = npt.NDArray[np.bool_]
Numbers: TypeAlias = npt.NDArray[np.int32]

# start and target are at least this share of the longest way from the start apart
FAR = (4, 5)
LESS_FAR = (1, 2)
_TRIES = 24  # targets drawn until one is out of sight, then as many less far


@dataclass(frozen=True)
class Dug:
    """What :func:`dig_from` found, flat.

    Args:
        owner: Whose a place is; -1 where nobody came.
        came: The place from which each was reached.
        depth: Rounds in which each was reached.
    """

    owner: Numbers
    came: Numbers
    depth: Numbers

    def way_back(self, place: int) -> list[int]:
        """From a place to the beginning from which it was reached, both included."""
        way = [place]
        while self.came[way[-1]] != way[-1]:
            way.append(int(self.came[way[-1]]))
        return way


def dig_from(owner: Numbers, hard: npt.NDArray[np.uint8]) -> Dug:
    """Grows owned places over the rest, as fast as it can be dug.

    Args:
        owner: (n,) whose a place is, -1 for nobody's.
        hard: Rounds that a place takes, shaped like the grid; 0 where none may be, as on the rim.
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
    """Neighbouring places, one pair for each joint of a tree of least digging between all owners."""
    pairs = []
    for step in (1, stride):
        one = np.arange(dug.owner.size - step)
        a = dug.owner[:-step]
        b = dug.owner[step:]
        met = (a >= 0) & (b >= 0) & (a != b)
        pairs.append(np.stack([one[met], one[met] + step], axis=1))
    table = np.concatenate(pairs)
    table = table[np.argsort(dug.depth[table].sum(axis=1), kind="stable")]
    met_by = np.sort(dug.owner[table].astype(np.int64), axis=1)
    _, first = np.unique(met_by[:, 0] * owners + met_by[:, 1], return_index=True)
    first.sort()
    tree = joining([(int(a), int(b)) for a, b in met_by[first]], owners)
    return [(int(a), int(b)) for a, b in table[first[tree]]]


def covered(windows: Grid, side: int) -> Grid:
    """The cells of all windows: bool, shaped like ``windows``."""
    rows, columns = windows.shape
    padded = np.zeros((rows + side - 1, columns + side - 1), dtype=np.bool_)
    padded[side - 1 :, side - 1 :] = windows
    return ~free_windows(padded, side, side)[:rows, :columns]


@dataclass(frozen=True)
class Poses:
    """Start and target, in half cells, with the heading in quarter turns."""

    start: tuple[int, int]
    target: tuple[int, int]
    quarter: int


def far_poses(
    rng: RandomStream,
    walls: Grid,
    side: int,
    begin: int,
    *,
    start_in: Grid | None = None,
    target_in: Grid | None = None,
) -> Poses:
    """Two places of one component with a long way between them, and no wall-less line if that can be had.

    Args:
        rng: The only source of chance.
        walls: Solid cells.
        side: Cells a side of the robot's window.
        begin: Any place of the component, flat.
        start_in: Where the start's window may be, at its first cell; anywhere where left out.
        target_in: Likewise the target's.
    """
    windows = free_windows(walls, side, side)
    columns = windows.shape[1]
    start = _far(rng, windows, begin, start_in, [FAR])[0]
    candidates = _far(rng, windows, start, target_in, [FAR] * _TRIES + [LESS_FAR] * _TRIES)
    middle = _middle(start, columns, side)
    hidden = (
        place for place in candidates if not in_sight(walls, middle, _middle(place, columns, side))
    )
    target = next(hidden, candidates[0])
    ways = [way for way, (dx, dy) in enumerate(STEPS) if windows.ravel()[start + dx + dy * columns]]
    return Poses(middle, _middle(target, columns, side), rng.choice(ways or [0, 1, 2, 3]))


def _far(
    rng: RandomStream, windows: Grid, begin: int, within: Grid | None, shares: list[tuple[int, int]]
) -> list[int]:
    """Places drawn from those at least a share of the longest way from one, a place for each share."""
    steps, order = steps_from(windows, begin)
    if within is not None:
        allowed = order[within.ravel()[order]]
        order = allowed if len(allowed) else order
    limits = [int(steps[order[-1]]) * over // under for over, under in shares]
    firsts = np.searchsorted(steps[order], limits).tolist()
    return [int(order[rng.between(first, len(order) - 1)]) for first in firsts]


def _middle(place: int, columns: int, side: int) -> tuple[int, int]:
    return 2 * (place % columns) + side, 2 * (place // columns) + side


def in_sight(walls: Grid, here: tuple[int, int], there: tuple[int, int]) -> bool:
    """Whether no wall is on the straight line between two points, in half cells; exact.

    A line along walls on one side, or between two cells that touch in a corner only, is free.
    """
    if abs(there[1] - here[1]) > abs(there[0] - here[0]):
        return in_sight(walls.T, here[::-1], there[::-1])
    (ax, ay), (bx, by) = sorted((here, there))
    if ax == bx:
        return True
    rise = by - ay
    run = bx - ax
    for column in range(ax // 2, -(-bx // 2)):
        left = max(2 * column, ax)
        right = min(2 * column + 2, bx)
        ends = sorted(
            ay * run + (x - ax) * rise for x in (left, right)
        )  # y, times run, in half cells
        low = ends[0] // (2 * run)
        high = -(-ends[1] // (2 * run))
        if low == high:  # along the border of two rows of cells: only both together are in the way
            if walls[low - 1 : low + 1, column].all():
                return False
        elif walls[low:high, column].any():
            return False
    return True
