"""``covered``: the centre has been in every cell that the coverage task requires."""

from __future__ import annotations

from collections import deque

import numpy as np
import shapely

from fuzz.evidence_checks._plain import lattice_cell
from sim.evidence import CoveredEvidence
from sim.motion import Motion
from sim.trace import Trace
from worldgen.world import World

_ROUNDING = 1e-9  # m


def check_covered(world: World, trace: Trace, evidence: CoveredEvidence, motion: Motion) -> str:
    """Check that the last step enters a new cell, and that no other cell is left to visit.

    The cells are counted again with shapely: from the start's cell, each cell is reached from a
    neighbour by a straight line between their centres on which the disc is clear. Cells that can
    only be reached in another way are not searched for.
    """
    columns = lattice_cell(trace.x / world.cell_size).astype(np.int64)
    rows = lattice_cell(trace.y / world.cell_size).astype(np.int64)
    visited = set(zip(columns.tolist(), rows.tolist(), strict=True))
    before = set(zip(columns[:-1].tolist(), rows[:-1].tolist(), strict=True))
    if evidence.step != trace.steps or len(visited) == len(before):
        return f"step {evidence.step} does not end the run in a new cell"
    left = _cells_from(world, (int(columns[0]), int(rows[0]))) - visited
    if left:
        return f"cell {min(left)} can be reached and was not visited"
    if len(visited) < evidence.cells:
        return f"{len(visited)} cells were visited, fewer than the {evidence.cells} claimed"
    return ""


def _cells_from(world: World, first: tuple[int, int]) -> set[tuple[int, int]]:
    """Return the cells that straight lines between centres lead to, not counting the first."""
    # The checker must not share code with the core, so shapely decides what is clear.
    side = world.cell_size
    height, width = world.walls.shape
    grid = shapely.box(0.0, 0.0, width * side, height * side)
    solid = np.argwhere(world.walls)
    boxes = shapely.box(
        solid[:, 1] * side, solid[:, 0] * side, (solid[:, 1] + 1) * side, (solid[:, 0] + 1) * side
    )
    obstacles = shapely.union_all([*boxes, grid.exterior])
    shapely.prepare(obstacles)

    def is_clear(one: tuple[int, int], other: tuple[int, int]) -> bool:
        line = shapely.LineString([((x + 0.5) * side, (y + 0.5) * side) for x, y in (one, other)])
        return bool(shapely.distance(line, obstacles) >= world.robot_radius - _ROUNDING)

    # The robot does not even fit at the centre of its first cell.
    if world.walls[first[1], first[0]] or not is_clear(first, first):
        return set()
    # Breadth first over the four neighbours.
    found = {first}
    queue = deque([first])
    while queue:
        x, y = queue.popleft()
        for cell in ((x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)):
            inside = 0 <= cell[0] < width and 0 <= cell[1] < height
            if not inside or cell in found or world.walls[cell[1], cell[0]]:
                continue
            if is_clear((x, y), cell):
                found.add(cell)
                queue.append(cell)
    return found - {first}
