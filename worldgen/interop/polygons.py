"""Walls as polygons with holes, in the coordinates of a file: what maps and plans are made of."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    import shapely

__all__ = ["Polygon", "Ring", "cell_polygons"]

Ring: TypeAlias = list[tuple[int, int]]
Polygon: TypeAlias = list[Ring]


def cell_polygons(boxes: npt.NDArray[np.int64]) -> list[Polygon]:
    """Polygons that cover exactly the boxes; cells that touch at a corner only are polygons of their own.

    Args:
        boxes: (n, 4) int64, as :func:`worldgen.interop.boxes.merged_boxes` gives them; none overlap.

    Returns:
        Polygons in order of their first corners; each its outline, counter-clockwise, then its holes, clockwise;
        each ring from its lowest, leftmost corner on, in cells, without the corner repeated at its end.
    """
    import shapely

    union = shapely.union_all(shapely.box(*boxes.T.astype(np.float64)))  # whole numbers: exact
    parts = [part for part in shapely.get_parts(union) if isinstance(part, shapely.Polygon)]
    polygons = []
    for part in parts:
        holes = sorted(_ring(hole, clockwise=True) for hole in part.interiors)
        polygons.append([_ring(part.exterior, clockwise=False), *holes])
    return sorted(polygons)


def _ring(line: shapely.LinearRing, *, clockwise: bool) -> Ring:
    """The ring's corners, those on a straight line left out, turned and begun as all are."""
    points = np.asarray(line.coords)[:-1].astype(np.int64)
    ahead, behind = np.roll(points, -1, axis=0) - points, points - np.roll(points, 1, axis=0)
    corners = points[ahead[:, 0] * behind[:, 1] != ahead[:, 1] * behind[:, 0]]
    if line.is_ccw == clockwise:
        corners = corners[::-1]
    first = int(np.lexsort((corners[:, 0], corners[:, 1]))[0])  # the lowest, of these the leftmost
    return [(x, y) for x, y in np.roll(corners, -first, axis=0).tolist()]
