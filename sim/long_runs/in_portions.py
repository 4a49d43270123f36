"""A compiled controller's run, portion by portion: never more of it is held than a portion's states."""

from __future__ import annotations

import functools
from collections.abc import Iterator
from typing import Any, NamedTuple

import numba
import numpy as np
import numpy.typing as npt

from sim.controllers.base import CompiledController, compiled_act, numba_config
from sim.kernel_types import episode_types, typed_kernel
from sim.kernels import layout
from sim.kernels.lattice_motion import MOST_POINTS
from sim.kernels.lattice_state import Arena, new_robot, new_room, set_out
from sim.long_runs.onward import lattice_onward

__all__ = ["MOST_HELD", "Portion", "portions"]

MOST_HELD = 1 << 26  # bytes of states: a run with less is recorded with all of them

_MOST_ROWS = 1 << 16  # of a portion

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]


class Portion(NamedTuple):
    """Some steps of a run, one after the other; the arrays are overwritten by the next portion.

    Args:
        first: Number of the first of these steps; the start is step 0.
        rows: (n, ROW_STATE + STATE_MEMORY + memory) ``ROW_``.
        path: (m, POINT_SIZE) ``POINT_``.
    """

    first: int
    rows: Ints
    path: Ints


def portions(
    controller: CompiledController, arena: Arena, settings: Ints, scales: Floats, steps: int
) -> Iterator[Portion]:
    """The run from its start to a step that it is known to reach.

    Args:
        controller: Who drives.
        arena: The world before the first event; changed.
        settings: ``SET_``.
        scales: ``SCALE_``.
        steps: How many.
    """
    memory = np.array(controller.memory, np.float64)
    robot, room = new_robot(memory.size, arena.events), new_room(memory.size, int(settings[layout.SET_BEAMS]))
    width = layout.ROW_STATE + robot.state.size
    most = min(_MOST_ROWS, max(1, MOST_HELD // 4 // (8 * width)))
    rows = np.zeros((min(most, steps) + 1, width), np.int64)
    path = np.zeros((MOST_POINTS * (len(rows) + len(arena.events)), layout.POINT_SIZE), np.int64)
    set_out(settings, scales, memory, room, robot, 0)
    rows[0, layout.ROW_STATE :] = robot.state
    yield Portion(0, rows[:1], path[:0])
    kernel, act, begun = _typed_onward(), compiled_act(controller.act), np.zeros(2, np.int64)
    while begun[0] < steps and robot.counts[layout.OUT_ENDING] == layout.LIMIT:
        done, points = int(begun[0]), int(robot.counts[layout.OUT_POINTS])
        count = min(most, steps - done)
        try:
            kernel(arena, settings, scales, act, room, robot, begun, rows[:count], path)
        except Exception:  # noqa: BLE001 - raised in the compiled controller; the run ended there the first time too
            count = int(begun[0]) - done
            steps = done + count
        yield Portion(done + 1, rows[:count], path[: int(robot.counts[layout.OUT_POINTS]) - points])


@functools.cache
def _typed_onward() -> Any:
    """The kernel, typed for any compiled controller, so that it compiles once for all of them."""
    if numba_config.DISABLE_JIT:
        return lattice_onward
    arena, robot, room, act = episode_types()
    ints, floats, rows = numba.int64[::1], numba.float64[::1], numba.int64[:, ::1]
    return typed_kernel(lattice_onward, numba.void(arena, ints, floats, act, room, robot, ints, rows, rows))
