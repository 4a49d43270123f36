"""Many episodes of one controller in one world, in one call."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from sim.kernels import layout
from sim.kernels._jit import rare_kernel
from sim.kernels.lattice_episode import last_event, lattice_episode
from sim.kernels.lattice_state import Arena, Robot, Room, same, set_out
from sim.kernels.lattice_step import one_step
from sim.kernels.layout import UNIT

__all__ = ["lattice_batch", "lattice_entry", "lone_step"]

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
def lattice_entry(
    arenas: tuple[Arena, Arena],
    settings: Ints,
    scales: Floats,
    act: Any,
    memory: Floats,
    rooms: tuple[Room, Room],
    robots: tuple[Robot, Robot],
    period: int,
    most: int,
) -> int:
    """First step of a recurrence after the last event; the first robot is left in that step's state.

    Two equal robots find it, the second ``period`` steps ahead of the first. -1 if the state does not come again.

    Args:
        arenas: Two copies of the surroundings before the first event.
        settings: ``SET_``.
        scales: ``SCALE_``.
        act: Compiled controller, for which the recurrence was found.
        memory: Its memory at reset.
        rooms: Two.
        robots: Two.
        period: Steps of the recurrence.
        most: Step in which it was found.
    """
    for which in range(2):
        set_out(settings, scales, memory, rooms[which], robots[which])
    (slow, fast), quiet = robots, last_event(arenas[0])
    step, event_slow, event_fast = 0, 0, 0
    for ahead in range(1, period + 1):
        event_fast = lone_step(arenas[1], settings, scales, act, rooms[1], fast, ahead, event_fast)
    while step < quiet or not same(slow.state, fast.state):
        if step >= most:
            return -1
        step += 1
        event_slow = lone_step(arenas[0], settings, scales, act, rooms[0], slow, step, event_slow)
        event_fast = lone_step(arenas[1], settings, scales, act, rooms[1], fast, step + period, event_fast)
    return step


@rare_kernel
def lattice_batch(
    fresh: Arena,
    arenas: tuple[Arena, Arena],
    settings: Ints,
    scales: Floats,
    act: Any,
    memory: Floats,
    rooms: tuple[Room, Room],
    robots: tuple[Robot, Robot],
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
        arenas: Two copies of them, to be used.
        settings: ``SET_``; start, seed, steps and the search for loops are changed and set back.
        scales: ``SCALE_``.
        act: Compiled controller.
        memory: Its memory at reset.
        rooms: Two, to be used.
        robots: Likewise.
        starts: (n, 3) x, y, heading, lattice units.
        seeds: (n,) bits of uint64s.
        nothing: (0, 1) int64.
        counts: (n, OUT_SIZE), filled.
        sums: (n, SUM_SIZE), filled.
    """
    steps, find_loop = settings[layout.SET_STEPS], settings[layout.SET_FIND_LOOP]
    robot = robots[0]
    for n in range(seeds.size):
        for k in range(3):
            settings[layout.SET_X + k] = starts[n, k]
        settings[layout.SET_SEED] = seeds[n]
        period = -1
        while True:  # a second time for a loop, up to the end of its first period
            _renew(arenas[0], fresh, settings)
            lattice_episode(arenas[0], settings, scales, act, memory, rooms[0], robot, nothing, nothing)
            if period >= 0 or robot.counts[layout.OUT_ENDING] != layout.LOOP:
                break
            period = robot.counts[layout.OUT_PERIOD]
            for which in range(2):
                _renew(arenas[which], fresh, settings)
            found = robot.counts[layout.OUT_STEPS]
            entry = lattice_entry(arenas, settings, scales, act, memory, rooms, robots, period, found)
            if entry < 0:
                period = 0  # and then for as long as there are steps
            else:
                settings[layout.SET_STEPS] = entry + period
            settings[layout.SET_FIND_LOOP] = 0
        if period > 0:
            robot.counts[layout.OUT_ENDING], robot.counts[layout.OUT_PERIOD] = layout.LOOP, period
        settings[layout.SET_STEPS], settings[layout.SET_FIND_LOOP] = steps, find_loop
        for k in range(counts.shape[1]):
            counts[n, k] = robot.counts[k]
        for k in range(sums.shape[1]):
            sums[n, k] = robot.sums[k]
