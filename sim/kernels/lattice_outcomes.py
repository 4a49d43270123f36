"""What one step makes of each of many states, for every value that a random number may have."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from sim.kernels import layout
from sim.kernels._jit import rare_kernel
from sim.kernels.lattice_state import Arena, Robot, Room
from sim.kernels.lattice_step import is_inside, move_and_sense, obey, remember

__all__ = ["lattice_outcomes"]

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]


@rare_kernel
def lattice_outcomes(
    arena: Arena,
    settings: Ints,
    scales: Floats,
    act: Any,
    room: Room,
    robot: Robot,
    states: Ints,
    faces: Ints,
    after: Ints,
    endings: Ints,
    drew: Ints,
) -> None:
    """One step from each state. The world must not change, and nothing but the controller may draw random numbers.

    Args:
        arena: Surroundings.
        settings: ``SET_``; ``SET_COIN`` says how many values a random number has.
        scales: ``SCALE_``.
        act: Compiled controller.
        room: Of an episode, to be used.
        robot: Likewise.
        states: (n, STATE_MEMORY + memory) complete states; the number of draws is left out of account.
        faces: (n,) which value the random number has that is drawn next, from 0.
        after: Like ``states``, filled; the number of draws is 0.
        endings: (n,) filled, ``LIMIT`` where the run goes on.
        drew: (n,) filled, 1 if the random number was used up.
    """
    senses, coin = settings[layout.SET_SENSES], settings[layout.SET_COIN]
    for n in range(states.shape[0]):
        for k in range(states.shape[1]):
            robot.state[k] = states[n, k]
        for k in range(room.words.size):
            room.words[k] = states[n, layout.STATE_MEMORY + k]
        robot.state[layout.STATE_DRAWS], robot.counts[layout.OUT_ENDING] = 0, layout.LIMIT
        move_and_sense(arena, settings, scales, room, robot, 1, 0)
        if robot.counts[layout.OUT_ENDING] == layout.LIMIT and is_inside(arena, robot):
            if senses & layout.SENSE_RANDOM != 0:
                room.observation[layout.OBS_RANDOM] = faces[n] / coin
            act(room.observation, room.memory, room.command)
            obey(settings, scales, room.command, 1, robot)
        remember(room, robot)
        endings[n], drew[n] = robot.counts[layout.OUT_ENDING], robot.state[layout.STATE_DRAWS]
        robot.state[layout.STATE_DRAWS] = 0
        for k in range(states.shape[1]):
            after[n, k] = robot.state[k]
