"""Convert worlds between the library's form and the page's."""

from __future__ import annotations

import dataclasses
from typing import Any

import msgspec
import numpy as np

from fuzz.failure import Failure
from fuzz.player import MOST_CELLS
from fuzz.studio.requests.limits import LENGTHS, MOST_EVENTS
from fuzz.studio.requests.protocol import (
    Events,
    OpenedMessage,
    RecordedRun,
    RobotEnds,
    Triple,
    WorldMessage,
)
from worldgen.errors import InvalidParameter, InvalidWorld
from worldgen.files.grid import dumps, loads
from worldgen.timeline import Timeline
from worldgen.world import Pose, Robot, Target, World

_SOURCE_LIMIT = 8 << 20  # characters of a file's text, which the page keeps and sends back


def message_of(world: World) -> WorldMessage:
    """Return a world as the page edits it, without its proof.

    Raises:
        InvalidWorld: If it has more cells or events than the page allows, or cells of another size.
    """
    least, largest = LENGTHS
    if not least <= world.cell_size <= largest:
        raise InvalidWorld(
            "out-of-range",
            "cell_size={cell_size:g} m: the studio draws cells of {least} to {largest} m; "
            "worldgen show draws other sizes",
            cell_size=world.cell_size,
            least=least,
            largest=largest,
        )
    if world.walls.size > MOST_CELLS or len(world.timeline) > MOST_EVENTS:
        raise InvalidWorld(
            "too-large",
            "{width} x {height} cells with {count} changes are more than the studio's "
            "{most_cells} cells and {most_events} changes",
            "worldgen show draws larger worlds",
            at_terminal=True,
            width=world.width,
            height=world.height,
            count=len(world.timeline),
            most_cells=MOST_CELLS,
            most_events=MOST_EVENTS,
        )
    text = dumps(world)
    is_kept = len(text) <= _SOURCE_LIMIT
    columns = (column.tolist() for column in world.timeline.columns)
    start, target = _ends(world.robots[0])
    return WorldMessage(
        world.width,
        world.height,
        np.packbits(world.walls, bitorder="little").tobytes(),
        world.cell_size,
        world.robot_radius,
        world.robot_speed,
        start,
        target,
        Events(*columns) if world.is_dynamic else None,
        # Without the file's text, the other robots are lost.
        [RobotEnds(*_ends(robot), robot.radius) for robot in world.robots[1:]] if is_kept else [],
        text.decode("utf-8") if is_kept else None,
    )


def _ends(robot: Robot) -> tuple[Triple, Triple]:
    start, target = robot.start, robot.target
    return (start.x, start.y, start.heading), (target.x, target.y, target.radius)


def opened_message(world: World, **more: Any) -> OpenedMessage:
    """Return a world together with the facts in its file, and more fields of the message."""
    made = world.provenance
    failure = Failure.found_in(world)
    record = None if failure is None else failure.record
    return OpenedMessage(
        world=message_of(world),
        made=None if made is None else f"{made.family}, version {made.version}, seed {made.seed}",
        failure=None
        if record is None
        else RecordedRun(
            record.controller,
            record.motion,
            record.seed,
            dict(record.parameters),
            record.verdict,
            record.trace_digest,
        ),
        **more,
    )


def world_of(message: WorldMessage) -> World:
    """Return the world that a message contains, without proof.

    Raises:
        InvalidParameter: If it has too few cells or too many.
        InvalidWorld: If the parts do not form a valid world.
    """
    count = message.width * message.height
    if count > MOST_CELLS:
        raise InvalidWorld(
            "too-large",
            "{width} x {height} cells",
            "the studio draws worlds of 1 to {most} cells",
            width=message.width,
            height=message.height,
            most=MOST_CELLS,
        )
    if len(message.cells) != -(-count // 8):
        raise InvalidParameter(
            "wrong-count",
            "the message's cells have {count} bytes",
            "send one bit per cell",
            count=len(message.cells),
        )
    bits = np.frombuffer(message.cells, np.uint8)
    walls = np.unpackbits(bits, count=count, bitorder="little").astype(np.bool_)
    return World(
        walls=walls.reshape(message.height, message.width),
        start=Pose(*message.start),
        target=Target(*message.target),
        cell_size=message.cell_size,
        robot_radius=message.robot_radius,
        robot_speed=message.robot_speed,
        timeline=Timeline()
        if message.events is None
        else Timeline(*map(np.array, msgspec.structs.astuple(message.events))),
    )


def restored(message: WorldMessage) -> World:
    """Return the world in a message.

    If it still equals the one in its file, it has the file's proof, provenance and failure. The
    page shows and edits one robot; the file's other robots stay as they are.

    Raises:
        InvalidParameter: As for ``world_of``.
        InvalidWorld: If the parts do not form a valid world.
        FormatError: If the file's text is no longer valid.
    """
    world = world_of(message)
    if message.source is None:
        return world
    opened = loads(message.source.encode("utf-8"))
    world = _with_robot_of(opened, world)
    if opened.alone(1) == world:
        return opened
    if not opened.is_fleet:
        return world
    # Their positions in a resized world are undefined.
    if (opened.walls.shape, opened.cell_size) != (world.walls.shape, world.cell_size):
        raise InvalidWorld(
            "other-robots",
            "the file has {robots} robots, and the studio cannot reposition the others when you "
            "resize the world",
            "undo the change of size, or open a copy with a single [[robot]]",
            robots=len(opened.robots),
        )
    return dataclasses.replace(world, robots=(*world.robots, *opened.robots[1:]))


def _with_robot_of(opened: World, world: World) -> World:
    """Return an edited world with what the page does not show of the file's first robot.

    That is its body, its drive, and what counts as arriving.
    """
    robot = opened.robots[0]
    shown = world.target
    goal = dataclasses.replace(robot.target, x=shown.x, y=shown.y, radius=shown.radius)
    robot = dataclasses.replace(
        robot, start=world.start, target=goal, radius=world.robot_radius, speed=world.robot_speed
    )
    return dataclasses.replace(world, robots=(robot,))
