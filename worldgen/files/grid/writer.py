"""Write a world as bytes: the same world gives the same bytes, wherever and whenever."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

import numpy as np

from worldgen.errors import InvalidWorld
from worldgen.files.grid.records import word_faults
from worldgen.files.grid.schema import (
    DRIVES,
    END,
    FREE,
    MAGIC,
    MAX_HEADER_BYTES,
    ROBOT_KEYS,
    SOLID,
    TABLES_MAGIC,
)
from worldgen.files.grid.toml_text import number_text, value_text
from worldgen.support.rows import flip_rows
from worldgen.timeline import CellState
from worldgen.world import (
    DEFAULT_ROBOT_SPEED,
    Certificate,
    Cut,
    FailureRecord,
    JointWitness,
    Pose,
    Provenance,
    Target,
    Value,
    Witness,
    World,
)

# Cells written at a time.
_PIECE = 1 << 20


def dumps(world: World) -> bytes:
    """Return the canonical ``.grid`` text of a world.

    Returns:
        The text is UTF-8 with LF line ends; :func:`worldgen.files.grid.loads` returns an equal
        world.

    Raises:
        InvalidWorld: If the format cannot express the world: a number that isn't finite, a value
            that isn't a ``Value``, or more provenance and failure than fits into a header.
    """
    return b"".join(pieces(world))


def pieces(world: World) -> Iterator[bytes]:
    """Yield the same text in pieces, so that a large world is not held in memory twice.

    Raises:
        InvalidWorld: Same as :func:`dumps`, for the header before the first piece.
    """
    header = "\n".join(_header_lines(world)).encode("utf-8")
    if len(header) > MAX_HEADER_BYTES - len(MAGIC):
        raise InvalidWorld(
            "too-large",
            "provenance and failure take {bytes} bytes of header; the limit is {most}",
            "keep long evidence in a separate file",
            bytes=len(header),
            most=MAX_HEADER_BYTES,
        )
    yield header + b"\n%cells\n"
    yield from _cells(world)
    yield "".join(f"{line}\n" for line in _section_lines(world)).encode("ascii")
    yield f"%{END}\n".encode("ascii")


def world_digest(world: World) -> str:
    """Return the world's id.

    Args:
        world: The world.

    Returns:
        SHA-256 of its canonical bytes without provenance and failure, in hex.
    """
    digest = hashlib.sha256()
    for piece in pieces(replace(world, provenance=None, failure=None)):
        digest.update(piece)
    return digest.hexdigest()


def _header_lines(world: World) -> Iterator[str]:
    # The order of the keys is fixed, so that equal worlds give equal bytes.
    has_tables = _has_tables(world)
    yield TABLES_MAGIC if has_tables else MAGIC
    yield f"cell_size = {number_text(world.cell_size, 'cell_size')}"
    if has_tables:
        yield from _robot_lines(world)
    else:
        yield f"robot_radius = {number_text(world.robot_radius, 'robot_radius')}"
        if world.robot_speed != DEFAULT_ROBOT_SPEED:
            yield f"robot_speed = {number_text(world.robot_speed, 'robot_speed')}"
        yield from _ends_lines(world.start, world.target)
    if world.provenance is not None:
        yield from _provenance_lines(world.provenance)
    if world.certificate is not None:
        yield from _certificate_lines(world.certificate, fleet=world.is_fleet)
    if world.failure is not None:
        yield from _failure_lines(world.failure)


def _has_tables(world: World) -> bool:
    """Return True for a world that only version 2 can hold."""
    return world.is_fleet or not world.robots[0].is_plain


def _robot_lines(world: World) -> Iterator[str]:
    for robot in world.robots:
        yield from ("", "[[robot]]")
        yield from _ends_lines(robot.start, robot.target)
        values = {
            **_goal_values(robot.target),
            "contact": robot.target.contact,
            "radius": robot.radius if robot.is_disc else None,
            "footprint": [list(corner) for corner in robot.footprint] or (),
            "speed": robot.speed,
            "drive": DRIVES[0] if robot.drive.is_car else None,
            "turning_radius": robot.drive.turning_radius,
            "reverse": robot.drive.reverse,
            "steering_rate": robot.drive.steering_rate,
        }
        yield from _given(values)
        if robot.waypoints:
            rows = ", ".join(map(_waypoint_text, robot.waypoints))
            yield f"waypoints = [{rows}]"


def _goal_values(goal: Target) -> dict[str, object]:
    return {
        "target_heading": goal.heading,
        "heading_tolerance": goal.heading_tolerance,
        "arrival": goal.arrival,
        "arrival_speed": goal.arrival_speed,
        "arrival_turn_rate": goal.arrival_turn_rate,
    }


def _waypoint_text(goal: Target) -> str:
    """Return one table of the list of waypoints, with its keys in the order of a robot's."""
    place = f"target = {_numbers('waypoints', (goal.x, goal.y, goal.radius))}"
    return f"{{ {', '.join((place, *_given(_goal_values(goal))))} }}"


def _given(values: Mapping[str, object]) -> Iterator[str]:
    """Yield ``key = value`` for all values of a robot or a goal that are not the default."""
    for key, value in values.items():
        if value != ROBOT_KEYS[key].default:
            text = number_text(value, key) if isinstance(value, float) else value_text(value, key)
            yield f"{key} = {text}"


def _ends_lines(start: Pose, target: Target) -> Iterator[str]:
    yield f"start = {_numbers('start', (start.x, start.y, start.heading))}"
    yield f"target = {_numbers('target', (target.x, target.y, target.radius))}"


def _certificate_lines(proof: Certificate, *, fleet: bool) -> Iterator[str]:
    kind = "cut" if isinstance(proof, Cut) else "witness"
    yield from ("", "[certificate]", f'kind = "{kind}"')
    if fleet and isinstance(proof, Cut):
        yield f"robot = {proof.robot}"
    if isinstance(proof, Cut) and proof.waypoint:
        yield f"waypoint = {proof.waypoint}"
    if isinstance(proof, JointWitness):
        clearances = (path.clearance for path in proof.paths)
        yield f"clearance = {_numbers('certificate.clearance', clearances)}"
    else:
        yield f"clearance = {number_text(proof.clearance, 'certificate.clearance')}"


def _numbers(what: str, values: Iterable[float]) -> str:
    return "[" + ", ".join(number_text(value, what) for value in values) + "]"


def _provenance_lines(made: Provenance) -> Iterator[str]:
    yield from ("", "[provenance]")
    for key in ("family", "version", "seed"):
        yield f"{key} = {value_text(getattr(made, key), f'provenance.{key}')}"
    yield from _table_line("provenance", "params", made.params)
    for name, value in made.metrics.items():
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InvalidWorld(
                "not-a-number",
                "provenance.metrics.{name} is a {kind}: a metric is a number",
                "leave it out",
                name=name,
                kind=type(value).__name__,
            )
    yield from _table_line("provenance", "metrics", dict(made.metrics))


def _failure_lines(failure: FailureRecord) -> Iterator[str]:
    for _, fault in word_faults(failure):
        raise InvalidWorld.of(fault)
    yield from ("", "[failure]")
    for key in ("controller", "motion", "seed", "verdict", "trace_digest"):
        yield f"{key} = {value_text(getattr(failure, key), f'failure.{key}')}"
    for key in ("parameters", "evidence", "details"):
        yield from _table_line("failure", key, getattr(failure, key))


def _table_line(table: str, key: str, values: Mapping[str, Value]) -> Iterator[str]:
    if values:
        yield f"{key} = {value_text(values, f'{table}.{key}')}"


def _cells(world: World) -> Iterator[bytes]:
    """Yield the rows in chunks, top row first."""
    rows = flip_rows(world.walls)
    at_once = max(1, _PIECE // world.width)
    letters = np.array([ord(FREE), ord(SOLID)], np.uint8)
    for first in range(0, world.height, at_once):
        some = rows[first : first + at_once]
        text = np.full((len(some), world.width + 1), ord("\n"), np.uint8)
        text[:, :-1] = letters[some.view(np.uint8)]
        yield text.tobytes()


def _section_lines(world: World) -> Iterator[str]:
    # Sections without lines are omitted.
    certificate = world.certificate
    if world.is_dynamic:
        yield "%timeline"
        words = [state.word for state in sorted(CellState)]
        columns = (column.tolist() for column in world.timeline.columns)
        for time, ix, iy, state in zip(*columns, strict=True):
            yield f"{time + 0.0!r} {ix} {iy} {words[state]}"
    if isinstance(certificate, Witness):
        yield "%witness"
        yield from _point_lines(certificate, "1 " if _has_tables(world) else "")
    elif isinstance(certificate, JointWitness):
        yield "%witness"
        for number, path in enumerate(certificate.paths, start=1):
            yield from _point_lines(path, f"{number} ")
    elif isinstance(certificate, Cut):
        yield "%cut"
        rows = certificate.cells if certificate.boxes is None else certificate.boxes
        yield from (" ".join(map(str, row)) for row in rows.tolist())


def _point_lines(path: Witness, prefix: str) -> Iterator[str]:
    """Return the points of one path; ``prefix`` precedes each."""
    columns = [path.times, path.x, path.y]
    if path.headings is not None:
        columns.append(path.headings)
    points = np.column_stack(columns) + 0.0
    if not np.isfinite(points).all():
        raise InvalidWorld(
            "not-finite",
            "the witness has a number that is not finite; a .grid file cannot hold it; prove "
            "it again",
        )
    for point in points.tolist():
        yield prefix + " ".join(map(repr, point))
