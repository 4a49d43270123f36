"""Cut polygons into the rows of a grid, with shapely."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import shapely

from worldgen.errors import InvalidWorld

__all__ = ["cut_into_rows", "prepared", "row_pieces"]

# Depth, cells, up to which a shape only touches a cell, because coordinates are rounded.
TOUCH = 1e-6
# Limit on the corners; crossings grow with their square, and 500 random corners took minutes.
_MENDABLE = 8
# Half the width, cells, given to lines, because they stop robots too.
_LINE = 1e-3


def prepared(points: npt.NDArray[np.float64]) -> Any:
    """Return a valid shape of (n, 2) corners, in cells; two corners make a thin wall between them.

    Raises:
        InvalidWorld: If an outline of many corners crosses itself.
    """
    shape: Any = shapely.Polygon(points) if len(points) > 2 else shapely.LineString(points)
    if not shape.is_valid:
        if len(points) > _MENDABLE:
            raise InvalidWorld(
                "crosses-itself",
                "an outline of {corners} corners crosses itself",
                "draw it again, or as several",
                corners=len(points),
            )
        shape = shapely.make_valid(shape)
    if shape.area < TOUCH:
        shape = shapely.buffer(shape, _LINE)
    shapely.prepare(shape)
    return shape


def cut_into_rows(
    shape: Any, rows: slice, columns: slice
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return the cells of each row that the shape reaches into, and those left partly free.

    Args:
        shape: The shape, in cells.
        rows: Rows of the grid.
        columns: Columns of the grid.

    Returns:
        Two arrays (n, 3) int64 of row, first and end column, counted from the first row and column.
    """
    bands = shapely.box(
        columns.start,
        np.arange(rows.start, rows.stop),
        columns.stop,
        np.arange(rows.start, rows.stop) + 1,
    )
    inside = shapely.intersection(shape, bands)
    outside = shapely.difference(bands, shape)
    return row_pieces(inside, columns), row_pieces(outside, columns)


def row_pieces(parts: npt.NDArray[np.object_], columns: slice) -> npt.NDArray[np.int64]:
    """Yield row, first and end column of each piece of a row, without slivers."""
    pieces, index = shapely.get_parts(parts, return_index=True)
    # Collections contain the pieces.
    pieces, inner = shapely.get_parts(pieces, return_index=True)
    bounds = shapely.bounds(pieces)
    keep = (shapely.area(pieces) > TOUCH**2) & (bounds[:, 3] - bounds[:, 1] > TOUCH)
    first = np.floor(bounds[keep, 0] + TOUCH).astype(np.int64)
    end = np.ceil(bounds[keep, 2] - TOUCH).astype(np.int64)
    width = columns.stop - columns.start
    found = [
        index[inner][keep],
        np.clip(first - columns.start, 0, width),
        np.clip(end - columns.start, 0, width),
    ]
    return np.stack(found, axis=1)
