"""The result of every format's reader, and how readers get bytes from the disk."""

from __future__ import annotations

import functools
import hashlib
import stat
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from fractions import Fraction
from pathlib import Path
from typing import Concatenate, NamedTuple, ParamSpec, TypeVar

from worldgen.domain import MAX_SIDE
from worldgen.errors import FormatError, WorldgenError
from worldgen.files.whole import read_bytes
from worldgen.lattice import exact
from worldgen.robot import Corner, Drive, Robot, Target
from worldgen.support.arrays import Bools
from worldgen.support.paths import real_path
from worldgen.support.plain_text import quote
from worldgen.world import Value, World

_Options = ParamSpec("_Options")
_Contents = TypeVar("_Contents")

# 8000 x 8000 cells. A small compressed picture can claim far more than a machine can hold.
MAX_CELLS = 64_000_000
# A plain PGM takes up to 4 bytes per cell.
MAX_FILE_BYTES = 256 << 20
# Families of the provenance of an imported map, and of the sidecar of an exported one.
IMPORTED = "import"
EXPORTED = "export"


@dataclass(frozen=True)
class UsualRobot:
    """The robot that a kind of map is drawn for, used if neither the user nor the file gives one.

    Args:
        size: Radius of its disc, in m or in cells.
        in_cells: True if ``size`` counts cells.
        source: The origin of this robot, as shown to the user.
    """

    size: Fraction
    in_cells: bool
    source: str

    def radius(self, cell_size: float) -> float:
        """Return the radius, m, on a map with cells of this side, m."""
        return float(self.size * exact(cell_size) if self.in_cells else self.size)


THESIS_ROBOT = UsualRobot(Fraction(7, 10), True, "0.7 cells, like the thesis's robot")
GRID_AGENT = UsualRobot(
    Fraction(2, 5), True, "0.4 cells, so that it fits through a corridor one cell wide"
)
FLOOR_ROBOT = UsualRobot(Fraction(11, 50), False, "Nav2's default, a TurtleBot's")


class ForeignRobot(NamedTuple):
    """What a file has of a robot.

    A robot after the first has a start and a target, and the first one's numbers if it has none.

    Args:
        start: x and y, m, and, if the file has it, the heading, rad; used if the robot is clear
            there.
        target: x and y, m, and, if the file has it, the radius, m.
        radius: Radius of the robot, m.
        speed: Top speed, m/s.
        footprint: Corners of its body, m, from its axle; empty for a disc.
        drive: How it may move.
        goal: A target whose place and radius do not count, but all the rest.
        waypoints: Goals before the target, from the grid's lower-left corner.
    """

    start: tuple[float, ...] | None = None
    target: tuple[float, ...] | None = None
    radius: float | None = None
    speed: float | None = None
    footprint: tuple[Corner, ...] = ()
    drive: Drive = Drive()
    goal: Target | None = None
    waypoints: tuple[Target, ...] = ()

    def applied_to(self, robot: Robot) -> Robot:
        """Return a disc that turns on the spot with the footprint, the drive and the goals."""
        target = robot.target
        if self.goal is not None:
            target = replace(self.goal, x=target.x, y=target.y, radius=target.radius)
        return replace(
            robot,
            target=target,
            footprint=self.footprint,
            drive=self.drive,
            waypoints=self.waypoints,
        )


@dataclass(frozen=True, eq=False)
class ForeignMap:
    """A map as stored in its file, before a robot is put into it.

    Args:
        walls: (height, width) bool, True is solid; row 0 is the lowest y.
        cell_size: Side of a cell, m.
        params: Provenance beyond the file's format, name and digest, which the importer records.
        notes: Sentences worth knowing.
        warnings: Sentences about likely mistakes.
        world: The world, if the format stores a complete one.
        robots: The file's robots, at least one, in order.
        origin: x and y, m, of the grid's lower-left corner in the file's frame.
        usual_robot: The robot that such maps are drawn for; ``read_map`` fills in its format's.
        unread: Elements of the file that ``walls`` lacks, such as ``"2 shapes of <mesh>"``. Nothing
            is proved on such a map. ``read_map`` adds what the parsers were not asked for.
        is_picture: True if the cells are pixels, so that the map may show its surroundings too.
        numbers: For each robot, counted from 1, its number in the file, if it has a place of its
            own there; empty if the file just lists its robots.
        is_resampled: True if a cell is solid where only a part of it is in the file, so that only
            ``reachable`` holds for the file too.
    """

    walls: Bools
    cell_size: float
    params: Mapping[str, Value] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    world: World | None = None
    robots: tuple[ForeignRobot, ...] = (ForeignRobot(),)
    origin: tuple[float, float] = (0.0, 0.0)
    usual_robot: UsualRobot = THESIS_ROBOT
    unread: tuple[str, ...] = ()
    is_picture: bool = False
    numbers: tuple[int, ...] = ()
    is_resampled: bool = False

    @property
    def robot(self) -> ForeignRobot:
        """The first robot."""
        return self.robots[0]


def origin_of(world: World) -> tuple[float, float]:
    """Return x and y, m, of the grid's lower-left corner in the imported map's frame, or 0."""
    return (0.0, 0.0) if world.provenance is None else world.provenance.origin


@contextmanager
def naming(path: Path) -> Iterator[None]:
    """Name a file in the errors raised inside, because readers know only the line.

    An error that already names a file, such as a picture next to the map, keeps that name.
    """
    try:
        yield
    except FormatError as error:
        error.source = error.source or str(path)
        raise


def names_its_file(
    read: Callable[Concatenate[Path, _Options], _Contents],
) -> Callable[Concatenate[Path, _Options], _Contents]:
    """Name the file of a reader, which is its first argument, as :func:`naming` does."""

    @functools.wraps(read)
    def named(path: Path, /, *args: _Options.args, **options: _Options.kwargs) -> _Contents:
        with naming(path):
            return read(path, *args, **options)

    return named


@names_its_file
def read_bounded(path: Path, limit: int = MAX_FILE_BYTES) -> bytes:
    """Return a file's bytes.

    Raises:
        FormatError: If it is missing, unreadable, not a regular file, or larger than ``limit``
            bytes.
    """
    try:
        is_regular = stat.S_ISREG(path.stat().st_mode)
    # ValueError means that the name contains a NUL.
    except (OSError, ValueError) as error:
        raise FormatError.unreadable(path, error) from error
    if not is_regular:
        raise FormatError("not-a-regular-file", "is not a regular file", "use the map file itself")
    return read_bytes(path, limit, "cut a smaller map out of it")


def sibling_file(path: Path, key: str, name: str, *, line: int | None = None) -> Path:
    """Return the path of a file that a map file names: only one next to it or below it.

    Args:
        path: The map file.
        key: The key that names the other file, for messages.
        name: The other file's name as written there.
        line: Its line.

    Raises:
        FormatError: If it leads out of the map's folder, or does not exist.
    """
    if "\0" in name:
        raise FormatError(
            "not-a-file-name", "{key} has a NUL in its name", "correct it", key=key, line=line
        )
    folder = real_path(path.parent)
    other = real_path(folder / name)
    if not other.is_relative_to(folder):
        raise FormatError(
            "outside-folder",
            "{key} {name} is outside the map's folder",
            "copy it there and name it without a path",
            key=key,
            name=quote(name, 80),
            line=line,
        )
    try:
        there = other.is_file()
    # The name is too long for the file system.
    except OSError:
        there = False
    if not there:
        raise FormatError(
            "no-such-file",
            "{key} {name} does not exist",
            "put it next to {map}",
            key=key,
            name=quote(name, 80),
            map=path.name,
            line=line,
        )
    return path.parent / other.relative_to(folder)


def unix_text(data: bytes) -> bytes:
    """Decode text; drop a byte order mark and DOS's end-of-file byte, turn a lone CR into LF."""
    data = data.removeprefix(b"\xef\xbb\xbf").removesuffix(b"\x1a")
    return data if b"\n" in data else data.replace(b"\r", b"\n")


def check_sides(
    width: int, height: int, *, line: int | None = None, remedy: str = "cut or shrink it"
) -> None:
    """Reject sizes that no world may have.

    Raises:
        FormatError: If a side is 0 or above ``MAX_SIDE``, or there are more than ``MAX_CELLS``
            cells.
    """
    if not (0 < width <= MAX_SIDE and 0 < height <= MAX_SIDE and width * height <= MAX_CELLS):
        raise FormatError(
            "wrong-size",
            "{width} x {height} cells; a map has sides of 1 to {max_side} and at most {max_cells} "
            "cells",
            remedy,
            width=width,
            height=height,
            max_side=MAX_SIDE,
            max_cells=MAX_CELLS,
            line=line,
        )


def without_file(error: WorldgenError) -> str:
    """Return an error in words without the name of its file."""
    if isinstance(error, FormatError) and error.line is not None:
        return f"line {error.line}: {error.message}"
    return str(error.message)


def digest(data: bytes) -> str:
    """Return the SHA-256 in hex, for provenance."""
    return hashlib.sha256(data).hexdigest()
