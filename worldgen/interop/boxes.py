"""Walls as few axis-aligned boxes: what 3D simulators and meshes are built of."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from worldgen.world import World

__all__ = ["closing_boxes", "merged_boxes"]


def merged_boxes(solid: npt.NDArray[np.bool_]) -> npt.NDArray[np.int64]:
    """Boxes that cover the solid cells, each exactly once.

    Greedy: runs of cells along x, the same run in row after row joined along y. A 61 x 61 maze of 1,922 solid
    cells becomes some 480 boxes.

    Args:
        solid: (height, width) bool, row 0 the lowest y.

    Returns:
        (n, 4) int64, rows (ix, iy, ix end, iy end) in cells, ends exclusive; sorted by iy, then ix.
    """
    height = solid.shape[0]
    padded = np.zeros((height + 1, solid.shape[1] + 2), np.int8)
    padded[:height, 1:-1] = solid
    edges = np.diff(padded, axis=1)
    rows, begins = np.nonzero(edges == 1)
    ends = np.nonzero(edges == -1)[1]
    boxes: list[tuple[int, int, int, int]] = []
    open_runs: dict[tuple[int, int], int] = {}
    bounds = np.searchsorted(rows, np.arange(height + 2))
    for iy in range(height + 1):
        here = slice(bounds[iy], bounds[iy + 1])
        runs = dict.fromkeys(zip(begins[here].tolist(), ends[here].tolist(), strict=True), iy)
        for run in [run for run in open_runs if run not in runs]:
            boxes.append((run[0], open_runs.pop(run), run[1], iy))
        for run, begin in runs.items():
            open_runs.setdefault(run, begin)
    return np.array(sorted(boxes, key=lambda box: (box[1], box[0])), np.int64).reshape(-1, 4)


def closing_boxes(world: World) -> npt.NDArray[np.int64]:
    """Boxes one cell thick round the grid, for outside it everything is solid; none where its border is closed.

    Returns:
        (0 or 4, 4) int64 as :func:`merged_boxes`, with cells -1 and beyond the sides.
    """
    walls, width, height = world.walls, world.width, world.height
    if walls[0].all() and walls[-1].all() and walls[:, 0].all() and walls[:, -1].all():
        return np.zeros((0, 4), np.int64)
    right, top = width + 1, height + 1
    ring = [(-1, -1, right, 0), (-1, 0, 0, height), (width, 0, right, height), (-1, height, right, top)]
    return np.array(ring, np.int64)
