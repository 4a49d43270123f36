"""A disc on two wheels for Gazebo, and the systems that move it, by release."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from worldgen.interop.format import Destination, decimal
from worldgen.interop.format import decimal_text as text
from worldgen.interop.geometry.solid_scene import numbered
from worldgen.lattice import exact
from worldgen.world import Robot, World

__all__ = ["SYSTEMS", "robot_lines"]

SYSTEMS: dict[str, tuple[tuple[str, str], ...]] = {"none": ()} | {
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


def robot_lines(world: World, destination: Destination, plugins: str) -> Iterator[str]:
    """Yield the model ``robot`` at the start, and ``robot_2`` and so on for the others.

    Each is a cylinder of its robot's radius, with joints ``left_joint`` and ``right_joint``.

    Args:
        world: The world.
        destination: Gives the position of the grid's lower-left corner.
        plugins: A key of ``SYSTEMS``; with any but ``none`` the robot takes velocity commands.
    """
    for number, robot in enumerate(world.robots, start=1):
        yield from _model(robot, numbered("robot", number), destination, plugins)


def _model(robot: Robot, name: str, destination: Destination, plugins: str) -> Iterator[str]:
    radius = exact(robot.radius)
    start = robot.start
    yield f'    <model name="{name}">'
    yield (
        f"      <pose>{destination.x(start.x)} {destination.y(start.y)} 0 0 0 "
        f"{decimal(start.heading)}</pose>"
    )
    yield from _chassis(radius)
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


def _both(name: str, pose: str, geometry: str, surface: str = "") -> Iterator[str]:
    inside = f"<pose>{pose}</pose><geometry>{geometry}</geometry>"
    yield f'        <collision name="{name}">{inside}{surface}</collision>'
    paint = "<material><ambient>0.1 0.4 0.9 1</ambient><diffuse>0.1 0.4 0.9 1</diffuse></material>"
    yield f'        <visual name="{name}_seen">{inside}{paint}</visual>'


def _cylinder(radius: Fraction, length: Fraction) -> str:
    return f"<cylinder><radius>{text(radius)}</radius><length>{text(length)}</length></cylinder>"


def _chassis(radius: Fraction) -> Iterator[str]:
    smooth = "<surface><friction><ode><mu>0</mu><mu2>0</mu2></ode></friction></surface>"
    about = _MASS * radius**2 / 2
    yield '      <link name="chassis">'
    middle = text(radius * (_GAP + _TALL / 2))
    yield f"        <pose>0 0 {middle} 0 0 0</pose>"
    yield _inertial(_MASS, about, about / 2, axis="z")
    yield from _both("disc", "0 0 0 0 0 0", _cylinder(radius, radius * _TALL), smooth)
    ball = radius * _GAP / 2
    for name, side in (("front", 1), ("back", -1)):
        pose = (
            f"{text(side * radius * _CASTER_AT)} 0 {text(ball - radius * (_GAP + _TALL / 2))} 0 0 0"
        )
        yield from _both(
            f"{name}_caster", pose, f"<sphere><radius>{text(ball)}</radius></sphere>", smooth
        )
    yield "      </link>"


def _wheel(name: str, side: int, radius: Fraction) -> Iterator[str]:
    wheel = radius * _WHEEL
    about = _WHEEL_MASS * wheel**2 / 2
    yield f'      <link name="{name}_wheel">'
    yield f"        <pose>0 {text(side * radius * _WHEEL_AT)} {text(wheel)} 0 0 0</pose>"
    yield _inertial(_WHEEL_MASS, about, about / 2, axis="y")
    yield from _both(
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
