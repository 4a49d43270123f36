"""Indices into the flat arrays that controllers compiled by numba receive.

Such a controller is a function ``act(observation, memory, command)``. The names match those in
``worldgen_controller.h``, which gives the meaning and unit of each number: ``OBS_BUMP`` is
``WgObservation.bump``. The range beams, in metres, follow from index ``OBS_SIZE`` on.
"""

from __future__ import annotations

from sim._core import ffi, lib

_NUMBER = 8  # bytes


def _place(struct: str, field: str) -> int:
    return int(ffi.offsetof(struct, field)) // _NUMBER


OBS_BUMP = _place("WgObservation", "bump")
OBS_BUMP_BEARING = _place("WgObservation", "bump_bearing")
OBS_SIGNAL = _place("WgObservation", "signal")
OBS_SIGNAL_HEADING = _place("WgObservation", "signal_heading")
OBS_HEADING = _place("WgObservation", "heading")
OBS_X = _place("WgObservation", "x")
OBS_Y = _place("WgObservation", "y")
OBS_TARGET_HEADING = _place("WgObservation", "target_heading")
OBS_TARGET_DISTANCE = _place("WgObservation", "target_distance")
OBS_RANDOM = _place("WgObservation", "random")
OBS_TIME_STEP = _place("WgObservation", "time_step")
OBS_TOP_SPEED = _place("WgObservation", "top_speed")
OBS_RADIUS = _place("WgObservation", "radius")
OBS_TIME = _place("WgObservation", "time")
OBS_ODOMETRY_X = _place("WgObservation", "odometry_x")
OBS_ODOMETRY_Y = _place("WgObservation", "odometry_y")
OBS_ODOMETRY_HEADING = _place("WgObservation", "odometry_heading")
OBS_SIZE = _place("WgObservation", "beams")

CMD_SPEED = _place("WgCommand", "speed")
CMD_TURN_RATE = _place("WgCommand", "turn_rate")
CMD_DRAW = _place("WgCommand", "used_random")
CMD_SIZE = CMD_DRAW + 1
CMD_MESSAGE = CMD_SIZE
"""Index of the first number of a message to the neighbours; the run's options set its length."""

MESSAGE_SIZE = int(lib.WG_MOST_MESSAGE)
"""The most numbers that a message has."""

NEIGHBOUR_X = _place("WgNeighbour", "x")
NEIGHBOUR_Y = _place("WgNeighbour", "y")
NEIGHBOUR_HEADING = _place("WgNeighbour", "heading")
NEIGHBOUR_SPEED = _place("WgNeighbour", "speed")
NEIGHBOUR_RADIUS = _place("WgNeighbour", "radius")
NEIGHBOUR_MESSAGE = _place("WgNeighbour", "message")
"""Where a neighbour's message begins in its row. A row has so many numbers and the message's.

Rows follow the beams, the nearest neighbour first; rows without a neighbour are nan.
"""
