"""Run the thesis's simulator, which is written in C: arrays in, a finished run out.

Everything is in the thesis's own frame: pixels, y down, ten pixels per cell, ``cells[x, y]``;
heading 0 is -x, pi/2 is -y (up), growing clockwise on the screen; times are in milliseconds.

``cells`` (int32) holds the signal, the squared distance in cells to the target's cell (0 there),
changed by the noise filter; or ``WALL``; or ``FLAME``, which carries no signal and does not stop
the robot. The border must be ``WALL``.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from sim._core import ffi, lib
from worldgen.support.arrays import Floats, Ints, Words
from worldgen.support.ccall import check, pointer, writable

Cells = npt.NDArray[np.int32]
Rows = npt.NDArray[np.void]

# Pixels per cell; the listing calls it `length`.
CELL = 10.0

# Pixels per ms. At 15 ms, a tick moves 2 or 3 px, decided by the last bit of a cosine.
ROBOT_SPEED = 0.2
WALL: int = lib.WG_THESIS_WALL
FLAME: int = lib.WG_THESIS_FLAME

ROW = np.dtype([(name, np.float64) for name, _ in ffi.typeof("WgThesisRow").fields])
"""A row of a trace: the state after a tick."""

STATE_FIELDS: tuple[str, ...] = ROW.names[: lib.WG_THESIS_WORDS] if ROW.names else ()
"""The fields of a row that decide the robot's future."""

# From this field on, the state's fields are whole numbers.
_FIRST_COUNT = STATE_FIELDS.index("collision")

# Pixels that one call may step through, about 0.1 s; Ctrl-C is noticed between calls.
_WORK = 1 << 22


class ThesisSetup(NamedTuple):
    """The robot and the options of its run.

    ``WgThesisSettings`` in ``sim/core/thesis/wg_thesis.h`` explains each field.
    """

    rule: int
    time_step: float
    sense: int = 1
    collide_ticks: int = 5
    drive_ticks: int = 2
    turn_angle: float = math.pi / 2
    radius: float = 7.0
    speed: float = ROBOT_SPEED
    tolerance: float = 1.0
    steps: int = 20_000
    find_loop: int = lib.WG_NO_LOOP
    loop_entry: int = 0
    digest: int = 1
    stop_at_tunnel: int = 0
    reading: int = 0
    repairs: int = 0
    acceleration: float = 0.0
    friction: float = 0.0
    wall_friction: float = 0.0
    slip: float = 0.0
    sensor_field: float = 0.0
    sensor_noise: float = 0.0
    signal: int = lib.WG_SIGNAL_OPEN
    map_scale: int = 1
    target_x: int = 0
    target_y: int = 0
    seed: int = 0


class ThesisEpisode:
    """A run, from its start to its last continuation.

    Args:
        cells: (width, height) the signal with walls; copied.
        light: (width, height) the signal that returns when a cell becomes free.
        events: (n, 4) rows (step, x, y, state), sorted by step; applied before that step's move.
        start: x and y in px, and the heading in rad.
        setup: The robot and the options of the run.
    """

    def __init__(
        self,
        cells: Cells,
        light: Cells,
        events: Ints,
        start: tuple[float, float, float],
        setup: ThesisSetup,
    ) -> None:
        self.cells = np.array(cells, np.int32, order="C")
        self.visited = np.zeros(cells.shape, np.uint8)
        self.setup = setup
        # C only keeps addresses, so the arrays must stay alive here.
        self._light = np.ascontiguousarray(light, np.int32)
        self._events = np.ascontiguousarray(events, np.int64).reshape(-1, 4)
        seeks = setup.find_loop == lib.WG_SEEK_LOOP
        self._log = np.zeros(setup.steps + 1 if seeks else 1, np.uint64)
        self._known = np.zeros(lib.WG_THESIS_WORDS, np.uint64)
        if self._light.shape != cells.shape:
            raise ValueError(
                f"light is {self._light.shape}, cells are {cells.shape}; give both one shape"
            )
        arena = {
            "width": cells.shape[0],
            "height": cells.shape[1],
            "cells": writable(ffi, self.cells, np.int32),
            "light": pointer(ffi, self._light, np.int32),
            "events": ffi.cast("WgThesisEvent *", pointer(ffi, self._events, np.int64)),
            "event_count": len(self._events),
            "visited": writable(ffi, self.visited, np.uint8),
        }
        search = {
            "log": writable(ffi, self._log, np.uint64),
            "log_size": self._log.size,
            "known": writable(ffi, self._known, np.uint64),
            "words": self._known.size,
        }
        self._arena = ffi.new("WgThesisArena *", arena)
        self._settings = ffi.new("WgThesisSettings *", setup._asdict())
        self._search = ffi.new("WgSearch *", search)
        self.run: Any = ffi.new("WgThesisRun *")
        lib.wg_thesis_begin(self.run, *start, setup.speed)

    def go(self, until: int, draws: Floats, rows: Rows, first_row: int = 0) -> bool:
        """Continue until the run is decided or a step is done.

        Args:
            until: That step; never after ``setup.steps``.
            draws: Random numbers in [0, 1) for the random rule, starting with the first.
            rows: (n,) of type :data:`ROW`; row k receives the state after step ``first_row`` + k.
            first_row: Step of the first row.

        Returns:
            False if there were too few draws. Then append more draws and call again.
        """
        numbers = pointer(ffi, np.ascontiguousarray(draws, np.float64), np.float64)
        table = ffi.cast("WgThesisRow *", writable(ffi, rows.view(np.float64), np.float64))
        work = (self._arena, self._settings, self.run, self._search, numbers, len(draws))
        last = min(until, self.setup.steps)
        portion = max(1, int(_WORK / max(1.0, self.setup.speed * self.setup.time_step)))
        # Continue in portions of roughly equal work, so that Ctrl-C is noticed.
        while True:
            end = min(last, self.run.steps + portion)
            check(lib.wg_thesis_run(*work, table, len(rows), first_row, end))
            if self.run.ending != lib.WG_LIMIT or self.run.steps >= last:
                return bool(self.run.ending != lib.WG_NEEDS_DRAWS)

    def proved_state(self) -> Words:
        """Return the state to which a proved loop returns, in the words of a trace."""
        words = self._known.copy()
        counts = self._known[_FIRST_COUNT:].view(np.int64).astype(np.float64)
        words[_FIRST_COUNT:] = counts.view(np.uint64)
        return words


def new_rows(count: int) -> Rows:
    """Return an empty trace with this many rows."""
    return np.zeros(count, ROW)


def signal_map(width: int, height: int, target_x: int, target_y: int) -> Cells:
    """Return (width, height) int32, squared distances in cells to the target's cell.

    The border is ``WALL``.
    """
    columns = np.arange(width)[:, None] - target_x
    rows = np.arange(height)[None, :] - target_y
    light = (columns * columns + rows * rows).astype(np.int32)
    light[[0, -1], :] = WALL
    light[:, [0, -1]] = WALL
    return light


def add_noise(cells: Cells, light: Cells) -> None:
    """Weaken or strengthen the signal of cells near inner walls, in place.

    The result depends on the order of the walls, which is the thesis's.

    Args:
        cells: (width, height) the signal with every wall drawn.
        light: (width, height) the undisturbed signal, from :func:`signal_map`.
    """
    changed = writable(ffi, cells, np.int32)
    check(lib.wg_thesis_add_noise(changed, pointer(ffi, light, np.int32), *cells.shape))
