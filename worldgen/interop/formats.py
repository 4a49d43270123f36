"""The foreign formats by name: how to recognise one, how to read it."""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from worldgen.errors import FormatError, InvalidParameter
from worldgen.family import check_between
from worldgen.grid_file import read_world
from worldgen.interop.foreign_map import CELL_SIZES, ForeignMap, digest, read_bounded
from worldgen.interop.movingai import read_movingai
from worldgen.interop.numpy_map import read_numpy_map
from worldgen.interop.ros_map import read_ros_map
from worldgen.interop.text_map import read_text_map
from worldgen.interop.thesis_map import read_thesis_map
from worldgen.world import DEFAULT_CELL_SIZE, Value

__all__ = ["FORMATS", "MapFormat", "ReadOptions", "find_format", "looks_like_a_map", "read_map"]

_HEAD = 4096  # bytes looked at to recognise a file


@dataclass(frozen=True)
class ReadOptions:
    """What a file leaves open.

    Args:
        cell_size: Side of a cell, m, for formats without units.
        unknown: What cells are that a ROS map does not know: ``solid`` or ``free``.
    """

    cell_size: float | None = None
    unknown: str | None = None


class MapFormat(NamedTuple):
    """A format that ``import`` reads.

    Args:
        name: As ``--from`` takes it.
        files: What its files are called, for messages.
        suffixes: Endings of file names, lower case.
        magic: Matches the beginning of its files' contents.
        read: The reader.
        options: Names of the :class:`ReadOptions` that mean something to it.
    """

    name: str
    files: str
    suffixes: tuple[str, ...]
    magic: re.Pattern[bytes]
    read: Callable[[Path, ReadOptions], ForeignMap]
    options: tuple[str, ...] = ()


def _read_movingai(path: Path, options: ReadOptions) -> ForeignMap:
    return read_movingai(path, DEFAULT_CELL_SIZE if options.cell_size is None else options.cell_size)


def _read_ros(path: Path, options: ReadOptions) -> ForeignMap:
    return read_ros_map(path, "solid" if options.unknown is None else options.unknown)


def _read_thesis(path: Path, options: ReadOptions) -> ForeignMap:
    return read_thesis_map(path, DEFAULT_CELL_SIZE if options.cell_size is None else options.cell_size)


def _read_text(path: Path, options: ReadOptions) -> ForeignMap:
    return read_text_map(path, DEFAULT_CELL_SIZE if options.cell_size is None else options.cell_size)


def _read_numpy(path: Path, options: ReadOptions) -> ForeignMap:
    return read_numpy_map(path, DEFAULT_CELL_SIZE if options.cell_size is None else options.cell_size)


def _read_grid(path: Path, options: ReadOptions) -> ForeignMap:
    params: dict[str, Value] = {"format": "grid", "source": path.name, "sha256": digest(read_bounded(path))}
    world = read_world(path)
    if world.provenance is not None:
        made = world.provenance
        params["made_by"] = {
            "family": made.family, "version": made.version, "seed": made.seed, "params": dict(made.params),
        }  # fmt: skip
    return ForeignMap(world.walls, world.cell_size, params, world=world)


FORMATS = {
    known.name: known
    for known in (
        MapFormat(
            "movingai", "MovingAI octile map, .map", (".map",),
            re.compile(rb"type\s"), _read_movingai, ("cell_size",),
        ),
        MapFormat(
            "ros", "ROS map_server, .yaml with .pgm or .png", (".yaml", ".yml"),
            re.compile(rb"(?s).*?(?m:^)image[ \t]*:"), _read_ros, ("unknown",),
        ),
        MapFormat(
            "thesis", "map of the thesis's simulator, .gex", (".gex",),
            re.compile(rb"\xac\xed"), _read_thesis, ("cell_size",),
        ),
        MapFormat(
            "grid", "a world of ours, .grid or .grid.gz", (".grid", ".gz"),
            re.compile(rb"%worldgen-grid"), _read_grid,
        ),
        MapFormat(
            "npy", "NumPy array of cells, .npy", (".npy",),
            re.compile(rb"\x93NUMPY"), _read_numpy, ("cell_size",),
        ),
        MapFormat(
            "text", "drawing with a character a cell, .txt", (".txt",),
            re.compile(rb"[ .SGE]*#[# .SGE]*\r?\n[# .SGE]+(\r?\n|\Z)"), _read_text, ("cell_size",),
        ),
    )
}  # fmt: skip
_COMMON = (".txt", ".yaml", ".yml")  # endings of much that is no map
_PICTURE = re.compile(rb"P[1-6]\s|\x89PNG|BM")


def find_format(path: Path, name: str | None = None) -> MapFormat:
    """The format of a file: as said, or by its contents, or by the ending of its name.

    Raises:
        InvalidParameter: If no format has that name.
        FormatError: If the file is none that is known.
    """
    if name is not None:
        if name not in FORMATS:
            close = difflib.get_close_matches(name, FORMATS, n=1)
            hint = f"did you mean {close[0]!r}? " if close else ""
            raise InvalidParameter(f"no map format is called {name!r}; {hint}known: {', '.join(FORMATS)}")
        return FORMATS[name]
    head = _head(path)
    by_contents = _by_contents(head)
    if by_contents is not None:
        return by_contents
    suffix = path.suffix.lower()
    if suffix in (".pgm", ".png", ".bmp") or _PICTURE.match(head):
        raise FormatError("a picture alone has no scale; give the YAML file that names it", source=str(path))
    if suffix == ".scen" or re.match(rb"version\s+1", head):
        raise FormatError("a scenario file has no map; give the .map file, and this one with --scen", source=str(path))
    for known in FORMATS.values():
        if suffix in known.suffixes:
            return known
    listed = "; ".join(f"{known.name} ({known.files})" for known in FORMATS.values())
    raise FormatError(
        f"is no map that is known: {listed}; if it is one of these, say which with --from", source=str(path)
    )


def looks_like_a_map(path: Path) -> bool:
    """Whether a file among others is worth reading as a map: by its contents, or by an ending that only maps have."""
    suffix = "" if path.suffix.lower() == ".gz" and not path.name.lower().endswith(".grid.gz") else path.suffix.lower()
    if suffix not in _COMMON and any(suffix in known.suffixes for known in FORMATS.values()):
        return True
    try:
        return _by_contents(_head(path)) is not None
    except FormatError:
        return False


def _by_contents(head: bytes) -> MapFormat | None:
    return next((known for known in FORMATS.values() if known.magic.match(head)), None)


def _head(path: Path) -> bytes:
    try:
        if path.is_file():
            with path.open("rb") as stream:
                return stream.read(_HEAD)
    except (OSError, ValueError):
        pass
    return read_bounded(path, _HEAD)  # says what is wrong with the file


def read_map(path: Path, name: str | None = None, options: ReadOptions | None = None) -> ForeignMap:
    """Reads a map of any known format.

    Args:
        path: The file.
        name: Format; recognised where left out.
        options: What the file leaves open.

    Raises:
        FormatError: If the file breaks its format's rules, or is of no known format.
        InvalidParameter: If the format is unknown, or an option means nothing to it.
    """
    options = options or ReadOptions()
    known = find_format(path, name)
    for option in ("cell_size", "unknown"):
        if getattr(options, option) is not None and option not in known.options:
            takers = ", ".join(other.name for other in FORMATS.values() if option in other.options)
            raise InvalidParameter(
                f"{option} means nothing to a {known.name} map, whose file says it; it is for {takers}; leave it out"
            )
    if options.cell_size is not None:
        check_between("cell_size", options.cell_size, *CELL_SIZES, "m")
    return known.read(path, options)
