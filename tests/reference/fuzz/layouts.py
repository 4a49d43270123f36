"""Decode layout bytes to worlds, and check whether a robot can certainly reach the target.

A row of cells is one number here: bit ``ix + MARGIN`` of row ``iy + MARGIN`` is 1 if the cell is
solid, and everything around a world is solid. The meaning of the bytes is fixed by
:func:`fuzz.layouts.features.decode_world`, the same bit for bit.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from fuzz.layouts import layout_bytes
from fuzz.layouts.layout_bytes import CLEAR, HEAD_BYTES, SMALLEST_SIDE, SPREAD_OF_SIDES

Bytes = npt.NDArray[np.uint8]
Ints = npt.NDArray[np.int64]

NEAR = 2
"""How many cells the simulator's masks see to each side."""

MARGIN = NEAR
"""Rows and columns of solid cells around a world, as many as the simulator's masks see."""

ROWS = SMALLEST_SIDE + SPREAD_OF_SIDES - 1 + 2 * MARGIN
"""Rows of the tallest world with its margin."""

_WINDOW = 2 * NEAR + 1
_ROW_OF_MASK = (1 << _WINDOW) - 1


def byte_of(layouts: Bytes, n: int, k: int) -> Any:
    """Byte k of layout n as a number that does not wrap around."""
    return int(layouts[n, k])


def size_of(layouts: Bytes, n: int) -> tuple[int, int]:
    """Width and height of a layout's world, cells."""
    wide, high = byte_of(layouts, n, 0) % SPREAD_OF_SIDES, byte_of(layouts, n, 1) % SPREAD_OF_SIDES
    return SMALLEST_SIDE + wide, SMALLEST_SIDE + high


def places_of(layouts: Bytes, n: int) -> tuple[int, int, int, int]:
    """Cells of a layout's start and target: ix, iy, ix, iy."""
    width, height = size_of(layouts, n)
    return (
        2 + byte_of(layouts, n, 2) % (width - 4),
        2 + byte_of(layouts, n, 3) % (height - 4),
        width - 3 - byte_of(layouts, n, 5) % (width - 4),
        height - 3 - byte_of(layouts, n, 6) % (height - 4),
    )


def _stamp_size(kind: int, length: int, depth: int, thickness: int) -> tuple[int, int]:
    """Height and width of a feature before it is turned."""
    if kind == layout_bytes.BOX:
        return depth, length
    if kind == layout_bytes.WALL:
        return thickness, length + depth
    if kind == layout_bytes.CUP:
        return depth + thickness, length + 2 * thickness
    if kind == layout_bytes.CORNER:
        return depth + thickness, length + thickness
    if kind == layout_bytes.GATE:
        return thickness, length + depth + 2
    if kind == layout_bytes.DIAGONAL:
        return length + depth, length + depth
    return depth + thickness, 3 * (1 + length // 3) + 1


def _is_in_stamp(kind: int, i: int, j: int, form: tuple[int, int, int]) -> bool:
    """Return whether row i, column j of a feature is solid."""
    length, depth, thickness = form
    if kind == layout_bytes.CUP:
        return i >= depth or j < thickness or j >= thickness + length
    if kind == layout_bytes.CORNER:
        return i < thickness or j < thickness
    if kind == layout_bytes.GATE:
        return j < length or j >= length + 2
    if kind == layout_bytes.DIAGONAL:
        return j == i or (thickness > 1 and j == i + 1)
    if kind == layout_bytes.COMB:
        return i < thickness or j % 3 == 0
    return True


def _draw_feature(layouts: Bytes, n: int, first: int, solid: Ints) -> None:
    """Draws the feature whose bytes begin at ``first``; cells outside the world are cut off."""
    width, height = size_of(layouts, n)
    kind, form = byte_of(layouts, n, first) % layout_bytes.KINDS, byte_of(layouts, n, first + 5)
    x, y = (
        1 + byte_of(layouts, n, first + 1) % (width - 2),
        1 + byte_of(layouts, n, first + 2) % (height - 2),
    )
    length, depth = 1 + byte_of(layouts, n, first + 3) % 12, 1 + byte_of(layouts, n, first + 4) % 8
    turn, thickness = form % 4, 1 + form // 4 % 2
    rows, columns = _stamp_size(kind, length, depth, thickness)
    high, wide = (columns, rows) if turn % 2 == 1 else (rows, columns)
    for i in range(min(high, height - y)):
        for j in range(min(wide, width - x)):
            if turn == 0:
                k, m = i, j
            elif turn == 1:
                k, m = j, columns - 1 - i
            elif turn == 2:
                k, m = rows - 1 - i, columns - 1 - j
            else:
                k, m = rows - 1 - j, i
            if _is_in_stamp(kind, k, m, (length, depth, thickness)):
                solid[y + i + MARGIN] |= 1 << (x + j + MARGIN)


def draw_layout(layouts: Bytes, n: int, solid: Ints) -> None:
    """Draws a layout's cells.

    Args:
        layouts: (n, LAYOUT_BYTES or more) uint8.
        n: Which one.
        solid: (ROWS,) rows of bits, filled up to the margin above the world.
    """
    width, height = size_of(layouts, n)
    for iy in range(height + 2 * MARGIN):
        solid[iy] = 0
    for k in range(byte_of(layouts, n, 7) % (layout_bytes.MAX_FEATURES + 1)):
        _draw_feature(layouts, n, HEAD_BYTES + k * layout_bytes.FEATURE_BYTES, solid)
    start_x, start_y, target_x, target_y = places_of(layouts, n)
    block = (1 << (2 * CLEAR + 1)) - 1
    for d in range(-CLEAR, CLEAR + 1):
        solid[start_y + d + MARGIN] &= ~(block << (start_x - CLEAR + MARGIN))
        solid[target_y + d + MARGIN] &= ~(block << (target_x - CLEAR + MARGIN))
    border = ~(((1 << (width - 2)) - 1) << (1 + MARGIN))
    for iy in range(height + 2 * MARGIN):
        solid[iy] = -1 if iy <= MARGIN or iy >= height - 1 + MARGIN else solid[iy] | border


def fill_arena(solid: Ints, cells: Bytes, near: npt.NDArray[np.int32]) -> int:
    """Write a drawn world's cells and masks, (height, width), and return how many are solid."""
    height, width = cells.shape
    count = 0
    for iy in range(height):
        for ix in range(width):
            mask = 0
            for k in range(_WINDOW):
                mask |= ((int(solid[iy + k]) >> ix) & _ROW_OF_MASK) << (_WINDOW * k)
            taken = (int(solid[iy + MARGIN]) >> (ix + MARGIN)) & 1
            cells[iy, ix], near[iy, ix] = taken, mask
            count += taken
    return count


def _joined(clear: int, row: int, below: int, above: int, seen: int) -> int:
    """Corners that can be reached in one more step, in one row."""
    return (row | row << 1 | row >> 1 | below | above) & clear & ~seen


def flood_length(layouts: Bytes, n: int, solid: Ints, room: Ints) -> int:
    """Count steps from a corner of the start's cell to one of the target's, along clear corners.

    A disc whose radius is at most a cell, and that fits into start and target, can follow them: no
    solid cell is nearer to them than a whole cell.

    Args:
        layouts: (n, LAYOUT_BYTES or more) uint8.
        n: Which one.
        solid: Rows of bits, :func:`draw_layout`.
        room: (3, ROWS) to be used: rows of corners that are clear, reached, and reached last.

    Returns:
        Their number, -1 if there is no such path. A corner of cell (ix, iy) has the bit and the row
        of the cell above and to the right of it.
    """
    height = size_of(layouts, n)[1]
    start_x, start_y, target_x, target_y = places_of(layouts, n)
    room[0, 0], room[1, 0], room[2, 0] = 0, 0, 0
    for iy in range(1, height + 2 * MARGIN):
        free = ~(solid[iy] | solid[iy - 1])
        room[0, iy] = free & (free << 1)
        room[1, iy], room[2, iy] = 0, 0
    low, high = start_y + MARGIN, start_y + MARGIN + 1
    for iy in (low, high):
        room[1, iy] = room[2, iy] = 3 << (start_x + MARGIN)
    goal, steps = 3 << (target_x + MARGIN), 0
    while low <= high:
        if (room[1, target_y + MARGIN] | room[1, target_y + MARGIN + 1]) & goal != 0:
            return steps
        steps += 1
        first, last, before = high + 2, low - 2, 0
        for iy in range(max(low - 1, 1), min(high + 1, height + 2 * MARGIN - 2) + 1):
            row = room[2, iy]
            new = _joined(room[0, iy], row, before, room[2, iy + 1], room[1, iy])
            before = row
            room[2, iy] = new
            if new != 0:
                room[1, iy] |= new
                first, last = min(first, iy), max(last, iy)
        low, high = first, last
    return -1
