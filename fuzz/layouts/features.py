"""Worlds from a few bytes: structured features, rasterised.

A fuzzer that draws raw cells finds noise and shrinks badly. Here a short byte string of fixed
length describes an arena, a start, a target, and up to eight features: boxes, U and L shapes, walls
with a gap, diagonals, combs. All-zero bytes are the simplest world, an empty arena, so Hypothesis
shrinks towards it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from fuzz.layouts.layout_bytes import (
    CLEAR,
    FEATURE_BYTES,
    FINER,
    HEAD_BYTES,
    HEADINGS,
    LAYOUT_BYTES,
    MAX_FEATURES,
    SCENE_BYTES,
    SCENE_HEADING,
    SCENE_RADIUS,
    SCENE_TARGET,
    SMALLEST_SIDE,
    SPREAD_OF_SIDES,
)
from fuzz.layouts.variation import layout_disc, with_robot
from worldgen.errors import InvalidParameter
from worldgen.lattice import cell_middle
from worldgen.support.arrays import Bools
from worldgen.world import (
    DEFAULT_CELL_SIZE,
    DEFAULT_ROBOT_RADIUS,
    DEFAULT_ROBOT_SPEED,
    Pose,
    Target,
    Value,
    World,
)

RADII = (DEFAULT_ROBOT_RADIUS, 0.06, 0.08, 0.09)
"""Radii of a scene's robot, m.

All fit if a layout leaves room for the default one, and none is as wide as a gap of one or two
cells, where even complete controllers fail."""

TARGET_RADII = (DEFAULT_CELL_SIZE / 2, 0.02, 0.08)
"""Radii of a scene's target, m, with cells of the usual size."""


def decode_world(
    data: bytes, *, robot_radius: float = DEFAULT_ROBOT_RADIUS, cell_size: float = DEFAULT_CELL_SIZE
) -> World:
    """Return the world that a layout string describes; any ``LAYOUT_BYTES`` bytes describe one.

    Args:
        data: ``LAYOUT_BYTES`` bytes.
        robot_radius: Radius of the robot, m.
        cell_size: Side of a cell, m.

    Returns:
        An arena of 8 to 28 cells per side inside a border of solid cells, without certificate.
    """
    width = SMALLEST_SIDE + data[0] % SPREAD_OF_SIDES
    height = SMALLEST_SIDE + data[1] % SPREAD_OF_SIDES
    walls = np.zeros((height, width), bool)
    for k in range(data[7] % (MAX_FEATURES + 1)):
        feature = data[HEAD_BYTES + k * FEATURE_BYTES : HEAD_BYTES + (k + 1) * FEATURE_BYTES]
        _draw(walls, feature)
    start = (2 + data[2] % (width - 4), 2 + data[3] % (height - 4))
    target = (width - 3 - data[5] % (width - 4), height - 3 - data[6] % (height - 4))
    # Clear the start and target after the features, and close the border last.
    for ix, iy in (start, target):
        walls[iy - CLEAR : iy + CLEAR + 1, ix - CLEAR : ix + CLEAR + 1] = False
    walls[[0, -1], :] = True
    walls[:, [0, -1]] = True
    x, y, to_x, to_y = (cell_middle(index, cell_size) for index in (*start, *target))
    return World(
        walls,
        start=Pose(x, y, data[4] % HEADINGS * (2 * math.pi / HEADINGS)),
        target=Target(to_x, to_y, cell_size / 2),
        cell_size=cell_size,
        robot_radius=robot_radius,
        robot_speed=DEFAULT_ROBOT_SPEED,
    )


def arena_for(values: Mapping[str, Value]) -> World:
    """Return the simplest arena, with cells that suit the robot of these values, and that robot.

    Args:
        values: As for :func:`fuzz.layouts.variation.applied`.
    """
    _, cell_size = layout_disc(values)
    return with_robot(decode_world(bytes(LAYOUT_BYTES), cell_size=cell_size), values)


def decode_scene(data: bytes, *, cell_size: float = DEFAULT_CELL_SIZE) -> World:
    """Return the world that a scene describes.

    A scene is a layout, and three bytes for the robot's radius, the target's radius and the
    heading. Three zeros change nothing, nor do three missing bytes.

    Args:
        data: ``SCENE_BYTES`` or ``LAYOUT_BYTES`` bytes.
        cell_size: Side of a cell, m, to which the target's radius is in proportion.

    Raises:
        InvalidParameter: If there are more or fewer.
    """
    if len(data) == LAYOUT_BYTES:
        return decode_world(data, cell_size=cell_size)
    if len(data) != SCENE_BYTES:
        raise InvalidParameter(
            "wrong-size",
            "a scene does not have {count} bytes",
            "use {scene_bytes}, or {layout_bytes} for a layout",
            count=len(data),
            scene_bytes=SCENE_BYTES,
            layout_bytes=LAYOUT_BYTES,
        )
    radius = RADII[data[SCENE_RADIUS] % len(RADII)]
    world = decode_world(data, robot_radius=radius, cell_size=cell_size)
    reach = target_radii(cell_size)[data[SCENE_TARGET] % len(TARGET_RADII)]
    heading = data[4] % HEADINGS * FINER + data[SCENE_HEADING] % FINER
    return replace(
        world,
        start=replace(world.start, heading=heading * (2 * math.pi / (HEADINGS * FINER))),
        target=replace(world.target, radius=reach),
    )


def target_radii(cell_size: float) -> tuple[float, ...]:
    """Return the radii of a scene's target, m, in proportion to its cells."""
    if cell_size == DEFAULT_CELL_SIZE:
        return TARGET_RADII
    return tuple(round(radius / DEFAULT_CELL_SIZE * cell_size, 9) for radius in TARGET_RADII)


def _draw(walls: Bools, feature: bytes) -> None:
    """Draw one feature; any part outside the arena is cut off."""
    kind, x, y, length, depth, form = feature
    height, width = walls.shape
    x = 1 + x % (width - 2)
    y = 1 + y % (height - 2)
    length = 1 + length % 12
    depth = 1 + depth % 8
    turn = form % 4
    thickness = 1 + form // 4 % 2
    stamp = _SHAPES[kind % len(_SHAPES)](length, depth, thickness)
    stamp = np.rot90(stamp, turn)
    stamp = stamp[: height - y, : width - x]
    walls[y : y + stamp.shape[0], x : x + stamp.shape[1]] |= stamp


def _box(length: int, depth: int, thickness: int) -> Bools:
    return np.ones((depth, length), bool)


def _wall(length: int, depth: int, thickness: int) -> Bools:
    return np.ones((thickness, length + depth), bool)


def _cup(length: int, depth: int, thickness: int) -> Bools:
    stamp = np.ones((depth + thickness, length + 2 * thickness), bool)
    stamp[:depth, thickness : thickness + length] = False
    return stamp


def _corner(length: int, depth: int, thickness: int) -> Bools:
    stamp = np.zeros((depth + thickness, length + thickness), bool)
    stamp[:thickness, :] = True
    stamp[:, :thickness] = True
    return stamp


def _gate(length: int, depth: int, thickness: int) -> Bools:
    """Return a long wall with an opening of 2 cells."""
    stamp = np.ones((thickness, length + depth + 2), bool)
    stamp[:, length : length + 2] = False
    return stamp


def _diagonal(length: int, depth: int, thickness: int) -> Bools:
    side = length + depth
    return np.eye(side, dtype=bool) | (np.eye(side, k=1, dtype=bool) if thickness > 1 else False)


def _comb(length: int, depth: int, thickness: int) -> Bools:
    stamp = np.zeros((depth + thickness, 3 * (1 + length // 3) + 1), bool)
    stamp[:thickness, :] = True
    stamp[:, ::3] = True
    return stamp


_SHAPES = (_box, _wall, _cup, _corner, _gate, _diagonal, _comb)
