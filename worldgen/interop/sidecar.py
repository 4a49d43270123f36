"""The sidecar of an exported file: a small TOML file with what its format cannot store.

``maze.map`` has ``maze.map.worldgen.toml``. It contains only what the file itself does not store,
so that edits of the file take effect.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias

from worldgen.errors import FormatError
from worldgen.files.grid.header import Header
from worldgen.files.grid.toml_text import value_text
from worldgen.interop.format import (
    HELD,
    LENGTHS,
    PAIRS,
    ROBOT_FACTS,
    Destination,
    fact_numbers,
    held_values,
    robot_values,
)
from worldgen.interop.format.foreign_map import ForeignMap, ForeignRobot, digest, read_bounded
from worldgen.world import Robot, Value, World

SUFFIX = ".worldgen.toml"
_VERSION = 1
_MOST_BYTES = 1 << 20
_SIZE = "size"
# Table of each robot after the first.
_ROBOT = "robot"

_Values: TypeAlias = "Mapping[str, tuple[float, ...]]"


@dataclass(frozen=True)
class Sidecar:
    """The contents of a sidecar.

    Args:
        name: Name of its file.
        sha256: SHA-256 of its file.
        size: Width and height, in cells, of the map that it is for.
        values: Values by the names of :data:`~worldgen.interop.format.HELD`, in m, rad and m/s; a
            point is two numbers. The values for a robot are the first robot's.
        others: The values of each robot after the first.
    """

    name: str
    sha256: str
    size: tuple[int, int]
    values: _Values
    others: tuple[_Values, ...] = ()


def sidecar_text(
    world: World, destination: Destination, missing: Collection[str], others: Sequence[Robot]
) -> bytes:
    """Return the sidecar's contents.

    Args:
        world: The world that was exported.
        destination: Its destination.
        missing: Names of :data:`~worldgen.interop.format.HELD` that the file does not store.
        others: The robots after the first that the file has.
    """
    values = held_values(world, destination)
    kept: dict[str, Value] = {"worldgen": _VERSION, _SIZE: [world.width, world.height]}
    kept |= {name: value for name, value in values.items() if name in missing}
    lines = [
        f"# Facts that {destination.name!r} cannot store; m, rad, m/s, from the grid's lower-left "
        f"corner, y up."
    ]
    lines += [f"{name} = {value_text(value, name)}" for name, value in kept.items()]
    # Each further robot has a table with its own values.
    own = [name for name in ROBOT_FACTS if name in missing]
    for robot in others if own else ():
        facts = robot_values(robot)
        lines += [
            "",
            f"[[{_ROBOT}]]",
            *(f"{name} = {value_text(facts[name], name)}" for name in own),
        ]
    return ("\n".join(lines) + "\n").encode()


def read_sidecar(path: Path) -> Sidecar | None:
    """Return the sidecar next to a file, or None if there is none.

    Raises:
        FormatError: If it isn't a sidecar, with the line at fault.
    """
    companion = path.with_name(path.name + SUFFIX)
    try:
        if not companion.exists():
            return None
    except (OSError, ValueError):
        return None
    data = _bytes(companion)
    source = str(companion)
    try:
        header = Header(data.decode("utf-8-sig"), 1, source, "the sidecar")
    except UnicodeDecodeError as error:
        raise FormatError(
            "not-utf8", "is not UTF-8 text", "delete it, or export the world again", source=source
        ) from error
    _check_keys(header, header.data, ("worldgen", _SIZE, *HELD, _ROBOT))
    if header.data.get("worldgen") != _VERSION:
        raise FormatError(
            "other-version",
            "the sidecar's version must be worldgen = {version}",
            "export the world again",
            version=_VERSION,
            **header.at("worldgen"),
        )
    size = _numbers(header, header.data, _SIZE)
    values = {key: _numbers(header, header.data, key) for key in HELD if key in header.data}
    sides = (int(size[0]), int(size[1]))
    return Sidecar(companion.name, digest(data), sides, values, tuple(_others(header)))


def _check_keys(
    header: Header, table: Mapping[str, object], known: Sequence[str], index: int | None = None
) -> None:
    for key in table:
        if key not in known:
            raise FormatError(
                "unknown-name",
                "{name!q} is not a key of a sidecar",
                "it has {known!l}",
                name=key,
                known=list(known),
                **header.at(key, table=_ROBOT, index=index),
            )


def _others(header: Header) -> Iterator[_Values]:
    """Yield the values of each robot after the first."""
    tables = header.data.get(_ROBOT, [])
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        raise FormatError(
            "wrong-type",
            "{key} must be tables, one [[{key}]] for each robot after the first",
            key=_ROBOT,
            **header.at(_ROBOT),
        )
    for index, table in enumerate(tables):
        _check_keys(header, table, ROBOT_FACTS, index)
        yield {key: _numbers(header, table, key, index) for key in ROBOT_FACTS if key in table}


def _bytes(path: Path) -> bytes:
    try:
        return read_bounded(path, _MOST_BYTES)
    # Its remedy is for maps.
    except FormatError as error:
        message = error.message.with_remedy("delete it, or export the world again")
        raise FormatError.of(message, source=str(path)) from error


def _numbers(
    header: Header, table: Mapping[str, object], key: str, index: int | None = None
) -> tuple[float, ...]:
    """Return the numbers of a key: the right count, finite, lengths above 0.

    Args:
        header: The sidecar.
        table: The table that has the key: the sidecar itself, or one robot's.
        key: Name of the value.
        index: Number of the robot's table, from 0; None for the sidecar itself.
    """
    numbers = fact_numbers(key, table.get(key))
    if numbers is None:
        rule = (
            "{key} must be two finite numbers in brackets"
            if key in PAIRS
            else "{key} must be a finite number"
        )
        raise FormatError("wrong-type", rule, key=key, **header.at(key, table=_ROBOT, index=index))
    if key in LENGTHS and min(numbers) <= 0:
        raise FormatError(
            "not-positive",
            "{key} must be above 0",
            key=key,
            **header.at(key, table=_ROBOT, index=index),
        )
    return numbers


def with_sidecar(found: ForeignMap, sidecar: Sidecar) -> ForeignMap:
    """Add what the file could not store to its map.

    If the sidecar belongs to another map, return the map unchanged, with a warning.
    """
    height, width = found.walls.shape
    if (width, height) != sidecar.size:
        warning = (
            f"{sidecar.name} belongs to a map of {sidecar.size[0]} x {sidecar.size[1]} cells, not "
            f"{width} x {height}; it was ignored; delete it, or export the world again"
        )
        return replace(found, warnings=(*found.warnings, warning))

    # Find each robot's values.
    values, warnings = _values_of_robots(found, sidecar)
    if found.numbers:
        half = found.cell_size / 2
        values = [
            _unmoved(robot, own, half) for robot, own in zip(found.robots, values, strict=True)
        ]
    of_map = {name: value for name, value in sidecar.values.items() if name not in ROBOT_FACTS}
    used = of_map.keys() | {name for own in values for name in own}
    if not used:
        return replace(found, warnings=(*found.warnings, *warnings))

    # Complete the robots, and report which values were used.
    origin = of_map.get("origin")
    said = ", ".join(words for name, words in HELD.items() if name in used)
    return replace(
        found,
        robots=tuple(map(_completed, found.robots, values)),
        origin=found.origin if origin is None else (origin[0], origin[1]),
        params={**found.params, "sidecar_sha256": sidecar.sha256},
        notes=(*found.notes, f"{sidecar.name} says {said}"),
        warnings=(*found.warnings, *warnings),
    )


def _values_of_robots(found: ForeignMap, sidecar: Sidecar) -> tuple[list[_Values], tuple[str, ...]]:
    """Return the sidecar's values of each of the file's robots, with warnings if some have none."""
    first = {name: value for name, value in sidecar.values.items() if name in ROBOT_FACTS}
    known = (first, *sidecar.others)
    count = len(found.robots)
    # If the file just lists its robots, a missing one leaves the numbers of the rest unknown.
    if not found.numbers and count < len(known):
        warning = (
            f"{sidecar.name} has values of {len(known)} robots, but the file has {count}; they "
            f"were ignored; export the world again"
        )
        return [{}] * count, (warning,)
    numbers = found.numbers or range(1, count + 1)
    absent = [number for number in numbers if number > len(known)]
    warnings = []
    if absent and any(known):
        which = f"robot {absent[0]}" if len(absent) == 1 else f"robots {absent[0]} to {absent[-1]}"
        warnings.append(f"{sidecar.name} has no values of {which}; export the world again")
    return [known[number - 1] if number <= len(known) else {} for number in numbers], tuple(
        warnings
    )


def _unmoved(robot: ForeignRobot, values: _Values, half: float) -> _Values:
    """Return a robot's values without the places that the file now has in other cells."""
    kept = dict(values)
    for name, third, own in (
        ("start", "heading", robot.start),
        ("target", "target_radius", robot.target),
    ):
        point = values.get(name)
        # The file has the middle of the cell; a place on its edge belongs to it too.
        if (
            point
            and own
            and any(
                abs(at - middle) > half * (1 + 1e-9) for at, middle in zip(point, own, strict=False)
            )
        ):
            del kept[name]
            kept.pop(third, None)
    return kept


def _completed(robot: ForeignRobot, values: _Values) -> ForeignRobot:
    return ForeignRobot(
        _joined(values.get("start"), values.get("heading"), robot.start),
        _joined(values.get("target"), values.get("target_radius"), robot.target),
        *(
            values[name][0] if name in values else own
            for name, own in (("robot_radius", robot.radius), ("robot_speed", robot.speed))
        ),
    )


def _joined(
    point: tuple[float, ...] | None, third: tuple[float, ...] | None, own: tuple[float, ...] | None
) -> tuple[float, ...] | None:
    """Return a point; its third number comes from the sidecar if that has one, else the file."""
    if point is None and own is None:
        return None
    own = own or ()
    return (*(point or own[:2]), *(third or own[2:]))
