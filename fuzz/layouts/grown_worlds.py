"""Worlds that keep a robot busy for long: along one wall, around one island, through many gaps.

A world is a few bytes: the scene that it begins with, and how it was grown from there, by parts
that repeat and by roads that continue where a run ended. Its children are grown further.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from fuzz.layouts.layout_bytes import SCENE_BYTES
from fuzz.layouts.small_worlds import SCENES, Build, Scene, world_of_scene
from worldgen.random_streams import RandomStream
from worldgen.world import Value, World

# Cells that a grown world may have along a side, and in all.
_LONGEST_SIDE = 600
_MOST_CELLS = 14_400
# Cells on the way through a scene that was not made for long ways.
_CELLS = (6, 40)

# The bytes of a genome: its scene, the scene's seed, and two for each edit: what, and where.
_SEED = slice(1, 9)
_FIRST_EDIT = 9
_MOST_EDITS = (SCENE_BYTES - _FIRST_EDIT) // 2


def new_genome(stream: RandomStream) -> bytes:
    """Return the genome of a scene that nothing was added to.

    Args:
        stream: Source of randomness; it is advanced.
    """
    # Half of the scenes are made for long ways.
    long = stream.below(2) == 0
    scene = stream.below(len(_LONG)) if long else len(_LONG) + stream.below(len(SCENES))
    seed = stream.next64().to_bytes(8, "little")
    return bytes([scene]) + seed + bytes(SCENE_BYTES - _FIRST_EDIT)


def grown(genome: bytes, stream: RandomStream) -> bytes:
    """Return a genome with one or two more edits; a full one loses its last.

    Args:
        genome: The parent's genome.
        stream: Source of randomness; it is advanced.
    """
    edits = [*_edits(genome)]
    for _ in range(1 + (stream.below(3) == 0)):
        del edits[_MOST_EDITS - 1 :]
        edits.append((stream.choice(_OFTEN), stream.below(256)))
    tail = bytes(byte for edit in edits for byte in edit)
    return (genome[:_FIRST_EDIT] + tail).ljust(SCENE_BYTES, b"\0")


def grown_world(genome: bytes, values: Mapping[str, Value]) -> World | None:
    """Return the world of a genome, with its witness; ``None`` if it has no path.

    Args:
        genome: ``SCENE_BYTES`` bytes; any bytes describe a world.
        values: As for :func:`~fuzz.layouts.small_worlds.small_world`.
    """
    stream = RandomStream(int.from_bytes(genome[_SEED], "little"))
    builds = (*_LONG, *SCENES)
    scene = builds[genome[0] % len(builds)](stream, stream.between(*_CELLS))
    for what, where in _edits(genome):
        edited = _EDITS[what % len(_EDITS)](scene, where)
        # What is as large as it may be stays as it is.
        if max(edited.walls.shape) <= _LONGEST_SIDE and edited.walls.size <= _MOST_CELLS:
            scene = edited
    # Of a small scene that is continued, nothing may be left between the two.
    return None if scene.start == scene.target else world_of_scene(scene, stream, values)


def _edits(genome: bytes) -> list[tuple[int, int]]:
    tail = genome[_FIRST_EDIT : _FIRST_EDIT + 2 * _MOST_EDITS]
    pairs = zip(tail[::2], tail[1::2], strict=True)
    return [(what - 1, where) for what, where in pairs if what]


def _serpentine(stream: RandomStream, _: int) -> Scene:
    """Return a lane that leads to and fro, between walls that are one."""
    width, lanes, length = stream.between(3, 4), stream.between(2, 5), stream.between(12, 40)
    walls = np.zeros((lanes * (width + 1) - 1, length), bool)
    for lane in range(1, lanes):
        row = lane * (width + 1) - 1
        walls[row, : length - width] = True
        if lane % 2 == 0:
            walls[row] = walls[row, ::-1]
    last = walls.shape[0] - 2
    return Scene(walls, (1, 1), (last, 1 if lanes % 2 == 0 else length - 2))


def _spiral(stream: RandomStream, _: int) -> Scene:
    """Return rings that lead inwards, each all the way around."""
    width, rings = stream.between(3, 4), stream.between(2, 5)
    pitch = width + 1
    side = 3 * pitch * rings + 4
    walls = np.zeros((side, side), bool)
    for ring in range(1, rings + 1):
        low, high = ring * pitch - 1, side - ring * pitch
        walls[low, low : high + 1] = walls[high, low : high + 1] = True
        walls[low : high + 1, low] = walls[low : high + 1, high] = True
    # Along the top, a wall closes each lane just before the gap that leads to the next one.
    column = side - rings * pitch - 2
    for ring in range(1, rings + 1):
        low = ring * pitch - 1
        at = column - (ring - 1) * pitch
        walls[low, at - width : at] = False
        walls[low - width : low, at] = True
    start = (1, column + 2)
    return Scene(walls, start, (side // 2, side // 2))


def _room(stream: RandomStream, _: int) -> Scene:
    """Return a target in a room whose door is on the far side, in the middle of a hall."""
    inner, margin = stream.between(6, 24), stream.between(3, 5)
    thick, width = stream.between(1, 3), stream.between(2, 3)
    rows, columns = (inner + 2 * (margin + thick), inner + stream.between(0, 20) + 2 * margin + 6)
    walls = np.zeros((rows, columns), bool)
    walls[margin:-margin, margin:-margin] = True
    walls[margin + thick : -margin - thick, margin + thick : -margin - thick] = False
    # The door.
    row = margin + thick + stream.below(inner - width)
    walls[row : row + width, columns - margin - thick : columns - margin] = False
    return Scene(walls, (rows // 2, 1), (rows // 2, margin + thick + 1))


def _gaps(stream: RandomStream, _: int) -> Scene:
    """Return walls across a hall, one behind the other, each with a gap."""
    walls_across, apart, rows = (stream.between(3, 10), stream.between(4, 6), stream.between(7, 12))
    walls = np.zeros((rows, (walls_across + 1) * apart), bool)
    for number in range(1, walls_across + 1):
        first = stream.below(rows - 2)
        walls[:, number * apart] = True
        walls[first : first + 2, number * apart] = False
    return Scene(walls, (rows // 2, 1), (rows // 2, walls.shape[1] - 2))


_LONG: tuple[Build, ...] = (_serpentine, _spiral, _room, _gaps)


def _with_more_columns(scene: Scene, where: int) -> Scene:
    """Repeat a column, so that what is there gets longer."""
    walls = scene.walls
    columns = walls.shape[1]
    at = where * columns // 256
    more = max(columns // 2, 4)
    wider = np.insert(walls, [at] * more, walls[:, [at]], axis=1)
    start, target = (
        (row, column + more * (column > at)) for row, column in (scene.start, scene.target)
    )
    return scene._replace(walls=wider, start=start, target=target)


def _twice(scene: Scene, _: int) -> Scene:
    """Make everything twice as large."""
    walls = np.kron(scene.walls, np.ones((2, 2), bool))
    start, target = ((2 * row, 2 * column) for row, column in (scene.start, scene.target))
    return scene._replace(walls=walls, start=start, target=target)


def _continued(scene: Scene, _: int) -> Scene:
    """Continue behind the target with the mirror image of the way that led there."""
    walls = scene.walls
    row, column = scene.target
    before = walls[:, : column + 1] if column >= scene.start[1] else walls[:, column:][:, ::-1]
    start = (
        scene.start[0],
        scene.start[1] if column >= scene.start[1] else _column_from_end(scene),
    )
    longer = np.concatenate((before, before[:, -2::-1]), axis=1)
    longer[row, before.shape[1] - 1] = False
    return scene._replace(
        walls=longer, start=start, target=(start[0], longer.shape[1] - 1 - start[1])
    )


def _column_from_end(scene: Scene) -> int:
    """Return the start's column, counted from the last."""
    return int(scene.walls.shape[1]) - 1 - scene.start[1]


def _turned(scene: Scene) -> Scene:
    start, target = (place[::-1] for place in (scene.start, scene.target))
    return scene._replace(walls=scene.walls.T, start=start, target=target)


def _filled(scene: Scene, where: int, *, solid: bool) -> Scene:
    """Fill or clear a few cells."""
    walls = scene.walls.copy()
    stream = RandomStream(where)
    row, column = (stream.below(side) for side in walls.shape)
    walls[row : row + stream.between(1, 3), column : column + stream.between(1, 3)] = solid
    walls[scene.start] = walls[scene.target] = False
    return scene._replace(walls=walls)


_EDITS = (
    _twice,
    _with_more_columns,
    lambda scene, where: _turned(_with_more_columns(_turned(scene), where)),
    _continued,
    lambda scene, where: _turned(_continued(_turned(scene), where)),
    lambda scene, where: _filled(scene, where, solid=True),
    lambda scene, where: _filled(scene, where, solid=False),
    lambda scene, _: scene._replace(start=scene.target, target=scene.start),
)
# How often each edit is made; edits are stored as numbers from 1.
_OFTEN = (1, 2, 2, 2, 3, 3, 3, 4, 4, 4, 5, 5, 5, 6, 6, 7, 8)
