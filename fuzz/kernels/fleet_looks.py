"""First looks at many worlds in lockstep, for a controller that acts for many robots at once.

Each place in the fleet holds a robot in a world of its own. When its run is over it is watched for a while where that
says more, and then the next world takes its place, so that the controller always acts for as many as there are places.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from fuzz.kernels._jit import kernel, rare_kernel
from fuzz.kernels.looks import (
    LOOK_HEIGHT,
    LOOK_WIDTH,
    Batch,
    Desk,
    begin_watch,
    close_look,
    goes_on,
    masks_do,
    next_look,
    note_step,
)
from sim.kernels import layout
from sim.kernels._views import row
from sim.kernels.lattice_fleet import (
    SHAPE_HEIGHT,
    SHAPE_TABLE,
    SHAPE_WIDTH,
    Fleet,
    act_slot,
    arena_of,
    fleet_begin,
    move_slot,
    robot_of,
    room_of,
)
from sim.kernels.recurrence import TOUCHED

__all__ = ["RIDE_RUN", "RIDE_SIZE", "board_fleet", "next_step"]

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]

RIDE_RUN, RIDE_WATCH = 0, 1  # the run that a place is taken by; steps for which it is watched, 0 before its run is over
RIDE_HEADING, RIDE_TOUCHED = 2, 3  # of a robot that is watched, before its next step
RIDE_SIZE = 4

_ENDLESS = 1 << 62  # steps


@kernel
def _desk_at(desk: Desk, fleet: Fleet, robot: int) -> Desk:
    """A desk on which a world is drawn right into a robot's own arrays."""
    return Desk(
        desk.solid,
        desk.flood,
        row(fleet.cells, robot),
        row(fleet.near, robot),
        row(fleet.clearance, robot),
        row(fleet.visited, robot),
        desk.events,
        desk.headings,
        row(fleet.settings, robot),
        row(fleet.scales, robot),
        desk.nothing,
    )


@rare_kernel
def _board(batch: Batch, desk: Desk, fleet: Fleet, rides: Ints, memory: Floats, slot: int) -> bool:
    """Put a robot in the next world where there is a way to the target; false if none is left."""
    robot = fleet.order[slot]
    place = _desk_at(desk, fleet, robot)
    n = next_look(batch, place)
    if n < 0:
        return False
    batch.at[0] = n + 1
    rides[robot, RIDE_RUN] = n
    rides[robot, RIDE_WATCH] = 0
    fleet.shape[robot, SHAPE_HEIGHT] = batch.looks[n, LOOK_HEIGHT]
    fleet.shape[robot, SHAPE_WIDTH] = batch.looks[n, LOOK_WIDTH]
    fleet.shape[robot, SHAPE_TABLE] = 0 if masks_do(place.settings, place.scales) else 1
    fleet_begin(fleet, slot, memory)
    return True


@rare_kernel
def board_fleet(batch: Batch, desk: Desk, fleet: Fleet, rides: Ints, memory: Floats) -> int:
    """Fill all places, as far as there are worlds, and move their robots for the first time.

    Args:
        batch: The runs, from ``at`` on.
        desk: To be used.
        fleet: One world for each robot.
        rides: (n, RIDE_SIZE), filled.
        memory: The controller's memory at reset.

    Returns:
        How many places are taken, the first ones.
    """
    count = 0
    while count < fleet.order.size and _board(batch, desk, fleet, rides, memory, count):
        move_slot(fleet, count)
        count += 1
    return count


@kernel
def _rides_on(batch: Batch, fleet: Fleet, rides: Ints, slot: int, is_over: bool) -> bool:
    """Notes what a step of a robot says; whether it goes on in its world."""
    robot, looks = fleet.order[slot], batch.looks
    n = rides[robot, RIDE_RUN]
    arena, room, driver = arena_of(fleet, robot), room_of(fleet, robot, slot), robot_of(fleet, robot)
    if rides[robot, RIDE_WATCH] == 0:
        if not is_over:
            return True
        close_look(batch, arena, driver, n)
        if looks[n, layout.OUT_ENDING] != layout.LOOP and looks[n, layout.OUT_ENDING] != layout.LIMIT:
            return False
        rides[robot, RIDE_WATCH] = begin_watch(driver, batch, n)
        rides[robot, RIDE_TOUCHED] = room.search.marks[TOUCHED]
        fleet.settings[robot, layout.SET_FIND_LOOP] = layout.NO_LOOP
        fleet.settings[robot, layout.SET_STEPS] = _ENDLESS
    else:
        before = (rides[robot, RIDE_HEADING], rides[robot, RIDE_TOUCHED] != 0)
        touches = note_step(arena, row(fleet.settings, robot), room, driver, before, looks, n)
        rides[robot, RIDE_TOUCHED] = 1 if touches else 0
    rides[robot, RIDE_HEADING] = driver.state[layout.STATE_HEADING]
    return goes_on(arena, driver, looks, n, rides[robot, RIDE_WATCH])


@rare_kernel
def next_step(batch: Batch, desk: Desk, fleet: Fleet, rides: Ints, memory: Floats, after: Floats, count: int) -> int:
    """Let each robot obey, note what its step says, and move it on; whoever is done makes room for the next world.

    All of this is one pass over the robots, because what one of them needs is read from memory only once then.

    Args:
        batch: The runs; the results of those that are done are filled in.
        desk: To be used.
        fleet: After the controller acted; its order changes.
        rides: As :func:`board_fleet` filled them.
        memory: The controller's memory at reset.
        after: (n, memory) by slot, memory as the controller wants it.
        count: Slots that are taken.

    Returns:
        How many are taken now, the first ones.
    """
    kept = 0
    for slot in range(count):
        is_last = act_slot(fleet, slot, after)
        stays = _rides_on(batch, fleet, rides, slot, is_last)
        if not stays and not _board(batch, desk, fleet, rides, memory, slot):
            continue
        if kept != slot:
            fleet.order[kept] = fleet.order[slot]
            for k in range(fleet.words.shape[1]):
                fleet.words[kept, k] = fleet.words[slot, k]
            # A robot that ends in its next move senses nothing there: what it sensed last still counts.
            for k in range(fleet.observation.shape[1]):
                fleet.observation[kept, k] = fleet.observation[slot, k]
        move_slot(fleet, kept)
        kept += 1
    return kept
