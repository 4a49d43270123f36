"""The search over free squares: the specification of ``coarse.c``."""

from typing import Any

import numpy as np


def walk_squares(solid: Any, side: Any, source: Any, goal: Any, state: Any, heights: Any) -> Any:
    """Breadth-first search over free squares.

    Args:
        solid: (height, width) uint8, 1 is solid.
        side: Side of the squares, cells.
        source: Where to begin: (row + 1) * (width + 2) + column + 1 of a square's first cell.
        goal: The square to end at.
        state: ((height + 2) * (width + 2),) uint8 zeros, for the squares.
        heights: (width,) int32 zeros.

    Returns:
        (n,) squares from source to goal, without those in the middle of a straight line; empty if
        there is no path.
    """
    height, width = solid.shape
    stride = width + 2
    for iy in range(height):
        run = 0
        for ix in range(width):
            heights[ix] = heights[ix] + 1 if solid[iy, ix] == 0 else 0
            run = run + 1 if heights[ix] >= side else 0
            if run >= side:
                state[(iy - side + 2) * stride + ix - side + 2] = 1
    now = np.empty(1024, np.int32)
    after = np.empty(1024, np.int32)
    now[0], count = source, 1 if state[source] == 1 and state[goal] == 1 else 0
    state[source] = 6
    while count > 0 and state[goal] == 1:
        if 4 * count > len(after):
            after = np.empty(8 * count, np.int32)
        found = 0
        for i in range(count):
            at = np.int64(now[i])
            for step in range(4):
                there = at + (
                    1 if step == 0 else stride if step == 1 else -1 if step == 2 else -stride
                )
                if state[there] == 1:
                    state[there] = 2 + step
                    after[found] = there
                    found += 1
        now, after, count = after, now, found
    corners, at, step = 0, goal, 0
    if state[goal] > 1:
        while step != 6:
            corners += state[at] != step
            step = int(state[at])
            at -= (
                1
                if step == 2
                else stride
                if step == 3
                else -1
                if step == 4
                else -stride
                if step == 5
                else 0
            )
    way = np.empty(corners, np.int64)
    at, step = goal, 0
    while corners > 0:
        if state[at] != step:
            corners -= 1
            way[corners] = at
            step = int(state[at])
        at -= (
            1
            if step == 2
            else stride
            if step == 3
            else -1
            if step == 4
            else -stride
            if step == 5
            else 0
        )
    return way
