"""The header's tables, read as :mod:`worldgen.files.grid.schema` declares them.

Robots, provenance, certificate and failure are each checked, with lines in errors.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

from worldgen.errors import FormatError, InvalidWorld, Message
from worldgen.files.grid.header import Header
from worldgen.files.grid.schema import (
    CERTIFICATE_KINDS,
    DRIVES,
    HEADER_KEYS,
    MAGIC,
    REQUIRED,
    ROBOT_KEYS,
    TABLE_KEYS,
    TABLES_HEADER_KEYS,
    TABLES_MAGIC,
    TABLES_TABLE_KEYS,
    WAYPOINT_KEYS,
    WORD,
    WORD_KEYS,
    Key,
)
from worldgen.files.grid.values import READERS, Place, kind_of, read_number, read_numbers
from worldgen.parameters.known_names import unknown_name
from worldgen.plugins.trust import note_names
from worldgen.robot import Drive, Pose, Robot, Target, convex_footprint
from worldgen.support.plain_text import quote
from worldgen.world import FailureRecord, Provenance


class Table(NamedTuple):
    """The top of the header, one ``[name]`` table, or one ``[[name]]`` table.

    Args:
        header: The header.
        values: The table's contents.
        keys: Its declared keys.
        name: Its name; empty for the top.
        row: Its number among the ``[[name]]`` tables, from 0.
        inner: Its place in that table if it is one of a list there, such as ``waypoint 1``.
    """

    header: Header
    values: Mapping[str, object]
    keys: Mapping[str, Key]
    name: str = ""
    row: int | None = None
    inner: str = ""

    def at(self, *path: str) -> dict[str, Any]:
        """Return the place of a key, or of the table, as :class:`FormatError` takes it."""
        if self.inner:
            path = (f"{self.inner.split(' ')[0]}s",)
        if self.row is not None:
            return self.header.at(*path, table=self.name, index=self.row)
        if self.name:
            path = (self.name, *path)
        return self.header.at(*path) if path else self.header.at_the_end()

    def place(self, key: str) -> Place:
        """Return the place of a key's value."""
        what = key
        if self.row is not None:
            what = " ".join(filter(None, (f"{self.name} {self.row + 1}", self.inner, key)))
        elif self.name:
            what = f"{self.name}.{key}"
        declared = self.keys[key]
        return Place(what, declared.meaning, partial(self.at, key))

    def read(self, key: str) -> Any:
        """Return the value of a key, or its default.

        Raises:
            FormatError: If it is missing and has no default, or is not what the key declares.
        """
        declared = self.keys[key]
        if key in self.values:
            return READERS[declared.kind](self.values[key], self.place(key))
        if declared.default is not REQUIRED:
            return declared.default
        raise self.missing(key)

    def missing(self, key: str) -> FormatError:
        """Return the error for a key that must be there."""
        declared = self.keys[key]
        where = f"[[{self.name}]] number {self.row + 1}" if self.row is not None else ""
        where += f", {self.inner}," if self.inner else ""
        return FormatError(
            "missing-key",
            "{place} has no {key}",
            "add `{key} = {example}`: {meaning}",
            place=where or (f"[{self.name}]" if self.name else "the header"),
            key=key,
            example=declared.example,
            meaning=declared.meaning,
            **self.at(),
        )

    def read_all(self) -> dict[str, Any]:
        """Return the values of all keys."""
        return {key: self.read(key) for key in self.keys}

    def check_keys(self, what: str) -> None:
        """Reject every undeclared key.

        Raises:
            FormatError: At the key, with the nearest declared one.
        """
        for key in self.values:
            if key not in self.keys:
                message = unknown_name("unknown {what}: {name!q}", key, list(self.keys), what=what)
                raise FormatError.of(message, **self.at(key))


class CertificateRecord(NamedTuple):
    """The contents of the ``[certificate]`` table.

    Args:
        kind: ``witness`` or ``cut``.
        clearances: Clearances, m; one number, or one for each robot's path of a joint witness.
        robot: Number of the robot that a cut of version 2 stops; 1 in version 1.
        waypoint: Number of the waypoint that it separates from the start; 0 for the target.
    """

    kind: str
    clearances: tuple[float, ...]
    robot: int = 1
    waypoint: int = 0


def read_top(header: Header, *, tables: bool) -> Table:
    """Return the top of the header, after a check of the names of all keys and tables.

    Args:
        header: The header.
        tables: True if it is in version 2, with [[robot]] tables.

    Raises:
        FormatError: At a key that the version does not know, with the nearest known one.
    """
    keys = TABLES_HEADER_KEYS if tables else HEADER_KEYS
    known_tables = TABLES_TABLE_KEYS if tables else TABLE_KEYS
    for key, value in header.data.items():
        if tables and key == "robot":
            continue
        if key not in keys and key not in known_tables:
            raise FormatError.of(_strange_key(key, tables=tables), **header.at(key))
        if key in known_tables and not isinstance(value, dict):
            raise FormatError(
                "wrong-type",
                "{key} is {kind}; it must be a table: write [{key}] on a separate line",
                key=key,
                kind=kind_of(value),
                **header.at(key),
            )
    for name, known in known_tables.items():
        for key in header.data.get(name, ()):
            if key in keys and key not in known:
                raise FormatError(
                    "wrong-place",
                    "{key} is in [{table}]; it belongs above the first [table]",
                    key=key,
                    table=name,
                    **header.at(name, key),
                )
        Table(header, header.data.get(name, {}), known, name).check_keys(f"key in [{name}]")
    return Table(header, header.data, keys)


def _strange_key(key: str, *, tables: bool) -> Message:
    if tables and key in HEADER_KEYS:
        return Message(
            "wrong-place",
            "{key} is above the [[robot]] tables; in version 2 each robot has its own",
            "write `{own} = ...` in each [[robot]] table",
            key=key,
            own=key.removeprefix("robot_"),
        )
    if not tables and key == "robot":
        return Message(
            "other-version",
            "[[robot]] tables belong to version 2, and this file has version 1",
            "begin it with `{magic}`",
            magic=TABLES_MAGIC,
        )
    known = (
        (*TABLES_HEADER_KEYS, "robot", *TABLES_TABLE_KEYS)
        if tables
        else (*HEADER_KEYS, *TABLE_KEYS)
    )
    return unknown_name("unknown {what}: {name!q}", key, known, what="key")


def read_robots(header: Header) -> list[Robot]:
    """Return the robots of version 2, in order.

    Raises:
        FormatError: If there is none, a table breaks a rule, or the only robot belongs to version 1.
    """
    tables = tables_of(header, "robot", ROBOT_KEYS)
    if not tables:
        raise FormatError(
            "missing-key",
            "the header has no [[{key}]] table",
            "add one for each robot",
            key="robot",
            **header.at_the_end(),
        )
    robots = [replace(_robot(table), waypoints=_waypoints(table)) for table in tables]
    # One world has one text.
    if len(robots) == 1 and robots[0].is_plain:
        raise FormatError(
            "one-robot",
            "version 2 with one disc that turns on the spot and has to touch its target; such a "
            "file has version 1",
            "write version 1: begin it with `{magic}`, with start, target, robot_radius and "
            "robot_speed above the first [table]",
            magic=MAGIC,
            **header.at("robot"),
        )
    return robots


def _robot(table: Table) -> Robot:
    own = table.read_all()
    given = [name for name in ("radius", "footprint") if name in table.values]
    if len(given) == 2:
        raise FormatError(
            "conflict",
            "[[robot]] number {number} has a radius and a footprint",
            "remove one of the two: a body is a disc or a polygon",
            number=(table.row or 0) + 1,
            **table.at("radius"),
        )
    if not given:
        raise table.missing("radius")
    _check_drive(table, own["drive"])
    goal = _goal(own)
    drive = Drive(own["turning_radius"], own["reverse"], own["steering_rate"])
    try:
        if "footprint" in given:
            # An empty list is no footprint, which the file must not have.
            footprint = convex_footprint(own["footprint"])
            return Robot(
                Pose(*own["start"]), goal, speed=own["speed"], footprint=footprint, drive=drive
            )
        return Robot(Pose(*own["start"]), goal, own["radius"], own["speed"], drive=drive)
    except InvalidWorld as error:
        raise FormatError.of(error.message, **table.at("footprint")) from error


def _goal(own: Mapping[str, Any]) -> Target:
    """Return the goal of a table's values; a waypoint has no contact."""
    x, y, radius = own["target"]
    return Target(
        x, y, radius, own["target_heading"], own["heading_tolerance"], own["arrival"],
        own["arrival_speed"], own["arrival_turn_rate"], own.get("contact"),
    )  # fmt: skip


def _waypoints(table: Table) -> tuple[Target, ...]:
    """Return the waypoints of a robot's table, in order."""
    rows = [
        table._replace(values=values, keys=WAYPOINT_KEYS, inner=f"waypoint {number}")
        for number, values in enumerate(table.read("waypoints"), start=1)
    ]
    for row in rows:
        if "contact" in row.values:
            raise FormatError(
                "wrong-place",
                "{key} is in {table}; it is about the whole run",
                "write it in [[robot]] itself",
                key="contact",
                table=row.inner,
                **row.at(),
            )
        row.check_keys(f"key in {row.inner}")
    return tuple(_goal(row.read_all()) for row in rows)


def _check_drive(table: Table, drive: str | None) -> None:
    """Reject a drive that is not a car's, or keys of a car without it."""
    if drive is not None and drive not in DRIVES:
        raise FormatError.of(
            unknown_name("unknown {what}: {name!q}", drive, list(DRIVES), what="drive"),
            **table.at("drive"),
        )
    if drive is not None and "turning_radius" not in table.values:
        raise table.missing("turning_radius")
    if drive is None:
        for key in ("turning_radius", "reverse", "steering_rate"):
            if key in table.values:
                raise FormatError(
                    "conflict",
                    "{key} without a drive",
                    'add `drive = "car"`, or remove it: other robots turn on the spot',
                    key=key,
                    **table.at(key),
                )


def tables_of(header: Header, name: str, keys: Mapping[str, Key]) -> list[Table]:
    """Return the ``[[name]]`` tables of the header, in order.

    Raises:
        FormatError: If it is something else, or one has a key that is not declared.
    """
    listed = header.data.get(name, [])
    if not isinstance(listed, list) or not all(isinstance(each, dict) for each in listed):
        raise FormatError(
            "wrong-type",
            "{key} is {kind}; it must be tables: begin each with [[{key}]]",
            key=name,
            kind=kind_of(listed),
            **header.at(name),
        )
    tables = [Table(header, each, keys, name, k) for k, each in enumerate(listed)]
    for table in tables:
        table.check_keys(f"key in [[{name}]]")
    return tables


def read_provenance(header: Header) -> Provenance | None:
    """Return the ``[provenance]`` table."""
    values = _named(header, "provenance")
    return None if values is None else Provenance(**values)


def read_failure(header: Header) -> FailureRecord | None:
    """Return the ``[failure]`` table."""
    values = _named(header, "failure")
    if values is None:
        return None
    record = FailureRecord(**values)
    for key, fault in word_faults(record):
        raise FormatError.of(fault, **header.at("failure", key))
    return record


def _named(header: Header, name: str) -> dict[str, Any] | None:
    """Return the values of a table that may name code, which anybody may have written."""
    if name not in header.data:
        return None
    note_names(header.data[name], header.source)
    return Table(header, header.data[name], TABLE_KEYS[name], name).read_all()


def read_certificate(
    header: Header, robots_of_world: Sequence[Robot], *, tables: bool
) -> CertificateRecord | None:
    """Return the ``[certificate]`` table of a world with these robots.

    Args:
        header: The header.
        robots_of_world: All robots.
        tables: True if it is in version 2.
    """
    # Check the kind.
    robots = len(robots_of_world)
    keys = (TABLES_TABLE_KEYS if tables else TABLE_KEYS)["certificate"]
    if "certificate" not in header.data:
        return None
    table = Table(header, header.data["certificate"], keys, "certificate")
    values = table.read_all()
    kind = values["kind"]
    if kind not in CERTIFICATE_KINDS:
        raise FormatError(
            "unknown-name",
            "certificate kind is {came}",
            'write "witness" or "cut"',
            came=quote(kind) if isinstance(kind, str) else kind_of(kind),
            **table.at("kind"),
        )
    # A joint witness has a clearance for each robot, any other certificate has one.
    place = table.place("clearance")
    robot = values.get("robot")
    if robots > 1 and kind == "witness":
        if robot is not None:
            raise FormatError(
                "conflict",
                'kind = "witness", but [certificate] names a robot; a witness covers all of them',
                "remove `robot`",
                **table.at("robot"),
            )
        place = place._replace(meaning="m, one for each robot")
        return CertificateRecord(kind, read_numbers(values["clearance"], place, robots))
    if robots == 1:
        robot = 1
    # A cut names the robot that it stops.
    elif robot is None:
        raise table.missing("robot")
    if not 1 <= robot <= robots:
        raise FormatError(
            "out-of-range",
            "certificate.{name} is {robot}",
            "the robots are numbered from 1 to {last}",
            name="robot",
            robot=robot,
            last=robots,
            **table.at("robot"),
        )
    waypoint = _separated(table, robots_of_world[robot - 1], values.get("waypoint"))
    return CertificateRecord(kind, (read_number(values["clearance"], place),), robot, waypoint)


def _separated(table: Table, robot: Robot, waypoint: int | None) -> int:
    """Return the number of the waypoint that a cut separates from the start; 0 for the target."""
    if waypoint is None:
        return 0
    last = len(robot.waypoints)
    if table.values["kind"] == "witness":
        raise FormatError(
            "conflict",
            'kind = "witness", but [certificate] names a waypoint; a witness leads through all',
            "remove `waypoint`",
            **table.at("waypoint"),
        )
    if not 1 <= waypoint <= last:
        raise FormatError(
            "out-of-range",
            "certificate.{name} is {waypoint}",
            "the waypoints are numbered from 1 to {last}" if last else "the robot has none",
            name="waypoint",
            waypoint=waypoint,
            last=last,
            **table.at("waypoint"),
        )
    return waypoint


def word_faults(record: FailureRecord) -> Iterator[tuple[str, Message]]:
    """Yield each key of a failure whose value must be a word and is not, and the fault."""
    for key, example in WORD_KEYS.items():
        value = getattr(record, key)
        if not WORD.match(value):
            yield (
                key,
                Message(
                    "not-a-word",
                    "failure.{key} is {value!q}",
                    "write a word of at most 64 lower-case letters, digits and dashes, like "
                    "{example}",
                    key=key,
                    value=value,
                    example=example,
                ),
            )
