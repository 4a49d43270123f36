"""The sidecar of an exported file: a small TOML file with what its format cannot store.

``maze.map`` has ``maze.map.worldgen.toml``. It contains only what the file itself does not store,
so that edits of the file take effect.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from worldgen.errors import FormatError, Message
from worldgen.files.grid.header import Header
from worldgen.files.grid.toml_text import value_text
from worldgen.interop.foreign_map import ForeignMap, digest, read_bounded
from worldgen.interop.format import HELD, Destination, held_values
from worldgen.world import Value, World

__all__ = ["SUFFIX", "Sidecar", "read_sidecar", "sidecar_text", "with_sidecar"]

SUFFIX = ".worldgen.toml"
_VERSION = 1
_MOST_BYTES = 64 << 10
_PAIRS = ("start", "target", "origin")
# These must be above 0.
_LENGTHS = ("target_radius", "robot_radius", "robot_speed", "cell_size")
_SIZE = "size"


@dataclass(frozen=True)
class Sidecar:
    """The contents of a sidecar.

    Args:
        name: Name of its file.
        sha256: SHA-256 of its file.
        size: Width and height, in cells, of the map that it is for.
        values: Values by the names of :data:`~worldgen.interop.format.HELD`, in m, rad and m/s; a
            point is two numbers.
    """

    name: str
    sha256: str
    size: tuple[int, int]
    values: Mapping[str, tuple[float, ...]]


def sidecar_text(world: World, destination: Destination, missing: Collection[str]) -> bytes:
    """Return the sidecar's contents.

    Args:
        world: The world that was exported.
        destination: Where it was written.
        missing: Names of :data:`~worldgen.interop.format.HELD` that the file does not store.
    """
    values = held_values(world, destination)
    kept: dict[str, Value] = {"worldgen": _VERSION, _SIZE: [world.width, world.height]}
    kept |= {name: value for name, value in values.items() if name in missing}
    lines = [
        f"# Facts that {destination.name!r} cannot store; m, rad, m/s, from the grid's lower-left "
        f"corner, y up."
    ]
    lines += [f"{name} = {value_text(value, name)}" for name, value in kept.items()]
    return ("\n".join(lines) + "\n").encode()


def read_sidecar(path: Path) -> Sidecar | None:
    """Return the sidecar next to a file, or None if there is none.

    Args:
        path: The map's file.

    Raises:
        FormatError: If it isn't a sidecar, with the line at fault.
    """
    beside = path.with_name(path.name + SUFFIX)
    try:
        if not beside.exists():
            return None
    except (OSError, ValueError):
        return None
    data = _bytes(beside)
    source = str(beside)
    try:
        header = Header(data.decode("utf-8-sig"), 1, source, "the sidecar")
    except UnicodeDecodeError as error:
        raise FormatError(
            "not-utf8", "is not UTF-8 text", "delete it, or export the world again", source=source
        ) from error
    known = ("worldgen", _SIZE, *HELD)
    for key in header.data:
        if key not in known:
            raise header.fault(
                Message(
                    "unknown-name",
                    "{name!q} is not a key of a sidecar",
                    "it has {known!l}",
                    name=key,
                    known=list(known),
                ),
                key,
            )
    if header.data.get("worldgen") != _VERSION:
        raise header.fault(
            Message(
                "other-version",
                "worldgen = {version} must be the sidecar's version",
                "export the world again",
                version=_VERSION,
            ),
            "worldgen",
        )
    size = _numbers(header, _SIZE)
    values = {key: _numbers(header, key) for key in HELD if key in header.data}
    return Sidecar(beside.name, digest(data), (int(size[0]), int(size[1])), values)


def _bytes(path: Path) -> bytes:
    try:
        return read_bounded(path, _MOST_BYTES)
    # Its remedy is for maps.
    except FormatError as error:
        message = error.message.with_remedy("delete it, or export the world again")
        raise FormatError.of(message, source=str(path)) from error


def _numbers(header: Header, key: str) -> tuple[float, ...]:
    """Return the numbers of a key: the right count, finite, lengths above 0."""
    value = header.data.get(key)
    items = value if isinstance(value, list) else [value]
    count = 2 if key in (*_PAIRS, _SIZE) else 1
    numbers = tuple(
        float(item)
        for item in items
        if isinstance(item, int | float) and not isinstance(item, bool)
    )
    if len(items) != count or len(numbers) != count or not all(map(math.isfinite, numbers)):
        rule = (
            "{key} must be two finite numbers in brackets"
            if count == 2
            else "{key} must be a finite number"
        )
        raise header.fault(Message("wrong-type", rule, key=key), key)
    if key in (*_LENGTHS, _SIZE) and min(numbers) <= 0:
        raise header.fault(Message("not-positive", "{key} must be above 0", key=key), key)
    return numbers


def with_sidecar(found: ForeignMap, sidecar: Sidecar) -> ForeignMap:
    """Add what the file could not store to its map.

    If the sidecar belongs to another map, return the map unchanged, with a warning.
    """
    height, width = found.walls.shape
    if (width, height) != sidecar.size:
        warning = (
            f"{sidecar.name} belongs to a map of {sidecar.size[0]} x {sidecar.size[1]} cells, not "
            f"{width} x {height}; "
            "it was ignored; delete it, or export the world again"
        )
        return replace(found, warnings=(*found.warnings, warning))
    values = sidecar.values
    start = _joined(values.get("start"), values.get("heading"), found.start)
    target = _joined(values.get("target"), values.get("target_radius"), found.target)
    said = ", ".join(HELD[name] for name in values)
    return replace(
        found,
        start=start,
        target=target,
        robot_radius=next(_firsts(values, "robot_radius"), found.robot_radius),
        robot_speed=next(_firsts(values, "robot_speed"), found.robot_speed),
        origin=(values["origin"][0], values["origin"][1]) if "origin" in values else found.origin,
        params={**found.params, "sidecar_sha256": sidecar.sha256},
        notes=(*found.notes, f"{sidecar.name} says {said}"),
    )


def _joined(
    point: tuple[float, ...] | None, third: tuple[float, ...] | None, own: tuple[float, ...] | None
) -> tuple[float, ...] | None:
    """Return a point; its third number comes from the sidecar if that has one, else the file."""
    if point is None and own is None:
        return None
    rest = third or (own[2:] if own else ())
    return (*(point or (own or ())[:2]), *rest)


def _firsts(values: Mapping[str, tuple[float, ...]], name: str) -> Iterator[float]:
    return iter(values.get(name, ()))
