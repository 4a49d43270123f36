"""Read IR-SIM worlds: walls, robot and goal from their YAML files.

Source: IR-SIM 2.12, ``world/world.py``, ``object_factory.py``, ``geometry_handler.py`` and
    ``image_map_generator.py``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

import numpy as np

from worldgen.errors import FormatError, InvalidWorld
from worldgen.family import check_between
from worldgen.interop.format.foreign_map import ForeignMap, ForeignRobot, read_bounded, sibling_file
from worldgen.interop.geometry.raster import Raster, RasterBox, natural_cell_size, painted
from worldgen.interop.geometry.shapes import Shapes, turned
from worldgen.interop.readers.grey_image import read_picture_file
from worldgen.interop.readers.yaml_table import YamlTable, read_yaml
from worldgen.robot import convex_footprint
from worldgen.support.arrays import Bools
from worldgen.support.plain_text import counted
from worldgen.support.rows import flip_rows
from worldgen.world import DEFAULT_CELL_SIZE, Target, Value

# A maze of 500 x 500 cells has 1 MB of boxes.
MAX_YAML_BYTES = 2 << 20
_MOST_OBJECTS = 1_000_000
# IR-SIM's default width and height, m.
_SIZE = Fraction(10)
_STATE = [Fraction(1), Fraction(1), Fraction(0)]
_GOAL = [Fraction(1), Fraction(9), Fraction(0)]


@dataclass
class _IrsimScene:
    """The contents of the file, m, from the world's corner."""

    width: Fraction
    height: Fraction
    corner: tuple[Fraction, Fraction]
    shapes: Shapes = field(default_factory=Shapes)
    image: tuple[Bools, str, str] | None = None
    notes: list[str] = field(default_factory=list)
    unread: list[str] = field(default_factory=list)


def read_irsim(path: Path, *, cell_size: float = 0.0, threshold: float = 0.5) -> ForeignMap:
    """Read an IR-SIM world file.

    Args:
        path: The YAML file.
        cell_size: Side of a cell, m; 0 means the obstacle map's, or the largest with all walls on
            its lines, or 0.1.
        threshold: Minimum darkness of a solid pixel of the obstacle map, 0 white to 1 black.

    Raises:
        FormatError: If the file breaks a rule, with the line if there is one.
    """
    # Parse the file.
    check_between("threshold", threshold, 0.0, 1.0)
    data = read_bounded(path, MAX_YAML_BYTES)
    top = read_yaml(data, "an IR-SIM world has `world:` with width and height")
    if "world" not in top:
        raise FormatError(
            "missing-key", "world is missing; an IR-SIM world has `world:` with width and height"
        )
    world = YamlTable() if top.is_null("world") else top.tables("world")[0]
    # Collect the walls.
    scene = _IrsimScene(_length(world, "width"), _length(world, "height"), _point(world, "offset"))
    if "obstacle_map" in world and not world.is_null("obstacle_map"):
        scene.image = _picture(world, path, threshold)
    for table in _tables(top, "obstacle"):
        _add_obstacles(scene, table)
    walls, size = _cells(scene, cell_size)
    # Record the picture, and read the robot.
    params: dict[str, Value] = (
        {} if scene.image is None else {"image": scene.image[1], "image_sha256": scene.image[2]}
    )
    robot = _robot(top, scene)
    origin = (float(scene.corner[0]), float(scene.corner[1]))
    return ForeignMap(
        walls, size, params, (*scene.notes, *dict.fromkeys(scene.shapes.notes)), (), None, (robot,),
        origin, unread=tuple(scene.unread),
    )  # fmt: skip


def _tables(table: YamlTable, key: str) -> list[YamlTable]:
    return table.tables(key) if key in table and not table.is_null(key) else []


def _word(table: YamlTable, key: str, default: str) -> str:
    return default if key not in table or table.is_null(key) else table.word(key)


def _fraction(table: YamlTable, key: str, default: Fraction) -> Fraction:
    return default if key not in table else table.fraction(key)


def _length(table: YamlTable, key: str, default: Fraction = _SIZE) -> Fraction:
    value = _fraction(table, key, default)
    if key in table and not 0 < value < 10**9:
        raise FormatError(
            "not-positive",
            "{key} is {value:g}; it must be a length above 0 m",
            key=key,
            value=float(value),
            line=table.line_of(key),
        )
    return value


def _point(table: YamlTable, key: str) -> tuple[Fraction, Fraction]:
    """Return the two numbers of a key; 0 and 0 if it is missing."""
    rows = table.rows(key) if key in table else [[Fraction(0), Fraction(0)]]
    if len(rows[0]) != 2 or (key == "offset" and len(rows) != 1):
        raise FormatError(
            "wrong-type", f"{key} must be two numbers, [x m, y m]", line=table.line_of(key)
        )
    return rows[0][0], rows[0][1]


def _picture(world: YamlTable, path: Path, threshold: float) -> tuple[Bools, str, str]:
    """Return the obstacle map's solid cells, lowest row first, its name and its digest."""
    line = world.line_of("obstacle_map")
    image = sibling_file(path, "obstacle_map", _picture_name(world), line=line)
    grey, image_digest = read_picture_file(image)
    grey.report_transparent()
    dark = (grey.maximum - grey.values.astype(np.float64)) / grey.maximum
    step = int(_fraction(world, "mdownsample", Fraction(1)))
    if not 1 <= step <= min(dark.shape):
        raise FormatError(
            "wrong-type",
            "mdownsample is {value}; it must be a whole number of 1 or more",
            value=step,
            line=world.line_of("mdownsample"),
        )
    # IR-SIM's own rule is "above one half"; at other thresholds, a pixel exactly at the threshold
    # counts too.
    solid = dark > 0.5 if threshold == 0.5 else dark >= threshold
    return flip_rows(solid)[::step, ::step], image.name, image_digest


def _picture_name(world: YamlTable) -> str:
    """Return the obstacle map's file: a word, or a table with ``name: image`` and ``path``."""
    try:
        return world.word("obstacle_map")
    except FormatError:
        table = world.tables("obstacle_map")[0]
    kind = _word(table, "name", "none")
    if kind != "image" or "path" not in table:
        raise FormatError(
            "unsupported",
            "obstacle_map {kind!q} is drawn by IR-SIM itself",
            "save the map that it draws as a picture, and name that",
            kind=kind,
            line=world.line_of("obstacle_map"),
        )
    return table.word("path")


def _add_obstacles(scene: _IrsimScene, table: YamlTable) -> None:
    """Add the obstacles of one entry.

    There are ``number`` of them, each with a shape and a state; the last ones also apply to the
    rest.
    """
    # Check the number of obstacles.
    number = int(_fraction(table, "number", Fraction(1)))
    if not 0 <= number <= _MOST_OBJECTS:
        raise FormatError(
            "out-of-range",
            "number is {number}; it must be a whole number of obstacles, up to {most_objects}",
            number=number,
            most_objects=_MOST_OBJECTS,
            line=table.line_of("number"),
        )
    # Skip obstacles that move, or have no known place.
    count = f"{counted(number, 'obstacle')} at line {table.line}"
    kinematics = _tables(table, "kinematics")
    if kinematics and _word(kinematics[0], "name", "static") != "static":
        scene.unread.append(f"{count} that can move")
        table.pass_over()
        return
    if _word(table, "unobstructed", "false").lower() == "true":
        scene.notes.append(f"{count} do not stop a robot in IR-SIM, so they are ignored")
        table.pass_over()
        return
    if _placing(table) != "manual":
        scene.unread.append(f"{count} placed at random")
        table.pass_over()
        return
    # Add one shape after another.
    states = table.rows("state") if "state" in table else [_STATE]
    shapes = _tables(table, "shape") or [YamlTable()]
    flat = len(states) == 1
    for index in range(min(number, max(len(states), len(shapes)))):
        state = states[0] if flat else states[min(index, len(states) - 1)]
        if len(state) < 2:
            raise FormatError(
                "wrong-type", "state must have x and y, [1.5, 2, 0]", line=table.line_of("state")
            )
        _add_shape(scene, table, shapes[min(index, len(shapes) - 1)], state)


def _placing(table: YamlTable) -> str:
    found = _tables(table, "distribution")
    return _word(found[0], "name", "manual") if found else "manual"


def _add_shape(
    scene: _IrsimScene, owner: YamlTable, shape: YamlTable, state: list[Fraction]
) -> None:
    """Add one shape at a state, or the parts of a compound shape one after another."""
    # The shape's name decides how it is read.
    x, y, heading = (*state, Fraction(0))[:3]
    at = (x - scene.corner[0], y - scene.corner[1])
    name = _word(shape, "name", "circle")
    if _word(shape, "random_shape", "false").lower() == "true":
        scene.unread.append(f"1 obstacle at line {shape.line} with a random shape")
        shape.pass_over()
    elif name == "circle":
        usual = Fraction(1, 5) if _tables(owner, "shape") else Fraction(1)
        radius = _length(shape, "radius", usual)
        scene.shapes.disc(_point(shape, "center"), radius, at, heading)
    elif name == "rectangle":
        half = _length(shape, "length", Fraction(1)) / 2, _length(shape, "width", Fraction(1)) / 2
        back = (
            half[0] if "wheelbase" not in shape else (2 * half[0] - shape.fraction("wheelbase")) / 2
        )
        scene.shapes.outline(_corners(-back, -half[1], 2 * half[0] - back, half[1]), at, heading)
    elif name in ("polygon", "linestring") and "vertices" in shape:
        scene.shapes.outline(_vertices(shape), at, heading, closed=name == "polygon")
    elif name == "compound":
        _add_parts(scene, owner, shape, (x, y, heading))
    else:
        raise FormatError(
            "unsupported",
            "shape {shape!q} cannot be read; only circle, rectangle, polygon and linestring can",
            shape=name,
            line=owner.line_of("shape"),
        )


def _vertices(shape: YamlTable) -> list[tuple[Fraction, Fraction]]:
    rows = shape.rows("vertices")
    least = 2 if _word(shape, "name", "") == "linestring" else 3
    if len(rows) < least or any(len(row) != 2 for row in rows):
        raise FormatError(
            "wrong-count",
            "vertices must be {least} or more points, [[0, 0], [1, 0], [1, 1]]",
            least=least,
            line=shape.line_of("vertices"),
        )
    return [(row[0], row[1]) for row in rows]


def _corners(
    left: Fraction, low: Fraction, right: Fraction, high: Fraction
) -> list[tuple[Fraction, Fraction]]:
    return [(left, low), (right, low), (right, high), (left, high)]


def _add_parts(
    scene: _IrsimScene,
    owner: YamlTable,
    shape: YamlTable,
    pose: tuple[Fraction, Fraction, Fraction],
) -> None:
    x, y, heading = pose
    for part in _tables(shape, "parts"):
        if _word(part, "name", "circle") == "compound":
            raise FormatError(
                "unsupported",
                "a compound in a compound cannot be read",
                "put its parts into the outer one",
                line=part.line_of("name"),
            )
        own = (
            [*part.rows("pose")[0], Fraction(0), Fraction(0)]
            if "pose" in part
            else [Fraction(0)] * 3
        )
        turned_point = turned(
            np.array([own[:2]], np.float64), (Fraction(0), Fraction(0)), float(heading)
        )[0]
        moved = own[:2] if heading == 0 else [Fraction(float(value)) for value in turned_point]
        _add_shape(scene, owner, part, [x + moved[0], y + moved[1], heading + own[2]])


def _cells(scene: _IrsimScene, wanted: float) -> tuple[Bools, float]:
    """Return the walls, and the side of a cell, m."""
    size = _cell_size(scene, wanted)
    raster = painted((scene.width, scene.height), size, lambda raster: _paint(raster, scene, size))
    if raster.partly:
        scene.notes.append(
            f"{raster.partly} of {np.count_nonzero(raster.solid)} solid cells of {float(size):g} m "
            f"are only partly covered; a smaller cell_size is more accurate"
        )
    return raster.solid, float(size)


def _cell_size(scene: _IrsimScene, wanted: float) -> Fraction:
    if wanted:
        return Fraction(repr(wanted))
    if scene.image is not None:
        rows, columns = scene.image[0].shape
        return min(scene.width / int(columns), scene.height / int(rows))
    usual = Fraction(repr(DEFAULT_CELL_SIZE))
    return natural_cell_size(scene.width, scene.height, scene.shapes.boxes) or usual


def _paint(raster: Raster, scene: _IrsimScene, size: Fraction) -> None:
    height, width = raster.solid.shape
    if scene.image is not None:
        rows, columns = scene.image[0].shape
        raster.picture(scene.image[0], scene.width / int(columns), scene.height / int(rows))
    scene.shapes.paint(raster)
    # The last cells may extend beyond the world.
    raster.box(RasterBox(scene.width, Fraction(0), width * size, height * size))
    raster.box(RasterBox(Fraction(0), scene.height, width * size, height * size))


_Point = tuple[float, ...] | None


def _robot(top: YamlTable, scene: _IrsimScene) -> ForeignRobot:
    """Return the first robot."""
    # Take the first robot.
    tables = _tables(top, "robot")
    if not tables:
        scene.notes.append("there is no robot in the file")
        return ForeignRobot()
    first = tables[0]
    number = sum(int(_fraction(table, "number", Fraction(1))) for table in tables)
    if number > 1:
        scene.notes.append(f"the file has {number} robots; only the first was used")
    # Read its start and its last goal.
    start: _Point = None
    target: _Point = None
    reach = float(_length(first, "goal_threshold", Fraction(1, 10)))
    if _placing(first) == "manual":
        state = first.rows("state")[0] if "state" in first else _STATE
        goals = first.rows("goal") if "goal" in first and not first.is_null("goal") else [_GOAL]
        if len(goals) > 1:
            scene.notes.append(f"the robot has {len(goals)} goals; the last is the target")
        start = (*_from_corner(scene, first, "state", state), float((*state, Fraction(0))[2]))
        target = (*_from_corner(scene, first, "goal", goals[-1]), reach)
    else:
        scene.notes.append(
            f"IR-SIM places the robot at random ({_placing(first)}), so start and target were "
            f"placed here"
        )
    # Read its speed.
    speeds = first.rows("vel_max")[0] if "vel_max" in first else [Fraction(1)]
    if speeds[0] <= 0:
        raise FormatError(
            "not-positive",
            "vel_max begins with {speed:g}; it must be a speed above 0 m/s",
            speed=float(speeds[0]),
            line=first.line_of("vel_max"),
        )
    goal = None
    if target is not None and _word(first, "arrive_mode", "position") == "state":
        # IR-SIM then compares x, y and the heading as one vector.
        aim = None
        if reach < math.pi:
            aim = float((*goals[-1], Fraction(0), Fraction(0))[2])
        goal = Target(0.0, 0.0, reach, heading=aim, heading_tolerance=reach, arrival="step")
    body = _body(first, scene)
    return body._replace(start=start, target=target, speed=float(speeds[0]), goal=goal)


def _from_corner(
    scene: _IrsimScene, table: YamlTable, key: str, point: list[Fraction]
) -> tuple[float, float]:
    if len(point) < 2:
        raise FormatError(
            "wrong-type", "{key} must have x and y, [1.5, 2, 0]", key=key, line=table.line_of(key)
        )
    return float(point[0] - scene.corner[0]), float(point[1] - scene.corner[1])


def _body(robot: YamlTable, scene: _IrsimScene) -> ForeignRobot:
    """Return the robot's radius or its footprint; what is no convex polygon becomes a disc."""
    # A circle has a radius.
    shapes = _tables(robot, "shape")
    if not shapes:
        return ForeignRobot(radius=1.0)
    shape = shapes[0]
    name = _word(shapes[0], "name", "circle")
    if name == "circle":
        return ForeignRobot(radius=float(_length(shape, "radius", Fraction(1, 5))))
    # Any other shape is measured from the robot's own point.
    around = _IrsimScene(_SIZE, _SIZE, (Fraction(0), Fraction(0)))
    _add_shape(around, robot, shape, [Fraction(0)] * 3)
    outlines = [_corners(*box) for box in around.shapes.boxes]
    outlines += [polygon.tolist() for polygon in around.shapes.polygons]
    if name == "polygon":
        outlines = [_vertices(shape)]
    if len(outlines) == 1 and not around.shapes.circles:
        try:
            corners = convex_footprint([(float(x), float(y)) for x, y in outlines[0]])
        except InvalidWorld as error:
            scene.notes.append(f"the robot's {name} cannot be a footprint: {error.message}")
        else:
            _note_steering(robot, shape, scene)
            return ForeignRobot(footprint=corners)

    # A disc around the robot's point that holds all of it is sure to be large enough.
    points = [corner for outline in outlines for corner in outline]
    radius = max((math.sqrt(float(x) ** 2 + float(y) ** 2) for x, y in points), default=0.0)
    radius = max(
        [radius, *(math.sqrt(c.x * c.x + c.y * c.y) + c.radius for c in around.shapes.circles)]
    )
    if radius <= 0.0:
        raise FormatError(
            "unsupported",
            "the robot's shape {shape!q} cannot be read",
            "give it a circle with a radius",
            shape=name,
            line=robot.line_of("shape"),
        )
    scene.notes.append(f"the robot is a {name}; it became a disc of {radius:g} m that holds it")
    return ForeignRobot(radius=radius)


def _note_steering(robot: YamlTable, shape: YamlTable, scene: _IrsimScene) -> None:
    """Say how to import a robot that steers as the car that it is."""
    kinematics = _tables(robot, "kinematics")
    if not kinematics or _word(kinematics[0], "name", "") != "acker":
        return
    fastest = robot.rows("vel_max")[0] if "vel_max" in robot else []
    limit = float(fastest[1]) if len(fastest) > 1 else 1.0
    if "wheelbase" in shape and 0.0 < limit < 0.5 * math.pi:
        radius = float(shape.fraction("wheelbase")) / math.tan(limit)
        scene.notes.append(
            f"the robot steers like a car; --drive car --turning-radius {radius:.4g} imports it as one"
        )
