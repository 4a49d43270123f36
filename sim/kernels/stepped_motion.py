"""The thesis's motion: forward in steps of one pixel until something is touched, with its three faults.

It slides along a wall after looking at one cell only, backs off without looking, and goes on where only the
corner of a cell is touched; so a robot that turns often works itself into walls and through them. Any
controller can be moved by it.

Source: the thesis's listing, ``simGuiExp.checkCollision`` and ``advanceRobot``; the disc test is Java's
``Ellipse2D.intersects``.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from sim.kernels._jit import kernel
from sim.kernels.thesis_layout import CELL, WALL

__all__ = ["advance", "clamp_inside", "disc_touches_cell"]

Cells = npt.NDArray[np.int32]

_FREE, _TOUCH_X, _TOUCH_Y = 0, 1, 2  # which of the two single-axis moves also touch; both is 3


@kernel
def disc_touches_cell(x: float, y: float, radius: float, cell_x: int, cell_y: int) -> bool:
    """Whether the open disc meets the cell, in the ellipse's own coordinates, where its radius is 1/2."""
    width = radius * 2.0
    left = (cell_x * CELL - (x - radius)) / width - 0.5
    top = (cell_y * CELL - (y - radius)) / width - 0.5
    right, bottom = left + CELL / width, top + CELL / width
    near_x, near_y = 0.0, 0.0
    if left > 0.0:
        near_x = left
    elif right < 0.0:
        near_x = right
    if top > 0.0:
        near_y = top
    elif bottom < 0.0:
        near_y = bottom
    return near_x * near_x + near_y * near_y < 0.25


@kernel
def _contact(cells: Cells, x: float, y: float, previous_x: float, previous_y: float, radius: float) -> int:
    """What one pixel's step meets: ``_FREE``, or which of its single-axis parts touch the cell it touches.

    Rows outside the grid are skipped, where the listing leaves its loop: the same inside a border of walls.
    """
    beyond = x >= cells.shape[0] * CELL - radius or y >= cells.shape[1] * CELL - radius
    centre_x, centre_y = int(x / CELL), int(y / CELL)
    reach = int(math.ceil(radius / CELL))
    for cell_y in range(min(centre_y + reach, cells.shape[1] - 1), max(centre_y - reach, 0) - 1, -1):
        for cell_x in range(max(centre_x - reach, 0), min(centre_x + reach, cells.shape[0] - 1) + 1):
            wall = cells[cell_x, cell_y] == WALL
            if not (beyond or (wall and disc_touches_cell(x, y, radius, cell_x, cell_y))):
                continue
            touched = _TOUCH_X if disc_touches_cell(x, previous_y, radius, cell_x, cell_y) else _FREE
            if disc_touches_cell(previous_x, y, radius, cell_x, cell_y):
                touched += _TOUCH_Y
            if touched != _FREE:
                return touched
    return _FREE


@kernel
def clamp_inside(cells: Cells, x: float, y: float, radius: float) -> tuple[float, float]:
    """Keeps the disc one cell away from the grid's edge."""
    low = radius + CELL
    high_x, high_y = cells.shape[0] * CELL - radius - CELL, cells.shape[1] * CELL - radius - CELL
    x, y = max(x, low), max(y, low)
    return min(x, high_x), min(y, high_y)


@kernel
def advance(cells: Cells, x: float, y: float, goal_x: float, goal_y: float, radius: float) -> tuple[float, float, bool]:
    """Moves the disc towards a goal, px by px, as the thesis does.

    Args:
        cells: (width, height), see :mod:`sim.kernels.thesis_layout`.
        x: Centre now, px.
        y: Likewise.
        goal_x: Where the tick's motion would lead, px; finite, a few cells away at most.
        goal_y: Likewise.
        radius: px.

    Returns:
        The centre afterwards, and whether the listing's collision flag is up.
    """
    way_x, way_y = goal_x - x, goal_y - y
    length = math.sqrt(way_x * way_x + way_y * way_y)
    if length == 0.0:  # the listing divides by it and compares with nan: nothing moves
        x, y = clamp_inside(cells, x, y, radius)
        return x, y, False
    unit_x, unit_y = 1.0 / length * way_x, 1.0 / length * way_y
    gone_x, gone_y = unit_x, unit_y
    here_x, here_y = x, y
    next_x, next_y = x + gone_x, y + gone_y
    collision = False
    while abs(gone_x) < abs(way_x) or abs(gone_y) < abs(way_y):
        touched = _contact(cells, next_x, next_y, here_x, here_y, radius)
        if touched != _FREE:
            collision = True
            here_x = next_x if touched == _TOUCH_Y else here_x - unit_x
            here_y = next_y if touched == _TOUCH_X else here_y - unit_y
            break
        gone_x += unit_x
        gone_y += unit_y
        here_x, here_y = next_x, next_y
        next_x, next_y = x + gone_x, y + gone_y
    here_x, here_y = clamp_inside(cells, here_x, here_y, radius)
    return here_x, here_y, collision
