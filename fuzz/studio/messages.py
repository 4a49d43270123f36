"""Worlds as JSON messages, with numbers that a browser represents exactly."""

from __future__ import annotations

import base64
import binascii
import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any, TypedDict

import numpy as np
import numpy.typing as npt

from fuzz.failure import Failure
from fuzz.player import MOST_CELLS
from fuzz.player.streams import bits
from fuzz.studio.limits import LENGTHS
from worldgen.errors import InvalidParameter, InvalidWorld
from worldgen.files.grid import dumps, loads
from worldgen.timeline import Timeline
from worldgen.world import Pose, Target, World

__all__ = [
    "EventsMessage",
    "WorldMessage",
    "field",
    "is_same_place",
    "message_of",
    "opened_message",
    "restored",
    "seed_of",
    "world_of",
]

_MOST_EVENTS = 1_000_000
_SOURCE_LIMIT = 8 << 20  # characters of a file's text, which the page keeps and sends back


class EventsMessage(TypedDict):
    """Changes of cells, in columns.

    Time in s, column, row from the lowest, and state: 0 free, 1 solid, 2 burning.
    """

    times: list[float]
    ix: list[int]
    iy: list[int]
    state: list[int]


class WorldMessage(TypedDict):
    """A world without its proof.

    Lengths are in m; ``cells`` are bits in base64, row by row from the lowest y. ``source`` is the
    text of the file from which it was opened, or null. As long as the world stays the same, it is
    saved with that file's proof, provenance and failure.
    """

    width: int
    height: int
    cells: str
    cell_size: float
    robot_radius: float
    robot_speed: float
    start: list[float]
    target: list[float]
    events: EventsMessage | None
    source: str | None


def message_of(world: World) -> WorldMessage:
    """Return a world as the page edits it.

    Raises:
        InvalidWorld: If it has more cells or events than the page allows, or cells of another size.
    """
    least, largest = LENGTHS
    if not least <= world.cell_size <= largest:
        raise InvalidWorld(
            "out-of-range",
            "cell_size={cell_size:g} m: the studio draws cells of {least} to {largest} m; worldgen "
            "show draws others",
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
    line = world.timeline
    text = dumps(world)
    return {
        "width": world.width,
        "height": world.height,
        "cells": bits(world.walls),
        "cell_size": world.cell_size,
        "robot_radius": world.robot_radius,
        "robot_speed": world.robot_speed,
        "start": [world.start.x, world.start.y, world.start.heading],
        "target": [world.target.x, world.target.y, world.target.radius],
        "events": {
            "times": line.times.tolist(),
            "ix": line.ix.tolist(),
            "iy": line.iy.tolist(),
            "state": line.states.tolist(),
        }
        if world.is_dynamic
        else None,
        "source": text.decode("utf-8") if len(text) <= _SOURCE_LIMIT else None,
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


def world_of(message: Mapping[str, Any]) -> World:
    """Return the world in a message, without proof.

    Raises:
        InvalidParameter: If a part of the message is missing or of another type.
        InvalidWorld: If the parts do not form a valid world.
    """
    width, height = (field(message, side, int) for side in ("width", "height"))
    if min(width, height) < 1 or width * height > MOST_CELLS:
        raise InvalidWorld(
            "too-large",
            "{width} x {height} cells",
            "the studio draws worlds of 1 to {most} cells",
            width=width,
            height=height,
            most=MOST_CELLS,
        )
    events = message.get("events")
    return World(
        walls=_cells(field(message, "cells", str), width, height),
        start=Pose(*_numbers(message, "start", 3)),
        target=Target(*_numbers(message, "target", 3)),
        cell_size=field(message, "cell_size", float),
        robot_radius=field(message, "robot_radius", float),
        robot_speed=field(message, "robot_speed", float),
        timeline=Timeline() if events is None else _timeline(events),
    )


def restored(message: Mapping[str, Any]) -> World:
    """Return the world in a message.

    If it still equals the one in its file, it has the file's proof, provenance and failure.

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
    return opened if is_same_place(opened, world) else world


def is_same_place(one: World, other: World) -> bool:
    """Return True if two worlds differ at most in proof, provenance and failure."""
    bare = (
        dataclasses.replace(world, certificate=None, provenance=None, failure=None)
        for world in (one, other)
    )
    return next(bare) == next(bare)


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
    if not (seed.isascii() and seed.isdigit() and len(seed) <= 20 and int(seed) < 1 << 64):
        raise InvalidParameter(
            "not-a-seed",
            "seed={seed!r} is not an integer from 0 to 2**64 - 1",
            "choose one in that range",
            seed=seed[:40],
        )
    return int(seed)


def _numbers(message: Mapping[str, Any], name: str, count: int) -> list[float]:
    values = field(message, name, list)
    if len(values) != count:
        raise InvalidParameter(
            "wrong-count",
            "the message's {name} has {count} numbers; it must have {wanted}",
            name=name,
            count=len(values),
            wanted=count,
        )
    return [field({name: value}, name, float) for value in values]


def _cells(text: str, width: int, height: int) -> npt.NDArray[np.bool_]:
    try:
        data = np.frombuffer(base64.b64decode(text, validate=True), np.uint8)
    except (binascii.Error, ValueError) as error:
        raise InvalidParameter(
            "not-base64", "the message's cells are not base64", "send the cells' bits"
        ) from error
    if len(data) != -(-width * height // 8):
        raise InvalidParameter(
            "wrong-count",
            "the message's cells have {count} bytes",
            "send one bit for each cell",
            count=len(data),
        )
    return (
        np.unpackbits(data, count=width * height, bitorder="little")
        .astype(np.bool_)
        .reshape(height, width)
    )


def _timeline(events: object) -> Timeline:
    if not isinstance(events, dict):
        raise InvalidParameter(
            "wrong-type", "the message's events are not a table", "send times, ix, iy and state"
        )
    columns: list[Sequence[Any]] = [
        field(events, name, list) for name in ("times", "ix", "iy", "state")
    ]
    if len({len(column) for column in columns}) != 1 or len(columns[0]) > _MOST_EVENTS:
        raise InvalidParameter(
            "wrong-count",
            "the message's events are not columns of one length up to {most}",
            most=_MOST_EVENTS,
        )
    times = [field({"times": value}, "times", float) for value in columns[0]]
    ix, iy, state = (
        [field({"events": value}, "events", int) for value in column] for column in columns[1:]
    )
    if any(not 0 <= value <= 2 for value in state) or any(
        abs(value) > 1 << 20 for value in (*ix, *iy)
    ):
        raise InvalidParameter(
            "out-of-range",
            "the message's events have a state other than 0, 1 and 2, or a cell far outside",
        )
    return Timeline(
        np.array(times), np.array(ix, np.int64), np.array(iy, np.int64), np.array(state, np.uint8)
    )
