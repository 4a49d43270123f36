"""Single parts of the thesis's simulator in C, for tests."""

from __future__ import annotations

from typing import Any

import numpy as np

from sim._core import ffi as _ffi
from sim._core import lib as _lib
from sim.thesis.core_calls import ThesisSetup
from worldgen.support.ccall import check, pointer

SLIDE: int = _lib.WG_SLIDE
WEAKENED: int = _lib.WG_SIGNAL_WEAKENED
BLOCKED: int = _lib.WG_SIGNAL_BLOCKED


def move(
    cells: Any,
    x: float,
    y: float,
    goal_x: float,
    goal_y: float,
    radius: float,
    repairs: int,
    friction: float,
) -> Any:
    """Move the disc towards a goal: a ``WgThesisMove``."""
    moved = _ffi.new("WgThesisMove *")
    grid = (pointer(_ffi, cells, np.int32), *cells.shape)
    robot = ThesisSetup(
        rule=1, time_step=15.0, radius=radius, repairs=repairs, wall_friction=friction
    )
    settings = _ffi.new("WgThesisSettings *", robot._asdict())
    check(_lib.wg_thesis_move(*grid, settings, x, y, goal_x, goal_y, moved))
    return moved


def sensed(cells: Any, setup: ThesisSetup, x: float, y: float, looking: float, step: int) -> float:
    """Return the heading to the best signal."""
    heading = _ffi.new("double *")
    settings = _ffi.new("WgThesisSettings *", setup._asdict())
    grid = (pointer(_ffi, cells, np.int32), *cells.shape)
    check(_lib.wg_thesis_sense(*grid, settings, x, y, looking, step, heading))
    return float(heading[0])


def walls_between(cells: Any, x: int, y: int, to_x: int, to_y: int) -> int:
    """Count the walls on the straight line between two cells."""
    walls = _ffi.new("int64_t *")
    check(
        _lib.wg_thesis_walls_between(
            pointer(_ffi, cells, np.int32), *cells.shape, x, y, to_x, to_y, walls
        )
    )
    return int(walls[0])
