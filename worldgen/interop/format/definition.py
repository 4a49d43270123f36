"""The definition of a foreign format: its name, how to recognise it, how to read and write it."""

from __future__ import annotations

import functools
import re
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path, PurePath
from typing import Any

from worldgen.errors import InvalidParameter
from worldgen.files.grid.toml_text import value_text
from worldgen.interop.format.foreign_map import MAX_FILE_BYTES, THESIS_ROBOT, ForeignMap, UsualRobot
from worldgen.lattice import exact
from worldgen.parameters import (
    Parameter,
    check_declared,
    find_parameter,
    parameters_of,
    parameters_of_fields,
)
from worldgen.parameters.bounds import check_between
from worldgen.plugins.registry import Registry
from worldgen.world import Drive, Robot, Value, World

# Limit on coordinates, m; beyond it a float cannot distinguish cells of a millimetre.
_FURTHEST = 1e12

_PI = Fraction(
    "3.14159265358979323846264338327950288419716939937510582097494459230781640628620899862803482534211706798"
)
# Number of decimals; the smallest float, 5e-324 rad, needs fewer.
_MOST_PLACES = 400

HELD = {
    "start": "the start",
    "heading": "the robot's heading at the start",
    "target": "the target",
    "target_radius": "the target's radius",
    "robot_radius": "the robot's radius",
    "robot_speed": "the robot's speed",
    "footprint": "the robot's footprint",
    "drive": "how the car drives",
    "goal": "what counts as arriving",
    "waypoints": "the waypoints",
    "cell_size": "the cell size",
    "origin": "the origin",
}
"""Facts about a world other than its cells, which a file may be unable to store, as worded in
messages.
"""
KINDS = ("footprint", "drive", "goal", "waypoints")
"""The facts that a disc which turns on the spot and has to touch its target lacks: they are no
numbers.
"""
PLAIN_FACTS = frozenset(HELD) - frozenset(KINDS)
"""The facts that every robot has, which a file has to store for a disc."""
PAIRS = ("size", "start", "target", "origin")
"""The facts that are two numbers; any other is one."""
LENGTHS = ("size", "target_radius", "robot_radius", "robot_speed", "cell_size")
"""The facts that are above 0."""
ROBOT_FACTS = tuple(name for name in HELD if name not in ("cell_size", "origin"))
"""The facts of :data:`HELD` that each robot of a world has."""


@dataclass(frozen=True)
class Destination:
    """The destination of an export.

    Args:
        name: Name of the file, without folder.
        origin: x and y, m, of the grid's lower-left corner in the file's frame: the imported map's,
            usually 0.

    Raises:
        InvalidParameter: If the origin is more than 1e12 m away.
    """

    name: str
    origin: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        for name, value in zip(("origin's x", "origin's y"), self.origin, strict=True):
            check_between(name, value, -_FURTHEST, _FURTHEST, "m")

    def sibling_file(self, ending: str) -> str:
        """Return the name of a file next to this one, such as ``office.pgm`` for ``office.yaml``.

        Raises:
            InvalidParameter: If that is the file's own name.
        """
        name = f"{PurePath(self.name).stem}{ending}"
        if name == self.name:
            raise InvalidParameter(
                "reserved-name",
                "{name}: a second file next to it needs that name",
                "give it another ending",
                name=self.name,
            )
        return name

    def x(self, value: float) -> str:
        """Convert an x of the world, m, to the file's frame, as an exact decimal."""
        return decimal(value, self.origin[0])

    def y(self, value: float) -> str:
        """Convert a y of the world, m, to the file's frame, as an exact decimal."""
        return decimal(value, self.origin[1])


def decimal(value: float, shift: float = 0.0) -> str:
    """Return the sum of the shortest decimals of two numbers, exactly and without exponent."""
    return decimal_text(exact(value) + exact(shift))


def decimal_text(value: Fraction) -> str:
    """Return a fraction that is a decimal number, exactly and without exponent."""
    # Sums and halves of decimals are decimals, so this division ends.
    places = next(n for n in range(2000) if (value * 10**n).denominator == 1)
    sign = "-" if value < 0 else ""
    digits = str(abs(int(value * 10**places))).rjust(places + 1, "0")
    return sign + (f"{digits[:-places]}.{digits[-places:]}" if places else digits)


def radians(degrees: Fraction) -> float:
    """Convert degrees to an angle in rad, correctly rounded."""
    return float(degrees * _PI / 180)


def degrees_text(angle: float) -> str:
    """Return the shortest decimal of degrees that :func:`radians` converts to the same angle.

    Args:
        angle: Angle, rad.
    """
    whole = Fraction(angle) * 180 / _PI
    tried = (Fraction(round(whole * 10**places), 10**places) for places in range(_MOST_PLACES))
    return next(decimal_text(value) for value in tried if radians(value) == angle)


@dataclass(frozen=True)
class Exported:
    """The output of a format's writer.

    Args:
        files: Contents by file name; the main file comes first, the others are written next to it.
        altered: The facts of :data:`HELD` that this file stores differently, each with a sentence
            about the difference; the true value goes into the sidecar.
        notes: Sentences about what else is lost, or how the other program treats the file.
    """

    files: Mapping[str, bytes]
    altered: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    @property
    def data(self) -> bytes:
        """Contents of the main file."""
        return next(iter(self.files.values()))


@dataclass(frozen=True)
class Format:
    """A foreign format; register it in the entry point group ``worldgen.formats``.

    ``read`` and ``write`` declare their options as families do: keyword-only parameters with plain
    defaults, which become ``--from NAME+option=value`` and ``--to NAME+option=value``.

    Args:
        name: Name that ``--from`` and ``--to`` take.
        summary: What its files are, in a few words.
        suffixes: Lower-case endings of file names, the usual one first.
        magic: Pattern that matches the first 4096 bytes of its files and of few others.
        read: ``read(path, *, ...) -> ForeignMap``; None for a format that is only written.
        write: ``write(world, destination, *, ...) -> Exported``; None for a format that is only
            read.
        holds: The facts of :data:`HELD` that its files can store.
        changes: True if its files can store worlds that change with time.
        robots: True if its files can store several robots.
        client: The programs that read it, in a few words.
        usual_robot: The robot that its maps are drawn for, used if neither the file nor the user
            gives one.
        most_bytes: Largest file that ``read`` accepts; ``export`` warns when it writes a larger
            one.
        harmless: Names of elements of its files that no reader needs, because they cannot be
            obstacles, such as ``"color"`` or ``"link/visual"``. What ``read`` does not take, and is
            not named here, is unread, and a map with anything unread is not certified. This holds
            for readers that use the parsers of ``worldgen.interop.readers`` for XML, YAML and JSON;
            others report what they skip as ``ForeignMap.unread``.
        options: A dataclass with ``read``'s options, for those that several formats share; ``read``
            is then ``read(path, options) -> ForeignMap``.
    """

    name: str
    summary: str
    suffixes: tuple[str, ...]
    magic: re.Pattern[bytes] | None = None
    read: Callable[..., ForeignMap] | None = None
    write: Callable[..., Exported] | None = None
    holds: frozenset[str] = frozenset()
    changes: bool = False
    robots: bool = False
    client: str = ""
    usual_robot: UsualRobot = THESIS_ROBOT
    most_bytes: int = MAX_FILE_BYTES
    harmless: frozenset[str] = frozenset()
    options: type | None = None

    def __post_init__(self) -> None:
        unknown = sorted(self.holds - HELD.keys())
        if unknown or not self.suffixes:
            raise InvalidParameter(
                "wrong-declaration",
                "format {name!r}: holds {unknown!l:nothing wrong}, suffixes {suffixes}; it needs "
                "a suffix, and may hold only {held!l}",
                name=self.name,
                unknown=list(unknown),
                suffixes=self.suffixes,
                held=list(HELD),
            )
        own = self.read if self.options is None else None
        for function, positional in ((own, 1), (self.write, 2)):
            if function is not None:
                check_declared(function, f"format {self.name!r}", positional=positional)

    @property
    def direction(self) -> str:
        """``both``, ``in`` or ``out``."""
        return "both" if self.read and self.write else "in" if self.read else "out"

    @functools.cached_property
    def read_options(self) -> tuple[Parameter, ...]:
        """Options of ``read``."""
        if self.options is not None:
            return parameters_of_fields(self.options)
        return parameters_of(self.read, f"format {self.name!r}") if self.read else ()

    @functools.cached_property
    def write_options(self) -> tuple[Parameter, ...]:
        """Options of ``write``."""
        return parameters_of(self.write, f"format {self.name!r}") if self.write else ()

    def open(self, path: Path, given: Mapping[str, Value]) -> ForeignMap:
        """Read a file, with options that :meth:`accept` has checked.

        Raises:
            InvalidParameter: If the format is only written.
        """
        if self.read is None:
            raise InvalidParameter("only-written", "{format} cannot be read", format=self.name)
        if self.options is not None:
            return self.read(path, self.options(**given))
        return self.read(path, **given)

    def accept(self, given: Mapping[str, Value | None], *, out: bool) -> dict[str, Value]:
        """Check the types of options, and parse those that come from the command line.

        Args:
            given: Values by name; an option from the command line is the text after ``=``, or None.
            out: True if the options are for ``write``.

        Raises:
            InvalidParameter: If the format lacks an option, or a value has the wrong type.
        """
        known = self.write_options if out else self.read_options
        owner = f"format {self.name} on {'export' if out else 'import'}"
        accepted = {}
        for name, value in given.items():
            option = find_parameter(name, known, owner)
            is_text = value is None or (
                isinstance(value, str) and not isinstance(option.default, str)
            )
            if is_text:
                accepted[name] = option.parse(value, self.name)  # type: ignore[arg-type]
            else:
                accepted[name] = option.accept(value, self.name)
        return accepted


def _accept(name: str, thing: Any) -> Format:
    if not isinstance(thing, Format):
        raise InvalidParameter(
            "wrong-type",
            "format {name!r} is {value!r}, not a Format",
            "make one of worldgen.interop",
            name=name,
            value=thing,
        )
    return thing


def held_values(world: World, destination: Destination) -> dict[str, Value]:
    """Return the size, in cells, and the facts of :data:`HELD` about a world, in m, rad and m/s.

    A point is two numbers, from the grid's lower-left corner.
    """
    return {
        "size": [world.width, world.height],
        **robot_values(world.robots[0]),
        "cell_size": world.cell_size,
        "origin": list(destination.origin),
    }


def robot_values(robot: Robot) -> dict[str, Value]:
    """Return the facts of :data:`ROBOT_FACTS` about a robot, as :func:`held_values` does."""
    return {
        "start": [robot.start.x, robot.start.y],
        "heading": robot.start.heading,
        "target": [robot.target.x, robot.target.y],
        "target_radius": robot.target.radius,
        "robot_radius": robot.radius,
        "robot_speed": robot.speed,
    }


def robot_kinds(robot: Robot) -> dict[str, Any]:
    """Return the facts of :data:`KINDS` that a robot has: corners, a drive, a target, and others."""
    found: dict[str, Any] = {}
    if not robot.is_disc:
        found["footprint"] = robot.footprint
    if robot.drive != Drive():
        found["drive"] = robot.drive
    if not robot.target.is_plain:
        found["goal"] = robot.target
    if robot.waypoints:
        found["waypoints"] = robot.waypoints
    return found


def fact_numbers(name: str, value: object) -> tuple[float, ...] | None:
    """Return the numbers of a fact of :data:`HELD`, or of the size, as a file has them.

    It is None if their count is wrong, or one is not a finite number.
    """
    items = value if isinstance(value, list) else [value]
    numbers = tuple(
        float(item)
        for item in items
        if isinstance(item, int | float)
        and not isinstance(item, bool)
        and abs(item) <= sys.float_info.max
    )
    count = 2 if name in PAIRS else 1
    return numbers if len(items) == len(numbers) == count else None


def held_lines(world: World, destination: Destination) -> list[str]:
    """Return the comment at the top of a text file that describes a world beyond its walls.

    It is a sentence followed by ``name = value`` lines in TOML.
    """
    return [
        "Below: m, rad, m/s; start and target from the grid's lower-left corner, which is at "
        "origin.",
        *(
            f"{name} = {value_text(value, name)}"
            for name, value in held_values(world, destination).items()
        ),
    ]


FORMATS: Registry[Format] = Registry("worldgen.formats", "format", _accept)
