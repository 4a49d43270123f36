"""Straight lines through the cells of a world.

Range beams, and walls between a place and the target.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from tests.reference.sim.geometry import cell_state
from tests.reference.sim.layout import BURNING, SOLID, TURN, UNIT

Cells = npt.NDArray[np.uint8]

_FAR = 1e300


def _next_line(place: int, cell: int, direction: float) -> float:
    """Distance along a ray from a coordinate to the side of its cell that the ray approaches."""
    if direction > 0.0:
        return float((cell + 1) * UNIT - place) / direction
    if direction < 0.0:
        return float(cell * UNIT - place) / direction
    return _FAR


def _cosine(headings: npt.NDArray[np.int64], heading: int) -> float:
    """Direction of a heading, correct to the last bits."""
    place = heading % TURN
    return float(headings[place]) / (1 << 30) + float(headings[TURN + place]) / (1 << 60)


def ray_distance(
    cells: Cells, headings: npt.NDArray[np.int64], x: int, y: int, heading: int, longest: float
) -> float:
    """Distance from a place to the first solid cell in a direction, lattice units.

    ``longest`` if that is nearer. A ray that runs along a face, or past a single corner, continues;
    between two cells that touch at a corner it stops. Each distance is one exact difference divided
    by a direction, so errors do not add up.

    Source: John Amanatides and Andrew Woo, "A fast voxel traversal algorithm for ray tracing",
        Eurographics 1987.
    """
    along, across = _cosine(headings, heading), _cosine(headings, heading - TURN // 4)
    ix, iy = x // UNIT, y // UNIT
    if along < 0.0 and x == ix * UNIT:
        ix -= 1
    if across < 0.0 and y == iy * UNIT:
        iy -= 1
    step_x, step_y = (1 if along > 0.0 else -1), (1 if across > 0.0 else -1)
    while True:
        to_x, to_y = _next_line(x, ix, along), _next_line(y, iy, across)
        at = min(to_x, to_y)
        if at >= longest:
            return longest
        if to_x == to_y:
            both = (
                cell_state(cells, ix + step_x, iy) == SOLID
                and cell_state(cells, ix, iy + step_y) == SOLID
            )
            ix, iy = ix + step_x, iy + step_y
            if both or cell_state(cells, ix, iy) == SOLID:
                return at
        else:
            if to_x < to_y:
                ix += step_x
            else:
                iy += step_y
            if cell_state(cells, ix, iy) == SOLID:
                return at


def _next_cell(
    x: int, y: int, to_x: int, to_y: int, cell: tuple[int, int], last: tuple[int, int]
) -> tuple[int, int]:
    """Return the next cell on the straight line between two places.

    This is decided in integers: of the next column border and the next row border, the line crosses
    the one that comes first; if both coincide, the line passes through the corner.
    """
    ix, iy = cell
    dx, dy = abs(to_x - x), abs(to_y - y)
    step_x, step_y = (1 if to_x > x else -1), (1 if to_y > y else -1)
    line_x = (ix + 1) * UNIT - x if step_x > 0 else x - ix * UNIT
    line_y = (iy + 1) * UNIT - y if step_y > 0 else y - iy * UNIT
    first_x, first_y = (
        line_x * dy,
        line_y * dx,
    )  # both times dx * dy: how far along the line each border is
    if iy == last[1] or (ix != last[0] and first_x <= first_y):
        ix += step_x
        if first_x == first_y and iy != last[1]:
            iy += step_y
    else:
        iy += step_y
    return ix, iy


def walls_on_the_way(cells: Cells, x: int, y: int, to_x: int, to_y: int) -> int:
    """Return how many solid cells the straight line between two places goes through, not counting
    the cells of its ends.
    """
    cell, last = (x // UNIT, y // UNIT), (to_x // UNIT, to_y // UNIT)
    count = 0
    while cell[0] != last[0] or cell[1] != last[1]:
        cell = _next_cell(x, y, to_x, to_y, cell, last)
        if (cell[0] != last[0] or cell[1] != last[1]) and cell_state(
            cells, cell[0], cell[1]
        ) == SOLID:
            count += 1
    return count


def _in_smoke(cells: Cells, ix: int, iy: int, reach: int) -> bool:
    """Return whether a cell burns, or one around it within reach of smoke."""
    for jy in range(max(iy - reach, 0), min(iy + reach + 1, cells.shape[0])):
        for jx in range(max(ix - reach, 0), min(ix + reach + 1, cells.shape[1])):
            if cells[jy, jx] == BURNING:
                return True
    return False


def smoke_on_the_way(cells: Cells, x: int, y: int, to_x: int, to_y: int, reach: int) -> int:
    """Return how many cells of the straight line between two places are in smoke, including the
    cells of its ends.
    """
    cell, last = (x // UNIT, y // UNIT), (to_x // UNIT, to_y // UNIT)
    count = 1 if _in_smoke(cells, cell[0], cell[1], reach) else 0
    while cell[0] != last[0] or cell[1] != last[1]:
        cell = _next_cell(x, y, to_x, to_y, cell, last)
        if _in_smoke(cells, cell[0], cell[1], reach):
            count += 1
    return count


def beam_heading(heading: int, beam: int, beams: int, field: float) -> int:
    """World heading of a beam.

    Beams are spread evenly over ``field`` around the robot's heading, or over a whole turn starting
    at it.
    """
    if field >= float(TURN):
        return heading + math.floor(float(beam) * TURN / beams + 0.5)
    if beams == 1:
        return heading
    return heading + math.floor((float(beam) / (beams - 1) - 0.5) * field + 0.5)
