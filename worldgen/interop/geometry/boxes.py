"""Cover walls with few axis-aligned boxes, the parts of 3D worlds and meshes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from worldgen.support.arrays import Bools, Ints
from worldgen.timeline import CellState
from worldgen.world import World


class _Lines(NamedTuple):
    """Maximal lines through solid cells, along x, (n,) each.

    The fields are the row and both ends, as corners.
    """

    y: Ints
    begin: Ints
    end: Ints

    def only(self, which: Bools) -> _Lines:
        return _Lines(self.y[which], self.begin[which], self.end[which])


def merged_boxes(solid: Bools) -> Ints:
    """Cover the solid cells with as few boxes as possible, each cell exactly once.

    A corner of free cells that points into the walls needs a cut, and a cut from one such corner to
    another serves both. So as many of those as possible are made first, without any two touching: a
    largest independent set in a bipartite graph. A 61 x 61 maze of 1,323 solid cells becomes 243
    boxes; joining runs row by row gives 288.

    Args:
        solid: (height, width) bool, row 0 the lowest y.

    Returns:
        (n, 4) int64, rows (ix, iy, ix end, iy end) in cells, ends exclusive; sorted by iy, then ix.

    Source: Tatsuo Ohtsuki, "Minimum dissection of rectilinear regions", Proc. IEEE ISCAS 1982.
    """
    padded = np.pad(solid, 1)
    corner = (
        padded[:-1, :-1].view(np.int8) + padded[:-1, 1:] + padded[1:, :-1] + padded[1:, 1:]
    ) == 3
    level = _lines(padded)
    upright = _lines(padded.T)
    level_joins, upright_joins = (
        lines.only(at[lines.y, lines.begin] & at[lines.y, lines.end])
        for lines, at in ((level, corner), (upright, corner.T))
    )
    keep_level, keep_upright = _apart(level_joins, upright_joins, corner.shape)
    along = level_joins.only(keep_level)
    across = upright_joins.only(keep_upright)
    # Corners where a cut begins or ends need no further cut.
    for lines, at in ((along, corner), (across, corner.T)):
        at[lines.y, lines.begin] = at[lines.y, lines.end] = False
    crossed = _corners_on(across, (corner.shape[1], corner.shape[0])).T >= 0
    level_cut = _edges_on(along, corner.shape)
    upright_cut = _edges_on(across, corner.shape[::-1]).T
    _cut_from_corners(level, corner, crossed, level_cut)
    return _rectangles(padded, level_cut, upright_cut)


def _lines(padded: Bools) -> _Lines:
    """Return the lines between rows of cells that are both solid."""
    height, width = padded.shape
    inside = np.zeros((height - 1, width + 1), np.int8)
    inside[:, 1:] = padded[:-1] & padded[1:]
    # x counts padded cells, so it is one more than the left corner's.
    edges = np.diff(inside, axis=1)
    y, begin = np.nonzero(edges == 1)
    return _Lines(y, begin - 1, np.nonzero(edges == -1)[1] - 1)


def _spread(lines: _Lines, more: int) -> tuple[Ints, Ints, Ints]:
    """Return one entry for every corner of every line (``more`` = 1), or every edge (0).

    The result is the line's number, y and x.
    """
    lengths = lines.end - lines.begin + more
    number = np.repeat(np.arange(len(lengths)), lengths)
    along = np.arange(len(number)) - np.repeat(np.cumsum(lengths) - lengths, lengths)
    return number, lines.y[number], lines.begin[number] + along


def _corners_on(lines: _Lines, shape: tuple[int, ...]) -> Ints:
    """Return the line that each corner is on, -1 for none."""
    on = np.full(shape, -1, np.int64)
    number, y, x = _spread(lines, 1)
    on[y, x] = number
    return on


def _edges_on(lines: _Lines, shape: tuple[int, ...]) -> Bools:
    on = np.zeros(shape, np.bool_)
    _, y, x = _spread(lines, 0)
    on[y, x] = True
    return on


def _apart(level: _Lines, upright: _Lines, shape: tuple[int, ...]) -> tuple[Bools, Bools]:
    """Return a largest set of lines that do not touch, as masks over those along x and along y.

    It follows from a largest matching by Koenig's theorem. The nodes reachable from unmatched ones
    are the same for every such matching, so the answer does not depend on which one SciPy finds.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import breadth_first_order, maximum_bipartite_matching

    # Two lines touch if they share a corner.
    first = _corners_on(level, shape)
    second = _corners_on(upright, shape[::-1]).T
    meet = (first >= 0) & (second >= 0)
    one = first[meet]
    other = second[meet]
    along = len(level.y)
    across = len(upright.y)
    if not len(one):
        return np.ones(along, np.bool_), np.ones(across, np.bool_)
    touching = csr_array((np.ones(len(one), np.int8), (one, other)), shape=(along, across))
    mate = maximum_bipartite_matching(touching, perm_type="column")

    # Alternating paths: from node 0 to the unmatched lines along x, from there to every line that
    # they touch, and back from a line along y to its mate.
    matched = np.flatnonzero(mate >= 0)
    alone = np.flatnonzero(mate < 0)
    begins = np.concatenate([np.zeros(len(alone), np.int64), 1 + one, 1 + along + mate[matched]])
    ends = np.concatenate([1 + alone, 1 + along + other, 1 + matched])
    count = 1 + along + across
    paths = csr_array((np.ones(len(begins), np.int8), (begins, ends)), shape=(count, count))
    reached = np.zeros(count, np.bool_)
    reached[breadth_first_order(paths, 0, return_predecessors=False)] = True
    return reached[1 : 1 + along], ~reached[1 + along :]


def _cut_from_corners(level: _Lines, corner: Bools, crossed: Bools, cut: Bools) -> None:
    """Cut along x from the remaining corners to the next wall's end or cut."""
    rest = level.only(corner[level.y, level.begin] | corner[level.y, level.end])
    for y, begin, end in zip(rest.y.tolist(), rest.begin.tolist(), rest.end.tolist(), strict=True):
        stops = np.flatnonzero(crossed[y, begin + 1 : end]) + begin + 1
        if corner[y, begin]:
            cut[y, begin : int(stops[0]) if len(stops) else end] = True
        if corner[y, end]:
            cut[y, int(stops[-1]) if len(stops) else begin : end] = True


def _rectangles(padded: Bools, level_cut: Bools, upright_cut: Bools) -> Ints:
    """Return the boxes, each from its lower-left cell to the next edges on the right and above."""
    solid = padded[1:-1, 1:-1]
    below = ~(padded[:-1, 1:-1] & padded[1:, 1:-1]) | level_cut[:, :-1]
    left = ~(padded[1:-1, :-1] & padded[1:-1, 1:]) | upright_cut[:-1]
    iy, ix = np.nonzero(solid & below[:-1] & left[:, :-1])
    return np.stack([ix, iy, _next(left, iy, ix), _next(below.T, ix, iy)], axis=1).astype(np.int64)


def _next(edge: Bools, row: Ints, place: Ints) -> Ints:
    """Return the first edge after a place for each of some rows."""
    length = edge.shape[1]
    flat = np.flatnonzero(edge)
    after: Ints = flat[np.searchsorted(flat, row * length + place, side="right")] % length
    return after


def always_solid(world: World) -> Bools:
    """Return the cells that are solid at all times, (height, width) bool.

    In a static world these are its walls.
    """
    opened = world.timeline.after(0.0).cells_that_become(
        CellState.FREE, CellState.BURNING, shape=world.walls.shape
    )
    always: Bools = (world.cells_at(0.0) == CellState.SOLID) & ~opened
    return always


def closing_boxes(world: World) -> Ints:
    """Return boxes one cell thick around the grid, because everything outside it is solid.

    There are none if the world's border is already closed.

    Returns:
        (0 or 4, 4) int64 as :func:`merged_boxes`, with cells -1 and beyond the sides.
    """
    walls = always_solid(world)
    width = world.width
    height = world.height
    if walls[0].all() and walls[-1].all() and walls[:, 0].all() and walls[:, -1].all():
        return np.zeros((0, 4), np.int64)
    right = width + 1
    top = height + 1
    ring = [
        (-1, -1, right, 0),
        (-1, 0, 0, height),
        (width, 0, right, height),
        (-1, height, right, top),
    ]
    return np.array(ring, np.int64)
