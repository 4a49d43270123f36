"""Exact tests of a disc against square cells, on the pose lattice.

Coordinates are integers in 1/1024 of a cell, so "is this pose clear" and "is this segment clear"
are decided in integers, with no tolerance. Cells outside the grid are solid.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from tests.reference.sim.layout import SOLID, UNIT

Cells = npt.NDArray[np.uint8]

# Above this, a squared cross product no longer fits in 63 bits; a closer call than 1e-12 is then
# "not clear".
_EXACT_CROSS = 3_000_000_000


NEAR = 2
"""How many cells a mask of :func:`near_masks` covers to each side."""

_SIDE = 2 * NEAR + 1
_EACH_ROW = 0b00001_00001_00001_00001_00001


def cell_state(cells: Cells, ix: int, iy: int) -> int:
    """State of a cell; outside the grid everything is solid."""
    if ix < 0 or iy < 0 or iy >= cells.shape[0] or ix >= cells.shape[1]:
        return SOLID
    return int(cells[iy, ix])


def point_box_distance_sq(x: int, y: int, ix: int, iy: int) -> int:
    """Squared distance from a lattice point to a closed cell, lattice units squared, exact."""
    left, low = ix * UNIT, iy * UNIT
    dx = max(left - x, 0, x - left - UNIT)
    dy = max(low - y, 0, y - low - UNIT)
    return dx * dx + dy * dy


def pose_is_clear(cells: Cells, state: int, clear_sq: int, reach: int, x: int, y: int) -> bool:
    """Whether the disc at (x, y) is clear of every cell in ``state``, exactly."""
    if x < 0 or y < 0 or x > cells.shape[1] * UNIT or y > cells.shape[0] * UNIT:
        return state != SOLID
    for iy in range(max((y - reach) // UNIT, -1), min((y + reach) // UNIT, cells.shape[0]) + 1):
        for ix in range(max((x - reach) // UNIT, -1), min((x + reach) // UNIT, cells.shape[1]) + 1):
            if (
                cell_state(cells, ix, iy) == state
                and point_box_distance_sq(x, y, ix, iy) < clear_sq
            ):
                return False
    return True


def _corner_is_clear(clear_sq: int, along: int, across: int, length_sq: int) -> bool:
    """Whether a corner is clear of the inside of a segment, from its dot and cross products."""
    if along <= 0 or along >= length_sq:
        return True  # the nearest point is an end, and ends are tested as poses
    needed = float(clear_sq) * float(length_sq)
    have = float(across) * float(across)
    if have > needed * (1.0 + 1e-12):
        return True
    if have < needed * (1.0 - 1e-12) or abs(across) > _EXACT_CROSS:
        return False
    return across * across >= clear_sq * length_sq


def segment_box_is_clear(
    clear_sq: int, px: int, py: int, qx: int, qy: int, ix: int, iy: int
) -> bool:
    """Whether the disc swept from p to q is clear of one closed cell, exactly.

    P itself is assumed to be clear. If a segment and a box do not cross, their nearest points
    include an end of the segment or a corner of the box, so these and the crossing itself decide.
    """
    if point_box_distance_sq(qx, qy, ix, iy) < clear_sq:
        return False
    dx, dy = qx - px, qy - py
    length_sq = dx * dx + dy * dy
    left, low = ix * UNIT - px, iy * UNIT - py
    above, below = False, False
    for corner in range(4):
        cx = left + (corner & 1) * UNIT
        cy = low + (corner >> 1) * UNIT
        across = dx * cy - dy * cx
        if not _corner_is_clear(clear_sq, dx * cx + dy * cy, across, length_sq):
            return False
        above = above or across > 0
        below = below or across < 0
    apart = (
        max(0, dx) < left or min(0, dx) > left + UNIT or max(0, dy) < low or min(0, dy) > low + UNIT
    )
    return apart or not (above and below)


def segment_first_not_clear(
    cells: Cells, state: int, clear_sq: int, reach: int, ends: tuple[int, int, int, int]
) -> tuple[bool, int, int]:
    """The first cell in ``state``, in order of rows, that the disc swept along a segment cuts.

    Args:
        cells: (height, width) cell states.
        state: Which cells count.
        clear_sq: Squared clear distance.
        reach: Its root, rounded up.
        ends: px, py, qx, qy; p is assumed to be clear.

    Returns:
        Whether a cell is cut, and its ix and iy.
    """
    px, py, qx, qy = ends
    dx, dy = qx - px, qy - py
    low, high = min(py, qy) - reach, max(py, qy) + reach
    for iy in range(max(low // UNIT, -1), min(high // UNIT, cells.shape[0]) + 1):
        left, right = min(px, qx), max(px, qx)
        if (
            abs(dx) > 2 * UNIT and abs(dy) > 2 * UNIT
        ):  # a long slanted move: only the part near this row
            a = (float(iy * UNIT - reach - py)) / float(dy)
            b = (float((iy + 1) * UNIT + reach - py)) / float(dy)
            first, last = max(0.0, min(a, b)), min(1.0, max(a, b))
            one = px + math.floor(first * dx)
            two = px + math.ceil(last * dx)
            left, right = min(one, two) - 1, max(one, two) + 1
        for ix in range(
            max((left - reach) // UNIT, -1), min((right + reach) // UNIT, cells.shape[1]) + 1
        ):
            if cell_state(cells, ix, iy) == state and not segment_box_is_clear(
                clear_sq, px, py, qx, qy, ix, iy
            ):
                return True, ix, iy
    return False, 0, 0


def segment_crosses_box(px: int, py: int, qx: int, qy: int, ix: int, iy: int) -> bool:
    """Return whether a segment, or a point if p = q, meets the open interior of a cell, exactly."""
    left, low = ix * UNIT - px, iy * UNIT - py
    dx, dy = qx - px, qy - py
    if (
        max(0, dx) <= left
        or min(0, dx) >= left + UNIT
        or max(0, dy) <= low
        or min(0, dy) >= low + UNIT
    ):
        return False
    above, below = False, False
    for corner in range(4):
        across = dx * (low + (corner >> 1) * UNIT) - dy * (left + (corner & 1) * UNIT)
        above = above or across > 0
        below = below or across < 0
    return (above and below) or (dx == 0 and dy == 0)


def segment_box_depth(radius: float, px: int, py: int, qx: int, qy: int, ix: int, iy: int) -> float:
    """Return how deep the disc swept from p to q cuts into a cell, lattice units; 0 if it does not.

    If the centre is inside the cell, that counts as the whole radius.
    """
    if segment_crosses_box(px, py, qx, qy, ix, iy):
        return radius
    nearest = min(
        float(point_box_distance_sq(px, py, ix, iy)), float(point_box_distance_sq(qx, qy, ix, iy))
    )
    dx, dy = qx - px, qy - py
    length_sq = dx * dx + dy * dy
    for corner in range(4):
        cx = (ix + (corner & 1)) * UNIT - px
        cy = (iy + (corner >> 1)) * UNIT - py
        along = dx * cx + dy * cy
        if 0 < along < length_sq:
            across = float(dx * cy - dy * cx)
            nearest = min(nearest, across * across / float(length_sq))
    return max(0.0, radius - math.sqrt(nearest))


def segment_point_within(
    px: int, py: int, qx: int, qy: int, x: int, y: int, within_sq: int
) -> bool:
    """Whether some point of a segment is within a distance of (x, y); squared distance, exact."""
    dx, dy = qx - px, qy - py
    cx, cy = x - px, y - py
    ex, ey = x - qx, y - qy
    if cx * cx + cy * cy <= within_sq or ex * ex + ey * ey <= within_sq:
        return True
    length_sq = dx * dx + dy * dy
    along = dx * cx + dy * cy
    if along <= 0 or along >= length_sq:
        return False
    across = float(dx * cy - dy * cx)
    return across * across <= float(within_sq) * float(length_sq)


def chessboard_clearance(cells: Cells, table: npt.NDArray[np.int32]) -> None:
    """Fills ``table`` with the chessboard distance, in cells, to the nearest cell that is not free.

    A point in a cell with distance D is at least (D - 1) cells away from every such cell, so most
    steps need no test of their path. Outside counts as solid. Two passes (Rosenfeld and Pfaltz,
    1966).
    """
    height, width = cells.shape
    for iy in range(height):
        for ix in range(width):
            border = min(ix, width - 1 - ix, iy, height - 1 - iy) + 1
            near = 0 if cells[iy, ix] != 0 else border
            if near > 0 and iy > 0:
                for k in range(max(ix - 1, 0), min(ix + 2, width)):
                    near = min(near, table[iy - 1, k] + 1)
            if near > 0 and ix > 0:
                near = min(near, table[iy, ix - 1] + 1)
            table[iy, ix] = near
    for iy in range(height - 1, -1, -1):
        for ix in range(width - 1, -1, -1):
            near = table[iy, ix]
            if near > 0 and iy < height - 1:
                for k in range(max(ix - 1, 0), min(ix + 2, width)):
                    near = min(near, table[iy + 1, k] + 1)
            if near > 0 and ix < width - 1:
                near = min(near, table[iy, ix + 1] + 1)
            table[iy, ix] = near


def mark_near(cells: Cells, near: npt.NDArray[np.int32], ix: int, iy: int) -> None:
    """Updates the masks of the surrounding cells with a cell's new state.

    A cell outside the grid counts as solid.
    """
    taken = cell_state(cells, ix, iy) != 0
    for jy in range(max(iy - NEAR, 0), min(iy + NEAR + 1, cells.shape[0])):
        for jx in range(max(ix - NEAR, 0), min(ix + NEAR + 1, cells.shape[1])):
            bit = np.int32(1 << ((iy - jy + NEAR) * _SIDE + ix - jx + NEAR))
            near[jy, jx] = near[jy, jx] | bit if taken else near[jy, jx] & ~bit


def near_masks(cells: Cells, near: npt.NDArray[np.int32]) -> None:
    """Fills ``near`` with the cells that are not free among the 25 around each cell.

    Bits in rows from the lowest.
    """
    height, width = cells.shape
    near[:, :] = 0
    for iy in range(-NEAR, height + NEAR):
        for ix in range(-NEAR, width + NEAR):
            if cell_state(cells, ix, iy) != 0:
                mark_near(cells, near, ix, iy)


def window_is_free(
    near: npt.NDArray[np.int32], reach: int, ends: tuple[int, int, int, int]
) -> bool:
    """Return whether the masks show that all cells in the box around a disc's path are free.

    If not, an exact test is needed.

    Args:
        near: :func:`near_masks`.
        reach: Radius of the disc, rounded up to whole lattice units.
        ends: px, py, qx, qy of its path.
    """
    px, py, qx, qy = ends
    ix, iy = px // UNIT, py // UNIT
    if not (0 <= ix < near.shape[1] and 0 <= iy < near.shape[0]):
        return False
    left, right = (
        (min(px, qx) - reach) // UNIT - ix + NEAR,
        (max(px, qx) + reach - 1) // UNIT - ix + NEAR,
    )
    low, high = (
        (min(py, qy) - reach) // UNIT - iy + NEAR,
        (max(py, qy) + reach - 1) // UNIT - iy + NEAR,
    )
    if left < 0 or low < 0 or right >= _SIDE or high >= _SIDE:
        return False
    columns = ((2 << right) - 1) & ~((1 << left) - 1)
    rows = ((1 << (_SIDE * (high + 1))) - 1) & ~((1 << (_SIDE * low)) - 1)
    return bool(near[iy, ix] & (columns * _EACH_ROW) & rows == 0)
