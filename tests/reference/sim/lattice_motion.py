"""How a commanded displacement becomes a path on the pose lattice: swept and endpoint.

``swept`` never tunnels, for any controller, because each of its segments has passed the exact
integer test of :mod:`tests.reference.sim.geometry`; floating point only proposes where to stop.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from tests.reference.sim import polygon
from tests.reference.sim.geometry import cell_state
from tests.reference.sim.layout import SOLID, TIME_UNIT, UNIT
from tests.reference.sim.shape import Shape, pose_is_clear, segment_first_not_clear

Cells = npt.NDArray[np.uint8]
Chain = npt.NDArray[np.int64]

_TRIES = 3  # straight pieces a move may have: ahead and two slides (face, then corner)
_GRAZE = (
    1e-6  # lattice units squared by which a path may cut a circle's square and still only graze it
)
MOST_POINTS = _TRIES + 1
"""Points that one move may add to a path, including the end of a wait."""


def round_away(value: float) -> int:
    """Nearest integer, halves away from zero, so that rounding has every mirror symmetry."""
    if value < 0.0:
        return -math.floor(0.5 - value)
    return math.floor(value + 0.5)


def _contact_with_corner(
    radius_sq: float, mx: float, my: float, dx: float, dy: float, graze: float
) -> float:
    """Time in [0, 1) at which a point moving by d from m meets the circle around the origin; 2 if
    it doesn't.

    A point that only grazes the circle doesn't meet it, unless ``graze`` is 0.

    Source: moving point against sphere, Ericson, Real-Time Collision Detection (2005), 5.3.2.
    """
    approach = mx * dx + my * dy
    if approach >= 0.0:
        return 2.0
    a = dx * dx + dy * dy
    inside = approach * approach - a * (mx * mx + my * my - radius_sq)
    if inside < graze * a:
        return 2.0
    return max(0.0, (-approach - math.sqrt(inside)) / a)


def first_contact(
    cells: Cells, radius: float, reach: int, x: int, y: int, dx: int, dy: int, graze: float
) -> tuple[float, float, float]:
    """Find when a moving disc first touches a solid cell, and the direction away from it.

    Args:
        cells: (height, width) cell states.
        radius: Radius of the disc, lattice units.
        reach: The same, rounded up.
        x: Start.
        y: Start.
        dx: Displacement.
        dy: Displacement.
        graze: How far the square of a corner's circle may be cut without a touch.

    Returns:
        Time in [0, 1] of the contact (2 for none) and the outward normal, of any length.
    """
    best, normal_x, normal_y = 2.0, 0.0, 0.0
    fx, fy = float(dx), float(dy)
    for iy in range(
        max((min(y, y + dy) - reach - 1) // UNIT, -1),
        min((max(y, y + dy) + reach) // UNIT, cells.shape[0]) + 1,
    ):
        for ix in range(
            max((min(x, x + dx) - reach - 1) // UNIT, -1),
            min((max(x, x + dx) + reach) // UNIT, cells.shape[1]) + 1,
        ):
            if cell_state(cells, ix, iy) != SOLID:
                continue
            left, low = float(ix * UNIT - x), float(iy * UNIT - y)
            if dx != 0:
                t = (left - radius) / fx if dx > 0 else (left + UNIT + radius) / fx
                if -1e-9 <= t < best and low <= t * fy <= low + UNIT:
                    best, normal_x, normal_y = max(t, 0.0), -fx, 0.0
            if dy != 0:
                t = (low - radius) / fy if dy > 0 else (low + UNIT + radius) / fy
                if -1e-9 <= t < best and left <= t * fx <= left + UNIT:
                    best, normal_x, normal_y = max(t, 0.0), 0.0, -fy
            for corner in range(4):
                mx, my = -left - (corner & 1) * UNIT, -low - (corner >> 1) * UNIT
                t = _contact_with_corner(radius * radius, mx, my, fx, fy, graze)
                if t < best:
                    best, normal_x, normal_y = t, mx + t * fx, my + t * fy
    return best, normal_x, normal_y


def _step_aside(
    cells: Cells, clear_sq: Shape, reach: int, ends: tuple[int, int, int, int], nx: float, ny: float
) -> tuple[bool, int, int]:
    """A clear end of a slide: its destination, or one or two lattice units off the wall."""
    x, y, qx, qy = ends
    sx = 1 if nx > 0.0 else (-1 if nx < 0.0 else 0)
    sy = 1 if ny > 0.0 else (-1 if ny < 0.0 else 0)
    main_x = sx if abs(nx) >= abs(ny) else 0
    main_y = sy if abs(ny) >= abs(nx) else 0
    for away in range(4):
        ax = qx + (away * main_x if away < 3 else sx)
        ay = qy + (away * main_y if away < 3 else sy)
        if not segment_first_not_clear(cells, SOLID, clear_sq, reach, (x, y, ax, ay))[0]:
            return True, ax, ay
    return False, x, y


def _stop_at(
    cells: Cells,
    clear_sq: Shape,
    reach: int,
    ends: tuple[int, int, int, int],
    contact: tuple[float, float, float],
) -> tuple[int, int]:
    """Find a lattice point near a contact that a clear segment leads to, or else the start.

    It is nearest to the contact, a little away from the wall if rounding would be inside it, or
    farther back.
    """
    x, y, dx, dy = ends
    t, nx, ny = contact
    length = math.sqrt(float(dx) * float(dx) + float(dy) * float(dy))
    for back in range(4):
        s = (t * length - back) / length
        if s <= 0.0:
            break
        goal = (x, y, x + round_away(s * dx), y + round_away(s * dy))
        if goal[2] == x and goal[3] == y:
            # If it is there, it is clear: this covers nine of ten contacts of a robot that pushes
            # along walls, 223 ns instead of 284.
            break
        found, qx, qy = _step_aside(cells, clear_sq, reach, goal, nx, ny)
        if found:
            return qx, qy
    return x, y


def _first_stop(
    cells: Cells, clear_sq: Shape, reach: int, ends: tuple[int, int, int, int]
) -> tuple[float, float, float, int, int]:
    """Find the first contact of a path that is not clear, and where the disc can stop.

    Corners that the path only grazes count only if nothing else explains why it is not clear: they
    play no part in a slide along a wall, however near they are.
    """
    x, y, dx, dy = ends
    graze = _GRAZE
    while True:
        if isinstance(clear_sq, tuple):
            t, nx, ny = polygon.first_contact(
                cells, clear_sq, ends, polygon.GRAZE if graze else 0.0
            )
        else:
            radius = math.sqrt(float(clear_sq))
            t, nx, ny = first_contact(cells, radius, reach, x, y, dx, dy, graze)
        if t > 1.0 and graze == 0.0:
            t, nx, ny = 1.0, -float(dx), -float(dy)  # a touch that only exact arithmetic detects
        if t <= 1.0:
            qx, qy = _stop_at(cells, clear_sq, reach, ends, (t, nx, ny))
            if graze == 0.0 or qx != x or qy != y or t * (abs(dx) + abs(dy)) < 1.0:
                return t, nx, ny, qx, qy
        graze = 0.0


def _append(chain: Chain, count: int, x: int, y: int, time: float) -> int:
    """Adds a point to a chain; returns the new number of points."""
    chain[count, 0], chain[count, 1] = x, y
    chain[count, 2] = math.floor(time * TIME_UNIT + 0.5)
    return count + 1


def swept_move(
    cells: Cells,
    clear_sq: Shape,
    reach: int,
    ends: tuple[int, int, int, int],
    during: tuple[float, float],
    wall_friction: float,
    chain: Chain,
    count: int,
) -> tuple[int, float, float]:
    """Moves a robot, stopping at walls and sliding along them.

    Args:
        cells: (height, width) cell states.
        clear_sq: Squared clear distance, lattice units squared; the corners of a body.
        reach: Its root, rounded up.
        ends: Start, a clear lattice pose, and displacement, lattice units: x, y, dx, dy.
        during: When the move begins and ends, as fractions of the step.
        wall_friction: Fraction of a slide that is lost to the wall, 0 to 1.
        chain: (n, 3) int64; rows x, y, time in the step are filled with the clear lattice points of
            the path after the start.
        count: Rows that are already filled; at most ``MOST_POINTS`` follow.

    Returns:
        The number of filled rows, and the normal of the last contact (0, 0: none).
    """
    x, y, dx, dy = ends
    now, end = during
    normal_x, normal_y = 0.0, 0.0
    for attempt in range(_TRIES):
        if dx == 0 and dy == 0:
            break
        if attempt == 0:
            free = not segment_first_not_clear(
                cells, SOLID, clear_sq, reach, (x, y, x + dx, y + dy)
            )[0]
            qx, qy = x + dx, y + dy
        else:
            free, qx, qy = _step_aside(
                cells, clear_sq, reach, (x, y, x + dx, y + dy), normal_x, normal_y
            )
        if free:
            count = _append(chain, count, qx, qy, end)
            break
        t, nx, ny, qx, qy = _first_stop(cells, clear_sq, reach, (x, y, dx, dy))
        now += (end - now) * t
        if qx != x or qy != y:
            count = _append(chain, count, qx, qy, now)
            x, y = qx, qy
        left_x, left_y = (1.0 - t) * dx, (1.0 - t) * dy
        into = (left_x * nx + left_y * ny) / (nx * nx + ny * ny)
        if into < 0.0:
            left_x, left_y = left_x - into * nx, left_y - into * ny
        if attempt > 0 and left_x * normal_x + left_y * normal_y < 0.0:
            normal_x, normal_y = nx, ny
            break  # wedged: the second wall pushes back into the first
        dx, dy = (
            round_away((1.0 - wall_friction) * left_x),
            round_away((1.0 - wall_friction) * left_y),
        )
        normal_x, normal_y = nx, ny
    return count, normal_x, normal_y


def endpoint_move(
    cells: Cells,
    clear_sq: Shape,
    reach: int,
    ends: tuple[int, int, int, int],
    chain: Chain,
    count: int,
) -> tuple[int, float, float]:
    """Moves a robot if it is clear at the end of the move, otherwise not at all.

    The path in between is not checked, as in most small simulators, so a fast robot passes through
    walls. Arguments and result as for :func:`swept_move`.
    """
    x, y, dx, dy = ends
    if dx == 0 and dy == 0:
        return count, 0.0, 0.0
    if pose_is_clear(cells, SOLID, clear_sq, reach, x + dx, y + dy):
        return _append(chain, count, x + dx, y + dy, 1.0), 0.0, 0.0
    return count, -float(dx), -float(dy)
