"""Positions of the bytes of a layout; ``fuzz/core/wg_looks.h`` defines the same for the core."""

from __future__ import annotations

MAX_FEATURES = 8
# Kind, x, y, length, depth, turn and thickness.
FEATURE_BYTES = 6
# Width, height, start x, y, heading, target x, y, number of features.
HEAD_BYTES = 8
LAYOUT_BYTES = HEAD_BYTES + MAX_FEATURES * FEATURE_BYTES

# A scene is a layout, followed by bytes for the robot and its target.
SCENE_RADIUS = LAYOUT_BYTES
SCENE_TARGET = LAYOUT_BYTES + 1
SCENE_HEADING = LAYOUT_BYTES + 2
SCENE_BYTES = LAYOUT_BYTES + 3

# Headings of a layout per turn.
HEADINGS = 16
# Headings of a scene per heading of a layout.
FINER = 16

# Arena sides, cells: 8 to 28.
SMALLEST_SIDE = 8
SPREAD_OF_SIDES = 21
# Cells kept free around start and target; with them the default disc always fits.
CLEAR = 1

# Kinds of features.
BOX, WALL, CUP, CORNER, GATE, DIAGONAL, COMB = range(7)
KINDS = 7
