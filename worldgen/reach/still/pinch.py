"""Add edges through the narrowest places, which steps along axes and diagonals cannot pass.

Between two corners the widest path is their bisector: it starts at the middle of the gap, a
multiple of half a cell, and is perpendicular to the gap. A disc barely narrower than a slanting gap
passes only along this line, so the graph gets it as an extra edge.
"""

from __future__ import annotations

import math

import numpy as np

from worldgen.lattice import UNIT
from worldgen.reach.still.cut import rim_cells
from worldgen.reach.still.lattice_graph import Graph
from worldgen.reach.still.walls import Walls

# Limit on the gaps to examine, narrowest first.
_MOST = 20_000
# Points on either side of a gap's middle.
_STEPS = 16
# Cells; a gap wider than the disc by this much isn't narrow.
_WIDE = 2


def bridges(walls: Walls, graph: Graph) -> list[tuple[int, int]]:
    """Return pairs of nodes joined by a clear line: a gap's middle and a point on its bisector."""
    unit = UNIT // graph.k
    found = []
    for middle_x, middle_y, step_x, step_y in _slanting_gaps(walls, graph):
        for sign in (1, -1):
            for j in range(1, _STEPS + 1):
                x = middle_x + sign * j * step_x
                y = middle_y + sign * j * step_y
                if (
                    not (0 <= x < graph.stride and 0 <= y < graph.clear.shape[0])
                    or not graph.clear[y, x]
                ):
                    break
                if not walls.is_clear((middle_x * unit, middle_y * unit), (x * unit, y * unit)):
                    break
                found.append((middle_y * graph.stride + middle_x, y * graph.stride + x))
    return found


def _slanting_gaps(walls: Walls, graph: Graph) -> list[tuple[int, int, int, int]]:
    """Return clear middles (node x, y) of gaps at odd angles, with the bisector's step."""
    # Its cell (0, 0) is cell (-1, -1) of the grid.
    rim = rim_cells(walls.solid)
    rows, columns = rim.shape
    reach = math.ceil(2 * walls.radius) + _WIDE + 1
    half = graph.k // 2
    # List the gaps that are just wide enough, narrowest first.
    found = []
    gaps = [(gx, gy) for gx in range(1, reach) for gy in range(1, reach) if gx != gy]
    near = [
        gap
        for gap in gaps
        if (2 * walls.radius) ** 2 <= gap[0] ** 2 + gap[1] ** 2 <= (2 * walls.radius + _WIDE) ** 2
    ]
    for gx, gy in sorted(near, key=lambda gap: gap[0] ** 2 + gap[1] ** 2):
        dx = gx + 1
        dy = gy + 1
        common = math.gcd(gx, gy)
        if dx >= columns or dy >= rows:
            continue
        # Find pairs of cells with such a gap, in both slants.
        for sign in (1, -1):
            low = rim[: rows - dy]
            high = rim[dy:]
            both = (
                low[:, : columns - dx] & high[:, dx:]
                if sign > 0
                else low[:, dx:] & high[:, : columns - dx]
            )
            # Keep those whose middle is clear.
            for iy, ix in np.argwhere(both).tolist():
                left = ix + (0 if sign > 0 else dx) - 1
                x = half * (2 * left + 1 + sign * dx)
                y = half * (2 * (iy - 1) + 1 + dy)
                inside = 0 <= x < graph.stride and 0 <= y < graph.clear.shape[0]
                if inside and graph.clear[y, x]:
                    found.append((x, y, -gy // common, sign * gx // common))
            if len(found) > _MOST:
                return found
    return found
