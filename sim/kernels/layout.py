"""What stands where in the flat arrays that kernels and controllers share.

Observation (float64), the same for every controller:

====================  =====================================================================
``OBS_BUMP``          1 if a wall stopped or bent the last move, else 0
``OBS_BUMP_BEARING``  direction of that contact from the robot's heading, rad in (-pi, pi]
``OBS_SIGNAL``        strength of the target's signal here: 1 / (1 + squared distance in cells)
``OBS_SIGNAL_HEADING``  world heading, rad, towards the neighbouring cell with the strongest signal
``OBS_HEADING``       own heading, rad in (-pi, pi]
``OBS_X``, ``OBS_Y``  own position, m
``OBS_TARGET_HEADING``  world heading towards the target, rad
``OBS_TARGET_DISTANCE``  distance to the target's centre, m
``OBS_RANDOM``        the next random number in [0, 1); say ``CMD_DRAW`` to use it up
``OBS_TIME_STEP``     duration of a step, s
``OBS_TOP_SPEED``     the robot's speed limit, m/s
====================  =====================================================================

Command (float64): ``CMD_SPEED`` m/s (negative: backwards), ``CMD_TURN_RATE`` rad/s (counter-clockwise),
``CMD_DRAW`` 1 if ``OBS_RANDOM`` was used.
"""

from __future__ import annotations

OBS_BUMP, OBS_BUMP_BEARING, OBS_SIGNAL, OBS_SIGNAL_HEADING, OBS_HEADING = 0, 1, 2, 3, 4
OBS_X, OBS_Y, OBS_TARGET_HEADING, OBS_TARGET_DISTANCE = 5, 6, 7, 8
OBS_RANDOM, OBS_TIME_STEP, OBS_TOP_SPEED = 9, 10, 11
OBS_SIZE = 12

# Senses that cost time (bits of SET_SENSES); the others are always there.
SENSE_BUMP_BEARING, SENSE_SIGNAL, SENSE_SIGNAL_HEADING = 1, 2, 4
SENSE_TARGET_HEADING, SENSE_TARGET_DISTANCE, SENSE_RANDOM = 8, 16, 32

CMD_SPEED, CMD_TURN_RATE, CMD_DRAW = 0, 1, 2
CMD_SIZE = 3

# How an episode ends.
LIMIT, REACHED, LOOP, TUNNEL, BURNED, INVALID_COMMAND = 0, 1, 2, 3, 4, 5

# Motion models that move on the pose lattice.
SWEPT, ENDPOINT = 0, 1

# Cell states.
FREE, SOLID, BURNING = 0, 1, 2

# settings (int64): what an episode is asked to do.
SET_X, SET_Y, SET_HEADING = 0, 1, 2  # start pose, lattice units
SET_TARGET_X, SET_TARGET_Y, SET_TARGET_SQ = 3, 4, 5  # target and its squared radius, lattice units
SET_CLEAR_SQ, SET_REACH = 6, 7  # squared clear distance; its root rounded up
SET_MOTION, SET_STEPS, SET_FIND_LOOP = 8, 9, 10
SET_SEED = 11  # seed of the draws, as the bits of a uint64
SET_SENSES = 12  # SENSE_ bits: what the controller looks at
SET_DIGEST = 13  # 1: the trace's digest is worked out
SET_SIZE = 14

# scales (float64): between the lattice and SI units.
SCALE_METRES = 0  # m per lattice unit
SCALE_SPEED = 1  # lattice units per step at 1 m/s
SCALE_TURN = 2  # heading units per step at 1 rad/s
SCALE_RADIANS = 3  # rad per heading unit
SCALE_TIME_STEP = 4  # s
SCALE_TOP_SPEED = 5  # m/s
SCALE_TOLERANCE = 6  # overlap that is not reported, lattice units
SCALE_START_SPEED = 7  # m/s, speed during the first step, before the controller has seen anything
SCALE_SIZE = 8

# counts (int64): what an episode reports.
OUT_ENDING, OUT_STEPS, OUT_PERIOD, OUT_COLLISIONS, OUT_LAST_NEW_CELL, OUT_DRAWS = 0, 1, 2, 3, 4, 5
OUT_DIGEST = 6  # rolling FNV-1a hash of every state, as the bits of a uint64
OUT_HIT_STEP, OUT_HIT_IX, OUT_HIT_IY, OUT_HIT_SEGMENT = 7, 8, 9, 10  # of TUNNEL and BURNED
OUT_OVERLAP_STEP, OUT_OVERLAP_IX, OUT_OVERLAP_IY = 11, 12, 13  # first cut deeper than the tolerance; -1
OUT_X, OUT_Y, OUT_HEADING = 14, 15, 16
OUT_HIT_STATE = 17  # SOLID (debris) or BURNING of the cell that ended the run as BURNED
OUT_SIZE = 18

# sums (float64)
SUM_PATH, SUM_OVERLAP = 0, 1  # lattice units: driven length; deepest cut
SUM_SIZE = 2

# The complete state after a step (int64): what a recurrence must repeat.
STATE_X, STATE_Y, STATE_HEADING = 0, 1, 2
STATE_DRIVE = 3  # commanded drive, lattice units a step
STATE_DRAWS = 4  # random numbers used so far
STATE_MEMORY = 5  # the controller's memory from here on, bits of float64s

# One row of a trace (int64): the corners of the path that led to a state, then the state.
ROW_BUMP, ROW_CORNERS = 0, 1
ROW_CORNER_1, ROW_CORNER_2 = 2, 4  # x, y of up to two corners between the last state and this
ROW_STATE = 6

UNIT = 1024  # lattice units per cell
TURN = 65536  # heading units per turn
