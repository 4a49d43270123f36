"""Many episodes of one controller in one world, in one call."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from sim.kernels import layout
from sim.kernels._jit import rare_kernel
from sim.kernels.lattice_episode import lattice_episode
from sim.kernels.lattice_state import Arena, Robot, Room, last_event
from sim.kernels.lattice_step import one_step
from sim.kernels.layout import UNIT
from sim.kernels.recurrence import entry_of_loop

__all__ = ["lattice_batch", "lone_step"]

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]


@rare_kernel
def lone_step(
    arena: Arena, settings: Ints, scales: Floats, act: Any, room: Room, robot: Robot, step: int, event: int
) -> int:
    """:func:`one_step` as a call of its own; the index of the next event."""
    return one_step(arena, settings, scales, act, room, robot, step, event)[0]


@rare_kernel
def _renew(arena: Arena, fresh: Arena, settings: Ints) -> None:
    """Sets an arena back to what it was before the first event."""
    if arena.events.shape[0] > 0:
        for iy in range(fresh.cells.shape[0]):
            for ix in range(fresh.cells.shape[1]):
                arena.cells[iy, ix] = fresh.cells[iy, ix]
                arena.near[iy, ix] = fresh.near[iy, ix]
    for iy in range(arena.visited.shape[0]):
        for ix in range(arena.visited.shape[1]):
            arena.visited[iy, ix] = 0
    x, y = settings[layout.SET_X] // UNIT, settings[layout.SET_Y] // UNIT
    arena.visited[min(y, arena.visited.shape[0] - 1), min(x, arena.visited.shape[1] - 1)] = 1


@rare_kernel
def lattice_batch(
    fresh: Arena,
    arena: Arena,
    settings: Ints,
    scales: Floats,
    act: Any,
    memory: Floats,
    room: Room,
    robot: Robot,
    starts: Ints,
    seeds: Ints,
    nothing: Ints,
    counts: Ints,
    sums: Floats,
) -> None:
    """Runs many episodes of one controller in one world.

    A recurrence is counted as :func:`sim.simulate` counts it: up to the end of its first period.

    Args:
        fresh: Surroundings before the first event; not changed.
        arena: A copy of them, to be used.
        settings: ``SET_``; start, seed, steps and the search for loops are changed and set back.
        scales: ``SCALE_``.
        act: Compiled controller.
        memory: Its memory at reset.
        room: To be used.
        robot: Likewise.
        starts: (n, 3) x, y, heading, lattice units.
        seeds: (n,) bits of uint64s.
        nothing: (0, 1) int64.
        counts: (n, OUT_SIZE), filled.
        sums: (n, SUM_SIZE), filled.
    """
    steps, find_loop = settings[layout.SET_STEPS], settings[layout.SET_FIND_LOOP]
    for n in range(seeds.size):
        for k in range(3):
            settings[layout.SET_X + k] = starts[n, k]
        settings[layout.SET_SEED] = seeds[n]
        _renew(arena, fresh, settings)
        lattice_episode(arena, settings, scales, act, memory, room, robot, nothing, nothing)

        # A loop is run again, up to the end of its first period, which also proves it.
        if robot.counts[layout.OUT_ENDING] == layout.LOOP:
            end, period = robot.counts[layout.OUT_STEPS], robot.counts[layout.OUT_PERIOD]
            entry = entry_of_loop(room.search.log, last_event(arena), end, period)
            settings[layout.SET_STEPS], settings[layout.SET_ENTRY] = entry + period, entry
            settings[layout.SET_FIND_LOOP] = layout.PROVE_LOOP
            _renew(arena, fresh, settings)
            lattice_episode(arena, settings, scales, act, memory, room, robot, nothing, nothing)

            # If two different states had one fingerprint, the budget counts.
            if robot.counts[layout.OUT_ENDING] == layout.LIMIT:
                settings[layout.SET_STEPS], settings[layout.SET_FIND_LOOP] = steps, layout.NO_LOOP
                _renew(arena, fresh, settings)
                lattice_episode(arena, settings, scales, act, memory, room, robot, nothing, nothing)
        settings[layout.SET_STEPS], settings[layout.SET_FIND_LOOP] = steps, find_loop
        for k in range(counts.shape[1]):
            counts[n, k] = robot.counts[k]
        for k in range(sums.shape[1]):
            sums[n, k] = robot.sums[k]
