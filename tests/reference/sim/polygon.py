"""Convex bodies against square cells, in whole numbers: what the core decides with error bounds.

A placed body is a tuple of corners, counter-clockwise and relative to the axle, in 2^-30 of a
lattice unit. ``SCALE`` of them are one unit.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from tests.reference.sim.geometry import cell_state
from tests.reference.sim.layout import SOLID, TURN, UNIT

Cells = npt.NDArray[np.uint8]
Corners = tuple[tuple[int, int], ...]

SCALE = 1 << 30
GRAZE = 1e-3  # lattice units that a body may go into a cell and only graze it


def turned(table: Sequence[int], body: Corners, heading: int) -> Corners:
    """Return a body's corners at a heading; the body's own are whole lattice units."""
    along, across = int(table[heading]), int(table[(heading - TURN // 4) % TURN])
    return tuple((x * along - y * across, x * across + y * along) for x, y in body)


def _sides(corners: Corners) -> Iterator[tuple[tuple[int, int], tuple[int, int]]]:
    """Each corner, and the outward normal of the side that begins there."""
    for k, (x, y) in enumerate(corners):
        nx, ny = corners[(k + 1) % len(corners)]
        yield (x, y), (ny - y, x - nx)


def _box(ix: int, iy: int, x: int, y: int) -> tuple[tuple[int, int], ...]:
    """A cell's corners relative to (x, y), scaled."""
    left, low = (ix * UNIT - x) * SCALE, (iy * UNIT - y) * SCALE
    side = UNIT * SCALE
    return ((left, low), (left + side, low), (left + side, low + side), (left, low + side))


def meets(corners: Corners, move: tuple[int, int], ix: int, iy: int, x: int, y: int) -> bool:
    """Whether the hull of a body's move by (dx, dy) from (x, y) meets the inside of a cell."""
    dx, dy = move[0] * SCALE, move[1] * SCALE
    hull = [*corners, *((cx + dx, cy + dy) for cx, cy in corners)]
    box = _box(ix, iy, x, y)
    axes = [(1, 0), (0, 1), *(normal for _, normal in _sides(corners))]
    if dx or dy:
        axes.append((-dy, dx))
    for nx, ny in axes:
        own = [nx * cx + ny * cy for cx, cy in hull]
        other = [nx * cx + ny * cy for cx, cy in box]
        if max(own) <= min(other) or max(other) <= min(own):
            return False
    return True


def _reach(corners: Corners, dx: int, dy: int) -> tuple[int, int, int, int]:
    """The left, right, low and high end of a body that moves by (dx, dy), rounded out, lattice units."""
    xs, ys = zip(*corners, strict=True)
    return (
        (min(xs) + min(0, dx) * SCALE) // SCALE,
        -((-max(xs) - max(0, dx) * SCALE) // SCALE),
        (min(ys) + min(0, dy) * SCALE) // SCALE,
        -((-max(ys) - max(0, dy) * SCALE) // SCALE),
    )


def first_not_clear(
    cells: Cells, state: int, corners: Corners, ends: tuple[int, int, int, int]
) -> tuple[bool, int, int]:
    """The first cell in ``state``, in order of rows, that a body cuts on its way from p to q."""
    px, py, qx, qy = (int(number) for number in ends)
    dx, dy = qx - px, qy - py
    left, right, low, high = _reach(corners, dx, dy)
    height, width = cells.shape
    for iy in range(max((py + low) // UNIT, -1), min((py + high - 1) // UNIT, height) + 1):
        for ix in range(max((px + left) // UNIT, -1), min((px + right - 1) // UNIT, width) + 1):
            if cell_state(cells, ix, iy) == state and meets(corners, (dx, dy), ix, iy, px, py):
                return True, ix, iy
    inside = px + left >= 0 and py + low >= 0
    inside = inside and px + right <= width * UNIT and py + high <= height * UNIT
    if state == SOLID and not inside:
        return True, min(max(qx // UNIT, -1), width), min(max(qy // UNIT, -1), height)
    return False, 0, 0


def clear_turn(
    cells: Cells,
    table: Sequence[int],
    body: Corners,
    pose: tuple[int, int, int],
    turn: int,
    state: int = SOLID,
) -> tuple[int, tuple[int, int] | None]:
    """How far a body turns through every heading, and the first cell in its way, if one is."""
    x, y, heading = pose
    side = 1 if turn >= 0 else -1
    for done in range(abs(turn)):
        corners = turned(table, body, (heading + side * (done + 1)) % TURN)
        cut, ix, iy = first_not_clear(cells, state, corners, (x, y, x, y))
        if cut:
            return side * done, (ix, iy)
    return turn, None


def _floats(corners: Corners) -> list[tuple[float, float]]:
    return [(x / SCALE, y / SCALE) for x, y in corners]


def _lowest(left: float, low: float, nx: float, ny: float) -> tuple[float, float]:
    return (left if nx > 0.0 else left + UNIT), (low if ny > 0.0 else low + UNIT)


def _gaps(corners: Corners, left: float, low: float) -> Iterator[tuple[float, float, float]]:
    """Gaps between a body and a cell along each axis, times the length of its outward normal."""
    xs, ys = zip(*_floats(corners), strict=True)
    yield left - max(xs), -1.0, 0.0
    yield min(xs) - left - UNIT, 1.0, 0.0
    yield low - max(ys), 0.0, -1.0
    yield min(ys) - low - UNIT, 0.0, 1.0
    for (x, y), (nx, ny) in _sides(corners):
        fx, fy = nx / SCALE, ny / SCALE
        px, py = _lowest(left, low, fx, fy)
        yield fx * (px - x / SCALE) + fy * (py - y / SCALE), -fx, -fy


def gap_to(corners: Corners, ix: int, iy: int, x: int, y: int) -> float:
    """The widest gap between a body at (x, y) and a cell along an axis, lattice units."""
    gaps = enumerate(_gaps(corners, float(ix * UNIT - x), float(iy * UNIT - y)))
    return max(gap if k < 4 else gap / math.sqrt(nx * nx + ny * ny) for k, (gap, nx, ny) in gaps)


def away_from(corners: Corners, ix: int, iy: int, x: int, y: int) -> tuple[float, float]:
    """The axis along which a body and a cell are farthest apart, away from the cell."""
    left, low = float(ix * UNIT - x), float(iy * UNIT - y)
    best, away = -math.inf, (0.0, 0.0)
    for k, (scaled, nx, ny) in enumerate(_gaps(corners, left, low)):
        gap = scaled if k < 4 else scaled / math.sqrt(nx * nx + ny * ny)
        if gap > best:
            best, away = gap, (nx, ny)
    return away


def first_contact(
    cells: Cells, corners: Corners, ends: tuple[int, int, int, int], graze: float
) -> tuple[float, float, float]:
    """When a body that moves by (dx, dy) from (x, y) first touches a solid cell, and where from.

    Every gap is a linear function of time; the body overlaps a cell while all of them are negative.
    """
    x, y, dx, dy = (int(number) for number in ends)
    fx, fy = float(dx), float(dy)
    best, normal_x, normal_y = 2.0, 0.0, 0.0
    left, right, low, high = _reach(corners, dx, dy)
    height, width = cells.shape
    for iy in range(max((y + low) // UNIT, -1), min((y + high - 1) // UNIT, height) + 1):
        for ix in range(max((x + left) // UNIT, -1), min((x + right - 1) // UNIT, width) + 1):
            if cell_state(cells, ix, iy) != SOLID:
                continue
            enter, leave, last, nx, ny = -1.0, 2.0, 0.0, -fx, -fy
            for now, ax, ay in _gaps(corners, float(ix * UNIT - x), float(iy * UNIT - y)):
                closing = -ax * fx + -ay * fy
                if now >= -1e-9 * (abs(ax) + abs(ay)):
                    time = max(now, 0.0) / closing if closing > 0.0 else 2.0
                    if time >= enter:
                        enter, last, nx, ny = time, closing, ax, ay
                elif closing < 0.0:
                    leave = min(leave, now / closing)
            leave = min(leave, 1.0)
            if enter >= best or enter > 1.0 or enter > leave:
                continue
            if graze > 0.0 and (leave - enter) * last < graze * math.sqrt(nx * nx + ny * ny):
                continue
            best, normal_x, normal_y = max(enter, 0.0), nx, ny
    return best, normal_x, normal_y


def depth(corners: Corners, ends: tuple[int, int, int, int], ix: int, iy: int) -> float:
    """How deep a body cuts a cell on its way from p to q: the shortest way out of it."""
    px, py, qx, qy = (int(number) for number in ends)
    dx, dy = float(qx - px), float(qy - py)
    left, low = float(ix * UNIT - px), float(iy * UNIT - py)
    points = _floats(corners)
    xs, ys = zip(*points, strict=True)
    found = min(
        max(xs) + max(0.0, dx) - left,
        left + UNIT - min(xs) - min(0.0, dx),
        max(ys) + max(0.0, dy) - low,
        low + UNIT - min(ys) - min(0.0, dy),
    )
    for (x, y), (nx, ny) in _sides(corners):
        fx, fy = nx / SCALE, ny / SCALE
        ax, ay = _lowest(left, low, fx, fy)
        beyond = fx * (ax - x / SCALE) + fy * (ay - y / SCALE) - max(0.0, fx * dx + fy * dy)
        found = min(found, -beyond / math.sqrt(fx * fx + fy * fy))
    for fx, fy in ((-dy, dx), (dy, -dx)) if dx or dy else ():
        ax, ay = _lowest(left, low, fx, fy)
        beyond = min(fx * (ax - x) + fy * (ay - y) for x, y in points)
        found = min(found, -beyond / math.sqrt(fx * fx + fy * fy))
    return max(0.0, found)


def contains_axle(body: Corners) -> bool:
    """Whether the point that a pose is about is in the body."""
    return all(
        x * ny - y * nx >= 0 for (x, y), (nx, ny) in zip(body, body[1:] + body[:1], strict=True)
    )
