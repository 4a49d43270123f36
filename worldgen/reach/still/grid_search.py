"""Searches over grids, in compiled code: floods, shortest paths, distances.

A grid is a bool raster, and a place in it a flat index, row by row. Searches for a disc among walls
at exact places are in `worldgen.reach`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from worldgen import _core
from worldgen.support.arrays import Bools, Ints
from worldgen.support.ccall import check, pointer, writable


class Floods:
    """Flood fills over the free places of one grid, in steps to the four neighbours.

    They share memory.

    Args:
        free: (rows, columns) bool, with a rim that is not free.

    Attributes:
        queue: (places,) int32; it begins with the last region flooded, in order of steps.
    """

    def __init__(self, free: Bools) -> None:
        self._free = free
        self._seen = np.zeros(free.size, np.uint8)
        self._count = 0
        self.queue: npt.NDArray[np.int32] = np.zeros(free.size, np.int32)

    def regions(self, first: int, last: int) -> Any:
        """Flood every region that has a place in ``first`` .. ``last - 1``.

        Returns:
            The number of ``regions`` and of their ``places``; a place, ``root``, of the ``largest``
            region, and that region's size.
        """
        ffi = _core.ffi
        lib = _core.lib
        self._count += 1
        found = ffi.new("WgRegions *")
        work = (writable(ffi, self._seen, np.uint8), writable(ffi, self.queue, np.int32))
        check(lib.wg_regions(*_grid(self._free), first, last, self._count, *work, found))
        return found


def free_windows(walls: Bools, width: int, height: int) -> Bools:
    """Return where a box of ``width`` x ``height`` cells is free, marked at its first cell.

    The result is bool and has the shape of ``walls``.
    """
    ffi = _core.ffi
    lib = _core.lib
    rows, columns = walls.shape
    windows = np.empty(walls.shape, dtype=np.bool_)
    solid = pointer(ffi, np.ascontiguousarray(walls), np.bool_)
    check(
        lib.wg_free_windows(solid, rows, columns, width, height, writable(ffi, windows, np.bool_))
    )
    return windows


def window_at(halves: int, side: int) -> int:
    """Return the first cell, along one axis, of the square around a coordinate in half cells."""
    return (halves - side) // 2


def steps_from(windows: Bools, start: int) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.int32]]:
    """Return the steps from a place to every other, -1 if no path leads there.

    Also return the places reached, the nearest first.
    """
    ffi = _core.ffi
    lib = _core.lib
    steps = np.empty(windows.size, dtype=np.int32)
    order = np.empty(windows.size, dtype=np.int32)
    reached = ffi.new("int64_t *")
    found = (writable(ffi, steps, np.int32), writable(ffi, order, np.int32), reached)
    check(lib.wg_steps_from(*_grid(windows), int(start), *found))
    return steps, order[: reached[0]]


def components(windows: Bools) -> tuple[npt.NDArray[np.int32], int]:
    """Return the number of each place's component, -1 if there is none, flat.

    Also return the number of components. Steps lead to the four neighbours.

    Args:
        windows: (rows, columns) bool, with a rim of False.
    """
    ffi = _core.ffi
    lib = _core.lib
    owner = np.empty(windows.size, dtype=np.int32)
    queue = np.empty(windows.size, dtype=np.int32)
    count = ffi.new("int64_t *")
    check(
        lib.wg_components(
            *_grid(windows), writable(ffi, owner, np.int32), writable(ffi, queue, np.int32), count
        )
    )
    return owner, int(count[0])


def _grid(windows: Bools) -> tuple[Any, int, int]:
    """Return a grid in the core's form: its places, their number, and the number in a row."""
    return (
        pointer(_core.ffi, np.ascontiguousarray(windows), np.bool_),
        windows.size,
        windows.shape[1],
    )


def shortest_path(windows: Bools, start: int, goal: int) -> list[int]:
    """Return the flat cells of a shortest path over free windows, including both ends.

    It is empty if there is no path.
    """
    ffi = _core.ffi
    lib = _core.lib
    came = np.empty(windows.size, np.int32)
    path = np.empty(windows.size, np.int32)
    length = ffi.new("int64_t *")
    found = (writable(ffi, came, np.int32), writable(ffi, path, np.int32), length)
    check(lib.wg_shortest_path(*_grid(windows), start, goal, *found))
    places: list[int] = path[: length[0]].tolist()
    return places


def by_distance(clear: Bools, pitch: int, x: int, y: int) -> tuple[Ints, Ints]:
    """Return the clear nodes, flat, sorted by distance from a point, and their squared distances.

    Args:
        clear: (height, width) bool, nodes at multiples of ``pitch``.
        pitch: Distance between nodes, in the units of the point.
        x: x of the point.
        y: y of the point.
    """
    ffi = _core.ffi
    lib = _core.lib
    count = int(np.count_nonzero(clear))
    places = np.empty(count, np.int64)
    squared = np.empty(count, np.int64)
    grid = (pointer(ffi, np.ascontiguousarray(clear), np.bool_), *clear.shape)
    found = (writable(ffi, places, np.int64), writable(ffi, squared, np.int64), count)
    check(lib.wg_by_distance(*grid, pitch, x, y, *found))
    return places, squared


def squared_distances(marked: Bools, most: int = 2**62) -> Ints:
    """Return the squared distance from each node to the nearest marked one; exact.

    The nearest point of a cell to a node is a node, so marking the nodes in cells gives distances
    to cells.

    Args:
        marked: (rows, columns) bool.
        most: Squares above this may be returned as any larger number, which takes less time.

    Source: Meijster, Roerdink, Hesselink, "A General Algorithm for Computing Distance Transforms in
        Linear Time",
    2000.
    """
    ffi = _core.ffi
    lib = _core.lib
    found: Ints = np.empty(marked.shape, np.int32)
    marks = pointer(ffi, np.ascontiguousarray(marked), np.bool_)
    check(lib.wg_squared_distances(marks, *marked.shape, most, writable(ffi, found, np.int32)))
    return found
