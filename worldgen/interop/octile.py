"""Shortest octile paths: moves between the centres of free cells, straight or diagonal, that cut no corner.

A diagonal move needs both cells beside it free. A path's length is a pair of counts, straight moves and diagonal
ones, so it is exact; as a number it is ``straight + diagonal * sqrt(2)``.

Jump points with tables ("JPS+") answer a question on a map of 512 x 512 cells in some ten microseconds. The tables say
for each cell and direction how far a path can go on before it may have to turn.

Source: Harabor and Grastien, "The JPS pathfinding system", SoCS 2012; Rabin and Sturtevant, "Combining bounding boxes
and JPS to prune grid pathfinding", AAAI 2016. Many hard questions on one map also get landmarks.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from worldgen.jit import lazy_kernel

__all__ = ["OctileMap"]

_ROOT_TWO = math.sqrt(2.0)
_SMALL = 2_500  # cells times questions up to which numba's import would take longer than the interpreter does
_TRIED = 32  # questions that are answered before it is known whether landmarks are worth their while
_WORTH = 8.0  # places to be looked at for each cell, from which on they are
_LANDMARKS = 8
_MOST_MARKED = 2_000_000  # cells; their landmarks take 200 bytes each

Counts = npt.NDArray[np.int64]
Cells = npt.NDArray[np.integer[Any]]


class OctileMap:
    """A map made ready for many questions.

    Two different lengths of up to ten million moves differ by more than the rounding of ``a + b * sqrt(2)`` in
    float64, so comparing those is comparing exactly.

    Args:
        walls: (height, width) bool, True is solid; what is outside is solid too.
    """

    def __init__(self, walls: npt.NDArray[np.bool_]) -> None:
        self._shape = walls.shape
        free = np.pad(~walls, 1)
        self._stride = int(free.shape[1])
        # Without cutting corners a diagonal move is never needed to get somewhere, so four moves give the regions.
        self._regions = ndimage.label(free)[0].ravel()
        stride = self._stride
        self._steps = np.array([1, 1 + stride, stride, stride - 1, -1, -1 - stride, -stride, 1 - stride], np.int64)
        self._free = free.astype(np.uint8).ravel()
        self._jumps: npt.NDArray[np.int16] | None = None

    def lengths(self, starts: Cells, goals: Cells) -> Counts:
        """Shortest paths.

        Args:
            starts: (n, 2) column and row of cells; rows count as in ``walls``.
            goals: (n, 2) likewise.

        Returns:
            (n, 2) straight and diagonal moves of a shortest path; -1, -1 where there is none, or an end is solid.
        """
        ends = [(1 + cells[:, 1].astype(np.int64)) * self._stride + 1 + cells[:, 0] for cells in (starts, goals)]
        found = np.full((len(starts), 2), -1, np.int64)
        region = self._regions[ends[0]]
        joined = np.flatnonzero((region != 0) & (region == self._regions[ends[1]]))
        if len(joined):
            found[joined] = self._answers(ends[0][joined], ends[1][joined])
        return found

    def _answers(self, starts: Counts, goals: Counts) -> Counts:
        """Straight and diagonal moves between cells that are joined, given by their numbers."""
        fill, search = _fill_jumps_compiled, _search_compiled
        if len(self._free) * len(starts) <= _SMALL:
            fill, search = _fill_jumps, _search
        if self._jumps is None:
            self._jumps = np.zeros((8, len(self._free)), np.int16)
            fill(self._free, self._steps, self._jumps)
        found = np.empty((len(starts), 2), np.int64)
        # Some are tried first, one in so many, for a benchmark's problems are sorted by their lengths.
        tried = np.arange(len(starts)) % max(len(starts) // _TRIED, 1) == 0
        marks, slack = np.zeros((1, 0)), 0.0
        for part in (np.flatnonzero(tried), np.flatnonzero(~tried)):
            if not len(part):
                break
            answers = np.empty((len(part), 2), np.int64)
            looked = search(self._jumps, self._steps, self._stride, starts[part], goals[part], answers, marks, slack)
            found[part] = answers
            if part[0] == 0 and looked / len(part) * (len(starts) - len(part)) > _WORTH * len(self._free):
                marks, slack = self._landmarks()
        return found

    def _landmarks(self) -> tuple[npt.NDArray[np.float64], float]:
        """Distances from landmarks in the largest region, and how wrong they may be; none on a map too large."""
        from worldgen.interop.landmarks import landmark_distances, rounding

        if len(self._free) > _MOST_MARKED:
            return np.zeros((1, 0)), 0.0
        largest = np.bincount(self._regions[self._regions != 0]).argmax()
        found = landmark_distances(self._free, self._steps, self._regions == largest, _LANDMARKS)
        return found, rounding(found)


def _fill_jumps(free: Any, steps: Any, jumps: Any) -> None:
    """Tables of jumps: k > 0 means that a path may have to turn after k moves; -k or 0 that only k are possible.

    Directions 0 to 7 go round from +x in eighths of a turn. Straight on, a path may have to turn where a side
    becomes free that was not; diagonally, where one of the two straight directions leads to such a place.

    Args:
        free: (n,) uint8, rows of ``steps[2]`` cells with a rim of zeros.
        steps: (8,) what a move adds to a cell's number.
        jumps: (8, n) int16 zeros, to be filled.
    """
    size = len(free)
    for turn in range(8):
        direction = turn * 2 % 8 + turn // 4  # the straight ones first: the diagonal ones look at their tables
        ahead = steps[direction]
        left, right = steps[(direction + 2) & 7], steps[(direction + 6) & 7]
        one, other = steps[(direction + 1) & 7], steps[(direction + 7) & 7]
        for count in range(size):
            cell = size - 1 - count if ahead > 0 else count
            if free[cell] == 0 or free[cell + ahead] == 0:
                continue
            after = cell + ahead
            if direction % 2 == 0:
                turns = (free[cell + left] == 0 and free[after + left] != 0) or (
                    free[cell + right] == 0 and free[after + right] != 0
                )
            else:
                if free[cell + one] == 0 or free[cell + other] == 0:
                    continue
                turns = jumps[(direction + 1) & 7, after] > 0 or jumps[(direction + 7) & 7, after] > 0
            further = jumps[direction, after]
            jumps[direction, cell] = 1 if turns else further + 1 if further > 0 else further - 1


def _search(jumps: Any, steps: Any, stride: Any, starts: Any, goals: Any, answers: Any, marks: Any, slack: Any) -> Any:
    """A* over jump points, one question after the other; start and goal of each are joined.

    A cell that is reached at equal cost from several directions is expanded in all that these allow.

    Args:
        jumps: (8, n) from :func:`_fill_jumps`.
        steps: (8,) what a move adds to a cell's number.
        stride: Cells a row.
        starts: (m,) numbers of cells.
        goals: (m,) likewise.
        answers: (m, 2) gets straight and diagonal moves.
        marks: (n, k) distances from landmarks; k may be 0.
        slack: By how much their differences may be too large.

    Returns:
        How many places were looked at.
    """
    size, looked = jumps.shape[1], 0
    seen = np.zeros(size, np.int32)  # the question, from 1, in which the rest is of use
    moves = np.empty((size, 2), np.int32)
    asked, done = np.empty(size, np.uint8), np.empty(size, np.uint8)  # a bit a direction
    keys, cells = np.empty(1024), np.empty(1024, np.int64)
    for row in range(len(starts)):
        start, goal = starts[row], goals[row]
        seen[start], moves[start, 0], moves[start, 1], asked[start], done[start] = row + 1, 0, 0, 255, 0
        waiting = _push(keys, cells, 0, 0.0, start)
        while True:
            cell = cells[0]
            if cell == goal:
                break
            waiting = _drop_first(keys, cells, waiting)
            looked += 1
            if waiting + 8 > len(keys):
                keys, cells = np.append(keys, np.empty(len(keys))), np.append(cells, np.empty(len(cells), np.int64))
            ways = asked[cell] & ~done[cell]
            done[cell] |= asked[cell]
            across, up = goal % stride - cell % stride, goal // stride - cell // stride
            for direction in range(8):
                if ways >> direction & 1 == 0:
                    continue
                length = _jump_length(jumps[direction, cell], direction, across, up)
                if length == 0:
                    continue
                after = cell + length * steps[direction]
                straight = moves[cell, 0] + (length if direction % 2 == 0 else 0)
                diagonal = moves[cell, 1] + (length if direction % 2 == 1 else 0)
                new = _ways_on(direction)
                if seen[after] == row + 1:
                    longer = (straight - moves[after, 0]) + (diagonal - moves[after, 1]) * _ROOT_TWO
                    if longer > 0.0 or (longer == 0.0 and new & ~asked[after] == 0):
                        continue
                    if longer == 0.0:
                        new |= asked[after]
                    else:
                        done[after] = 0
                else:
                    seen[after], done[after] = row + 1, 0
                asked[after], moves[after, 0], moves[after, 1] = new, straight, diagonal
                over, rise = abs(goal % stride - after % stride), abs(goal // stride - after // stride)
                key = (straight + abs(over - rise)) + (diagonal + min(over, rise)) * _ROOT_TWO
                for mark in range(marks.shape[1]):
                    further = abs(marks[goal, mark] - marks[after, mark]) - slack
                    key = max(key, straight + diagonal * _ROOT_TWO + further)
                waiting = _push(keys, cells, waiting, key, after)
        answers[row, 0], answers[row, 1] = moves[goal, 0], moves[goal, 1]
    return looked


def _jump_length(jump: Any, direction: Any, across: Any, up: Any) -> Any:
    """How many moves to go in a direction: to the goal, to its row or column, or to where to turn; 0 for none."""
    toward_x = (direction < 2 or direction == 7) - (3 <= direction <= 5)
    toward_y = (1 <= direction <= 3) - (direction >= 5)
    if direction % 2 == 0:
        if across * toward_y == 0 and up * toward_x == 0:  # in line, on this side or the other
            distance = across * toward_x + up * toward_y
            if 0 < distance <= abs(jump):
                return distance
    else:
        distance = min(across * toward_x, up * toward_y)
        if 0 < distance <= abs(jump):
            return distance
    return max(jump, 0)


def _ways_on(direction: Any) -> Any:
    """The directions, as bits, in which a path that came in one may go on: half a circle, diagonally a quarter."""
    ways = 1 << direction | 1 << ((direction + 1) & 7) | 1 << ((direction + 7) & 7)
    if direction % 2 == 0:
        ways |= 1 << ((direction + 2) & 7) | 1 << ((direction + 6) & 7)
    return ways


def _push(keys: Any, cells: Any, waiting: Any, key: Any, cell: Any) -> Any:
    """Puts a cell into the heap; gives how many are in it."""
    at = waiting
    while at > 0:
        above = (at - 1) // 2
        if keys[above] <= key:
            break
        keys[at], cells[at] = keys[above], cells[above]
        at = above
    keys[at], cells[at] = key, cell
    return waiting + 1


def _drop_first(keys: Any, cells: Any, waiting: Any) -> Any:
    """Takes the least from the heap; gives how many are left."""
    last = waiting - 1
    key, cell = keys[last], cells[last]
    at = 0
    while True:
        below = 2 * at + 1
        if below >= last:
            break
        if below + 1 < last and keys[below + 1] < keys[below]:
            below += 1
        if key <= keys[below]:
            break
        keys[at], cells[at] = keys[below], cells[below]
        at = below
    keys[at], cells[at] = key, cell
    return last


_fill_jumps_compiled = lazy_kernel(_fill_jumps)
_search_compiled = lazy_kernel(_search, _jump_length, _ways_on, _push, _drop_first)
