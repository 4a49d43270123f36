"""Whether the disc surely gets to the target: a flood over half cells that may miss a way, but never invents one."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from sim.kernels._jit import rare_kernel
from sim.kernels.geometry import pose_is_clear, segment_first_not_clear
from sim.kernels.layout import SOLID, UNIT

__all__ = ["HALF", "surely_reaches"]

HALF = UNIT // 2
"""Distance of two neighbouring nodes, lattice units."""


@rare_kernel
def _goes_straight(cells: npt.NDArray[np.uint8], clear_sq: int, reach: int, ends: tuple[int, int, int, int]) -> bool:
    """Whether the disc, which is clear at both ends, may go from one to the other."""
    return not segment_first_not_clear(cells, SOLID, clear_sq, reach, ends)[0]


@rare_kernel
def surely_reaches(
    cells: npt.NDArray[np.uint8],
    disc: tuple[int, int],
    ends: tuple[int, int, int, int],
    within_sq: int,
    seen: npt.NDArray[np.uint8],
    stack: npt.NDArray[np.int64],
) -> bool:
    """Whether the flood gets from the start into the target's disc.

    A step of half a cell along an axis has its least clearance at an end, a diagonal one at an end or in the middle
    (docs/reachability.md proves it).

    Args:
        cells: (height, width) uint8, 1 where the robot never goes.
        disc: Squared clear distance, and its root rounded up.
        ends: Start x, y and target x, y; lattice units.
        within_sq: Squared radius of the target.
        seen: (2 height + 1, 2 width + 1), to be used.
        stack: As many numbers, likewise.
    """
    (clear_sq, reach), (sx, sy, tx, ty) = disc, ends
    rows, columns = seen.shape
    for j in range(rows):
        for i in range(columns):
            seen[j, i] = 0
    if not pose_is_clear(cells, SOLID, clear_sq, reach, sx, sy):
        return False
    if (sx - tx) * (sx - tx) + (sy - ty) * (sy - ty) <= within_sq:
        return True
    target_is_clear = pose_is_clear(cells, SOLID, clear_sq, reach, tx, ty)
    count = 0
    for j in range(sy // HALF, (sy + HALF - 1) // HALF + 1):
        for i in range(sx // HALF, (sx + HALF - 1) // HALF + 1):
            x, y = i * HALF, j * HALF
            is_clear = pose_is_clear(cells, SOLID, clear_sq, reach, x, y)
            if is_clear and _goes_straight(cells, clear_sq, reach, (sx, sy, x, y)):
                seen[j, i], stack[count] = 1, j * columns + i
                count += 1
    while count > 0:
        count -= 1
        i, j = stack[count] % columns, stack[count] // columns
        x, y = i * HALF, j * HALF
        if (x - tx) * (x - tx) + (y - ty) * (y - ty) <= within_sq:
            return True
        is_near = target_is_clear and abs(x - tx) < HALF and abs(y - ty) < HALF
        if is_near and _goes_straight(cells, clear_sq, reach, (x, y, tx, ty)):
            return True
        for step in range(9):
            di, dj = step % 3 - 1, step // 3 - 1
            if not (0 <= i + di < columns and 0 <= j + dj < rows) or seen[j + dj, i + di] != 0:
                continue
            if not pose_is_clear(cells, SOLID, clear_sq, reach, x + di * HALF, y + dj * HALF):
                seen[j + dj, i + di] = 1
                continue
            middle_x, middle_y = x + di * (HALF // 2), y + dj * (HALF // 2)
            if di * dj == 0 or pose_is_clear(cells, SOLID, clear_sq, reach, middle_x, middle_y):
                seen[j + dj, i + di], stack[count] = 1, (j + dj) * columns + i + di
                count += 1
    return False
