"""Read Gazebo's files, and export a world as SDFormat 1.9, for Gazebo and other programs.

An exported world is a static model of boxes, with a floor, marks and a robot. A world file has no clock, so
cells that change with time become models that a script moves.

Source: the SDFormat 1.9 specification.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from fractions import Fraction
from typing import Literal

from worldgen.errors import InvalidWorld
from worldgen.interop.format import PLAIN_FACTS, Destination, Exported, Format, decimal
from worldgen.interop.format import decimal_text as text
from worldgen.interop.format.foreign_map import FLOOR_ROBOT
from worldgen.interop.geometry.body_shape import BodyBox, body_box
from worldgen.interop.geometry.placed_boxes import PlacedBox
from worldgen.interop.geometry.solid_scene import (
    TIMESTEPS,
    Body,
    numbered,
    plain_name,
    player_files,
    scene,
)
from worldgen.interop.readers.gazebo_models import GAZEBO_HARMLESS
from worldgen.interop.readers.gazebo_world import MAX_BYTES, grid_line, read_gazebo_world
from worldgen.interop.readers.places_text import kind_words
from worldgen.lattice import exact
from worldgen.parameters.bounds import check_between
from worldgen.world import Robot, World

# Thickness of a mark, m.
_THIN = Fraction(1, 1000)
# With more boxes than this, a physics step of Fortress takes longer than the millisecond it
# simulates.
_MANY = 2000
_SCHEMA = "urn:worldgen:sdf"
_COLOURS = {
    "ground": "0.9 0.9 0.9 1",
    "wall": "0.3 0.3 0.35 1",
    "cell": "0.5 0.4 0.3 1",
    "fire": "1 0.4 0.1 0.7",
    "start": "0.1 0.4 0.9 0.6",
    "target": "0.1 0.7 0.2 0.6",
    "robot": "0.1 0.4 0.9 1",
}


_SYSTEMS: dict[str, tuple[tuple[str, str], ...]] = {"none": ()} | {
    release: tuple(
        (f"{file}-{dashed}-system", f"{namespace}::{camel}")
        for dashed, camel in (
            ("physics", "Physics"),
            ("user-commands", "UserCommands"),
            ("scene-broadcaster", "SceneBroadcaster"),
        )
    )
    for release, file, namespace in (
        ("fortress", "ignition-gazebo", "ignition::gazebo::systems"),
        ("harmonic", "gz-sim", "gz::sim::systems"),
    )
}
"""Files and names of the systems that a world needs, by release."""

_DRIVES = {
    "fortress": ("ignition-gazebo-diff-drive-system", "ignition::gazebo::systems::DiffDrive"),
    "harmonic": ("gz-sim-diff-drive-system", "gz::sim::systems::DiffDrive"),
}
# Lengths in units of the robot's radius. Everything is inside the disc.
_WHEEL = Fraction(1, 2)
_WHEEL_WIDTH = Fraction(1, 8)
# Wheels, to the left and right.
_WHEEL_AT = Fraction(5, 8)
# Wheels, below the chassis.
_GAP = Fraction(1, 4)
# Height of the chassis.
_TALL = Fraction(3, 4)
# Casters, at the front and the back.
_CASTER_AT = Fraction(3, 4)
# Masses, kg.
_MASS = Fraction(1)
_WHEEL_MASS = Fraction(1, 10)


def write_sdf(
    world: World,
    destination: Destination,
    *,
    height: float = 1.0,
    robot: bool = False,
    plugins: Literal["none", "fortress", "harmonic"] = "none",
    timestep: float = 0.001,
) -> Exported:
    """Return the world file and, if the world changes, a script and the table that it plays.

    Args:
        world: The world.
        destination: Where the file is written.
        height: Height of the walls, m.
        robot: True to add a disc on two wheels at the start; with plugins it obeys velocity
            commands.
        plugins: The release of Gazebo that the listed systems are for; with none, Gazebo loads its
            defaults.
        timestep: Time step of the engine, s.

    Raises:
        InvalidParameter: If height or timestep is outside any sensible range.
        InvalidWorld: If the coordinates need more than 64 bits.
    """
    # Collect the parts of the world.
    check_between("timestep", timestep, *TIMESTEPS, "s")
    name = plain_name(destination)
    parts = scene(world, destination, height)
    tall = exact(height)
    lines = [
        '<?xml version="1.0"?>',
        f'<sdf version="1.9" xmlns:worldgen="{_SCHEMA}">',
        f'  <world name="{name}">',
        *_head(world, destination, timestep),
        *(f'    <plugin filename="{file}" name="{system}"/>' for file, system in _SYSTEMS[plugins]),
        *_light(parts.floor, tall),
        *_ground(parts.floor),
        *_walls(parts.still),
        *_marks(world, destination),
        *(line for body in parts.bodies for line in _moving(body, tall)),
        *(_robots(world, destination, plugins) if robot else ()),
        "  </world>",
        "</sdf>",
    ]
    # Add the player if something changes.
    player = player_files(destination, "gazebo_player.py", parts.bodies, height, name)
    notes = [
        f"{script} moves the cells that change, because a world file has no events"
        for script in [*player][:1]
    ]
    others = [one for one in world.robots if not one.is_disc and body_box(one) is None]
    if others:
        notes.append(
            f"the robot's {len(others[0].footprint)} corners are stored as a number, but drawn as a "
            f"disc of {others[0].radius:.6g} m that holds them: only rectangles become boxes"
        )
    # Many boxes make Gazebo slow.
    boxes = len(parts.still) + len(parts.bodies)
    if boxes > _MANY:
        notes.append(
            f"{boxes} boxes: Gazebo falls behind real time; doubling the boxes makes a step take "
            f"four times as long"
        )
    return Exported(
        {destination.name: ("\n".join(lines) + "\n").encode(), **player}, notes=tuple(notes)
    )


def _head(world: World, destination: Destination, timestep: float) -> Iterator[str]:
    """Yield physics, gravity and the grid's frame, and our elements for facts SDFormat lacks."""
    rate = text(Fraction(round(1 / exact(timestep))))
    x, y = (decimal(value) for value in destination.origin)
    yield from (
        '    <physics name="steps" type="ignored">',
        f"      <max_step_size>{decimal(timestep)}</max_step_size>",
        "      <real_time_factor>1</real_time_factor>",
        f"      <real_time_update_rate>{rate}</real_time_update_rate>",
        "    </physics>",
        "    <gravity>0 0 -9.8</gravity>",
        f'    <frame name="grid"><pose>{x} {y} 0 0 0 0</pose></frame>',
    )
    yield grid_line(world, destination)
    numbers = {"robot_radius": world.robot_radius, "robot_speed": world.robot_speed}
    yield from (
        f"    <worldgen:{key}>{decimal(value)}</worldgen:{key}>" for key, value in numbers.items()
    )
    for word in [kind_words(robot).get("footprint") for robot in world.robots]:
        if word is not None:
            yield f"    <worldgen:footprint>{word}</worldgen:footprint>"


def _light(floor: PlacedBox, tall: Fraction) -> Iterator[str]:
    yield from (
        '    <light type="directional" name="sun">',
        f"      <pose>{_pose(floor, 10 * tall)}</pose>",
        "      <cast_shadows>true</cast_shadows>",
        "      <diffuse>0.8 0.8 0.8 1</diffuse>",
        "      <direction>-0.3 -0.2 -1</direction>",
        "    </light>",
    )


def _shapes(
    kind: str, name: str, geometry: str, colour: str, pose: str = "", surface: str = ""
) -> Iterator[str]:
    """Yield a shape; ``kind`` makes it solid or only visible."""
    inside = f"{f'<pose>{pose}</pose>' if pose else ''}<geometry>{geometry}</geometry>"
    if kind == "solid":
        yield f'        <collision name="{name}">{inside}{surface}</collision>'
    paint = f"<material><ambient>{colour}</ambient><diffuse>{colour}</diffuse></material>"
    yield f'        <visual name="{name}_seen">{inside}{paint}</visual>'


def _model(name: str, pose: str, shapes: Iterator[str]) -> Iterator[str]:
    """Yield a static model.

    It writes ``1`` because some readers take ``true`` for 0 and let the walls fall.
    """
    yield f'    <model name="{name}">'
    yield "      <static>1</static>"
    if pose:
        yield f"      <pose>{pose}</pose>"
    yield '      <link name="link">'
    yield from shapes
    yield "      </link>"
    yield "    </model>"


def _ground(floor: PlacedBox) -> Iterator[str]:
    size = " ".join(map(text, floor.size[:2]))
    plane = f"<plane><normal>0 0 1</normal><size>{size}</size></plane>"
    yield from _model(
        "ground", _pose(floor, Fraction(0)), _shapes("solid", "floor", plane, _COLOURS["ground"])
    )


def _pose(box: PlacedBox, z: Fraction) -> str:
    """Return a pose above or below the middle of a box."""
    return f"{' '.join(map(text, (*box.centre[:2], z)))} 0 0 0"


def _cuboid(box: PlacedBox) -> str:
    return f"<box><size>{' '.join(map(text, box.size))}</size></box>"


def _walls(boxes: tuple[PlacedBox, ...]) -> Iterator[str]:
    def shapes() -> Iterator[str]:
        for box in boxes:
            yield from _shapes(
                "solid", box.name, _cuboid(box), _COLOURS["wall"], _pose(box, box.centre[2])
            )

    if boxes:
        yield from _model("walls", "", shapes())


def _marks(world: World, destination: Destination) -> Iterator[str]:
    """Yield the starts and targets, which are only visible; a start is as large as its robot."""
    for number, robot in enumerate(world.robots, start=1):
        start = robot.start
        target = robot.target
        for name, x, y, heading, box, radius in (
            ("start", start.x, start.y, start.heading, body_box(robot), robot.radius),
            ("target", target.x, target.y, target.heading or 0.0, None, target.radius),
        ):
            pose = f"{destination.x(x)} {destination.y(y)} {text(_THIN / 2)} 0 0 {decimal(heading)}"
            shape, place = _cylinder(exact(radius), _THIN), ""
            if box is not None:
                shape, place = _body_box(box, _THIN)
            shapes = _shapes("seen", "disc", shape, _COLOURS[name], place)
            yield from _model(numbered(name, number), pose, shapes)


def _moving(body: Body, tall: Fraction) -> Iterator[str]:
    """Yield a cell that the script moves.

    A burning cell has no collision, because fire does not stop anything.
    """
    pose = _pose(body.box, body.box.centre[2] if body.shown else -tall)
    kind, colour = ("seen", _COLOURS["fire"]) if body.burning else ("solid", _COLOURS["cell"])
    yield from _model(body.name, pose, _shapes(kind, "box", _cuboid(body.box), colour))


def _robots(world: World, destination: Destination, plugins: str) -> Iterator[str]:
    """Yield the model ``robot`` at the start, and ``robot_2`` and so on for the others.

    Each is a cylinder of its robot's radius, or a box, with joints ``left_joint`` and
    ``right_joint``. The wheels are in the largest disc about the axle that the body holds.

    Args:
        world: The world.
        destination: Gives the position of the grid's lower-left corner.
        plugins: A key of ``_SYSTEMS``; with any but ``none`` the robot takes velocity commands.
    """
    for number, robot in enumerate(world.robots, start=1):
        yield from _robot(robot, numbered("robot", number), destination, plugins)


def _robot(robot: Robot, name: str, destination: Destination, plugins: str) -> Iterator[str]:
    box = body_box(robot)
    # The wheels of a body are inside it; a disc that holds it has more room.
    radius = exact(robot.radius if box is None else robot.inner_radius)
    if radius <= 0:
        raise InvalidWorld(
            "axle-outside",
            "the robot's axle is outside its footprint, so there is no room for wheels",
            "export it without +robot",
        )
    start = robot.start
    yield f'    <model name="{name}">'
    yield (
        f"      <pose>{destination.x(start.x)} {destination.y(start.y)} 0 0 0 "
        f"{decimal(start.heading)}</pose>"
    )
    yield from _chassis(radius, box)
    for wheel, side in (("left", 1), ("right", -1)):
        yield from _wheel(wheel, side, radius)
    if plugins in _DRIVES:
        yield from _drive(*_DRIVES[plugins], radius, robot.speed)
    yield "    </model>"


def _inertial(mass: Fraction, about: Fraction, across: Fraction, *, axis: str) -> str:
    """Return the inertia of a flat disc: turning about its axis is twice as hard as across it."""
    moments = {name: text(about if name == axis * 2 else across) for name in ("xx", "yy", "zz")}
    inside = "".join(f"<i{name}>{value}</i{name}>" for name, value in moments.items())
    return f"        <inertial><mass>{text(mass)}</mass><inertia>{inside}</inertia></inertial>"


def _robot_part(name: str, pose: str, geometry: str, surface: str = "") -> Iterator[str]:
    yield from _shapes("solid", name, geometry, _COLOURS["robot"], pose, surface)


def _cylinder(radius: Fraction, length: Fraction) -> str:
    return f"<cylinder><radius>{text(radius)}</radius><length>{text(length)}</length></cylinder>"


def _body_box(box: BodyBox, tall: Fraction) -> tuple[str, str]:
    """Return a body's box, and its pose seen from the axle."""
    size = " ".join(map(text, (box.length, box.width, tall)))
    return f"<box><size>{size}</size></box>", f"{text(box.ahead)} {text(box.left)} 0 0 0 0"


def _chassis(radius: Fraction, box: BodyBox | None) -> Iterator[str]:
    smooth = "<surface><friction><ode><mu>0</mu><mu2>0</mu2></ode></friction></surface>"
    about = _MASS * radius**2 / 2
    yield '      <link name="chassis">'
    middle = text(radius * (_GAP + _TALL / 2))
    yield f"        <pose>0 0 {middle} 0 0 0</pose>"
    yield _inertial(_MASS, about, about / 2, axis="z")
    body, pose = _cylinder(radius, radius * _TALL), "0 0 0 0 0 0"
    if box is not None:
        body, pose = _body_box(box, radius * _TALL)
    yield from _robot_part("disc" if box is None else "box", pose, body, smooth)
    ball = radius * _GAP / 2
    for name, side in (("front", 1), ("back", -1)):
        pose = (
            f"{text(side * radius * _CASTER_AT)} 0 {text(ball - radius * (_GAP + _TALL / 2))} 0 0 0"
        )
        yield from _robot_part(
            f"{name}_caster", pose, f"<sphere><radius>{text(ball)}</radius></sphere>", smooth
        )
    yield "      </link>"


def _wheel(name: str, side: int, radius: Fraction) -> Iterator[str]:
    wheel = radius * _WHEEL
    about = _WHEEL_MASS * wheel**2 / 2
    yield f'      <link name="{name}_wheel">'
    yield f"        <pose>0 {text(side * radius * _WHEEL_AT)} {text(wheel)} 0 0 0</pose>"
    yield _inertial(_WHEEL_MASS, about, about / 2, axis="y")
    yield from _robot_part(
        "wheel", "0 0 0 1.5707963267948966 0 0", _cylinder(wheel, radius * _WHEEL_WIDTH)
    )
    yield "      </link>"
    yield f'      <joint name="{name}_joint" type="revolute">'
    yield f"        <parent>chassis</parent><child>{name}_wheel</child>"
    yield (
        "        <axis><xyz>0 1 "
        "0</xyz><limit><lower>-1e16</lower><upper>1e16</upper></limit></axis>"
    )
    yield "      </joint>"


def _drive(file: str, system: str, radius: Fraction, speed: float) -> Iterator[str]:
    """Yield the systems; commands arrive on the topic ``/model/NAME/cmd_vel``."""
    numbers = {
        "left_joint": "left_joint",
        "right_joint": "right_joint",
        "wheel_separation": text(2 * radius * _WHEEL_AT),
        "wheel_radius": text(radius * _WHEEL),
        "max_linear_velocity": decimal(speed),
        "min_linear_velocity": decimal(-speed),
    }
    yield f'      <plugin filename="{file}" name="{system}">'
    yield from (f"        <{key}>{value}</{key}>" for key, value in numbers.items())
    yield "      </plugin>"


sdf = Format(
    "sdf",
    "world or model of Gazebo, .sdf, .world",
    (".sdf",),
    re.compile(
        rb"(?s)(?:\xef\xbb\xbf)?\s*+(?:<\?(?:(?!\?>).)*+\?>\s*+|<!--(?:(?!-->).)*+-->\s*+)*+"
        rb"(?:<!DOCTYPE.*?>\s*)?<(?:sdf|gazebo)\b"
    ),
    read_gazebo_world,
    write_sdf,
    holds=PLAIN_FACTS | {"footprint"},
    changes=True,
    robots=True,
    client="Gazebo, PyBullet",
    most_bytes=MAX_BYTES,
    harmless=GAZEBO_HARMLESS,
    usual_robot=FLOOR_ROBOT,
)
