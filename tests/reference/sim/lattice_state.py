"""The data of episodes on the pose lattice:

the surroundings, the robot, a workspace for its controller.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from tests.reference.sim import layout
from tests.reference.sim.lattice_motion import MOST_POINTS
from tests.reference.sim.layout import SPEED_UNIT
from tests.reference.sim.recurrence import TOUCHED, Search, begin_search, new_search

HASH_START = np.uint64(1469598103934665603)
"""For the traces' digests, as in the thesis's vectors: FNV-1a over 64-bit words."""

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]


class Carriage(NamedTuple):
    """A body, or a car.

    Args:
        body: Corners in the robot's frame, counter-clockwise, lattice units; none for a disc.
        turn_per_unit: Heading units that a car turns, at most, on a lattice unit; 0: it is no car.
        turning_radius: Of a car, m.
        steering_rate: Largest change of its curvature, as a share of the largest, 1/s.
        reverse: Whether it may drive backwards.
    """

    body: tuple[tuple[int, int], ...]
    turn_per_unit: float
    turning_radius: float
    steering_rate: float
    reverse: bool


class Arena(NamedTuple):
    """The robot's surroundings; ``cells``, ``near`` and ``visited`` change during an episode.

    Args:
        cells: (height, width) uint8, cell states now.
        near: (height, width) int32, :func:`tests.reference.sim.geometry.near_masks` of ``cells``.
        clearance: (height, width) int32, chessboard distance to cells that are not free at some
            time; no rows if the masks reach as far as any step.
        events: (n, EVENT_SIZE) int64, sorted by step and time.
        headings: (131072,) int64, :func:`tests.reference.sim.lattice_sense.heading_table`.
        visited: (height, width) uint8, cells that the centre has been in.
        pushes: (n, PUSH_SIZE) int64, pushes at places first, then those at times, by step.
        decoys: Other sources of the signal: x, y, lattice units, and strength.
        wanted: (height, width) uint8, cells that a coverage task requires; no rows for other tasks.
        carriage: The robot's body and drive; None for a disc that turns on the spot.
        goals: The waypoints and the target, in order, each as the numbers of a WgGoal.
    """

    cells: npt.NDArray[np.uint8]
    near: npt.NDArray[np.int32]
    clearance: npt.NDArray[np.int32]
    events: Ints
    headings: Ints
    visited: npt.NDArray[np.uint8]
    pushes: Ints
    decoys: tuple[tuple[int, int, float], ...]
    wanted: npt.NDArray[np.uint8]
    carriage: Carriage | None = None
    goals: tuple[tuple[int, ...], ...] = ()


class Robot(NamedTuple):
    """The robot and its reports.

    Args:
        state: (STATE_MEMORY + memory,) int64, ``STATE_``; a robot with waypoints has one more: how
            many it has passed; a body or a car has two more: 1 plus the heading away from the wall
            that cut its last turn short, and its curvature; a car has two more, by which its exact
            place is away from the lattice, in 1/256 of a unit.
        odometry: (3,) x and y, lattice units, and heading, heading units, as the robot measured
            them.
        chain: (n, 3) int64, path of the last step: x, y, time in the step.
        counts: (OUT_SIZE,) int64, ``OUT_``.
        sums: (SUM_SIZE,) ``SUM_``.
        turned: (1,) how far a car has turned in the last step, heading units.
        journey: (2,) int64: 1 if its path has met a waypoint in this step, and the step in which it
            passed the last one.
    """

    state: Ints
    odometry: Floats
    chain: Ints
    counts: Ints
    sums: Floats
    turned: Ints
    journey: Ints


class Room(NamedTuple):
    """The workspace of an episode, made beforehand, so that kernels make no arrays.

    Args:
        memory: The controller's memory.
        words: The same bits as int64.
        observation: (OBS_SIZE + beams,) the controller's observation.
        command: (CMD_SIZE,) its command.
        search: For a recurring state.
    """

    memory: Floats
    words: Ints
    observation: Floats
    command: Floats
    search: Search


def new_robot(
    memory: int, events: Ints, pushes: int = 0, *, carriage: int = 0, legs: int = 1
) -> Robot:
    """A robot with this many numbers of memory, and room for the path of the step with the most
    events.
    """
    most = (
        int(np.unique(events[:, layout.EVENT_STEP], return_counts=True)[1].max())
        if len(events)
        else 0
    )
    return Robot(
        np.zeros(layout.STATE_MEMORY + memory + carriage, np.int64),
        np.zeros(3),
        np.zeros((MOST_POINTS * (most + legs + pushes), 3), np.int64),
        np.zeros(layout.OUT_SIZE, np.int64),
        np.zeros(layout.SUM_SIZE),
        np.zeros(1, np.int64),
        np.zeros(2, np.int64),
    )


def new_room(memory: int, beams: int, steps: int = 0, *, carriage: int = 0) -> Room:
    """Workspace for a controller with this many numbers of memory and range beams.

    Args:
        memory: Numbers of memory.
        beams: Range beams.
        steps: Steps of the longest run in which a recurrence is searched for; 0 for none.
    """
    values = np.zeros(memory)
    return Room(
        values,
        values.view(np.int64),
        np.full(layout.OBS_SIZE + beams, np.nan),
        np.zeros(layout.CMD_SIZE),
        new_search(layout.STATE_MEMORY + memory + carriage, steps),
    )


def last_event(arena: Arena) -> int:
    """Last step in which the world changes or something pushes the robot; 0 if there is none."""
    events, pushes = arena.events, arena.pushes
    changed = events[events.shape[0] - 1, layout.EVENT_STEP] if events.shape[0] > 0 else 0
    pushed = pushes[pushes.shape[0] - 1, layout.PUSH_STEP] if pushes.shape[0] > 0 else 0
    return max(changed, pushed)


def whole_speed(asked: float) -> int:
    """Whole units of speed, never more than commanded, so that the top speed is never exceeded."""
    whole = math.floor(abs(asked) + 1e-9)
    return whole if asked >= 0.0 else -whole


def _begin(settings: Ints, scales: Floats, robot: Robot) -> None:
    """Sets state and reports to the start of an episode."""
    state, counts = robot.state, robot.counts
    for k in range(counts.size):
        counts[k] = 0
    for k in range(robot.sums.size):
        robot.sums[k] = 0.0
    counts[layout.OUT_HIT_STEP], counts[layout.OUT_OVERLAP_STEP] = -1, -1
    counts[layout.OUT_DIGEST] = np.int64(HASH_START)
    counts[layout.OUT_VISITED] = 1
    state[layout.STATE_X], state[layout.STATE_Y] = settings[layout.SET_X], settings[layout.SET_Y]
    state[layout.STATE_HEADING] = settings[layout.SET_HEADING]
    speed = scales[layout.SCALE_START_SPEED] * scales[layout.SCALE_SPEED] * SPEED_UNIT
    state[layout.STATE_SPEED], state[layout.STATE_DRAWS] = whole_speed(speed), 0
    for k in range(3):
        robot.odometry[k] = float(state[layout.STATE_X + k])


def set_out(
    settings: Ints, scales: Floats, memory: Floats, room: Room, robot: Robot, quiet: int
) -> None:
    """Puts a robot at its start, with its memory at reset.

    Args:
        settings: ``SET_``.
        scales: ``SCALE_``.
        memory: The memory at reset.
        room: Its room.
        robot: The robot.
        quiet: Step of the last event, 0 if there is none.
    """
    if (
        settings[layout.SET_FIND_LOOP] == layout.SEEK_LOOP
        and room.search.log.size <= settings[layout.SET_STEPS]
    ):
        raise ValueError(
            "the room's log is shorter than the run; make it with new_room(..., steps)"
        )
    _begin(settings, scales, robot)
    for k in range(memory.size):
        room.memory[k] = memory[k]
        robot.state[layout.STATE_MEMORY + k] = room.words[k]
    for k in range(layout.STATE_MEMORY + memory.size, robot.state.size):
        robot.state[k] = 0
    room.search.marks[TOUCHED] = 0
    if settings[layout.SET_FIND_LOOP] != layout.NO_LOOP:
        begin_search(room.search, robot.state, quiet)
