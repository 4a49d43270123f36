"""An episode that stops and goes on."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from sim.kernels import layout
from sim.kernels._jit import rare_kernel
from sim.kernels.lattice_state import Arena, Robot, Room
from sim.kernels.lattice_step import one_step

__all__ = ["lattice_onward"]

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]


@rare_kernel
def lattice_onward(
    arena: Arena,
    settings: Ints,
    scales: Floats,
    act: Any,
    room: Room,
    robot: Robot,
    begun: Ints,
    rows: Ints,
    path: Ints,
) -> None:
    """Goes on by as many steps as there are rows, without digest and search for recurrences.

    Args:
        arena: As the steps before have left it.
        settings: ``SET_``.
        scales: ``SCALE_``.
        act: Compiled controller.
        room: As the steps before have left it.
        robot: Likewise.
        begun: (2,) steps that are done, and the index of the next event; counted on.
        rows: (n, ROW_STATE + STATE_MEMORY + len(memory)); filled.
        path: (points, POINT_SIZE), with room for all points of these steps; filled from the first row on.
    """
    before = robot.counts[layout.OUT_POINTS]
    for row in range(rows.shape[0]):
        step = begun[0] + 1
        event, count, bumped = one_step(arena, settings, scales, act, room, robot, step, begun[1])
        begun[0], begun[1] = step, event
        rows[row, layout.ROW_BUMP] = 1 if bumped else 0
        for k in range(robot.state.size):
            rows[row, layout.ROW_STATE + k] = robot.state[k]
        first = robot.counts[layout.OUT_POINTS] - count - before
        for k in range(count):
            path[first + k, layout.POINT_STEP], path[first + k, layout.POINT_TIME] = step, robot.chain[k, 2]
            path[first + k, layout.POINT_X], path[first + k, layout.POINT_Y] = robot.chain[k, 0], robot.chain[k, 1]
