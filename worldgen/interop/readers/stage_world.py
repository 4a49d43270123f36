"""Read Stage worlds: the floor plan's picture, a robot, and our name for its target.

Stage stretches the bounding box of the black pixels, not the picture, over the floor plan's size.
Source: rtv/Stage 4.3, ``blockgroup.cc``, ``stage.cc`` and ``model.cc``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

import numpy as np

from worldgen.errors import FormatError
from worldgen.interop.account import report_unread
from worldgen.interop.format import radians
from worldgen.interop.format.foreign_map import ForeignMap, naming, read_bounded, sibling_file
from worldgen.interop.geometry.raster import painted
from worldgen.interop.readers.grey_image import read_picture_file
from worldgen.interop.readers.stage_file import Entity, read_stage_file
from worldgen.support.arrays import Bools
from worldgen.support.rows import flip_rows
from worldgen.world import Value

# Name of a floor plan whose outermost pixels do not belong to the world.
RINGED = "walls-in-a-ring"
TARGET = "target"
_MAX_BYTES = 1 << 20
_MOST_INCLUDES = 100
# Largest grey, of 255, of a wall's pixel.
_BLACK = 127
# Prefixes of the names of included objects.
_ROBOTS = ("position", "pioneer", "turtlebot", "roomba", "erratic", "amigobot", "robot")
_UNITS = {"m": Fraction(1), "cm": Fraction(1, 100), "mm": Fraction(1, 1000)}

_Point = tuple[Fraction, Fraction]


@dataclass
class _Includes:
    """Files that a world file includes: those next to it are read, others are reported."""

    path: Path
    notes: list[str] = field(default_factory=list)
    read: int = 0

    def __call__(self, name: str, line: int) -> tuple[str, str] | None:
        self.read += 1
        if self.read > _MOST_INCLUDES:
            raise FormatError(
                "too-large",
                "more than {most} files are included",
                "does one include itself?",
                most=_MOST_INCLUDES,
                line=line,
                source=str(self.path),
            )
        try:
            file = sibling_file(self.path, "include", name)
        except FormatError as error:
            self.notes.append(f"{error}; its definitions are unknown")
            report_unread("files that cannot be included")
            return None
        return _text(file), str(file)


def _text(path: Path) -> str:
    return read_bounded(path, _MAX_BYTES).decode("utf-8", "surrogateescape").removeprefix("\ufeff")


@dataclass(frozen=True)
class _Plan:
    """The floor plan: its picture, the size of a pixel, and its lower-left corner, m."""

    solid: Bools
    across: Fraction
    along: Fraction
    corner: _Point


def read_stage(path: Path, *, cell_size: float = 0.0) -> ForeignMap:
    """Read a Stage world file.

    Args:
        path: The ``.world`` file; it names the picture.
        cell_size: Side of a cell, m; 0 means the size of the picture's pixels.

    Raises:
        FormatError: If a file breaks a rule, with the line if there is one.
    """
    # Parse the file and those that it includes.
    includes = _Includes(path)
    world = read_stage_file(_text(path), str(path), includes)
    unit, turn = _units(world)
    floor = _floor_plan(world, includes.notes)
    # The picture's name is relative to the world file, even if an included file has it.
    place = floor.place("bitmap")
    with naming(Path(place.source)):
        image = sibling_file(path, "bitmap", floor.text("bitmap"), line=place.line)
    # Black pixels are walls.
    grey, image_digest = read_picture_file(image)
    grey.report_transparent()
    report_unread("parts of the floor plan", len(floor.parts))
    solid = flip_rows(grey.values.astype(np.int64) * 255 // grey.maximum <= _BLACK)
    if not solid.any():
        raise FormatError(
            "empty",
            "has no black pixel, so Stage has no walls to stretch",
            "draw some",
            source=str(image),
        )
    plan = _plan(floor, solid, unit, includes.notes)
    walls, size = _cells(plan, cell_size, includes.notes)
    params: dict[str, Value] = {"image": image.name, "image_sha256": image_digest}
    # Read the robot and its target.
    robot = _robot(world, includes.notes)
    start = _pose(robot, plan, unit, turn) if robot is not None else None
    speeds = robot.numbers("velocity_bounds") if robot is not None else []
    speed = float(speeds[1] * unit) if len(speeds) > 1 and speeds[1] > 0 else None
    radius = _radius(robot, unit, includes.notes) if robot is not None else None
    origin = (float(plan.corner[0]), float(plan.corner[1]))
    target = _target(world, plan, unit, turn)
    return ForeignMap(
        walls, size, params, tuple(includes.notes), (), None, start, target, radius, speed, origin,
        unread=tuple(_unread(world, floor)),
    )  # fmt: skip


def _units(world: Entity) -> tuple[Fraction, bool]:
    """Return the unit of length in m, and whether angles are in degrees."""
    length = world.text("unit_length", "m")
    angle = world.text("unit_angle", "degrees")
    if length not in _UNITS:
        raise FormatError(
            "unknown-name",
            "unit_length is {name!q}; Stage knows m, cm and mm",
            name=length,
            line=world.place("unit_length").line,
            source=world.place("unit_length").source,
        )
    if angle not in ("degrees", "radians"):
        raise FormatError(
            "unknown-name",
            "unit_angle is {name!q}; Stage knows degrees and radians",
            name=angle,
            line=world.place("unit_angle").line,
            source=world.place("unit_angle").source,
        )
    return _UNITS[length], angle == "degrees"


def _floor_plan(world: Entity, notes: list[str]) -> Entity:
    """Return the only object with a picture, or the largest of several."""
    found = [entity for entity in world.parts if "bitmap" in entity]
    if not found:
        raise FormatError(
            "no-map-found",
            "has no model with a bitmap; a Stage world stores its walls as one, `floorplan ( "
            'bitmap "map.png" )`',
        )
    if len(found) > 1:
        notes.append(f"{len(found)} models have pictures; only the largest was used")
    return max(found, key=lambda entity: math.prod(entity.numbers("size")[:2]))


def _plan(floor: Entity, solid: Bools, unit: Fraction, notes: list[str]) -> _Plan:
    """Return the floor plan with these black pixels, stretched as Stage does it."""
    # Check the floor plan's size and pose.
    size = floor.numbers("size")
    pose = [*floor.numbers("pose"), *[Fraction(0)] * 4][:4]
    if len(size) < 2 or min(size[:2]) <= 0:
        raise FormatError(
            "wrong-type",
            "a floor plan needs its size, two or three lengths above 0, size [16 16 0.8]",
            line=floor.place("size").line,
            source=floor.place("size").source,
        )
    if pose[3] != 0 or any(floor.numbers("origin")):
        raise FormatError(
            "unsupported",
            "the floor plan is turned or has an origin; only upright ones can be read",
            "turn the picture",
            line=floor.place("pose").line,
            source=floor.place("pose").source,
        )
    if floor.numbers("obstacle_return") == [0]:
        notes.append("obstacle_return is 0: Stage's own robots drive through these walls")
    # Stretch the bounding box of the black pixels over the size.
    rows, columns = (np.flatnonzero(solid.any(axis=axis)) for axis in (1, 0))
    (low, high), (left, right) = ((int(index[0]), int(index[-1]) + 1) for index in (rows, columns))
    if (right - left, high - low) != solid.shape[::-1]:
        notes.append(
            f"black takes {right - left} x {high - low} of the picture's {solid.shape[1]} x "
            f"{solid.shape[0]} pixels; Stage stretches this part over the size, not the picture"
        )
    across = size[0] * unit / (right - left)
    along = size[1] * unit / (high - low)
    corner = (
        pose[0] * unit - size[0] * unit / 2 - left * across,
        pose[1] * unit - size[1] * unit / 2 - low * along,
    )
    if floor.text("name") == RINGED and min(solid.shape) > 2:
        return _Plan(solid[1:-1, 1:-1], across, along, (corner[0] + across, corner[1] + along))
    return _Plan(solid, across, along, corner)


def _cells(plan: _Plan, wanted: float, notes: list[str]) -> tuple[Bools, float]:
    """Return the walls, and the side of a cell, m."""
    size = Fraction(repr(wanted)) if wanted else min(plan.across, plan.along)
    rows, columns = plan.solid.shape
    raster = painted(
        (columns * plan.across, rows * plan.along),
        size,
        lambda raster: raster.picture(plan.solid, plan.across, plan.along),
    )
    if raster.partly:
        notes.append(
            f"{raster.partly} of {np.count_nonzero(raster.solid)} solid cells of {float(size):g} m "
            f"are only partly black, because pixels are {float(plan.across):g} x "
            f"{float(plan.along):g} m; a smaller cell_size is more accurate"
        )
    return raster.solid, float(size)


def _is_robot(entity: Entity) -> bool:
    return entity.kind == "position" or entity.kind.lower().startswith(_ROBOTS)


def _robot(world: Entity, notes: list[str]) -> Entity | None:
    robots = [entity for entity in world.parts if _is_robot(entity)]
    if len(robots) > 1:
        notes.append(f"the file has {len(robots)} robots; only the first was used")
    return robots[0] if robots else None


def _target(world: Entity, plan: _Plan, unit: Fraction, turn: bool) -> tuple[float, ...] | None:
    found = [entity for entity in world.parts if entity.text("name") == TARGET and "pose" in entity]
    if not found:
        return None
    size = found[0].numbers("size")
    reach = () if not size or size[0] <= 0 else (float(size[0] * unit / 2),)
    return (*_pose(found[0], plan, unit, turn)[:2], *reach)


def _pose(entity: Entity, plan: _Plan, unit: Fraction, turn: bool) -> tuple[float, ...]:
    """Return x and y from the grid's corner, m, and the heading, rad."""
    pose = [*entity.numbers("pose"), *[Fraction(0)] * 4][:4]
    x, y = (
        float(value * unit - corner) for value, corner in zip(pose[:2], plan.corner, strict=True)
    )
    return x, y, radians(pose[3]) if turn else float(pose[3])


def _radius(robot: Entity, unit: Fraction, notes: list[str]) -> float | None:
    """Return the radius of the disc around the robot's reference point that covers its blocks.

    It is None if the robot's size is unknown.
    """
    size = robot.numbers("size")
    shift = [*robot.numbers("origin"), Fraction(0), Fraction(0)]
    if len(size) < 2 or min(size[:2]) <= 0:
        notes.append("the robot's size is not in the file")
        return None
    points = _outline(robot) or [(Fraction(x), Fraction(y)) for x in (-1, 1) for y in (-1, 1)]
    spans = [(min(values), max(values)) for values in zip(*points, strict=True)]
    squared = Fraction(0)
    for point in points:
        at = [
            ((value - (low + high) / 2) / (high - low) * length + move) * unit
            if high > low
            else Fraction(0)
            for value, (low, high), length, move in zip(point, spans, size, shift, strict=False)
        ]
        squared = max(squared, at[0] ** 2 + at[1] ** 2)
    return float(_root(squared))


def _root(squared: Fraction) -> Fraction | float:
    above = math.isqrt(squared.numerator)
    below = math.isqrt(squared.denominator)
    if above**2 == squared.numerator and below**2 == squared.denominator:
        return Fraction(above, below)
    return math.sqrt(squared)


def _outline(robot: Entity) -> list[_Point]:
    """Return the corners of all blocks in their own units.

    Stage stretches them to the model's size.
    """
    found = []
    for block in robot.parts:
        if block.kind == "block":
            for key in block.properties:
                numbers = block.numbers(key) if key.startswith("point[") else []
                if len(numbers) == 2:
                    found.append((numbers[0], numbers[1]))
    return found


def _unread(world: Entity, floor: Entity) -> Iterator[str]:
    """Yield other obstacles in the world, such as a second picture."""
    others = [
        entity for entity in world.parts
        if entity is not floor and not _is_robot(entity) and entity.kind not in ("window", "speech", "camera")
        and entity.text("name") != TARGET and entity.numbers("obstacle_return") != [0]
    ]  # fmt: skip
    if others:
        names = ", ".join(sorted({entity.names[0] for entity in others})[:5])
        yield f"{len(others)} thing{'s' * (len(others) != 1)} besides the floor plan: {names}"
