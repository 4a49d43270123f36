"""Worlds as JSON messages, with numbers that a browser represents exactly."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from typing import Annotated, Any, TypeAlias, TypeVar

import msgspec
import numpy as np

from fuzz.failure import Failure
from fuzz.player import MOST_CELLS
from fuzz.player.streams import bits
from fuzz.studio.requests.limits import LENGTHS
from worldgen.domain import MASK64
from worldgen.errors import InvalidParameter, InvalidWorld
from worldgen.files.grid import dumps, loads
from worldgen.files.json_file import converted
from worldgen.support.arrays import Bools
from worldgen.timeline import Timeline
from worldgen.world import Pose, Robot, Target, World

T = TypeVar("T")

Request: TypeAlias = Mapping[str, Any]
"""A message from the page."""
SendPart: TypeAlias = Callable[[dict[str, Any]], None]
"""Sends a part of an answer to the page before the rest is known."""

# A column or row, which may be outside the grid but not absurdly far.
_Cell = Annotated[int, msgspec.Meta(ge=-(1 << 20), le=1 << 20)]
_MOST_EVENTS = 1_000_000
_SOURCE_LIMIT = 8 << 20  # characters of a file's text, which the page keeps and sends back


def message_of(world: World) -> dict[str, Any]:
    """Return a world as the page edits it, without its proof; ``WorldMessage`` in ``types.d.ts``.

    Lengths are in m; ``cells`` are bits in base64, row by row from the lowest y. ``events`` are
    columns: time in s, column, row from the lowest, and state: 0 free, 1 solid, 2 burning.
    ``others`` are the robots after the first, which the page draws but does not edit.
    ``source`` is the text of the file from which it was opened, or null. As long as the world stays
    the same, it is saved with that file's proof, provenance and failure.

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
    if world.walls.size > MOST_CELLS or len(world.timeline) > _MOST_EVENTS:
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
            most_events=_MOST_EVENTS,
        )
    times, ix, iy, states = (column.tolist() for column in world.timeline.columns)
    text = dumps(world)
    is_kept = len(text) <= _SOURCE_LIMIT
    return {
        "width": world.width,
        "height": world.height,
        "cells": bits(world.walls),
        "cell_size": world.cell_size,
        "robot_radius": world.robot_radius,
        "robot_speed": world.robot_speed,
        "start": [world.start.x, world.start.y, world.start.heading],
        "target": [world.target.x, world.target.y, world.target.radius],
        "events": {"times": times, "ix": ix, "iy": iy, "state": states}
        if world.is_dynamic
        else None,
        # Without the file's text, the other robots are lost.
        "others": [_ends(robot) for robot in world.robots[1:]] if is_kept else [],
        "source": text.decode("utf-8") if is_kept else None,
    }


def _ends(robot: Robot) -> dict[str, Any]:
    return {
        "start": [robot.start.x, robot.start.y, robot.start.heading],
        "target": [robot.target.x, robot.target.y, robot.target.radius],
        "radius": robot.radius,
    }


def opened_message(world: World) -> dict[str, Any]:
    """Return a world together with the facts in its file."""
    made = world.provenance
    failure = Failure.found_in(world)
    return {
        "world": message_of(world),
        "made": None
        if made is None
        else f"{made.family}, version {made.version}, seed {made.seed}",
        "failure": None
        if failure is None
        else {
            "controller": failure.record.controller,
            "motion": failure.record.motion,
            "seed": failure.record.seed,
            "verdict": failure.verdict,
            "digest": failure.record.trace_digest,
            "parameters": dict(failure.record.parameters),
        },
    }


class _Events(msgspec.Struct):
    times: list[float]
    ix: list[_Cell]
    iy: list[_Cell]
    state: list[Annotated[int, msgspec.Meta(ge=0, le=2)]]

    def timeline(self) -> Timeline:
        columns = (self.times, self.ix, self.iy, self.state)
        if len({len(column) for column in columns}) != 1 or len(self.times) > _MOST_EVENTS:
            raise InvalidParameter(
                "wrong-count",
                "the message's events are not columns of equal length up to {most}",
                most=_MOST_EVENTS,
            )
        return Timeline(*map(np.array, columns))


class _World(msgspec.Struct):
    width: int
    height: int
    cells: bytes
    cell_size: float
    robot_radius: float
    robot_speed: float
    start: tuple[float, float, float]
    target: tuple[float, float, float]
    events: _Events | None = None

    def walls(self) -> Bools:
        count = self.width * self.height
        if len(self.cells) != -(-count // 8):
            raise InvalidParameter(
                "wrong-count",
                "the message's cells have {count} bytes",
                "send one bit per cell",
                count=len(self.cells),
            )
        found = np.unpackbits(np.frombuffer(self.cells, np.uint8), count=count, bitorder="little")
        return found.astype(np.bool_).reshape(self.height, self.width)


def world_of(message: Mapping[str, Any]) -> World:
    """Return the world that a message contains, without proof.

    Raises:
        InvalidParameter: If a part of the message is missing or of another type.
        InvalidWorld: If the parts do not form a valid world.
    """
    sent = checked(message, _World)
    if min(sent.width, sent.height) < 1 or sent.width * sent.height > MOST_CELLS:
        raise InvalidWorld(
            "too-large",
            "{width} x {height} cells",
            "the studio draws worlds of 1 to {most} cells",
            width=sent.width,
            height=sent.height,
            most=MOST_CELLS,
        )
    return World(
        walls=sent.walls(),
        start=Pose(*sent.start),
        target=Target(*sent.target),
        cell_size=sent.cell_size,
        robot_radius=sent.robot_radius,
        robot_speed=sent.robot_speed,
        timeline=Timeline() if sent.events is None else sent.events.timeline(),
    )


def restored(message: Mapping[str, Any]) -> World:
    """Return the world in a message.

    If it still equals the one in its file, it has the file's proof, provenance and failure. The
    page shows and edits one robot; the file's other robots stay as they are.

    Raises:
        InvalidParameter: If a part of the message is missing or of another type.
        InvalidWorld: If the parts do not form a valid world.
        FormatError: If the file's text is no longer valid.
    """
    world = world_of(message)
    source = message.get("source")
    if not isinstance(source, str):
        return world
    opened = loads(source.encode("utf-8"))
    if is_same_place(opened.alone(1), world):
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


def is_same_place(one: World, other: World) -> bool:
    """Return True if two worlds differ at most in proof, provenance and failure."""
    bare = (world.bare for world in (one, other))
    return next(bare) == next(bare)


def checked(message: object, kind: type[T]) -> T:
    """Return a message as a checked value of a msgspec type.

    Raises:
        InvalidParameter: If a part of it is missing, of another type, or out of range.
    """
    try:
        return converted(message, kind)
    except ValueError as error:
        raise InvalidParameter(
            "wrong-message",
            "the page sent a malformed message: {reason}",
            "reload the page",
            reason=str(error),
        ) from error


def field(message: Mapping[str, Any], name: str, kind: type) -> Any:
    """Return a part of a message, checking its type; an integer is also accepted as a float.

    Raises:
        InvalidParameter: If it is missing or of another type.
    """
    value = message.get(name)
    # A browser represents integers exactly only up to 2**53.
    if kind is float and type(value) is int:
        value = float(value) if abs(value) < 1 << 53 else math.inf
    if type(value) is not kind:
        raise InvalidParameter(
            "wrong-type",
            "the message's {name} is {kind}; it must be {wanted}",
            name=name,
            kind=type(value).__name__,
            wanted=kind.__name__,
        )
    return value


def seed_of(message: Mapping[str, Any]) -> int:
    """Return a message's seed, which is sent as digits because a browser cannot hold all seeds.

    Raises:
        InvalidParameter: If it is not an integer from 0 to 2**64 - 1.
    """
    seed: str = field(message, "seed", str)
    if not (seed.isascii() and seed.isdigit() and len(seed) <= 20 and int(seed) <= MASK64):
        raise InvalidParameter(
            "not-a-seed",
            "seed={seed!r} is not an integer from 0 to 2**64 - 1",
            "choose a seed in that range",
            seed=seed[:40],
        )
    return int(seed)
