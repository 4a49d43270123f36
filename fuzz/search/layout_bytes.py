"""What is where in the bytes of a layout; ``fuzz/core/wg_looks.h`` says the same to the core."""

from __future__ import annotations

MAX_FEATURES = 8
FEATURE_BYTES = 6  # kind, x, y, length, depth, turn and thickness
HEAD_BYTES = 8  # width, height, start x, y, heading, target x, y, how many features
LAYOUT_BYTES = HEAD_BYTES + MAX_FEATURES * FEATURE_BYTES

# A scene is a layout, then bytes that say more about the robot and its target.
SCENE_RADIUS = LAYOUT_BYTES
SCENE_TARGET = LAYOUT_BYTES + 1
SCENE_HEADING = LAYOUT_BYTES + 2
SCENE_BYTES = LAYOUT_BYTES + 3

HEADINGS = 16  # of a layout, in a turn
FINER = 16  # headings of a scene for each of these

# arena sides, cells: 8 to 28
SMALLEST_SIDE = 8
SPREAD_OF_SIDES = 21
CLEAR = 1  # cells kept free round start and target; with them the default disc always fits

BOX, WALL, CUP, CORNER, GATE, DIAGONAL, COMB = range(7)  # kinds of features
KINDS = 7
