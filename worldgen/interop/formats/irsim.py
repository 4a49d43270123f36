"""IR-SIM worlds: a YAML file with the robot, its goal, and walls as rectangles or as a picture.

IR-SIM tests for collisions only at the ends of its steps, and only against what it calls obstacles;
its world has no border. Source: IR-SIM 2.12, ``world/world.py`` and ``object_base.py``.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from fractions import Fraction
from typing import Literal

from worldgen.family import check_between
from worldgen.interop.format import (
    PLAIN_FACTS,
    Destination,
    Exported,
    Format,
    decimal,
    decimal_text,
)
from worldgen.interop.format.foreign_map import FLOOR_ROBOT
from worldgen.interop.geometry import raster
from worldgen.interop.geometry.placed_boxes import PlacedBox, solid_boxes
from worldgen.interop.geometry.solid_scene import TIMESTEPS
from worldgen.interop.readers.grey_image import walls_png
from worldgen.interop.readers.irsim_world import MAX_YAML_BYTES, read_irsim
from worldgen.lattice import exact
from worldgen.world import Robot, World

_TURN_RATE = (
    # Turn rate, rad/s. Our worlds have no limit, and IR-SIM's default of 1 is slow for a robot of 2
    # m/s.
    "6.2832"
)
# The last beam coincides with the first.
_LIDAR = "[{type: lidar2d, range_max: 10, angle_range: 6.283185307179586, number: 257}]"


def write_irsim(
    world: World,
    destination: Destination,
    *,
    walls: Literal["boxes", "image"] = "boxes",
    robot: Literal["diff", "omni"] = "diff",
    lidar: bool = False,
    step_time: float = 0.1,
) -> Exported:
    """Return the YAML file and, with ``walls=image``, the picture that it names.

    Args:
        world: The world.
        destination: Where the file is written.
        walls: How to store the walls: as rectangles, or as pixels of an obstacle map.
        robot: IR-SIM's kinematics.
        lidar: True to give the robot a lidar with 257 beams over a full turn (the last one equals
            the first) and a range of 10 m.
        step_time: Length of IR-SIM's step, s.
    """
    check_between("step_time", step_time, *TIMESTEPS, "s")
    solid = solid_boxes(world, destination, height=1.0, floor=False)
    boxes = [box for box in solid if walls == "boxes" or box.name.startswith("border")]
    files: dict[str, bytes] = {}
    picture = destination.sibling_file(".png") if walls == "image" else None
    lines = [
        *_world(world, destination, picture, step_time),
        *_robots(world, destination, robot, lidar),
    ]
    lines += _obstacles(boxes)
    files[destination.name] = ("\n".join(lines) + "\n").encode()
    if picture is not None:
        files[picture] = walls_png(world.walls)
    return Exported(
        files,
        dict(_altered(world, destination, boxes, picture)),
        tuple(_notes(world, picture, step_time)),
    )


def _world(
    world: World, destination: Destination, picture: str | None, step_time: float
) -> Iterator[str]:
    side = exact(world.cell_size)
    yield "# A world made by worldgen for IR-SIM; m, rad, s."
    yield "world:"
    yield f"  width: {decimal_text(world.width * side)}"
    yield f"  height: {decimal_text(world.height * side)}"
    yield f"  offset: [{destination.x(0.0)}, {destination.y(0.0)}]"
    yield f"  step_time: {decimal(step_time)}"
    yield f"  sample_time: {decimal(step_time)}"
    yield "  control_mode: auto"
    yield "  collision_mode: stop"
    if picture is not None:
        quoted = picture.replace("'", "''")
        yield f"  obstacle_map: '{quoted}'"
        yield "  mdownsample: 1"


def _robots(world: World, destination: Destination, kinematics: str, lidar: bool) -> Iterator[str]:
    yield "robot:"
    for robot in world.robots:
        start = robot.start
        target = robot.target
        speed = decimal(robot.speed)
        # The second speed is a turn rate or a sideways speed, depending on the kinematics.
        other = _TURN_RATE if kinematics == "diff" else speed
        x = destination.x(start.x)
        y = destination.y(start.y)
        yield f"  - kinematics: {{name: {kinematics}}}"
        yield f"    shape: {_shape(robot)}"
        yield f"    state: [{x}, {y}, {decimal(start.heading)}]"
        heading = "0" if target.heading is None else decimal(target.heading)
        yield f"    goal: [{destination.x(target.x)}, {destination.y(target.y)}, {heading}]"
        if target.heading is not None:
            yield "    arrive_mode: state"
        yield f"    goal_threshold: {decimal(target.radius)}"
        yield f"    vel_min: [-{speed}, -{other}]"
        yield f"    vel_max: [{speed}, {other}]"
        if lidar:
            yield f"    sensors: {_LIDAR}"


def _shape(robot: Robot) -> str:
    if robot.is_disc:
        return f"{{name: circle, radius: {decimal(robot.radius)}}}"
    corners = ", ".join(f"[{decimal(x)}, {decimal(y)}]" for x, y in robot.footprint)
    return f"{{name: polygon, vertices: [{corners}]}}"


def _obstacles(boxes: list[PlacedBox]) -> Iterator[str]:
    """Yield the boxes, grouped by size."""
    if boxes:
        yield "obstacle:"
    sizes: dict[tuple[Fraction, ...], list[tuple[Fraction, ...]]] = {}
    for box in boxes:
        sizes.setdefault(box.size[:2], []).append(box.centre[:2])
    for (length, width), centres in sorted(sizes.items()):
        yield f"  - number: {len(centres)}"
        yield "    distribution: {name: manual}"
        yield (
            f"    shape: {{name: rectangle, length: {decimal_text(length)}, width: "
            f"{decimal_text(width)}}}"
        )
        yield "    state:"
        yield from (f"      - [{decimal_text(x)}, {decimal_text(y)}, 0]" for x, y in centres)


def _altered(
    world: World, destination: Destination, boxes: list[PlacedBox], picture: str | None
) -> Iterator[tuple[str, str]]:
    """Yield a note about the cell size if the walls would also fit larger cells."""
    side = exact(world.cell_size)
    x, y = map(exact, destination.origin)
    ends = ((*box.low[:2], *box.high[:2]) for box in boxes)
    sides = (
        raster.RasterBox(left - x, low - y, right - x, high - y) for left, low, right, high in ends
    )
    if (
        picture is None
        and raster.natural_cell_size(world.width * side, world.height * side, sides) != side
    ):
        yield (
            "cell_size",
            f"the cell size, {world.cell_size:g} m, is not stored; the walls fit larger cells too",
        )


def _notes(world: World, picture: str | None, step_time: float) -> Iterator[str]:
    step = world.robot_speed * step_time
    if step > world.cell_size:
        yield (
            f"at {world.robot_speed:g} m/s IR-SIM moves {step:g} m per step and checks for "
            f"collisions only at its end: "
            f"the robot can pass walls of {world.cell_size:g} m; a smaller step_time helps"
        )
    if picture is not None:
        yield f"IR-SIM looks for {picture} in the folder where it runs, not next to the YAML file"


# How things look and what a robot does; other robots are not part of the map.
_HARMLESS = frozenset({
    "gui", "plot", "keyboard", "mouse", "robot", "color", "name", "id", "world/step_time", "world/sample_time",
    "world/control_mode", "world/fog_map", "world/fog_map_resolution", "world/collision_mode", "world/plot",
    "world/status", "obstacle/goal", "obstacle/sensors",
    "obstacle/fov", "obstacle/fov_radius", "obstacle/description", "obstacle/static", "obstacle/goal_threshold",
    "obstacle/vel_min", "obstacle/vel_max", "obstacle/acce", "obstacle/velocity", "obstacle/behavior",
    "obstacle/group_behavior", "obstacle/arrive_mode", "obstacle/role", "distribution/range_low",
    "distribution/range_high", "shape/random_shape",
})  # fmt: skip

irsim = Format(
    "irsim",
    "IR-SIM world, .yaml",
    (".yaml", ".yml"),
    re.compile(rb"(?s)(?!.*?(?m:^)image[ \t]*:)(.*\n)?world[ \t]*:[ \t]*(\{|(#[^\n]*)?\r?\n)"),
    read_irsim,
    write_irsim,
    holds=PLAIN_FACTS | {"footprint"},
    robots=True,
    client="IR-SIM",
    most_bytes=MAX_YAML_BYTES,
    harmless=_HARMLESS,
    usual_robot=FLOOR_ROBOT,
)
