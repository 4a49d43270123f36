"""The sidecar of an exported file: the world as a ``.grid`` file, which names what it is for.

``maze.map`` has ``maze.map.worldgen.grid``. Only the facts that the file itself does not store are
taken from it, so that edits of the file take effect.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias

from worldgen.errors import FormatError, WorldgenError
from worldgen.files.grid.disk import unpack
from worldgen.files.grid.schema import MAX_FILE_BYTES
from worldgen.files.grid.writer import dumps
from worldgen.files.worlds import SIDECAR
from worldgen.interop.format import HELD, KINDS, ROBOT_FACTS, Destination, robot_kinds, robot_values
from worldgen.interop.format.foreign_map import (
    EXPORTED,
    ForeignMap,
    ForeignRobot,
    digest,
    origin_of,
    read_bounded,
)
from worldgen.world import Provenance, Robot, Value, World

_VERSION = 1
# Where the provenance of a sidecar lists its facts.
_KEPT = "kept"
_WAY_OUT = "delete it, or export the world again"

_Values: TypeAlias = "Mapping[str, Any]"


@dataclass(frozen=True)
class Sidecar:
    """The contents of a sidecar.

    Args:
        name: Name of its file.
        sha256: SHA-256 of its file.
        size: Width and height, in cells, of the map that it is for.
        values: Values by the names of :data:`~worldgen.interop.format.HELD`, in m, rad and m/s; a
            point is two numbers, and what is no number is as in a robot. The values for a robot are
            the first robot's.
        others: The values of each robot after the first.
    """

    name: str
    sha256: str
    size: tuple[int, int]
    values: _Values
    others: tuple[_Values, ...] = ()


def sidecar_text(
    world: World, destination: Destination, kept: Collection[str], robots: Sequence[Robot]
) -> bytes:
    """Return the sidecar's contents.

    Args:
        world: The world that was exported.
        destination: Its destination.
        kept: Names of :data:`~worldgen.interop.format.HELD` that the file does not store.
        robots: The robots that the file has; the first if it has none.
    """
    params: dict[str, Value] = {
        "file": destination.name,
        _KEPT: [name for name in HELD if name in kept],
        "origin": list(destination.origin),
    }
    made = Provenance(EXPORTED, _VERSION, 0, params)
    return dumps(
        replace(world, robots=tuple(robots), certificate=None, provenance=made, failure=None)
    )


def sidecar_of(path: Path) -> Path:
    """Return where a file's sidecar is."""
    return path.with_name(path.name + SIDECAR)


def read_sidecar(path: Path) -> Sidecar | None:
    """Return the sidecar next to a file, or None if there is none.

    Raises:
        FormatError: If it isn't a sidecar, with the line at fault.
    """
    companion = sidecar_of(path)
    try:
        exists = companion.exists()
    except (OSError, ValueError):
        exists = False
    if not exists:
        return None
    try:
        data = read_bounded(companion, MAX_FILE_BYTES)
    except FormatError as error:
        # Its remedies are for maps.
        message = error.message.with_remedy(_WAY_OUT)
        raise FormatError.of(message, line=error.line, source=str(companion)) from error
    try:
        return _of_grid(data, companion)
    except FormatError as error:
        fault = error.message
        message = fault.before(f", or {_WAY_OUT}") if fault.remedy else fault.with_remedy(_WAY_OUT)
        raise FormatError.of(message, line=error.line, source=str(companion)) from error


def is_sidecar(path: Path) -> bool:
    """Return True if a file is a sidecar; another file may have its name."""
    try:
        made = unpack(read_bounded(path, MAX_FILE_BYTES), str(path)).provenance
    except (OSError, WorldgenError):
        return False
    return made is not None and made.family == EXPORTED


def _of_grid(data: bytes, companion: Path) -> Sidecar:
    world = unpack(data, str(companion))
    made = world.provenance
    kept = made.params.get(_KEPT) if made is not None and made.family == EXPORTED else None
    if not isinstance(kept, list) or not all(name in list(HELD) for name in kept):
        raise FormatError("not-a-sidecar", "does not say which facts it is for")
    if made is not None and made.version != _VERSION:
        raise FormatError(
            "other-version",
            "the sidecar's version is {came}; it must be {version}",
            came=made.version,
            version=_VERSION,
        )
    of_map = {"cell_size": (world.cell_size,), "origin": origin_of(world)}
    robots = [
        _chosen(robot_values(robot), kept)
        | {name: value for name, value in robot_kinds(robot).items() if name in kept}
        for robot in world.robots
    ]
    return Sidecar(
        companion.name,
        digest(data),
        (world.width, world.height),
        {**robots[0], **_chosen(of_map, kept)},
        tuple(robots[1:]) if robots[0] else (),
    )


def _chosen(facts: Mapping[str, Any], kept: Collection[object]) -> dict[str, Any]:
    """Return some of a world's or a robot's facts as tuples; one without numbers is missing."""
    numbers = {
        name: tuple(value) if isinstance(value, list | tuple) else (value,)
        for name, value in facts.items()
        if name in kept
    }
    return {name: value for name, value in numbers.items() if value}


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
    kept = {name: values[name] for name in KINDS if name in values}
    for name in ("robot_radius", "robot_speed"):
        if name in values:
            kept[name.removeprefix("robot_")] = values[name][0]
    return robot._replace(
        start=_joined(values.get("start"), values.get("heading"), robot.start),
        target=_joined(values.get("target"), values.get("target_radius"), robot.target),
        **kept,
    )


def _joined(
    point: tuple[float, ...] | None, third: tuple[float, ...] | None, own: tuple[float, ...] | None
) -> tuple[float, ...] | None:
    """Return a point; its third number comes from the sidecar if that has one, else the file."""
    if point is None and own is None:
        return None
    own = own or ()
    return (*(point or own[:2]), *(third or own[2:]))
