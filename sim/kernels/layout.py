"""Indices into the flat arrays that controllers compiled by numba receive.

Such a controller is a function ``act(observation, memory, command)``. The names match those in
``worldgen_controller.h``, which gives the meaning and unit of each number: ``OBS_BUMP`` is
``WgObservation.bump``. The range beams, in metres, follow from index ``OBS_SIZE`` on; the number
of them is a setting of the run. A controller that declares the sense ``goal_heading`` finds it
behind everything else, at ``OBS_GOAL_HEADING``. For one that declares ``tilt`` or ``tilt_heading``,
all three are there, the goal's heading last.
"""

from __future__ import annotations

from sim._core import ffi, lib

_NUMBER = 8  # bytes


def place(struct: str, *fields: str | int) -> int:
    """Return the index of a field in a struct of numbers; several names descend into it."""
    return int(ffi.offsetof(struct, *fields)) // _NUMBER


OBS_BUMP = place("WgObservation", "bump")
OBS_BUMP_BEARING = place("WgObservation", "bump_bearing")
OBS_SIGNAL = place("WgObservation", "signal")
OBS_SIGNAL_HEADING = place("WgObservation", "signal_heading")
OBS_HEADING = place("WgObservation", "heading")
OBS_X = place("WgObservation", "x")
OBS_Y = place("WgObservation", "y")
OBS_TARGET_HEADING = place("WgObservation", "target_heading")
OBS_TARGET_DISTANCE = place("WgObservation", "target_distance")
OBS_RANDOM = place("WgObservation", "random")
OBS_TIME_STEP = place("WgObservation", "time_step")
OBS_TOP_SPEED = place("WgObservation", "top_speed")
OBS_RADIUS = place("WgObservation", "radius")
OBS_TIME = place("WgObservation", "time")
OBS_ODOMETRY_X = place("WgObservation", "odometry_x")
OBS_ODOMETRY_Y = place("WgObservation", "odometry_y")
OBS_ODOMETRY_HEADING = place("WgObservation", "odometry_heading")
OBS_SIZE = place("WgObservation", "beams")
OBS_TILT = -3
OBS_TILT_HEADING = -2
OBS_GOAL_HEADING = -1
OBS_TAIL = 3
"""How many numbers follow the beams in the rows of vector controllers and programs: these three."""

CMD_SPEED = place("WgCommand", "speed")
CMD_TURN_RATE = place("WgCommand", "turn_rate")
CMD_DRAW = place("WgCommand", "used_random")
CMD_SIZE = CMD_DRAW + 1
CMD_MESSAGE = CMD_SIZE
"""Index of the first number of a message to the neighbours; the run's options set its length."""

MESSAGE_SIZE = int(lib.WG_MOST_MESSAGE)
"""Maximum length of a message."""

NEIGHBOUR_X = place("WgNeighbour", "x")
NEIGHBOUR_Y = place("WgNeighbour", "y")
NEIGHBOUR_HEADING = place("WgNeighbour", "heading")
NEIGHBOUR_SPEED = place("WgNeighbour", "speed")
NEIGHBOUR_RADIUS = place("WgNeighbour", "radius")
NEIGHBOUR_MESSAGE = place("WgNeighbour", "message")
"""Where a neighbour's message begins in its row. A row has this many numbers, plus the message's.

Rows follow the beams, the nearest neighbour first; rows without a neighbour are nan.
"""
