"""The header's keys and tables.

Robots, provenance, certificate and failure are each checked, with lines in errors.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any, NamedTuple

from worldgen.errors import FormatError, Message
from worldgen.files.grid.header import Header
from worldgen.files.grid.schema import (
    CERTIFICATE_KINDS,
    FLEET_HEADER_KEYS,
    FLEET_MAGIC,
    FLEET_TABLE_KEYS,
    HEADER_KEYS,
    MAGIC,
    OPTIONAL_KEYS,
    ROBOT_KEYS,
    TABLE_KEYS,
    WORD,
    WORD_KEYS,
)
from worldgen.files.grid.values import finite, integer_at, kind_of, numbers_at, text_at, values_at
from worldgen.parameters.known_names import unknown_name
from worldgen.plugins.trust import NameInFile, note_names
from worldgen.support.plain_text import quote
from worldgen.world import DEFAULT_ROBOT_SPEED, FailureRecord, Pose, Provenance, Robot, Target


class CertificateRecord(NamedTuple):
    """The contents of the ``[certificate]`` table.

    Args:
        kind: ``witness`` or ``cut``.
        clearances: Clearances, m; one number, or one for each robot's path of a joint witness.
        robot: Number of the robot that a cut of version 2 stops; 1 in version 1.
    """

    kind: str
    clearances: tuple[float, ...]
    robot: int = 1


class _Place(NamedTuple):
    """Where keys are looked up: the top of the header, or one ``[[robot]]`` table, from 0."""

    header: Header
    values: Mapping[str, object]
    meanings: Mapping[str, str]
    robot: int | None = None

    @property
    def name(self) -> str:
        return "the header" if self.robot is None else f"[[robot]] number {self.robot + 1}"

    def named(self, key: str) -> str:
        return key if self.robot is None else f"robot {self.robot + 1} {key}"

    def at(self, key: str) -> dict[str, Any]:
        return self.header.at(key, table="robot", index=self.robot)

    def at_the_end(self) -> dict[str, Any]:
        return self.header.at_the_end() if self.robot is None else self.at("")


def check_keys(header: Header, *, fleet: bool = False) -> None:
    """Reject every key and table that the version does not know.

    Args:
        header: The header.
        fleet: True if it is in version 2.

    Raises:
        FormatError: At the unknown key, with the nearest known one.
    """
    # Check the keys at the top.
    keys = FLEET_HEADER_KEYS if fleet else HEADER_KEYS
    tables = FLEET_TABLE_KEYS if fleet else TABLE_KEYS
    for key, value in header.data.items():
        if fleet and key == "robot":
            continue
        if key not in keys and key not in tables:
            raise FormatError.of(_strange_key(key, fleet=fleet), **header.at(key))
        if key in tables and not isinstance(value, dict):
            raise FormatError(
                "wrong-type",
                "{key} is {kind}; it must be a table: write [{key}] on a separate line",
                key=key,
                kind=kind_of(value),
                **header.at(key),
            )
    # Check the keys in the tables.
    for table, known in tables.items():
        for key in header.data.get(table, ()):
            if key not in known:
                message = unknown_name(
                    "unknown {what}: {name!q}", key, known, what=f"key in [{table}]"
                )
                if key in keys:
                    message = Message(
                        "wrong-place",
                        "{key} is in [{table}]; it belongs above the first [table]",
                        key=key,
                        table=table,
                    )
                raise FormatError.of(message, **header.at(table, key))


def _strange_key(key: str, *, fleet: bool) -> Message:
    if fleet and key in HEADER_KEYS:
        return Message(
            "wrong-place",
            "{key} is above the [[robot]] tables; in version 2 each robot has its own",
            "write `{own} = ...` in each [[robot]] table",
            key=key,
            own=key.removeprefix("robot_"),
        )
    if not fleet and key == "robot":
        return Message(
            "other-version",
            "[[robot]] tables belong to version 2, and this file has version 1",
            "begin it with `{magic}`",
            magic=FLEET_MAGIC,
        )
    known = (
        (*FLEET_HEADER_KEYS, "robot", *FLEET_TABLE_KEYS) if fleet else (*HEADER_KEYS, *TABLE_KEYS)
    )
    return unknown_name("unknown {what}: {name!q}", key, known, what="key")


def read_robots(header: Header) -> list[Robot]:
    """Return the robots of version 2, in order.

    Raises:
        FormatError: If there are not at least two, or a table breaks a rule.
    """
    # There must be at least two [[robot]] tables.
    tables = header.data.get("robot")
    if tables is None:
        raise FormatError(
            "missing-key",
            "the header has no [[{key}]] table",
            "add one for each robot",
            key="robot",
            **header.at_the_end(),
        )
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        raise FormatError(
            "wrong-type",
            "robot is {kind}; the robots are tables: begin each with [[robot]]",
            kind=kind_of(tables),
            **header.at("robot"),
        )
    if len(tables) < 2:
        raise FormatError(
            "one-robot",
            "version 2 with {count} robots; a file with one robot has version 1",
            "write version 1: begin it with `{magic}`, with start, target, robot_radius and "
            "robot_speed above the first [table]",
            count=len(tables),
            magic=MAGIC,
            **header.at("robot"),
        )
    return [_read_robot(header, tables[k], k) for k in range(len(tables))]


def _read_robot(header: Header, table: Mapping[str, object], index: int) -> Robot:
    place = _Place(header, table, ROBOT_KEYS, index)
    for key in table:
        if key not in ROBOT_KEYS:
            raise FormatError.of(
                unknown_name("unknown {what}: {name!q}", key, ROBOT_KEYS, what="key in [[robot]]"),
                **place.at(key),
            )
    start = _triple(place, "start")
    target = _triple(place, "target")
    radius = _number(place, "radius")
    speed = _number(place, "speed", default=DEFAULT_ROBOT_SPEED)
    return Robot(Pose(*start), Target(*target), radius, speed)


def read_number(header: Header, key: str, *, default: float | None = None) -> float:
    """Return a length or speed, which must be above 0."""
    return _number(_Place(header, header.data, HEADER_KEYS), key, default=default)


def _number(place: _Place, key: str, *, default: float | None = None) -> float:
    if key not in place.values:
        if default is not None:
            return default
        raise _missing_key(place, key, "add `{key} = ...`: {meaning}")
    number = finite(place.values[key], place.named(key), partial(place.at, key))
    if number <= 0.0:
        raise FormatError(
            "not-positive",
            "{key} is {number}; it must be above 0: {meaning}",
            key=place.named(key),
            number=number,
            meaning=place.meanings[key],
            **place.at(key),
        )
    return number


def _missing_key(place: _Place, key: str, remedy: str) -> FormatError:
    return FormatError(
        "missing-key",
        "{place} has no {key}",
        remedy,
        place=place.name,
        key=key,
        meaning=place.meanings[key],
        **place.at_the_end(),
    )


def read_triple(header: Header, key: str) -> tuple[float, float, float]:
    """Return the three numbers of ``start`` or ``target``."""
    return _triple(_Place(header, header.data, HEADER_KEYS), key)


def _triple(place: _Place, key: str) -> tuple[float, float, float]:
    # The key must be a list of three numbers.
    if key not in place.values:
        raise _missing_key(place, key, "add `{key} = {meaning}`")
    value = place.values[key]
    if not isinstance(value, list) or len(value) != 3:
        came = f"a list of {len(value)}" if isinstance(value, list) else kind_of(value)
        raise FormatError(
            "wrong-type",
            "{key} is {came}",
            "write three numbers: {meaning}",
            key=place.named(key),
            came=came,
            meaning=place.meanings[key],
            **place.at(key),
        )
    numbers = [
        finite(item, f"{place.named(key)}[{k}]", partial(place.at, key))
        for k, item in enumerate(value)
    ]
    # A target without a radius has no disc.
    x, y, third = numbers
    if key == "target" and third <= 0.0:
        raise FormatError(
            "not-positive",
            "the {target}'s radius is {radius}; it must be above 0: {meaning}",
            target=place.named(key),
            radius=third,
            meaning=place.meanings[key],
            **place.at(key),
        )
    return x, y, third


def read_provenance(header: Header) -> Provenance | None:
    """Return the ``[provenance]`` table."""
    table = _table(header, "provenance")
    if table is None:
        return None
    note_names(table, header.source)
    return Provenance(
        family=NameInFile(text_at(header, table, "provenance", "family")),
        version=integer_at(header, table, "provenance", "version"),
        seed=integer_at(header, table, "provenance", "seed"),
        params=values_at(header, table, "provenance", "params"),
        metrics=numbers_at(header, table, "provenance", "metrics"),
    )


def read_certificate(header: Header, robots: int = 1) -> CertificateRecord | None:
    """Return the ``[certificate]`` table of a world with this many robots."""
    # Check the kind.
    table = _table(header, "certificate")
    if table is None:
        return None
    kind = table["kind"]
    if kind not in CERTIFICATE_KINDS:
        came = quote(kind) if isinstance(kind, str) else kind_of(kind)
        raise FormatError(
            "unknown-name",
            "certificate kind is {came}",
            'write "witness" or "cut"',
            came=came,
            **header.at("certificate", "kind"),
        )
    # A single robot's certificate has one clearance.
    at = partial(header.at, "certificate", "clearance")
    clearance = table["clearance"]
    if robots == 1:
        return CertificateRecord(str(kind), (finite(clearance, "clearance", at),))
    # A joint witness has a clearance for each robot.
    if kind == "witness":
        if "robot" in table:
            raise FormatError(
                "conflict",
                'kind = "witness", but [certificate] names a robot; a witness covers all of them',
                "remove `robot`",
                **header.at("certificate", "robot"),
            )
        if not isinstance(clearance, list) or len(clearance) != robots:
            came = (
                f"a list of {len(clearance)}" if isinstance(clearance, list) else kind_of(clearance)
            )
            raise FormatError(
                "wrong-type",
                "clearance is {came}",
                "write a list of {count} numbers, m, one for each robot",
                came=came,
                count=robots,
                **at(),
            )
        numbers = [finite(each, f"clearance[{k}]", at) for k, each in enumerate(clearance)]
        return CertificateRecord(str(kind), tuple(numbers))
    # A cut names the robot that it stops.
    if "robot" not in table:
        raise FormatError(
            "missing-key",
            "[{table}] has no {key}",
            "add `{key} = ...`: the number, from 1, of the robot that the cut stops",
            table="certificate",
            key="robot",
            **header.at("certificate"),
        )
    robot = integer_at(header, table, "certificate", "robot")
    if not 1 <= robot <= robots:
        raise FormatError(
            "out-of-range",
            "certificate.{name} is {robot}",
            "the robots are numbered from 1 to {last}",
            name="robot",
            robot=robot,
            last=robots,
            **header.at("certificate", "robot"),
        )
    return CertificateRecord(str(kind), (finite(clearance, "clearance", at),), robot)


def read_failure(header: Header) -> FailureRecord | None:
    """Return the ``[failure]`` table."""
    table = _table(header, "failure")
    if table is None:
        return None
    # It may name code, and anybody may have written the file.
    note_names(table, header.source)
    record = FailureRecord(
        controller=NameInFile(text_at(header, table, "failure", "controller")),
        motion=text_at(header, table, "failure", "motion"),
        seed=integer_at(header, table, "failure", "seed"),
        verdict=text_at(header, table, "failure", "verdict"),
        trace_digest=text_at(header, table, "failure", "trace_digest"),
        parameters=values_at(header, table, "failure", "parameters"),
        evidence=values_at(header, table, "failure", "evidence"),
        details=values_at(header, table, "failure", "details"),
    )
    for key, fault in word_faults(record):
        raise FormatError.of(fault, **header.at("failure", key))
    return record


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


def _table(header: Header, name: str) -> Mapping[str, object] | None:
    table: Mapping[str, object] | None = header.data.get(name)
    if table is not None:
        for key in TABLE_KEYS[name]:
            if key not in table and key not in OPTIONAL_KEYS:
                raise FormatError(
                    "missing-key",
                    "[{table}] has no {key}",
                    "add `{key} = ...` to it",
                    table=name,
                    key=key,
                    **header.at(name),
                )
    return table
