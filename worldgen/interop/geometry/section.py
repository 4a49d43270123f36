"""Cut triangles horizontally into cells: what a lidar at that height would see.

Closed bodies are solid inside: a cell's centre is inside if the outward-facing surfaces around it
wind around it more often than the others, so a building whose rooms are cavities has free rooms. A
cell that a surface passes through is solid too. Open bodies have no inside; their surfaces are
walls without thickness.

trimesh 5.2 needs another compiled library, rtree, to make polygons of a section, so the cut is made
here.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from worldgen.errors import InvalidWorld
from worldgen.support.arrays import Bools, Floats, Ints

# Half the thickness, cells, given to a wall that has none; on a line it blocks both sides.
_SHEET = 1e-3
# Depth in cells up to which an outline only touches a cell, because coordinates are rounded.
_TOUCH = 1e-6
# The same as a fraction of the largest coordinate: meshes are mostly stored as float32.
_ROUNDED = 2.0**-22
# Rows of cells that all segments together may pass.
_MOST_VISITS = 400_000_000
# Rows examined together.
_CHUNK = 2_000_000


class Bodies(NamedTuple):
    """Triangles sorted by whether they enclose a volume.

    Args:
        vertices: (n, 3) float64.
        closed: (m, 3) int64: triangles of closed bodies, counter-clockwise seen from outside.
        sheets: (k, 3) int64: triangles of all others; the first are those of open bodies, the last
            those that occur in both orientations, which are walls without thickness.
        open_faces: Number of triangles of open bodies.
        closed_count: Number of closed bodies.
        open_count: Number of open bodies.
    """

    vertices: Floats
    closed: Ints
    sheets: Ints
    open_faces: int
    closed_count: int
    open_count: int


class Section(NamedTuple):
    """Segments in the plane, (n, 2, 2) float64: from, to; x, y.

    Args:
        closed: Segments around volumes, which are on their left.
        sheets: All other segments.
    """

    closed: Floats
    sheets: Floats


def sort_bodies(vertices: Floats, faces: Ints) -> Bodies:
    """Sort triangles into closed bodies and sheets.

    Vertices at the same place count as one, no matter which part of the file they come from, so a
    wall of two materials is still one body. A body is closed if each of its edges runs as often one
    way as the other.

    Args:
        vertices: (n, 3) float64, finite.
        faces: (m, 3) int64, valid indices.
    """
    # Merge vertices that are equal to the last bit; adding zero turns -0.0 into 0.0.
    _, first, place = np.unique(_as_records(vertices + 0.0), return_index=True, return_inverse=True)
    vertices = vertices[first]
    faces = place.reshape(-1)[faces]
    proper = (
        (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    )
    faces, both_sides = _without_copies(faces[proper])

    # A body is a set of triangles connected by vertices; it is closed if its edges cancel out.
    body, count = _components(len(vertices), faces)
    unbalanced = np.zeros(count, np.bool_)
    unbalanced[body[_lone_edges(len(vertices), faces)]] = True
    is_open = unbalanced[body[faces[:, 0]]] if len(faces) else np.zeros(0, np.bool_)
    closed = faces[~is_open]
    sheets = np.concatenate([faces[is_open], both_sides])
    sheet_bodies, sheet_count = _components(len(vertices), sheets)
    return Bodies(
        vertices,
        closed,
        sheets,
        int(np.count_nonzero(is_open)),
        len(np.unique(body[closed[:, 0]])),
        len(np.unique(sheet_bodies[sheets[:, 0]])) if sheet_count else 0,
    )


def _as_records(rows: npt.NDArray[np.generic]) -> npt.NDArray[np.void]:
    """Return rows as single values, so that equal rows can be found."""
    whole = np.ascontiguousarray(rows)
    return whole.view(np.dtype((np.void, whole.dtype.itemsize * whole.shape[1]))).reshape(-1)


def _without_copies(faces: Ints) -> tuple[Ints, Ints]:
    """Return each triangle once, and separately those that occur in both orientations.

    Those are walls without thickness.
    """
    order = np.argsort(faces, axis=1)
    corners = np.take_along_axis(faces, order, axis=1)
    # The orders 012, 120 and 201 are rotated, not mirrored.
    even = np.isin(order[:, 0] * 9 + order[:, 1] * 3 + order[:, 2], (5, 15, 19))
    _, first, place = np.unique(_as_records(corners), return_index=True, return_inverse=True)
    net = np.bincount(place.reshape(-1), weights=np.where(even, 1.0, -1.0), minlength=len(first))
    once = corners[first]
    once[net < 0] = once[net < 0][:, ::-1]
    return once[net != 0], once[net == 0]


def _components(count: int, faces: Ints) -> tuple[Ints, int]:
    """Return the number of each vertex's connected part, and the number of parts."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    if not len(faces):
        return np.zeros(count, np.int64), 0
    begin = np.concatenate([faces[:, 0], faces[:, 1]])
    end = np.concatenate([faces[:, 1], faces[:, 2]])
    graph = coo_array((np.ones(len(begin), np.int8), (begin, end)), shape=(count, count))
    parts, labels = connected_components(graph, directed=False)
    return labels.astype(np.int64), int(parts)


def _lone_edges(count: int, faces: Ints) -> Ints:
    """Return a vertex of each edge that more triangles pass one way than the other."""
    begin = faces.reshape(-1)
    end = faces[:, [1, 2, 0]].reshape(-1)
    low = np.minimum(begin, end)
    edges, place = np.unique(low * count + np.maximum(begin, end), return_inverse=True)
    net = np.bincount(
        place.reshape(-1), weights=np.where(begin == low, 1.0, -1.0), minlength=len(edges)
    )
    lone: Ints = edges[net != 0] // max(count, 1)
    return lone


def open_count(bodies: Bodies, height: float) -> int:
    """Return the number of open bodies of which a missing triangle might be at a height.

    A hole is somewhere between the lowest and the highest corner of its body.
    """
    faces = bodies.sheets[: bodies.open_faces]
    if not len(faces):
        return 0
    labels, count = _components(len(bodies.vertices), faces)
    body = np.repeat(labels[faces[:, 0]], 3)
    levels = bodies.vertices[faces.reshape(-1), 2]
    low = np.full(count, np.inf)
    high = np.full(count, -np.inf)
    np.minimum.at(low, body, levels)
    np.maximum.at(high, body, levels)
    return int(np.count_nonzero((low <= height) & (high > height)))


def cut(bodies: Bodies, height: float) -> Section:
    """Cut bodies just above a height, so that no vertex is in the plane.

    Both triangles at an edge get the same point of it, to the last bit, so outlines of closed
    bodies are closed.
    """
    return Section(
        _segments(bodies.vertices, bodies.closed, height),
        _segments(bodies.vertices, bodies.sheets, height),
    )


def _segments(vertices: Floats, faces: Ints, height: float) -> Floats:
    above = vertices[:, 2] > height
    sides = above[faces]
    faces = faces[(sides.any(axis=1)) & ~(sides.all(axis=1))]
    sides = above[faces]

    # One edge of each such triangle rises through the plane and one sinks; the inside is to the
    # left of the direction from the sinking to the rising one.
    after = np.roll(sides, -1, axis=1)
    following = np.roll(faces, -1, axis=1)
    rows = np.arange(len(faces))
    ends = []
    for crossing in (sides & ~after, ~sides & after):
        column = np.argmax(crossing, axis=1)
        ends.append(_crossings(vertices, faces[rows, column], following[rows, column], height))
    return np.stack(ends, axis=1) if len(faces) else np.zeros((0, 2, 2))


def _crossings(vertices: Floats, one: Ints, other: Ints, height: float) -> Floats:
    """Return where edges cross a height, computed from the vertex with the lower number."""
    begin = vertices[np.minimum(one, other)]
    end = vertices[np.maximum(one, other)]
    share = (height - begin[:, 2]) / (end[:, 2] - begin[:, 2])
    points: Floats = begin[:, :2] + share[:, None] * (end[:, :2] - begin[:, :2])
    return points


def outlines(rings: list[Floats]) -> Section:
    """Return the section of a body with these outlines, of which those within others are holes.

    Args:
        rings: Corners of each, (n, 2), m, in any direction.

    Raises:
        InvalidWorld: If one crosses itself.
    """
    import shapely
    from shapely.geometry.polygon import orient

    shapes: list[Any] = [shapely.Polygon(ring) for ring in rings]
    if not all(shape.is_valid for shape in shapes):
        raise InvalidWorld("crosses-itself", "an outline crosses itself", "draw it as several")
    shape = functools.reduce(shapely.symmetric_difference, shapes)
    segments = [np.zeros((0, 2, 2))]
    # The inside is on the left of an outline, and of the outline of a hole.
    for part in map(orient, shapely.get_parts(shape)):
        for ring in (part.exterior, *part.interiors):
            corners = np.asarray(ring.coords)
            segments.append(np.stack([corners[:-1], corners[1:]], axis=1))
    return Section(np.concatenate(segments), segments[0])


def slack(furthest: float) -> float:
    """Return the largest rounding error, cells, of coordinates this far from the file's origin."""
    return min(_TOUCH + _ROUNDED * furthest, 0.01)


def paint(section: Section, width: int, height: int, touch: float) -> Bools:
    """Return the cells that a section fills.

    Args:
        section: The section, in cells from the grid's corner.
        width: Width of the grid, cells.
        height: Height of the grid, cells.
        touch: Depth, cells, up to which an outline only touches a cell, because coordinates are
            rounded.

    Returns:
        (height, width) bool, row 0 the lowest.

    Raises:
        InvalidWorld: If it would take minutes.
    """
    return fill(section, width, height, touch)[0]


def fill(section: Section, width: int, height: int, touch: float) -> tuple[Bools, Bools]:
    """Return the cells that a section fills, and those of them that no outline passes through.

    Args, Raises: As :func:`paint`.
    """
    inside = _insides(section.closed, width, height)
    passed = _passed(section.closed, width, height, touch)
    passed |= _passed(section.sheets, width, height, -_SHEET)
    return inside | passed, inside & ~passed


def _insides(segments: Floats, width: int, height: int) -> Bools:
    """Return the cells whose centres the outlines wind around."""
    turns = np.zeros((height, width + 1), np.int32)
    low = np.minimum(segments[:, 0, 1], segments[:, 1, 1])
    high = np.maximum(segments[:, 0, 1], segments[:, 1, 1])

    # Find the rows whose centre line a segment crosses: low <= row + 1/2 < high.
    first = np.ceil(low - 0.5)
    end = np.ceil(high - 0.5)
    for which, row in _rows(first, end, height):
        ax, ay = segments[which, 0].T
        bx, by = segments[which, 1].T
        x = ax + (row + 0.5 - ay) / (by - ay) * (bx - ax)
        column = np.clip(np.ceil(x - 0.5), 0, width).astype(np.int64)
        np.add.at(turns, (row, column), np.where(by > ay, -1, 1).astype(np.int32))
    np.cumsum(turns, axis=1, out=turns)
    return turns[:, :width] > 0


def _passed(segments: Floats, width: int, height: int, touch: float) -> Bools:
    """Return the cells that segments pass through."""
    runs = np.zeros((height, width + 1), np.int32)
    low = np.minimum(segments[:, 0, 1], segments[:, 1, 1])
    high = np.maximum(segments[:, 0, 1], segments[:, 1, 1])
    for which, row in _rows(np.floor(low + touch), np.ceil(high - touch), height):
        # Clip the segment to the row, then find the columns that the clipped part reaches into.
        ax, ay = segments[which, 0].T
        bx, by = segments[which, 1].T
        level = ay == by
        rise = np.where(level, 1.0, by - ay)
        near = np.where(level, 0.0, np.clip((row - ay) / rise, 0.0, 1.0))
        far = np.where(level, 1.0, np.clip((row + 1 - ay) / rise, 0.0, 1.0))
        x_near = ax + near * (bx - ax)
        x_far = ax + far * (bx - ax)
        first = np.clip(np.floor(np.minimum(x_near, x_far) + touch), 0, width).astype(np.int64)
        end = np.clip(np.ceil(np.maximum(x_near, x_far) - touch), 0, width).astype(np.int64)
        some = end > first
        np.add.at(runs, (row[some], first[some]), np.int32(1))
        np.add.at(runs, (row[some], end[some]), np.int32(-1))
    np.cumsum(runs, axis=1, out=runs)
    return runs[:, :width] > 0


def _rows(first: Floats, end: Floats, height: int) -> Iterator[tuple[Ints, Ints]]:
    """Yield pairs of a segment and a row for rows ``first`` to ``end``, millions at a time."""
    # Keep the rows that are in the grid, and limit their number.
    begin = np.clip(first, 0, height).astype(np.int64)
    counts = np.maximum(np.clip(end, 0, height).astype(np.int64) - begin, 0)
    totals = np.cumsum(counts)
    if len(totals) and totals[-1] > _MOST_VISITS:
        raise InvalidWorld(
            "too-large", "the mesh's outlines pass too many cells", "use a larger cell_size"
        )
    # Yield as many segments at a time as fit into a chunk.
    at = 0
    while at < len(counts):
        done = totals[at - 1] if at else 0
        stop = max(int(np.searchsorted(totals, done + _CHUNK, side="right")), at + 1)
        which = np.repeat(np.arange(at, stop), counts[at:stop])
        offset = np.arange(len(which)) - np.repeat(
            totals[at:stop] - counts[at:stop] - done, counts[at:stop]
        )
        yield which, begin[which] + offset
        at = stop
