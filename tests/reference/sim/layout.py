"""Layout of the flat arrays that kernels and controllers share.

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
``OBS_RADIUS``        the robot's radius, m
``OBS_TIME``          time since the start, s
``OBS_ODOMETRY_X``, ``OBS_ODOMETRY_Y``, ``OBS_ODOMETRY_HEADING``  own pose as the wheels say, m and
rad from ``OBS_SIZE`` on  range beams: distance to the first wall, m
====================  =====================================================================

Command (float64): ``CMD_SPEED`` m/s (negative: backwards), ``CMD_TURN_RATE`` rad/s
(counter-clockwise),
``CMD_DRAW`` 1 if ``OBS_RANDOM`` was used.
"""

from __future__ import annotations

OBS_BUMP, OBS_BUMP_BEARING, OBS_SIGNAL, OBS_SIGNAL_HEADING, OBS_HEADING = 0, 1, 2, 3, 4
OBS_X, OBS_Y, OBS_TARGET_HEADING, OBS_TARGET_DISTANCE = 5, 6, 7, 8
OBS_RANDOM, OBS_TIME_STEP, OBS_TOP_SPEED, OBS_RADIUS, OBS_TIME = 9, 10, 11, 12, 13
OBS_ODOMETRY_X, OBS_ODOMETRY_Y, OBS_ODOMETRY_HEADING = 14, 15, 16
OBS_SIZE = 17  # range beams follow

# Senses that cost time, or proofs (bits of SET_SENSES); the others are always there.
SENSE_BUMP_BEARING, SENSE_SIGNAL, SENSE_SIGNAL_HEADING = 1, 2, 4
SENSE_TARGET_HEADING, SENSE_TARGET_DISTANCE, SENSE_RANDOM = 8, 16, 32
SENSE_TIME, SENSE_ODOMETRY, SENSE_BEAMS = 64, 128, 256

CMD_SPEED, CMD_TURN_RATE, CMD_DRAW = 0, 1, 2
CMD_SIZE = 3

# How an episode ends.
LIMIT, REACHED, LOOP, TUNNEL, BURNED, INVALID_COMMAND = 0, 1, 2, 3, 4, 5
COVERED, CONTACT = 7, 9

# Motion models that move on the pose lattice.
SWEPT, ENDPOINT = 0, 1

# Cell states.
FREE, SOLID, BURNING = 0, 1, 2

# settings (int64): the options of an episode.
SET_X, SET_Y, SET_HEADING = 0, 1, 2  # start pose, lattice units
SET_TARGET_X, SET_TARGET_Y, SET_TARGET_SQ = 3, 4, 5  # target and its squared radius, lattice units
SET_CLEAR_SQ, SET_REACH = 6, 7  # squared clear distance; its root rounded up
SET_MOTION, SET_STEPS, SET_FIND_LOOP = 8, 9, 10
SET_SEED = 11  # seed of the draws, as the bits of a uint64
SET_SENSES = 12  # SENSE_ bits: what the controller reads
SET_DIGEST = 13  # 1: the trace's digest is computed
SET_SENSOR_CELLS = 14  # how many cells around the robot the signal sensor covers
SET_SIGNAL = 15  # OPEN, WEAKENED, BLOCKED
SET_BEAMS = 16
SET_PLAIN_SENSOR = 17  # 1: the signal sensor is the thesis's, without noise or limits
SET_SMOKE_REACH = 18  # cells around a burning one that its smoke fills
SET_ENTRY = 19  # step of the state that PROVE_LOOP compares with the last one
SET_DISTURBED = 20  # 1: something moves the robot besides its wheels
SET_MEASURES = 21  # 1: odometry may differ from the pose
SET_DRIFT_X, SET_DRIFT_Y = 22, 23  # what a tilted floor adds to each step, lattice units
SET_DRIFT_REACH = 24  # the length of that, rounded up
SET_PLACES = 25  # how many pushes are at places; they come first
SET_ARRIVAL, SET_CONTACT = 26, 27  # TOUCH, ...; SLIDE, ...
SET_HAS_GOAL_HEADING, SET_GOAL_HEADING, SET_HEADING_TOLERANCE = 28, 29, 30  # 0 or 1; heading units
SET_ARRIVAL_SPEED, SET_ARRIVAL_TURN = 31, 32  # for STOP: units of speed; heading units
SET_SIZE = 33

# The goal's settings, in the order of WgGoal.
GOAL_SETTINGS = (
    SET_TARGET_X, SET_TARGET_Y, SET_TARGET_SQ, SET_ARRIVAL, SET_HAS_GOAL_HEADING, SET_GOAL_HEADING,
    SET_HEADING_TOLERANCE, SET_ARRIVAL_SPEED, SET_ARRIVAL_TURN,
)  # fmt: skip

# When a robot has arrived: values of SET_ARRIVAL.
TOUCH, STEP, STOP = 0, 1, 2
# What a wall does to a move: values of SET_CONTACT.
SLIDE, HALT, FAIL = 0, 1, 2

# Values of SET_FIND_LOOP: how a recurrence of the complete state ends the run.
NO_LOOP = 0  # never
SEEK_LOOP = 1  # when it is found, at the latest in the last step of the budget
PROVE_LOOP = 2  # in the last step of the budget, if its state is that of step SET_ENTRY

# What walls do to the signal.
OPEN, WEAKENED, BLOCKED = 0, 1, 2

# scales (float64): between the lattice and SI units.
SCALE_METRES = 0  # m per lattice unit
SCALE_SPEED = 1  # lattice units per step at 1 m/s
SCALE_TURN = 2  # heading units per step at 1 rad/s
SCALE_RADIANS = 3  # rad per heading unit
SCALE_TIME_STEP = 4  # s
SCALE_TOP_SPEED = 5  # m/s
SCALE_TOLERANCE = 6  # overlap that is not reported, lattice units
SCALE_START_SPEED = 7  # m/s, speed during the first step, before the controller has seen anything
SCALE_TURN_LIMIT = 8  # rad/s
SCALE_GAIN = 9  # greatest gain of speed, SPEED_UNITth lattice units per step, in a step; inf: none
SCALE_LOSS = 10  # greatest loss, in the same units
SCALE_WALL_FRICTION = 11  # share of a slide that is lost to a wall
SCALE_SLIP = 12  # largest share of a step that is lost
SCALE_ODOMETRY_NOISE = 13  # largest relative error of a measured distance or turn
SCALE_SENSOR_RANGE = 14  # lattice units; inf: none
SCALE_SENSOR_FIELD = 15  # half the angle that the signal sensor covers, heading units
SCALE_SENSOR_NOISE = 16  # largest relative error of a reading
SCALE_BEAM_RANGE = 17  # lattice units
SCALE_BEAM_FIELD = (
    18  # angle between the first and the last beam, heading units; a whole turn: evenly all around
)
SCALE_BEAM_NOISE = 19  # largest relative error of a distance
SCALE_BEAM_DROPOUT = 20  # probability that a beam returns nothing
SCALE_RADIUS = 21  # m, of the robot
SCALE_SMOKE = 22  # share of the signal that a cell in smoke absorbs
SCALE_SIZE = 23

# counts (int64): what an episode reports.
OUT_ENDING, OUT_STEPS, OUT_PERIOD, OUT_COLLISIONS, OUT_LAST_NEW_CELL = 0, 1, 2, 3, 4
OUT_POINTS = 5  # points of the path after the start
OUT_DIGEST = 6  # rolling FNV-1a hash of every state, as the bits of a uint64
OUT_HIT_STEP, OUT_HIT_IX, OUT_HIT_IY = 7, 8, 9  # for TUNNEL, CONTACT and BURNED
OUT_OVERLAP_STEP, OUT_OVERLAP_IX, OUT_OVERLAP_IY = (
    10,
    11,
    12,
)  # first cut deeper than the tolerance; -1
OUT_HIT_STATE = 13  # SOLID (debris) or BURNING of the cell that ended the run as BURNED
OUT_VISITED = 14  # cells that the centre has been in, including the start's
OUT_UNVISITED = 15  # cells that a coverage task still requires
OUT_GOALS = 16  # goals that the robot has arrived at
OUT_SIZE = 17

# sums (float64)
SUM_PATH, SUM_OVERLAP = 0, 1  # lattice units: driven length; deepest cut
SUM_SIZE = 2

# The complete state after a step (int64): what a recurrence must repeat.
STATE_X, STATE_Y, STATE_HEADING = 0, 1, 2
STATE_SPEED = 3  # speed of the wheels, SPEED_UNITth lattice units per step
STATE_DRAWS = 4  # random numbers that the controller has used so far
STATE_MEMORY = 5  # the controller's memory from here on, bits of float64s
SPEED_UNIT = 65536

# One row of a trace (int64): whether a wall stopped or deflected the step, then the state after it.
ROW_BUMP = 0
ROW_STATE = 1

# One point of a path (int64): when, and where the centre was.
POINT_STEP = 0
POINT_TIME = 1  # time in the step, TIME_UNITths of it
POINT_X, POINT_Y = 2, 3
POINT_SIZE = 4
TIME_UNIT = 1 << 32

# One event (int64): the step in which it happens, its time in the step (TIME_UNITths), the cell,
# and its new state.
EVENT_STEP, EVENT_TIME, EVENT_IX, EVENT_IY, EVENT_STATE = 0, 1, 2, 3, 4
EVENT_SIZE = 5

# One push (int64): the step at whose end it happens, or 0 and the cell that pushes; then
# displacement and turn.
PUSH_STEP, PUSH_IX, PUSH_IY, PUSH_DX, PUSH_DY, PUSH_TURN = 0, 1, 2, 3, 4, 5
PUSH_SIZE = 6

UNIT = 1024  # lattice units per cell
TURN = 65536  # heading units per turn
