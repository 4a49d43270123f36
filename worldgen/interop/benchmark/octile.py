"""Shortest octile paths.

Moves between the centres of free cells, straight or diagonal, that cut no corner. A diagonal move
needs both cells beside it free. A path's length is a pair of counts, straight moves and diagonal
ones, so it is exact; as a number it is ``straight + diagonal * sqrt(2)``.

Jump points with tables ("JPS+") answer a question on a map of 512 x 512 cells in some ten
microseconds. The tables say for each cell and direction how far a path can go on before it may have
to turn.

Source: Harabor and Grastien, "The JPS pathfinding system", SoCS 2012; Rabin and Sturtevant,
    "Combining bounding boxes
and JPS to prune grid pathfinding", AAAI 2016. Many hard questions on one map also get landmarks.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import numpy.typing as npt

from worldgen import _core
from worldgen.support.ccall import check, pointer, writable

__all__ = ["OctileMap"]

_TRIED = (
    32  # questions that are answered before it is known whether landmarks are worth their while
)
_WORTH = 8.0  # places to be looked at for each cell, from which on they are
_LANDMARKS = 8
_MOST_MARKED = 2_000_000  # cells; their landmarks take 200 bytes each

Counts = npt.NDArray[np.int64]
Cells = npt.NDArray[np.integer[Any]]


class OctileMap:
    """A map made ready for many questions.

    Two different lengths of up to ten million moves differ by more than the rounding of
    ``a + b * sqrt(2)`` in float64, so comparing those is comparing exactly.

    Args:
        walls: (height, width) bool, True is solid; what is outside is solid too.
    """

    def __init__(self, walls: npt.NDArray[np.bool_]) -> None:
        self._shape = walls.shape
        free = np.pad(~walls, 1)
        self._stride = int(free.shape[1])
        # Without cutting corners a diagonal move is never needed to get somewhere, so four moves
        # give the regions.
        self._regions = _regions(free)
        stride = self._stride
        self._steps = np.array(
            [1, 1 + stride, stride, stride - 1, -1, -1 - stride, -stride, 1 - stride], np.int64
        )
        self._free = free.astype(np.uint8).ravel()

    def lengths(self, starts: Cells, goals: Cells) -> Counts:
        """Shortest paths.

        Args:
            starts: (n, 2) column and row of cells; rows count as in ``walls``.
            goals: (n, 2) likewise.

        Returns:
            (n, 2) straight and diagonal moves of a shortest path; -1, -1 where there is none, or an
            end is solid.
        """
        ends = [
            (1 + cells[:, 1].astype(np.int64)) * self._stride + 1 + cells[:, 0]
            for cells in (starts, goals)
        ]
        found = np.full((len(starts), 2), -1, np.int64)
        region = self._regions[ends[0]]
        joined = np.flatnonzero((region >= 0) & (region == self._regions[ends[1]]))
        if len(joined):
            found[joined] = self._answers(ends[0][joined], ends[1][joined])
        return found

    def _answers(self, starts: Counts, goals: Counts) -> Counts:
        """Straight and diagonal moves between cells that are joined, given by their numbers."""
        found = np.empty((len(starts), 2), np.int64)
        # Some are tried first, one in so many, for a benchmark's problems are sorted by their
        # lengths.
        tried = np.arange(len(starts)) % max(len(starts) // _TRIED, 1) == 0
        marks = np.zeros((1, 0))
        slack = 0.0
        for part in (np.flatnonzero(tried), np.flatnonzero(~tried)):
            if not len(part):
                break
            answers, looked = self._search(starts[part], goals[part], marks, slack)
            found[part] = answers
            if part[0] == 0 and looked / len(part) * (len(starts) - len(part)) > _WORTH * len(
                self._free
            ):
                marks, slack = self._landmarks()
        return found

    @functools.cached_property
    def _jumps(self) -> npt.NDArray[np.int16]:
        """Tables of jumps: how far a path can go on from each cell in each direction before it may have to turn."""
        ffi = _core.ffi
        lib = _core.lib
        jumps = np.empty((8, len(self._free)), np.int16)
        grid = (pointer(ffi, self._free, np.uint8), len(self._free), self._stride)
        check(lib.wg_octile_jumps(*grid, writable(ffi, jumps, np.int16)))
        return jumps

    def _search(
        self, starts: Counts, goals: Counts, marks: npt.NDArray[np.float64], slack: float
    ) -> tuple[Counts, int]:
        """Return straight and diagonal moves between cells, and how many places were looked at."""
        ffi = _core.ffi
        lib = _core.lib
        answers = np.empty((len(starts), 2), np.int64)
        asked = ffi.new("WgOctile *")
        asked.size = len(self._free)
        asked.stride = self._stride
        asked.marks = marks.shape[1]
        asked.slack = slack
        asked.questions = len(starts)
        tables = (
            pointer(ffi, self._jumps, np.int16),
            pointer(ffi, np.ascontiguousarray(marks), np.float64),
        )
        ends = (pointer(ffi, starts, np.int64), pointer(ffi, goals, np.int64))
        while asked.answered < asked.questions:
            check(lib.wg_octile_search(asked, *tables, *ends, writable(ffi, answers, np.int64)))
        return answers, asked.looked

    def _landmarks(self) -> tuple[npt.NDArray[np.float64], float]:
        """Distances from landmarks in the largest region, and how wrong they may be.

        None on a map too large.
        """
        from worldgen.interop.benchmark.landmarks import landmark_distances, rounding

        if len(self._free) > _MOST_MARKED:
            return np.zeros((1, 0)), 0.0
        largest = np.bincount(self._regions[self._regions >= 0]).argmax()
        found = landmark_distances(self._free, self._steps, self._regions == largest, _LANDMARKS)
        return found, rounding(found)


def _regions(free: npt.NDArray[np.bool_]) -> npt.NDArray[np.int32]:
    """Return the number of each cell's region, -1 where it is solid, flat."""
    ffi = _core.ffi
    lib = _core.lib
    owner = np.empty(free.size, np.int32)
    queue = np.empty(free.size, np.int32)
    count = ffi.new("int64_t *")
    grid = (pointer(ffi, np.ascontiguousarray(free), np.bool_), free.size, free.shape[1])
    check(
        lib.wg_components(
            *grid, writable(ffi, owner, np.int32), writable(ffi, queue, np.int32), count
        )
    )
    return owner
