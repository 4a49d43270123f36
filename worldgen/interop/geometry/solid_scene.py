"""A world as physics engines build it.

It has boxes in m, bodies that appear and disappear, and a floor, all as exact decimals.
"""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import resources
from pathlib import PurePath

from worldgen.interop.format import Destination, decimal_text
from worldgen.interop.geometry.boxes import always_solid
from worldgen.interop.geometry.placed_boxes import GridLines, PlacedBox, placed_box, solid_boxes
from worldgen.lattice import exact
from worldgen.timeline import CellState
from worldgen.world import World

# Time step of the player, s.
TIMESTEPS = (1e-6, 1e3)
# Limit on characters, because names become parts of topics and file paths in other programs.
_LONGEST_NAME = 60


@dataclass(frozen=True)
class Body:
    """A cell that exists at some times.

    Solid ones are called ``cell_IX_IY``, burning ones ``fire_IX_IY``.

    Args:
        name: Name of the body.
        box: Its place while it exists.
        burning: True if it is fire, which does not stop a robot.
        shown: True if it exists at time 0.
        changes: Times, s, and whether it exists after each.
    """

    name: str
    box: PlacedBox
    burning: bool
    shown: bool
    changes: tuple[tuple[float, bool], ...]


@dataclass(frozen=True)
class SolidScene:
    """The obstacles and the floor of a world.

    Args:
        still: Boxes that are always solid, with a wall around the grid if its border is open.
        bodies: Cells that appear and disappear.
        floor: The ground below everything.
    """

    still: tuple[PlacedBox, ...]
    bodies: tuple[Body, ...]
    floor: PlacedBox


def scene(world: World, destination: Destination, height: float) -> SolidScene:
    """Return the world in the file's frame.

    Args:
        world: The world.
        destination: Gives the position of the grid's lower-left corner.
        height: Height of the walls, m.

    Raises:
        InvalidParameter: If the height is below 1e-6 or above 1e6 m.
        InvalidWorld: If the coordinates need more than 64 bits.
    """
    *still, floor = solid_boxes(world, destination, height=height, floor=True)
    lines = GridLines(world, destination)
    always = always_solid(world)
    top = exact(height)
    bodies = [
        body
        for (iy, ix), by_time in sorted(_states(world).items())
        if not always[iy, ix]
        for body in _bodies(by_time, placed_box(f"{ix}_{iy}", (ix, iy, ix + 1, iy + 1), lines, top))
    ]
    return SolidScene(tuple(still), tuple(bodies), floor)


def _states(world: World) -> dict[tuple[int, int], dict[float, CellState]]:
    """Return the states of every cell in the timeline, by row and column and then by time.

    If a cell changes several times at one time, the last change counts.
    """
    states: dict[tuple[int, int], dict[float, CellState]] = {}
    for time, ix, iy, state in world.timeline:
        start = CellState.SOLID if world.walls[iy, ix] else CellState.FREE
        states.setdefault((iy, ix), {0.0: start})[time + 0.0] = state
    return states


def _bodies(by_time: dict[float, CellState], box: PlacedBox) -> Iterator[Body]:
    """Yield the states that a cell has at some times but not at all times."""
    for kind, word in ((CellState.SOLID, "cell"), (CellState.BURNING, "fire")):
        there = [(time, state == kind) for time, state in by_time.items()]
        changes = tuple(now for before, now in itertools.pairwise(there) if before[1] != now[1])
        if there[0][1] or changes:
            yield Body(f"{word}_{box.name}", box, kind == CellState.BURNING, there[0][1], changes)


def player_files(
    destination: Destination, player: str, bodies: tuple[Body, ...], height: float, world: str = ""
) -> dict[str, bytes]:
    """Return a script that moves the bodies, and the table that it plays; none if nothing changes.

    Args:
        destination: Where the file with the bodies is written.
        player: Name of the script in ``worldgen/interop/players``.
        bodies: As in :class:`SolidScene`.
        height: Height of the walls, m.
        world: Name of the world in the file, if it has one.
    """
    if not bodies:
        return {}
    script = resources.files("worldgen.interop").joinpath("players", player).read_bytes()
    return {
        destination.sibling_file("_player.py"): script,
        destination.sibling_file("_events.json"): _events(destination.name, bodies, height, world),
    }


def _events(model: str, bodies: tuple[Body, ...], height: float, world: str) -> bytes:
    """Return the table: places of bodies, and the height of their centres after each time.

    Args:
        model: Name of the file with the bodies.
        bodies: As in :class:`SolidScene`.
        height: Height of the walls, m; a body that does not exist is parked half that height below
            the floor.
        world: Name of the world in that file, if it has one.

    Returns:
        JSON: ``model`` is that name; ``bodies`` has x and y, m, by name; ``events`` has time, s,
            name and z, m, in order of time, with one event per body at time 0 first.
    """
    heights = {True: exact(height) / 2, False: -exact(height)}
    events = [(0.0, body.name, body.shown) for body in bodies]
    later = [(time, body.name, shown) for body in bodies for time, shown in body.changes]
    events += sorted(later, key=lambda event: event[0])
    places = [
        f"    {json.dumps(body.name)}: [{', '.join(map(decimal_text, body.box.centre[:2]))}]"
        for body in bodies
    ]
    rows = [
        f"    [{time!r}, {json.dumps(name)}, {decimal_text(heights[shown])}]"
        for time, name, shown in events
    ]
    named = f'  "world": {json.dumps(world)},\n' if world else ""
    head = f'{{\n  "model": {json.dumps(model)},\n{named}  "bodies": {{\n'
    return "".join(
        (head, ",\n".join(places), '\n  },\n  "events": [\n', ",\n".join(rows), "\n  ]\n}\n")
    ).encode()


def numbered(name: str, number: int) -> str:
    """Return the name of a robot's part; robots after the first have their number in it."""
    return name if number == 1 else f"{name}_{number}"


def plain_name(destination: Destination) -> str:
    """Return the file's stem in letters, digits, ``_`` and ``-``.

    Every program accepts such a name, in XML and in topics.
    """
    name = re.sub(r"[^A-Za-z0-9_-]+", "_", PurePath(destination.name).stem)[:_LONGEST_NAME].strip(
        "_"
    )
    # Gazebo reserves this name.
    usual = re.match("[A-Za-z]", name) and name != "world"
    return name if usual else f"worldgen_{name}".rstrip("_")
