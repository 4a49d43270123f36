"""Exporters by name: a world becomes a file of some other program."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from worldgen.errors import InvalidParameter
from worldgen.registry import Registry
from worldgen.world import World

__all__ = ["EXPORTERS", "ExportOptions", "Exported", "Exporter", "export_world"]


@dataclass(frozen=True)
class ExportOptions:
    """What can be asked of an exporter.

    Args:
        noise: Whether the thesis's noise filter goes over the map; where left out, as the imported file had it.
    """

    noise: bool | None = None


@dataclass(frozen=True)
class Exported:
    """A file's contents.

    Args:
        data: Its bytes.
        notes: Sentences on what the format does not hold, or its program does not take.
    """

    data: bytes
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Exporter:
    """A foreign format that a world can be written in; register it in the group ``worldgen.exporters``.

    Args:
        name: As ``export --to`` takes it.
        suffix: Usual ending of its files.
        summary: One line for people.
        export: Makes the file.
        options: Names of the :class:`ExportOptions` that mean something to it.
    """

    name: str
    suffix: str
    summary: str
    export: Callable[[World, ExportOptions], Exported]
    options: tuple[str, ...] = ()


def _accept(name: str, thing: Any) -> Exporter:
    if not isinstance(thing, Exporter):
        raise InvalidParameter(f"exporter {name!r} is {thing!r}, not an Exporter; make one of it")
    return thing


EXPORTERS: Registry[Exporter] = Registry("worldgen.exporters", "exporter", _accept)


def export_world(world: World, name: str, options: ExportOptions | None = None) -> Exported:
    """A world in a foreign format.

    Args:
        world: The world.
        name: A registered exporter, ``package.module:name``, or ``./file.py:name``.
        options: What can be asked of it.

    Raises:
        InvalidParameter: If there is no such exporter, or an option means nothing to it.
        InvalidWorld: If the format cannot hold the world.
    """
    exporter, options = EXPORTERS.get(name), options or ExportOptions()
    if options.noise is not None and "noise" not in exporter.options:
        raise InvalidParameter(f"noise means nothing to {exporter.name}; leave it out")
    return exporter.export(world, options)
