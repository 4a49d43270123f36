"""The thesis's motion: forward pixel by pixel until something is touched, with three faults.

It slides along a wall after looking at one cell only, backs off without looking, and continues
where only the corner of a cell is touched; so a robot that turns often gets into walls and through
them. Each fault can be repaired; with all three repaired, the disc is only ever at places that were
found clear. Any controller can be moved by it.

Source: the thesis's listing, ``simGuiExp.checkCollision`` and ``advanceRobot``; the disc test is
    Java's
``Ellipse2D.intersects``.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from tests.reference.sim.thesis_layout import CELL, WALL

Cells = npt.NDArray[np.int32]

# What a one-pixel step hits: nothing; a wall that one or both of the single-axis moves would also
# touch; or only the corner of a cell.
_FREE, _TOUCH_X, _TOUCH_Y, _TOUCH_BOTH, _TOUCH_CORNER = 0, 1, 2, 3, 4

# How a tick's move ends: as it began; sliding; backing off, or staying in place if that is
# repaired; and, instead of STRAIGHT, having continued past a corner that it touched.
STRAIGHT, SLIDE, BACK_OFF, CORNER = 0, 1, 2, 3

# Bits of `repairs`.
REPAIR_SLIDE, REPAIR_BACK_OFF, REPAIR_CORNER = 1, 2, 4


def disc_touches_cell(x: float, y: float, radius: float, cell_x: int, cell_y: int) -> bool:
    """Whether the open disc meets the cell, in the ellipse's own coordinates, where its radius is
    1/2.
    """
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


def _contact(
    cells: Cells, x: float, y: float, previous_x: float, previous_y: float, radius: float
) -> int:
    """What a one-pixel step hits, ``_FREE`` to ``_TOUCH_CORNER``.

    Only the first wall that a single-axis part touches counts. Rows outside the grid are skipped,
    whereas the listing leaves its loop; inside a border of walls this is the same.
    """
    beyond = x >= cells.shape[0] * CELL - radius or y >= cells.shape[1] * CELL - radius
    centre_x, centre_y = int(x / CELL), int(y / CELL)
    reach = math.ceil(radius / CELL)
    found = _FREE
    for cell_y in range(
        min(centre_y + reach, cells.shape[1] - 1), max(centre_y - reach, 0) - 1, -1
    ):
        for cell_x in range(
            max(centre_x - reach, 0), min(centre_x + reach, cells.shape[0] - 1) + 1
        ):
            wall = cells[cell_x, cell_y] == WALL and disc_touches_cell(x, y, radius, cell_x, cell_y)
            if not (beyond or wall):
                continue
            touched = (
                _TOUCH_X if disc_touches_cell(x, previous_y, radius, cell_x, cell_y) else _FREE
            )
            if disc_touches_cell(previous_x, y, radius, cell_x, cell_y):
                touched += _TOUCH_Y
            if touched != _FREE:
                return touched
            if wall:
                found = _TOUCH_CORNER
    return found


def _is_clear(cells: Cells, x: float, y: float, radius: float) -> bool:
    """Whether the disc touches no wall."""
    centre_x, centre_y = int(x / CELL), int(y / CELL)
    reach = math.ceil(radius / CELL)
    for cell_y in range(max(centre_y - reach, 0), min(centre_y + reach, cells.shape[1] - 1) + 1):
        for cell_x in range(
            max(centre_x - reach, 0), min(centre_x + reach, cells.shape[0] - 1) + 1
        ):
            if cells[cell_x, cell_y] == WALL and disc_touches_cell(x, y, radius, cell_x, cell_y):
                return False
    return True


def clamp_inside(cells: Cells, x: float, y: float, radius: float) -> tuple[float, float]:
    """Keeps the disc one cell away from the grid's edge."""
    low = radius + CELL
    high_x, high_y = cells.shape[0] * CELL - radius - CELL, cells.shape[1] * CELL - radius - CELL
    x, y = max(x, low), max(y, low)
    return min(x, high_x), min(y, high_y)


def advance(
    cells: Cells,
    x: float,
    y: float,
    goal_x: float,
    goal_y: float,
    radius: float,
    repairs: int,
    wall_friction: float,
) -> tuple[float, float, bool, int, float, float]:
    """Moves the disc towards a goal, px by px, as the thesis does.

    Args:
        cells: (width, height), see :mod:`tests.reference.sim.thesis_layout`.
        x: Centre now, px.
        y: Same as above.
        goal_x: Where the tick's motion would lead, px; finite, at most a few cells away.
        goal_y: Same as above.
        radius: px.
        repairs: Which faults are repaired, bits ``REPAIR_SLIDE``, ``REPAIR_BACK_OFF``,
            ``REPAIR_CORNER``.
        wall_friction: Share of a slide that is lost to friction, 0 to 1.

    Returns:
        The centre afterwards; whether the listing's collision flag is up; how the move ended,
        ``STRAIGHT`` to ``CORNER``; and the centre before the wall changed the move, equal to the
        first if none did.
    """
    way_x, way_y = goal_x - x, goal_y - y
    length = math.sqrt(way_x * way_x + way_y * way_y)
    if length == 0.0:  # the listing divides by it and compares with nan, so nothing moves
        x, y = clamp_inside(cells, x, y, radius)
        return x, y, False, STRAIGHT, x, y
    unit_x, unit_y = 1.0 / length * way_x, 1.0 / length * way_y
    gone_x, gone_y = unit_x, unit_y
    here_x, here_y = x, y
    next_x, next_y = x + gone_x, y + gone_y
    ending = STRAIGHT
    while abs(gone_x) < abs(way_x) or abs(gone_y) < abs(way_y):
        touched = _contact(cells, next_x, next_y, here_x, here_y, radius)
        if touched == _TOUCH_CORNER:
            ending = CORNER
            if repairs & REPAIR_CORNER:
                touched = _TOUCH_BOTH
        if touched in (_TOUCH_X, _TOUCH_Y, _TOUCH_BOTH):
            before_x, before_y = here_x, here_y
            here_x, here_y, ending = _meet_wall(
                cells,
                here_x,
                here_y,
                next_x,
                next_y,
                unit_x,
                unit_y,
                radius,
                touched,
                repairs,
                wall_friction,
            )
            here_x, here_y = clamp_inside(cells, here_x, here_y, radius)
            return here_x, here_y, True, ending, before_x, before_y
        gone_x += unit_x
        gone_y += unit_y
        here_x, here_y = next_x, next_y
        next_x, next_y = x + gone_x, y + gone_y
    here_x, here_y = clamp_inside(cells, here_x, here_y, radius)
    return here_x, here_y, False, ending, here_x, here_y


def _meet_wall(
    cells: Cells,
    here_x: float,
    here_y: float,
    next_x: float,
    next_y: float,
    unit_x: float,
    unit_y: float,
    radius: float,
    touched: int,
    repairs: int,
    wall_friction: float,
) -> tuple[float, float, int]:
    """The centre after a one-pixel step that hits a wall, and ``SLIDE`` or ``BACK_OFF``.

    A slide continues along one axis, and goes back by the step's component along the other.
    """
    if touched != _TOUCH_BOTH:
        to_x, to_y = here_x - unit_x, here_y - unit_y
        if touched == _TOUCH_Y:
            to_x = next_x if wall_friction == 0.0 else here_x + (1.0 - wall_friction) * unit_x
        else:
            to_y = next_y if wall_friction == 0.0 else here_y + (1.0 - wall_friction) * unit_y
        if not repairs & REPAIR_SLIDE or _is_clear(cells, to_x, to_y, radius):
            return to_x, to_y, SLIDE
    if repairs & REPAIR_BACK_OFF:
        return here_x, here_y, BACK_OFF
    return here_x - unit_x, here_y - unit_y, BACK_OFF
