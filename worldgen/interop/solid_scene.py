"""A world as physics engines build it: boxes in m, bodies that come and go, a floor, all as exact decimals."""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import PurePath

import numpy as np
import numpy.typing as npt

from worldgen.interop.boxes import closing_boxes, merged_boxes
from worldgen.interop.format import Destination, decimal_text
from worldgen.lattice import exact
from worldgen.timeline import CellState
from worldgen.world import World

__all__ = ["Body", "Box", "Scene", "events_file", "plain_name", "scene"]

_LONGEST_NAME = 60  # characters; names become parts of topics and file paths in other programs


@dataclass(frozen=True)
class Box:
    """An axis-aligned box on the floor, decimals, m.

    Args:
        x: Of its centre.
        y: Of its centre.
        half_x: Half its side along x.
        half_y: Half its side along y.
    """

    x: Fraction
    y: Fraction
    half_x: Fraction
    half_y: Fraction


@dataclass(frozen=True)
class Body:
    """A cell that is there at some times: solid ones are ``cell_IX_IY``, burning ones ``fire_IX_IY``.

    Args:
        name: Of the body.
        box: Where it stands.
        burning: Whether it is fire, which stops nothing.
        shown: Whether it is there at time 0.
        changes: Times, s, and whether it is there from then on.
    """

    name: str
    box: Box
    burning: bool
    shown: bool
    changes: tuple[tuple[float, bool], ...]


@dataclass(frozen=True)
class Scene:
    """What stands in a world.

    Args:
        still: What is always solid, with a wall round the grid where its border is open.
        bodies: What comes and goes.
        floor: The ground below the grid, with one cell more on every side.
    """

    still: tuple[Box, ...]
    bodies: tuple[Body, ...]
    floor: Box


def scene(world: World, destination: Destination) -> Scene:
    """The world in the file's frame.

    Args:
        world: The world.
        destination: Says where the grid's lower-left corner lies.
    """
    size = exact(world.cell_size)
    corner = (exact(destination.origin[0]), exact(destination.origin[1]))
    always, states = _always_solid(world), _states(world)
    boxes = np.concatenate([merged_boxes(always), closing_boxes(world)])
    still = tuple(_box(rows, size, corner) for rows in boxes.tolist())
    bodies = [
        body
        for (iy, ix), by_time in sorted(states.items())
        if not always[iy, ix]
        for body in _bodies(ix, iy, by_time, _box((ix, iy, ix + 1, iy + 1), size, corner))
    ]
    floor = _box((-1, -1, world.width + 1, world.height + 1), size, corner)
    return Scene(still, tuple(bodies), floor)


def _box(cells: tuple[int, int, int, int], size: Fraction, corner: tuple[Fraction, Fraction]) -> Box:
    left, low, right, high = cells
    x, y = corner[0] + size * (left + right) / 2, corner[1] + size * (low + high) / 2
    return Box(x, y, size * (right - left) / 2, size * (high - low) / 2)


def _states(world: World) -> dict[tuple[int, int], dict[float, CellState]]:
    """Of every cell that the timeline names, by row and column, its states from a time on; of one time the last."""
    states: dict[tuple[int, int], dict[float, CellState]] = {}
    for time, ix, iy, state in world.timeline:
        start = CellState.SOLID if world.walls[iy, ix] else CellState.FREE
        states.setdefault((iy, ix), {0.0: start})[time + 0.0] = state
    return states


def _always_solid(world: World) -> npt.NDArray[np.bool_]:
    line = world.timeline
    solid, later = world.walls.copy(), line.times > 0
    solid[line.iy[~later], line.ix[~later]] = line.states[~later] == CellState.SOLID
    opened = later & (line.states != CellState.SOLID)
    solid[line.iy[opened], line.ix[opened]] = False
    return solid


def _bodies(ix: int, iy: int, by_time: dict[float, CellState], box: Box) -> Iterator[Body]:
    """What a cell is at some times, but not at all."""
    for kind, word in ((CellState.SOLID, "cell"), (CellState.BURNING, "fire")):
        there = [(time, state == kind) for time, state in by_time.items()]
        changes = tuple(now for before, now in itertools.pairwise(there) if before[1] != now[1])
        if there[0][1] or changes:
            yield Body(f"{word}_{ix}_{iy}", box, kind == CellState.BURNING, there[0][1], changes)


def events_file(model: str, bodies: tuple[Body, ...], height: float, *, world: str = "") -> bytes:
    """What a player script plays: where bodies stand, and the height of their centres from a time on.

    Args:
        model: Name of the file that has the bodies.
        bodies: As in :class:`Scene`.
        height: Of the walls, m; what is not there is parked with its upper side half of that below the floor.
        world: Name of the world in that file, if it has one.

    Returns:
        JSON: ``model`` is that name; ``bodies`` has x and y, m, by name; ``events`` has time, s, name, z, m, in order
        of time; those of time 0 come first, one a body.
    """
    heights = {True: exact(height) / 2, False: -exact(height)}
    events = [(0.0, body.name, body.shown) for body in bodies]
    later = [(time, body.name, shown) for body in bodies for time, shown in body.changes]
    events += sorted(later, key=lambda event: event[0])
    places = [
        f"    {json.dumps(body.name)}: [{decimal_text(body.box.x)}, {decimal_text(body.box.y)}]" for body in bodies
    ]
    rows = [f"    [{time!r}, {json.dumps(name)}, {decimal_text(heights[shown])}]" for time, name, shown in events]
    named = f'  "world": {json.dumps(world)},\n' if world else ""
    head = f'{{\n  "model": {json.dumps(model)},\n{named}  "bodies": {{\n'
    return "".join((head, ",\n".join(places), '\n  },\n  "events": [\n', ",\n".join(rows), "\n  ]\n}\n")).encode()


def plain_name(destination: Destination) -> str:
    """The file's stem in letters, digits, ``_`` and ``-``: what every program takes as a name, in XML and in topics."""
    name = re.sub(r"[^A-Za-z0-9_-]+", "_", PurePath(destination.name).stem)[:_LONGEST_NAME].strip("_")
    usual = re.match("[A-Za-z]", name) and name != "world"  # which Gazebo keeps for itself
    return name if usual else f"worldgen_{name}".rstrip("_")
