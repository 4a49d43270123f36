"""What stands where in the flat arrays of the environments' kernels."""

from __future__ import annotations

# Sensors: what of the simulator's observation an environment shows, in how many numbers.
BUMP, BUMP_DIRECTION, SIGNAL, SIGNAL_DIRECTION = 0, 1, 2, 3
TARGET_DIRECTION, TARGET_DISTANCE, HEADING, POSITION, ODOMETRY, BEAMS = 4, 5, 6, 7, 8, 9

# rules (float64): what decides numbers of observations, commands and rewards.
RULE_EXTENT = 0  # m: what counts as 1 in distances
RULE_BEAM_RANGE = 1  # m: what counts as 1 in range beams
RULE_TURN_RATE = 2  # rad/s: what counts as 1 in actions
RULE_SLOWEST = 3  # share of the top speed: the least that an action may ask for
RULE_PROGRESS = 4  # a metre nearer to the target
RULE_TIME = 5  # a second
RULE_CONTACT = 6  # a step in which a wall stopped or bent the move
RULE_REACHED = 7
RULE_BURNED = 8
RULE_LIMIT = 9  # steps until an episode is cut off; 0: never
RULE_AUTORESET = 10  # NEXT_STEP, SAME_STEP, DISABLED
RULE_SIZE = 11

NEXT_STEP, SAME_STEP, DISABLED = 0, 1, 2

# place (int64): where a world's parts lie in the arrays of all worlds.
PLACE_CELLS, PLACE_HEIGHT, PLACE_WIDTH = 0, 1, 2  # first cell; cells in y and x
PLACE_CLEARANCE, PLACE_ROWS, PLACE_COLUMNS = 3, 4, 5  # first number of its table of distances, and that one's shape
PLACE_EVENT, PLACE_LAST_EVENT = 6, 7  # first event, and the one after the last
PLACE_WAY = 8  # first number of its ways to the target; -1: none
PLACE_SIZE = 9
