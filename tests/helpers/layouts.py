"""Layouts as the search's core draws them, for tests."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from fuzz._core import ffi, lib
from fuzz.screening.batch import LOOK, Batch, Patience, SceneRobots, Seat


class Drawn(NamedTuple):
    """A world that the core has drawn.

    Args:
        cells: (height, width) uint8, 1 where solid.
        near: (height, width) int32, the masks of the cells around.
        visited: (height, width) uint8, zeros.
        solid: Number of solid cells.
        distance: Cells of a path to the target, an upper bound; -1 if there is none.
    """

    cells: Any
    near: Any
    visited: Any
    solid: int
    distance: int


def draw(data: bytes) -> Drawn:
    """Draw the world of layout bytes."""
    settings = ffi.new("WgSettings *")
    layouts = np.frombuffer(data, np.uint8)[None, :].copy()
    zero = np.zeros(1, np.int64)
    robots = SceneRobots((0.07,), 0.1)
    patience = Patience(1, 1, 1, 1)
    batch = Batch(layouts, np.zeros(1, np.uint64), zero, zero, [settings], robots, patience)
    seat = Seat(batch, ())
    look = np.zeros(1, LOOK)
    at = ffi.cast("WgLook *", ffi.from_buffer("uint8_t[]", look.view(np.uint8)))
    solid = int(lib.wg_look_draw(ffi.from_buffer("uint8_t[]", layouts), seat.c, at))
    shape = (int(look["height"][0]), int(look["width"][0]))
    return Drawn(
        cells=_copy(seat.c.arena.cells, shape, np.uint8),
        near=_copy(seat.c.arena.near, shape, np.int32),
        visited=_copy(seat.c.arena.visited, shape, np.uint8),
        solid=solid,
        distance=int(look["distance"][0]),
    )


def _copy(address: Any, shape: tuple[int, int], kind: type[np.generic]) -> Any:
    size = shape[0] * shape[1] * np.dtype(kind).itemsize
    return np.frombuffer(ffi.buffer(address, size), kind).reshape(shape).copy()
