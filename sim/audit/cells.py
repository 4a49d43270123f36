"""Find the cells near a piece of a path, and the times at which they are solid or burning.

Lookups go through tables made with numpy and scipy alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from sim.audit.geometry import Parts
from worldgen.support.arrays import Bools, Floats, Indices, Ints
from worldgen.timeline import CellState
from worldgen.world import World


@dataclass(frozen=True)
class Pairs:
    """Pieces of the path and the cells near them, (n,) each.

    Args:
        piece: Row of the piece.
        ix: Column of the cell; -1 and the grid's width mean the outside.
        iy: Row of the cell; -1 and the grid's height mean the outside.
        span: Row of the time span in :class:`Surroundings`; -1 if the cell is always solid.
    """

    piece: Indices
    ix: Ints
    iy: Ints
    span: Indices

    def take(self, rows: Indices | Bools) -> Pairs:
        """Return some of the pairs."""
        return Pairs(self.piece[rows], self.ix[rows], self.iy[rows], self.span[rows])

    def followed_by(self, other: Pairs) -> Pairs:
        """Return these pairs and the others, in one record."""
        names = ("piece", "ix", "iy", "span")
        both = ((getattr(self, name), getattr(other, name)) for name in names)
        return Pairs(*map(np.concatenate, both))


class Surroundings:
    """A world's cells over time, in tables that answer which of them are near a path.

    The grid is ringed with solid cells that mean the outside. Cells that never change are
    found through tables of the nearest solid cell to the left and to the right: in each row only
    these can be nearest, so a large disc need not visit its whole area. Cells that change have
    spans of time, in order of cell and time.

    Args:
        world: The world whose cells these are.
    """

    def __init__(self, world: World) -> None:
        self.height, self.width = world.walls.shape
        changing = world.changing_cells

        # For each cell of the ringed grid, the columns of the nearest solid cells on both sides.
        self._still = np.pad(world.walls & ~changing, 1, constant_values=True)
        columns = np.arange(self.width + 2, dtype=np.int32)
        ahead = np.where(self._still, columns, np.int32(self.width + 1))
        self._left = np.maximum.accumulate(np.where(self._still, columns, np.int32(0)), axis=1)
        self._right = np.minimum.accumulate(ahead[:, ::-1], axis=1)[:, ::-1]
        self._spans_of(world)

        # When looking for cells that are ever blocked, skip pieces that stay far from all of them.
        blocked = self._still.copy()
        blocked[1:-1, 1:-1] |= changing
        self._far = ndimage.distance_transform_cdt(~blocked, metric="chessboard")

    def _spans_of(self, world: World) -> None:
        """Set ``since``, ``until`` (s) and ``state`` of the spans in which cells are blocked."""
        spans = world.timeline.spans(world.walls)
        kept = spans.states != CellState.FREE
        self.since = spans.since[kept]
        self.until = spans.until[kept]
        self.state = spans.states[kept]
        cell = spans.cells[kept]

        # Number the changing cells, and note which spans belong to each.
        used, self._first = np.unique(cell, return_index=True)
        self._end = np.append(self._first[1:], len(cell))
        self._changing = np.full(world.walls.shape, -1, np.int32)
        self._changing[used // self.width, used % self.width] = np.arange(len(used), dtype=np.int32)
        self._far_changing = None
        if len(used):
            self._far_changing = ndimage.distance_transform_cdt(
                self._changing < 0, metric="chessboard"
            )

    def span(self, row: int) -> tuple[float, float]:
        """Return the ends of a time span, s; -inf and inf if the cell is always solid."""
        return (
            (float(self.since[row]), float(self.until[row])) if row >= 0 else (-math.inf, math.inf)
        )

    def solid_spans(self, ix: int, iy: int) -> list[tuple[float, float]]:
        """Return the times when a cell is solid, s; the outside always is."""
        if self._still[iy + 1, ix + 1]:
            return [(-math.inf, math.inf)]
        cell = int(self._changing[iy, ix])
        rows = range(self._first[cell], self._end[cell]) if cell >= 0 else ()
        return [self.span(row) for row in rows if self.state[row] == int(CellState.SOLID)]

    def ever_blocked(self, ix: Ints, iy: Ints) -> Bools:
        """Return where cells, of the grid or next to it, are solid or burning at any time."""
        blocked: Bools = self._far[iy + 1, ix + 1] == 0
        return blocked

    def at_least(self, pieces: Parts) -> Floats:
        """Return a lower bound on each piece's distance to cells that are ever blocked, in cells.

        The bound may be negative.
        """
        return self._lower_bound(pieces, self._far, 1)

    def _lower_bound(self, pieces: Parts, far: npt.NDArray[np.int32], ring: int) -> Floats:
        ix = _cell(pieces.x + 0.5 * pieces.dx, self.width) + ring
        iy = _cell(pieces.y + 0.5 * pieces.dy, self.height) + ring
        return far[iy, ix] - 1.0 - 0.5 * pieces.length

    def near(self, pieces: Parts, times: tuple[Floats, Floats], reach: float) -> Pairs:
        """Return the cells within reach of pieces while the robot drives along these.

        Of the cells that are always solid, only the nearest are returned.

        Args:
            pieces: Short pieces of the path, inside the grid.
            times: When each begins and ends, s.
            reach: Distance, cells.

        Returns:
            All pairs within reach, and some that are not.
        """
        found = self._near_still(pieces, reach)
        if self._far_changing is not None:
            close = np.flatnonzero(self._lower_bound(pieces, self._far_changing, 0) < reach)
            if len(close):
                own = self._near_changing(pieces.take(close), reach)
                own = Pairs(close[own.piece], own.ix, own.iy, own.span)
                found = found.followed_by(self._in_time(own, times))
        return found

    def _near_still(self, pieces: Parts, reach: float) -> Pairs:
        # In each row, the nearest solid cells to the left and right of the piece.
        piece, iy = self._rows(pieces, reach)
        low, high = _ends(pieces.x, pieces.dx)
        first = _cell(low, self.width)[piece]
        last = _cell(high, self.width)[piece]
        row = iy + 1
        # Columns of the tables begin at the ring, one to the left of the grid.
        columns = [self._left[row, first] - 1, self._right[row, last + 2] - 1]

        # Add the solid cells that the piece itself passes over.
        valid = [np.ones(len(piece), np.bool_)] * 2
        for step in range(int((last - first).max(initial=-1)) + 1):
            column = np.minimum(first + step, last)
            columns.append(column)
            valid.append(self._still[row, column + 1] & (first + step <= last))
        kept = np.concatenate(valid)
        size = len(columns)
        piece = np.tile(piece, size)[kept]
        iy = np.tile(iy, size)[kept]
        ix = np.concatenate(columns)[kept].astype(np.int64)
        return _within_reach(pieces, Pairs(piece, ix, iy, np.full(len(piece), -1)), reach)

    def _near_changing(self, pieces: Parts, reach: float) -> Pairs:
        # Add the changing cells in the piece's bounding box, grown by the reach.
        piece, iy = self._rows(pieces, reach)
        inside = (iy >= 0) & (iy < self.height)
        piece = piece[inside]
        iy = iy[inside]
        low, high = _ends(pieces.x, pieces.dx)
        first = _cell(low - reach, self.width)[piece]
        last = _cell(high + reach, self.width)[piece]
        row, ix = _ranges(first, last)
        piece = piece[row]
        iy = iy[row]
        cell = self._changing[iy, ix]
        known = np.flatnonzero(cell >= 0)
        pairs = Pairs(piece[known], ix[known], iy[known], cell[known].astype(np.intp))
        return _within_reach(pieces, pairs, reach)

    def _rows(self, pieces: Parts, reach: float) -> tuple[Indices, Ints]:
        """Return each piece with each row, including the ring, that may be within reach of it."""
        low, high = _ends(pieces.y, pieces.dy)
        first = np.clip(np.floor(low - reach), -1, self.height).astype(np.int64)
        last = np.clip(np.floor(high + reach), -1, self.height).astype(np.int64)
        return _ranges(first, last)

    def _in_time(self, pairs: Pairs, times: tuple[Floats, Floats]) -> Pairs:
        """Return the pairs whose cell is blocked at some time while the robot is on the piece."""
        begin = times[0][pairs.piece]
        end = times[1][pairs.piece]
        first = self._search(pairs.span, lambda middle: self.until[middle] <= begin)
        after = self._search(pairs.span, lambda middle: self.since[middle] <= end)
        row, span = _ranges(first, after - 1)
        return Pairs(pairs.piece[row], pairs.ix[row], pairs.iy[row], span.astype(np.intp))

    def _search(self, cell: Indices, goes_on: Callable[[Ints], Bools]) -> Ints:
        """Return each cell's first span for which ``goes_on`` is false, by bisection.

        If it is true for all spans of a cell, return the index after its last one.
        """
        low = self._first[cell].astype(np.int64)
        high = self._end[cell].astype(np.int64)
        while (low < high).any():
            middle = np.minimum((low + high) // 2, len(self.since) - 1)
            on = goes_on(middle) & (low < high)
            low, high = np.where(on, middle + 1, low), np.where(on | (low >= high), high, middle)
        return low


def _cell(place: Floats, cells: int) -> Ints:
    """Return the column or row of a coordinate in cells, or the nearest one in the grid."""
    return np.clip(np.floor(place), 0, cells - 1).astype(np.int64)


def _ends(place: Floats, step: Floats) -> tuple[Floats, Floats]:
    return np.minimum(place, place + step), np.maximum(place, place + step)


def _ranges(first: Ints, last: Ints) -> tuple[Indices, Ints]:
    """Return all numbers of the ranges first..last (inclusive), and which range each is from."""
    count = np.maximum(last - first + 1, 0)
    row = np.repeat(np.arange(len(count)), count)
    offset = np.cumsum(count) - count
    return row, np.arange(len(row)) - offset[row] + first[row]


def _within_reach(pieces: Parts, pairs: Pairs, reach: float) -> Pairs:
    """Return the pairs whose cell is within ``reach`` of the piece's bounding box."""
    low_x, high_x = _ends(pieces.x, pieces.dx)
    low_y, high_y = _ends(pieces.y, pieces.dy)
    piece = pairs.piece
    gap_x = np.maximum(np.maximum(pairs.ix - high_x[piece], low_x[piece] - pairs.ix - 1), 0.0)
    gap_y = np.maximum(np.maximum(pairs.iy - high_y[piece], low_y[piece] - pairs.iy - 1), 0.0)
    return pairs.take(gap_x * gap_x + gap_y * gap_y <= reach * reach)
