"""Worlds with a walled-off target, described by a few bytes.

Only a robot that passes through a wall gets there.
"""

from __future__ import annotations

import math
from dataclasses import replace

from fuzz.layouts.features import decode_world
from fuzz.layouts.layout_bytes import FEATURE_BYTES
from worldgen.world import World

# Width, height, form, wall, bend; start and target across and along the wall; heading; number of
# features.
_HEAD_BYTES = 11
# More features would keep the robot away from the wall.
_MOST_FEATURES = 3
SEALED_BYTES = _HEAD_BYTES + _MOST_FEATURES * FEATURE_BYTES

# Arena sides, cells: 10 to 20; in smaller ones the robot hits the wall more often.
_SMALLEST = 10
_SPREAD = 11
# Side, cells, that `decode_world` makes from a zero byte.
_ARENA = 8
# Smallest distance, cells, from either end of an axis at which the default disc has room next to
# the border.
_INNER = 2
# Cells from start or target to the wall.
_ROOM = 2
_EDGE = _INNER + _ROOM

Cells = list[tuple[int, int]]


def decode_sealed(data: bytes) -> World:
    """Return the world that a layout string describes; any ``SEALED_BYTES`` bytes describe one.

    A wall of one cell, straight from side to side or bent around the target's corner, separates the
    target from the start. Boxes, cups and the other features of :mod:`fuzz.layouts.features` are
    scattered around.

    Returns:
        An arena of 10 to 20 cells per side inside a border of solid cells, without certificate.
    """
    # Lay the wall, bent or straight, in a frame in which it blocks the first axis.
    size = [_SMALLEST + data[k] % _SPREAD for k in (0, 1)]
    form = data[2]
    # The axis that the wall blocks; the wall itself is parallel to the other axis.
    axis = form % 2
    across = size[axis]
    along = size[1 - axis]
    wall = _EDGE + data[3] % (across - 2 * _EDGE)
    bend = _EDGE + data[4] % (along - 2 * _EDGE) if form // 8 % 3 == 0 else 0
    solid: Cells = [(wall, k) for k in range(bend, along)]
    if bend:
        solid += [(k, bend) for k in range(wall, across)]
    # Put start and target on its two sides.
    start = [_INNER + data[5] % (wall - _EDGE + 1), _INNER + data[6] % (along - 2 * _INNER)]
    target = [_beyond(wall, across, data[7]), _beyond(bend, along, data[8])]
    places = [*solid, (start[0], start[1]), (target[0], target[1])]
    # Mirror and turn the frame.
    if form // 2 % 2:
        places = [(across - 1 - a, b) for a, b in places]
    if form // 4 % 2:
        places = [(a, along - 1 - b) for a, b in places]
    if axis == 1:
        places = [(b, a) for a, b in places]
    return _build(size, places[:-2], places[-2], places[-1], data)


def _beyond(wall: int, length: int, draw: int) -> int:
    """Return a position behind a wall at ``wall``, or any position if that is 0."""
    first = max(wall + _ROOM, _INNER)
    return first + draw % (length - _INNER - first)


def _build(
    size: list[int], solid: Cells, start: tuple[int, int], target: tuple[int, int], data: bytes
) -> World:
    """Return the arena, its features, then the wall through them."""
    bytes_of_arena = [side - _ARENA for side in size]
    bytes_of_start = [place - _INNER for place in start]
    bytes_of_target = [side - 1 - _INNER - place for side, place in zip(size, target, strict=True)]
    head = bytes(
        [*bytes_of_arena, *bytes_of_start, 0, *bytes_of_target, data[10] % (_MOST_FEATURES + 1)]
    )
    world = decode_world(head + data[_HEAD_BYTES:])
    walls = world.walls.copy()
    for ix, iy in solid:
        walls[iy, ix] = True
    # With headings in eighths of a turn the thesis's robot hits walls at few angles: in 4,000 draws
    # each, rules 1 and 2 never got through to the target; with these headings they did in 5 and 4.
    return replace(
        world, walls=walls, start=replace(world.start, heading=data[9] * (math.pi / 128))
    )
