"""Many robots in lockstep, in worlds of any size: all move, then one call of their controller acts for all of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from sim.kernels import layout
from sim.kernels._jit import kernel, rare_kernel
from sim.kernels._views import page, part, row
from sim.kernels.lattice_episode import is_over
from sim.kernels.lattice_state import Arena, Robot, Room, last_event, set_out
from sim.kernels.lattice_step import is_inside, move_and_sense, obey, remember
from sim.kernels.recurrence import Search, entry_of_loop

__all__ = [
    "CLOCK_SIZE",
    "CLOCK_STEP",
    "SHAPE_HEIGHT",
    "SHAPE_SIZE",
    "SHAPE_TABLE",
    "SHAPE_WIDTH",
    "Fleet",
    "act_slot",
    "arena_of",
    "fleet_act",
    "fleet_begin",
    "fleet_entries",
    "fleet_move",
    "fleet_set_out",
    "move_slot",
    "robot_of",
    "room_of",
]

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]

CLOCK_STEP, CLOCK_EVENT = 0, 1  # steps done; index of the next event
CLOCK_POINTS, CLOCK_BUMP = 2, 3  # of the last step: points of its path, and whether a wall was touched
CLOCK_SIZE = 4

SHAPE_HEIGHT, SHAPE_WIDTH = 0, 1  # of a world, cells
SHAPE_TABLE = 2  # 1 if there is a table of distances
SHAPE_SIZE = 3


class Fleet(NamedTuple):
    """n robots in w worlds; what stands in ``order`` moves, the controller's numbers are in that order.

    Args:
        shape: (w, SHAPE_SIZE) int64, of each world.
        cells: (p, cells) uint8, pages of cell states, row by row, as many as the largest world has: one page for each
            world, or for each robot if worlds change.
        near: (p, cells) int32, as in :class:`sim.kernels.lattice_state.Arena`.
        clearance: (w, cells or 0) int32, likewise.
        events: (e, EVENT_SIZE) int64, of all worlds.
        headings: (131072,) int64.
        visited: (n, cells) uint8.
        page: (n,) int64, a robot's page.
        world: (n,) int64, a robot's world.
        span: (w, 2) int64, a world's first event, and the one after its last.
        settings: (n, SET_SIZE) int64.
        scales: (w, SCALE_SIZE).
        state: (n, STATE_MEMORY + memory) int64, and the like for all that a
            :class:`sim.kernels.lattice_state.Robot` has.
        odometry: (n, 3).
        chain: (n, points, 3) int64.
        counts: (n, OUT_SIZE) int64.
        sums: (n, SUM_SIZE).
        known: (n, STATE_MEMORY + memory) int64, and the like for all that a :class:`sim.kernels.recurrence.Search` has.
        prints: (n, blocks + 1) uint64.
        log: (n, steps + 1) uint64.
        marks: (n, MARKS) int64.
        clock: (n, CLOCK_SIZE) int64.
        order: (n,) int64, robots by slot.
        observation: (n, OBS_SIZE + beams) by slot.
        memory: (n, memory) by slot.
        words: The same bits as int64.
        command: (n, CMD_SIZE) by slot.
        nothing: (0, 1) int64.
    """

    shape: Ints
    cells: npt.NDArray[np.uint8]
    near: npt.NDArray[np.int32]
    clearance: npt.NDArray[np.int32]
    events: Ints
    headings: Ints
    visited: npt.NDArray[np.uint8]
    page: Ints
    world: Ints
    span: Ints
    settings: Ints
    scales: Floats
    state: Ints
    odometry: Floats
    chain: Ints
    counts: Ints
    sums: Floats
    known: Ints
    prints: npt.NDArray[np.uint64]
    log: npt.NDArray[np.uint64]
    marks: Ints
    clock: Ints
    order: Ints
    observation: Floats
    memory: Floats
    words: Ints
    command: Floats
    nothing: Ints


@kernel
def arena_of(fleet: Fleet, robot: int) -> Arena:
    """What surrounds a robot."""
    number, world = fleet.page[robot], fleet.world[robot]
    height, width = fleet.shape[world, SHAPE_HEIGHT], fleet.shape[world, SHAPE_WIDTH]
    table = fleet.shape[world, SHAPE_TABLE]
    return Arena(
        page(row(fleet.cells, number), height, width),
        page(row(fleet.near, number), height, width),
        page(row(fleet.clearance, world), table * height, table * width),
        part(fleet.events, fleet.span[world, 0], fleet.span[world, 1]),
        fleet.headings,
        page(row(fleet.visited, robot), height, width),
    )


@kernel
def robot_of(fleet: Fleet, robot: int) -> Robot:
    """A robot and what is reported of it."""
    return Robot(
        row(fleet.state, robot),
        row(fleet.odometry, robot),
        row(fleet.chain, robot),
        row(fleet.counts, robot),
        row(fleet.sums, robot),
    )


@kernel
def room_of(fleet: Fleet, robot: int, slot: int) -> Room:
    """The room of a robot in a slot."""
    return Room(
        row(fleet.memory, slot),
        row(fleet.words, slot),
        row(fleet.observation, slot),
        row(fleet.command, slot),
        Search(row(fleet.known, robot), row(fleet.prints, robot), row(fleet.log, robot), row(fleet.marks, robot)),
    )


@rare_kernel
def fleet_begin(fleet: Fleet, slot: int, memory: Floats) -> None:
    """Puts the robot in a slot at its start, with its memory at reset."""
    robot = fleet.order[slot]
    settings, scales = row(fleet.settings, robot), row(fleet.scales, fleet.world[robot])
    quiet = last_event(arena_of(fleet, robot))
    set_out(settings, scales, memory, room_of(fleet, robot, slot), robot_of(fleet, robot), quiet)
    for k in range(CLOCK_SIZE):
        fleet.clock[robot, k] = 0


@rare_kernel
def fleet_set_out(fleet: Fleet, count: int, memory: Floats) -> None:
    """Puts the robots in the first ``count`` slots at their starts, with their memory at reset."""
    for slot in range(count):
        fleet_begin(fleet, slot, memory)


@kernel
def move_slot(fleet: Fleet, slot: int) -> None:
    """Run the part of a step before the controller acts, for the robot in one slot."""
    robot = fleet.order[slot]
    settings = row(fleet.settings, robot)
    scales = row(fleet.scales, fleet.world[robot])
    clock = row(fleet.clock, robot)
    clock[CLOCK_STEP] += 1
    event, points, nx, ny = move_and_sense(
        arena_of(fleet, robot), settings, scales, room_of(fleet, robot, slot), robot_of(fleet, robot),
        clock[CLOCK_STEP], clock[CLOCK_EVENT],
    )  # fmt: skip
    clock[CLOCK_EVENT] = event
    clock[CLOCK_POINTS] = points
    clock[CLOCK_BUMP] = 1 if nx != 0.0 or ny != 0.0 else 0


@kernel
def act_slot(fleet: Fleet, slot: int, after: Floats) -> bool:
    """Run the rest of the step for the robot in one slot; arguments as for :func:`fleet_act`.

    Returns:
        Whether that was its last step.
    """
    robot = fleet.order[slot]
    settings = row(fleet.settings, robot)
    scales = row(fleet.scales, fleet.world[robot])
    arena, room, driver = arena_of(fleet, robot), room_of(fleet, robot, slot), robot_of(fleet, robot)
    clock = row(fleet.clock, robot)
    step = clock[CLOCK_STEP]
    if driver.counts[layout.OUT_ENDING] == layout.LIMIT and is_inside(arena, driver):
        for k in range(room.memory.size):
            room.memory[k] = after[slot, k]
        obey(settings, scales, room.command, step, driver)
    remember(room, driver)
    moved = (clock[CLOCK_POINTS], clock[CLOCK_BUMP] != 0)
    last = is_over(settings, room, driver, step, last_event(arena), moved, fleet.nothing, fleet.nothing)
    return bool(last or step >= settings[layout.SET_STEPS])


@rare_kernel
def fleet_move(fleet: Fleet, count: int) -> None:
    """The part of a step before the controller acts, for the robots in the first ``count`` slots."""
    for slot in range(count):
        move_slot(fleet, slot)


@rare_kernel
def fleet_act(fleet: Fleet, count: int, after: Floats, over: npt.NDArray[np.bool_]) -> int:
    """The rest of the step, with what ``command`` asks for.

    Args:
        fleet: The fleet.
        count: Slots that moved.
        after: (n, memory) by slot, memory as the controller wants it.
        over: (n,) by slot, filled: whether that was a robot's last step.

    Returns:
        How many had their last step.
    """
    ended = 0
    for slot in range(count):
        over[slot] = act_slot(fleet, slot, after)
        if over[slot]:
            ended += 1
    return ended


@rare_kernel
def fleet_entries(fleet: Fleet, robots: Ints, entries: Ints) -> None:
    """Fills in, for robots whose run ended as a loop, the step in which the loop begins."""
    for k in range(robots.size):
        robot = robots[k]
        counts, quiet = row(fleet.counts, robot), last_event(arena_of(fleet, robot))
        log, end = row(fleet.log, robot), counts[layout.OUT_STEPS]
        entries[k] = entry_of_loop(log, quiet, end, counts[layout.OUT_PERIOD])
