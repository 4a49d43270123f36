"""Straight lines through the cells of a world: range beams, and walls between a place and the target."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from sim.kernels._jit import kernel, rare_kernel
from sim.kernels.geometry import cell_state
from sim.kernels.layout import SOLID, TURN, UNIT

__all__ = ["beam_heading", "ray_distance", "walls_on_the_way"]

Cells = npt.NDArray[np.uint8]

_FAR = 1e300


@kernel
def _next_line(place: int, cell: int, direction: float) -> float:
    """Distance along a ray from a coordinate to the side of its cell that the ray makes for."""
    if direction > 0.0:
        return float((cell + 1) * UNIT - place) / direction
    if direction < 0.0:
        return float(cell * UNIT - place) / direction
    return _FAR


@kernel
def _cosine(headings: npt.NDArray[np.int64], heading: int) -> float:
    """Of a heading, right to the last bits."""
    place = heading % TURN
    return float(headings[place]) / (1 << 30) + float(headings[TURN + place]) / (1 << 60)


@rare_kernel
def ray_distance(cells: Cells, headings: npt.NDArray[np.int64], x: int, y: int, heading: int, longest: float) -> float:
    """Distance from a place to the first solid cell in a direction, lattice units; ``longest`` if that is nearer.

    A ray that runs along a face, or past a single corner, goes on; between two cells that touch at a corner it
    does not. Each distance is one exact difference divided by a direction, so errors do not add up.

    Source: John Amanatides and Andrew Woo, "A fast voxel traversal algorithm for ray tracing", Eurographics 1987.
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
            both = cell_state(cells, ix + step_x, iy) == SOLID and cell_state(cells, ix, iy + step_y) == SOLID
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


@rare_kernel
def walls_on_the_way(cells: Cells, x: int, y: int, to_x: int, to_y: int) -> int:
    """How many solid cells the straight line between two places goes through, its ends' cells not counted.

    Decided in integers: of the next column's and the next row's line, the one that comes first on the way is
    crossed; where both meet the line passes through the corner.
    """
    ix, iy, last_x, last_y = x // UNIT, y // UNIT, to_x // UNIT, to_y // UNIT
    dx, dy = abs(to_x - x), abs(to_y - y)
    step_x, step_y = (1 if to_x > x else -1), (1 if to_y > y else -1)
    count = 0
    while ix != last_x or iy != last_y:
        line_x = (ix + 1) * UNIT - x if step_x > 0 else x - ix * UNIT
        line_y = (iy + 1) * UNIT - y if step_y > 0 else y - iy * UNIT
        first_x, first_y = line_x * dy, line_y * dx  # both times dx * dy: how far along the way each line is
        if iy == last_y or (ix != last_x and first_x <= first_y):
            ix += step_x
            if first_x == first_y and iy != last_y:
                iy += step_y
        else:
            iy += step_y
        if (ix != last_x or iy != last_y) and cell_state(cells, ix, iy) == SOLID:
            count += 1
    return count


@kernel
def beam_heading(heading: int, beam: int, beams: int, field: float) -> int:
    """World heading of a beam: spread evenly over ``field`` about the robot's heading, over a whole turn from it."""
    if field >= float(TURN):
        return heading + int(math.floor(float(beam) * TURN / beams + 0.5))
    if beams == 1:
        return heading
    return heading + int(math.floor((float(beam) / (beams - 1) - 0.5) * field + 0.5))
