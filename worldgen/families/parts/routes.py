"""Paths for a square as wide as the robot: coarse, but where it fits, the disc does."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from worldgen import _core
from worldgen.support.ccall import check, pointer, writable

__all__ = ["free_windows", "shortest_way", "window_at"]


def free_windows(walls: npt.NDArray[np.bool_], width: int, height: int) -> npt.NDArray[np.bool_]:
    """Return where a box of ``width`` x ``height`` cells is free, at its first cell: bool, shaped like ``walls``."""
    ffi, lib = _core.ffi, _core.lib
    rows, columns = walls.shape
    windows = np.empty(walls.shape, dtype=np.bool_)
    solid = pointer(ffi, np.ascontiguousarray(walls), np.bool_)
    check(lib.wg_free_windows(solid, rows, columns, width, height, writable(ffi, windows, np.bool_)))
    return windows


def window_at(halves: int, side: int) -> int:
    """Return the first cell, along one axis, of the square around a coordinate in half cells."""
    return (halves - side) // 2


def shortest_way(windows: npt.NDArray[np.bool_], start: int, goal: int) -> list[int]:
    """Return the flat cells of a shortest path over free windows, both ends included; empty if there is none."""
    ffi, lib = _core.ffi, _core.lib
    came = np.empty(windows.size, np.int32)
    path = np.empty(windows.size, np.int32)
    length = ffi.new("int64_t *")
    grid = (pointer(ffi, np.ascontiguousarray(windows), np.bool_), windows.size, windows.shape[1])
    found = (writable(ffi, came, np.int32), writable(ffi, path, np.int32), length)
    check(lib.wg_shortest_path(*grid, start, goal, *found))
    places: list[int] = path[: length[0]].tolist()
    return places
