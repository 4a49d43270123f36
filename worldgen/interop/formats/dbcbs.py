"""Problems of db-CBS and dynobench: a YAML file with boxes, and robots with start and goal.

Source: Moldagalieva et al., "db-CBS: Discontinuity-Bounded Conflict-Based Search for Multi-Robot
Kinodynamic Motion Planning", ICRA 2024, and the examples of its repository.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

from worldgen.domain import MAX_SIDE
from worldgen.errors import FormatError
from worldgen.interop.format import Destination, Exported, Format, decimal, decimal_text
from worldgen.interop.format.foreign_map import (
    FLOOR_ROBOT,
    ForeignMap,
    ForeignRobot,
    check_sides,
    read_bounded,
)
from worldgen.interop.geometry.placed_boxes import solid_boxes
from worldgen.interop.geometry.raster import Raster, RasterBox, natural_cell_size
from worldgen.interop.readers.yaml_table import YamlTable, read_yaml
from worldgen.lattice import exact
from worldgen.parameters.bounds import check_between
from worldgen.world import DEFAULT_CELL_SIZE, World

_MAX_YAML_BYTES = 8 << 20
# Robots of these types are discs of 0.4 m that drive at 0.5 m/s; those without "sphere" are boxes
# of 0.5 x 0.25 m, which a disc of half their diagonal covers.
_TYPE = "unicycle_first_order_0_sphere"
_SPHERE = 0.4
_COVERED_BOX = 0.28
_SPEED = 0.5


def read_dbcbs(path: Path, *, cell_size: float = 0.0) -> ForeignMap:
    """Read a problem for one robot or several.

    Args:
        path: The YAML file.
        cell_size: Side of a cell, m; 0 means the largest with all walls on its lines, or 0.1.

    Raises:
        FormatError: If the file breaks a rule, or has a robot or an obstacle of another kind.
    """
    # Read the file.
    data = read_bounded(path, _MAX_YAML_BYTES)
    top = read_yaml(data, "a problem of db-CBS has `environment:` and `robots:`")
    for key in ("environment", "robots"):
        if key not in top:
            raise FormatError(
                "missing-key",
                "{key} is missing; a problem of db-CBS has `environment:` and `robots:`",
                key=key,
            )
    space = top.tables("environment")[0]
    low = _pair(space, "min")
    high = _pair(space, "max")
    width = high[0] - low[0]
    height = high[1] - low[1]
    if width <= 0 or height <= 0:
        raise FormatError(
            "out-of-range", "max must be above min, in x and in y", line=space.line_of("max")
        )

    # Paint the obstacles.
    obstacles = space.tables("obstacles") if "obstacles" in space else []
    boxes = [_box(table, low) for table in obstacles]
    size = exact(cell_size) if cell_size else natural_cell_size(width, height, boxes)
    size = size or exact(DEFAULT_CELL_SIZE)
    check_between("cell_size", float(size), 1e-6, 1e6, "m")
    columns, rows = (min(math.ceil(side / size), MAX_SIDE + 1) for side in (width, height))
    check_sides(columns, rows)
    raster = Raster(columns, rows, size)
    for box in boxes:
        raster.box(box)
    # The last cells may extend beyond the environment.
    raster.box(RasterBox(width, Fraction(0), columns * size, rows * size))
    raster.box(RasterBox(Fraction(0), height, columns * size, rows * size))
    notes: list[str] = []
    if raster.partly:
        notes.append(f"{raster.partly} cells are solid because an obstacle reaches into them")

    # Read the robots.
    found = [_robot(table, low) for table in top.tables("robots")]
    if not found:
        raise FormatError("empty", "there is no robot", "add one to `robots:`")
    if any(robot.radius == _COVERED_BOX for robot in found):
        notes.append("robots that are boxes are covered by discs of 0.28 m")
    first = found[0]
    return ForeignMap(
        raster.solid, float(size), notes=tuple(notes),
        start=first.start, target=first.target, robot_radius=first.radius, robot_speed=_SPEED,
        origin=(float(low[0]), float(low[1])), others=tuple(found[1:]),
    )  # fmt: skip


def _pair(table: YamlTable, key: str) -> tuple[Fraction, Fraction]:
    rows = table.rows(key) if key in table else [[]]
    if len(rows) != 1 or len(rows[0]) != 2:
        raise FormatError(
            "wrong-count",
            "{key} must be two numbers, [x m, y m]; worlds are flat",
            key=key,
            line=table.line_of(key),
        )
    return rows[0][0], rows[0][1]


def _box(table: YamlTable, low: tuple[Fraction, Fraction]) -> RasterBox:
    kind = table.word("type") if "type" in table else "nothing"
    if kind != "box":
        raise FormatError(
            "unsupported",
            "an obstacle of type {kind!q} cannot be read; only boxes can",
            kind=kind,
            line=table.line,
        )
    x, y = _pair(table, "center")
    width, height = _pair(table, "size")
    left = x - width / 2 - low[0]
    bottom = y - height / 2 - low[1]
    return RasterBox(left, bottom, left + width, bottom + height)


def _robot(table: YamlTable, low: tuple[Fraction, Fraction]) -> ForeignRobot:
    kind = table.word("type") if "type" in table else "nothing"
    if not re.match(r"unicycle|integrator", kind):
        raise FormatError(
            "unsupported",
            "a robot of type {kind!q} is not a disc, so it cannot be read",
            "use one of the unicycle types, such as {known}",
            kind=kind,
            known=_TYPE,
            line=table.line,
        )
    start = _state(table, "start", low)
    goal = _state(table, "goal", low)
    radius = _SPHERE if kind.endswith("_sphere") else _COVERED_BOX
    return ForeignRobot(start, goal[:2], radius, _SPEED)


def _state(table: YamlTable, key: str, low: tuple[Fraction, Fraction]) -> tuple[float, ...]:
    rows = table.rows(key) if key in table else [[]]
    if len(rows) != 1 or not 2 <= len(rows[0]) <= 5:
        raise FormatError(
            "wrong-count",
            "{key} must be numbers, [x m, y m, heading rad]",
            key=key,
            line=table.line_of(key),
        )
    x, y, *rest = rows[0]
    place = (float(x - low[0]), float(y - low[1]))
    return (*place, float(rest[0])) if rest else place


def write_dbcbs(world: World, destination: Destination) -> Exported:
    """Return a problem with a unicycle robot for each of the world's."""
    altered: dict[str, str] = {}
    for robot in world.robots:
        if robot.radius != _SPHERE:
            altered["robot_radius"] = (
                f"the robot's radius is not stored; robots of type {_TYPE} have a radius of "
                f"{_SPHERE} m"
            )
        if robot.speed != _SPEED:
            altered["robot_speed"] = (
                f"the robot's speed is not stored; robots of type {_TYPE} drive at {_SPEED} m/s"
            )
    text = "\n".join(_lines(world, destination)) + "\n"
    return Exported({destination.name: text.encode()}, altered)


def _lines(world: World, destination: Destination) -> Iterator[str]:
    # Compute the far corner exactly, so that the bounds are short decimals.
    side = exact(world.cell_size)
    x, y = (exact(value) for value in destination.origin)
    high = [decimal_text(x + world.width * side), decimal_text(y + world.height * side)]
    yield "# A world made by worldgen for db-CBS; m, rad."
    yield "environment:"
    yield f"  min: [{destination.x(0.0)}, {destination.y(0.0)}]"
    yield f"  max: [{high[0]}, {high[1]}]"
    # The environment bounds only the centres of robots, so an open border gets boxes too.
    boxes = solid_boxes(world, destination, height=1.0, floor=False)
    yield "  obstacles:" if boxes else "  obstacles: []"
    for box in boxes:
        middle = ", ".join(decimal_text(value) for value in box.centre[:2])
        size = ", ".join(decimal_text(value) for value in box.size[:2])
        yield "    - type: box"
        yield f"      center: [{middle}]"
        yield f"      size: [{size}]"
    # The format requires a heading at the goal too; ours is free.
    yield "robots:"
    for robot in world.robots:
        start = robot.start
        target = robot.target
        yield f"  - type: {_TYPE}"
        yield (
            f"    start: [{destination.x(start.x)}, {destination.y(start.y)}, "
            f"{decimal(start.heading)}]"
        )
        yield f"    goal: [{destination.x(target.x)}, {destination.y(target.y)}, 0]"


dbcbs = Format(
    "dbcbs",
    "problem of db-CBS or dynobench, .yaml",
    (".yaml", ".yml"),
    # Many obstacles may come before the robots, so the limits of the environment are enough.
    re.compile(
        rb"(?s)(?=(.*\n)?environment[ \t]*:[ \t]*(\{|(#[^\n]*)?\r?\n))"
        rb"((.*\n)?robots[ \t]*:|(?=.*[\s{,]min[ \t]*:).*[\s{,]max[ \t]*:)"
    ),
    read_dbcbs,
    write_dbcbs,
    holds=frozenset({"start", "heading", "target", "robot_radius", "robot_speed", "origin"}),
    robots=True,
    client="db-CBS, dynobench",
    usual_robot=FLOOR_ROBOT,
    most_bytes=_MAX_YAML_BYTES,
    harmless=frozenset({"name", "robots"}),
)
