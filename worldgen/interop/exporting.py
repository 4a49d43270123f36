"""Write a world as files of another program, with a sidecar for what its format cannot store."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from worldgen.errors import InvalidParameter, InvalidWorld, OutputError
from worldgen.files.whole import check_output, write_bytes
from worldgen.files.worlds import SIDECAR
from worldgen.interop.format import (
    FORMATS,
    HELD,
    KINDS,
    ROBOT_FACTS,
    Destination,
    Format,
    robot_kinds,
)
from worldgen.interop.format.foreign_map import origin_of
from worldgen.interop.sidecar import is_sidecar, sidecar_of, sidecar_text
from worldgen.parameters import split_options
from worldgen.robot_overrides import describe_body
from worldgen.timeline import CellState, Timeline
from worldgen.world import DEFAULT_CELL_SIZE, DEFAULT_ROBOT_SPEED, Value, World


@dataclass(frozen=True)
class Export:
    """A world in a foreign format.

    Args:
        format: The format.
        files: Contents by file name; the main file comes first, the sidecar, if any, last.
        lost: Sentences about values that the file itself does not store.
        sidecar: Name of the sidecar that stores them; None if nothing is lost or no sidecar is
            written.
        notes: Other sentences worth reading.
    """

    format: Format
    files: Mapping[str, bytes]
    lost: tuple[str, ...] = ()
    sidecar: str | None = None
    notes: tuple[str, ...] = ()

    @property
    def data(self) -> bytes:
        """Contents of the main file."""
        return next(iter(self.files.values()))


def export_world(
    world: World,
    name: str,
    *,
    file: str | None = None,
    options: Mapping[str, Value | None] | None = None,
    at: float | None = None,
    origin: tuple[float, float] | None = None,
    sidecar: bool = True,
) -> Export:
    """Convert a world to a foreign format.

    Args:
        world: The world.
        name: A registered format, ``package.module:name``, or ``./file.py:name``, optionally with
            ``+option=value``.
        file: Name of the file to write, without folder; ``world`` with the format's usual suffix if
            omitted.
        options: Options of the format; they take precedence over those in ``name``.
        at: For a world that changes, the time, s, whose cells are exported.
        origin: x and y, m, of the grid's lower-left corner in the file's frame; if omitted, the
            origin of the map that the world was imported from, otherwise 0.
        sidecar: True to write a sidecar with the values that the file does not store.

    Raises:
        InvalidParameter: If the format does not exist, is read-only, or lacks one of the options.
        InvalidWorld: If the format cannot hold the world.
    """
    # Check the format and its options.
    plain, worded = split_options(name)
    known = FORMATS.get(plain)
    if known.write is None:
        raise InvalidParameter(
            "only-read",
            "{format} can be read but not written",
            "use another format",
            format=known.name,
        )
    given = known.accept({**worded, **(options or {})}, out=True)
    still = world if at is None else frozen_at(world, at)
    if still.is_dynamic and not known.changes:
        raise InvalidWorld(
            "world-changes",
            "the world changes {changes} times, and {format} files are static",
            "use --at 0 for the cells at that time, or another format",
            at_terminal=True,
            changes=len(world.timeline),
            format=known.name,
        )
    _check_robots(still, known)
    # Write the file.
    destination = Destination(
        file or f"world{known.suffixes[0]}", origin_of(world) if origin is None else origin
    )
    written = known.write(still, destination, **given)
    # Collect the values that the file cannot hold, for the sidecar.
    missing = {
        key: said for key, said in _missing(still, known, destination) if key not in written.altered
    }
    files = dict(written.files)
    companion = f"{destination.name}{SIDECAR}" if sidecar and (missing or written.altered) else None
    if companion is not None:
        robots = still.robots if known.robots else still.robots[:1]
        files[companion] = sidecar_text(still, destination, [*missing, *written.altered], robots)
    # Tell the user what was lost.
    lost = [f"not stored: {', '.join(missing.values())}"] if missing else []
    notes = (
        *written.notes,
        *_notes(world, known, at, destination),
        *_too_large(known, written.data),
    )
    return Export(known, files, (*lost, *dict.fromkeys(written.altered.values())), companion, notes)


def _check_robots(world: World, known: Format) -> None:
    """Refuse several robots if a file holds one; any world can become a map without robots."""
    if not world.is_fleet or known.robots or "start" not in known.holds:
        return
    able = [other.name for other in map(FORMATS.get, FORMATS) if other.write and other.robots]
    raise InvalidWorld(
        "several-robots",
        "{format} files hold one robot, and the world has {count}",
        "export it to one of these formats: {known!l}",
        format=known.name,
        count=len(world.robots),
        known=able,
    )


def _missing(world: World, known: Format, destination: Destination) -> Iterator[tuple[str, str]]:
    """Yield the values that the format cannot store and ``import`` would not choose by itself."""
    cell_size = world.cell_size
    robots = world.robots if known.robots else world.robots[:1]
    usual_radius = known.usual_robot.radius(cell_size)
    as_usual = {
        "robot_radius": all(robot.radius == usual_radius for robot in robots),
        "robot_speed": all(robot.speed == DEFAULT_ROBOT_SPEED for robot in robots),
        "cell_size": cell_size == DEFAULT_CELL_SIZE,
        "origin": destination.origin == (0.0, 0.0),
    }
    values = {
        "start": f" ({world.start.x:g}, {world.start.y:g}) m",
        "heading": f" {world.start.heading:g} rad",
        "target": f" ({world.target.x:g}, {world.target.y:g}) m",
        "target_radius": f" {world.target.radius:g} m",
        "robot_radius": f" {world.robot_radius:g} m",
        "robot_speed": f" {world.robot_speed:g} m/s",
        "cell_size": f" {cell_size:g} m",
        "origin": f" ({destination.origin[0]:g}, {destination.origin[1]:g}) m",
    }
    # A file that cannot store a footprint, but a radius, has a disc that holds the robot.
    around = f"; the file has a disc of {world.robot_radius:.6g} m around it"
    values["footprint"] = f" ({describe_body(world.robots[0])}" + (
        f"{around})" if "robot_radius" in known.holds else ")"
    )
    if len(robots) > 1:
        values |= dict.fromkeys(ROBOT_FACTS, f" (of each of {len(robots)} robots)")
    special = {name for robot in robots for name in robot_kinds(robot)}
    for name, words in HELD.items():
        is_there = name not in KINDS or name in special
        if is_there and name not in known.holds and not as_usual.get(name, False):
            yield name, words + values.get(name, "")


def _too_large(known: Format, data: bytes) -> Iterator[str]:
    if known.read is not None and len(data) > known.most_bytes:
        yield (
            f"import reads {known.name} files of up to {known.most_bytes} bytes, but this one has "
            f"{len(data)}; keep the .grid, or export a smaller world"
        )


def _notes(
    world: World, known: Format, at: float | None, destination: Destination
) -> Iterator[str]:
    if at is not None and world.is_dynamic:
        yield (
            f"the world's {len(world.timeline)} changes are not stored; the file has the cells "
            f"at {at:g} s"
        )
    if world.is_fleet and "start" not in known.holds:
        yield (
            f"the file is a map; starts and targets of the {len(world.robots)} robots are not in it"
        )
    if world.failure is not None:
        yield f"the failure's record ({world.failure.outcome}) is not stored; it stays in the .grid"
    if destination.origin != (0.0, 0.0):
        yield (
            f"the world's (0, 0) is ({destination.x(0.0)}, {destination.y(0.0)}) m where the "
            f"file has coordinates"
        )


def frozen_at(world: World, time: float) -> World:
    """Return the world frozen at a time.

    Cells that burn at that time become solid, because no robot may touch them.

    Args:
        world: The world.
        time: s, 0 or later.

    Raises:
        InvalidParameter: If the time is negative or not a number.
    """
    if not (0.0 <= time < float("inf")):
        raise InvalidParameter(
            "below-minimum", "at={time:g} is not a time", "use a time of 0 s or more", time=time
        )
    walls = world.cells_at(time) != CellState.FREE
    same = np.array_equal(walls, world.walls) and not world.is_dynamic
    return (
        world
        if same
        else replace(world, walls=walls, timeline=Timeline(), certificate=None, failure=None)
    )


def guess_format(file: str) -> str:
    """Return the name of the only format with this file's suffix.

    Raises:
        InvalidParameter: If no format or several formats have it.
    """
    lower = file.lower()
    writable = [known for known in map(FORMATS.get, FORMATS) if known.write is not None]
    found = sorted(known.name for known in writable if lower.endswith(known.suffixes))
    usual = [known.name for known in writable if lower.endswith(known.suffixes[0])]
    if len(found) > 1 and len(usual) == 1:
        found = usual
    if len(found) == 1:
        return found[0]
    if found:
        raise InvalidParameter(
            "ambiguous-format",
            "{file}: files of several formats have this ending: {known!l}",
            "choose one with --to",
            at_terminal=True,
            file=file,
            known=list(found),
        )
    names = ", ".join(known.name for known in writable)
    raise InvalidParameter(
        "unknown-suffix",
        "{file}: no format has this file ending",
        "choose one with --to: {known}",
        at_terminal=True,
        file=file,
        known=names,
    )


def write_export(export: Export, folder: Path, *, force: bool = False) -> list[Path]:
    """Write all files of an export, or none if one of them already exists.

    Args:
        export: The export to write.
        folder: Folder for the files.
        force: True to overwrite existing files; an overwritten file's sidecar is deleted.

    Returns:
        The paths, the main file's first.

    Raises:
        OutputError: If a file exists and ``force`` is not set, or a file cannot be written.
    """
    paths = [folder / name for name in export.files]
    for path in paths:
        check_output(path, force)
    new = {path for path in paths if not path.exists()}
    written: list[Path] = []
    try:
        for path, data in zip(paths[::-1], list(export.files.values())[::-1], strict=True):
            # The main file comes last, because it names the others.
            write_bytes(path, data, force=force)
            written.append(path)
    except OutputError:
        # Delete files that are useless alone; keep what another program has written in the
        # meantime.
        for path in new.intersection(written):
            path.unlink(missing_ok=True)
        raise
    # An overwritten file's old sidecar is about other contents. A user's world may have its name.
    stale = sidecar_of(paths[0])
    if stale not in paths and stale.is_file() and is_sidecar(stale):
        stale.unlink()
    return paths
