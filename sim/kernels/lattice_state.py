"""What the episodes on the pose lattice work with: the surroundings, the robot, a room for its controller."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from sim.kernels import layout
from sim.kernels._jit import kernel, rare_kernel
from sim.kernels.lattice_motion import MOST_POINTS
from sim.kernels.layout import SPEED_UNIT

__all__ = ["HASH_START", "Arena", "Robot", "Room", "new_robot", "new_room", "same", "set_out", "whole_speed"]

HASH_START = np.uint64(1469598103934665603)
"""Of the traces' digests, as in the thesis's vectors: FNV-1a over 64-bit words."""

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]


class Arena(NamedTuple):
    """What surrounds the robot; ``cells``, ``near`` and ``visited`` change during an episode.

    Args:
        cells: (height, width) uint8, cell states now.
        near: (height, width) int32, :func:`sim.kernels.geometry.near_masks` of ``cells``.
        clearance: (height, width) int32, chessboard distance to cells that are ever not free; of no rows where
            the masks reach as far as any step.
        events: (n, EVENT_SIZE) int64, sorted by step and time.
        headings: (131072,) int64, :func:`sim.kernels.lattice_sense.heading_table`.
        visited: (height, width) uint8, cells that the centre has been in.
    """

    cells: npt.NDArray[np.uint8]
    near: npt.NDArray[np.int32]
    clearance: npt.NDArray[np.int32]
    events: Ints
    headings: Ints
    visited: npt.NDArray[np.uint8]


class Robot(NamedTuple):
    """The robot and what is reported of it.

    Args:
        state: (STATE_MEMORY + memory,) int64, ``STATE_``.
        odometry: (3,) x and y, lattice units, and heading, heading units, as the robot measured them.
        chain: (n, 3) int64, path of the last step: x, y, time in the step.
        counts: (OUT_SIZE,) int64, ``OUT_``.
        sums: (SUM_SIZE,) ``SUM_``.
    """

    state: Ints
    odometry: Floats
    chain: Ints
    counts: Ints
    sums: Floats


class Room(NamedTuple):
    """What an episode works with, made beforehand, so that kernels make no arrays.

    Args:
        memory: The controller's memory.
        words: The same bits as int64.
        observation: (OBS_SIZE + beams,) what the controller sees.
        command: (CMD_SIZE,) what it asks for.
        anchor: A state to come back to.
        brent: (3,) int64, steps from the anchor to the next one, steps since it, and whether the last step
            touched a wall.
    """

    memory: Floats
    words: Ints
    observation: Floats
    command: Floats
    anchor: Ints
    brent: Ints


def new_robot(memory: int, events: Ints) -> Robot:
    """A robot with so many numbers of memory, and room for the path of a step with the most events."""
    most = int(np.unique(events[:, layout.EVENT_STEP], return_counts=True)[1].max()) if len(events) else 0
    return Robot(
        np.zeros(layout.STATE_MEMORY + memory, np.int64),
        np.zeros(3),
        np.zeros((MOST_POINTS * (most + 1), 3), np.int64),
        np.zeros(layout.OUT_SIZE, np.int64),
        np.zeros(layout.SUM_SIZE),
    )


def new_room(memory: int, beams: int) -> Room:
    """Room for a controller with so many numbers of memory, and so many range beams."""
    values = np.zeros(memory)
    return Room(
        values,
        values.view(np.int64),
        np.full(layout.OBS_SIZE + beams, np.nan),
        np.zeros(layout.CMD_SIZE),
        np.zeros(layout.STATE_MEMORY + memory, np.int64),
        np.zeros(3, np.int64),
    )


@kernel
def whole_speed(asked: float) -> int:
    """Whole units of speed, never more than asked for, so that nobody outruns the top speed."""
    whole = int(math.floor(abs(asked) + 1e-9))
    return whole if asked >= 0.0 else -whole


@rare_kernel
def _begin(settings: Ints, scales: Floats, robot: Robot) -> None:
    """Sets state and reports to the start of an episode."""
    state, counts = robot.state, robot.counts
    for k in range(counts.size):
        counts[k] = 0
    for k in range(robot.sums.size):
        robot.sums[k] = 0.0
    counts[layout.OUT_HIT_STEP], counts[layout.OUT_OVERLAP_STEP] = -1, -1
    counts[layout.OUT_DIGEST] = np.int64(HASH_START)
    state[layout.STATE_X], state[layout.STATE_Y] = settings[layout.SET_X], settings[layout.SET_Y]
    state[layout.STATE_HEADING] = settings[layout.SET_HEADING]
    speed = scales[layout.SCALE_START_SPEED] * scales[layout.SCALE_SPEED] * SPEED_UNIT
    state[layout.STATE_SPEED], state[layout.STATE_DRAWS] = whole_speed(speed), 0
    for k in range(3):
        robot.odometry[k] = float(state[layout.STATE_X + k])


@rare_kernel
def set_out(settings: Ints, scales: Floats, memory: Floats, room: Room, robot: Robot) -> None:
    """Puts a robot at its start, with its memory at reset."""
    _begin(settings, scales, robot)
    for k in range(memory.size):
        room.memory[k] = memory[k]
        robot.state[layout.STATE_MEMORY + k] = room.words[k]
    for k in range(room.anchor.size):
        room.anchor[k] = 0
    room.brent[0], room.brent[1], room.brent[2] = 1, 0, 0


@kernel
def same(one: Ints, other: Ints) -> bool:
    """Whether two states are equal, word by word."""
    k = 0
    while k < one.size and one[k] == other[k]:
        k += 1
    return k == one.size
