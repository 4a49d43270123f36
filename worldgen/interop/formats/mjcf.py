"""Export a world as MJCF, MuJoCo's XML.

The file has boxes in the world's body, sites at start and target, and optionally a disc robot. A
model has no clock, so cells that change with time become bodies that a script moves.

Source: MuJoCo's XML reference.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

from worldgen.interop.format import PLAIN_FACTS, Destination, Exported, Format, decimal
from worldgen.interop.format import decimal_text as text
from worldgen.interop.geometry.solid_scene import (
    TIMESTEPS,
    Body,
    SolidScene,
    numbered,
    plain_name,
    player_files,
    scene,
)
from worldgen.lattice import exact
from worldgen.parameters.bounds import check_between
from worldgen.world import Robot, World

# Half the thickness of a mark, m.
_THIN = "0.001"
# Mass of each of the robot's two bodies, kg: one slides, the other turns on it.
_MASS = "0.5"


def write_mjcf(
    world: World,
    destination: Destination,
    *,
    height: float = 1.0,
    robot: bool = False,
    timestep: float = 0.002,
) -> Exported:
    """Return the model and, if the world changes, a script and the table that it plays.

    Args:
        world: The world.
        destination: Where the file is written.
        height: Height of the walls, m.
        robot: True to add a disc at the start that slides in x and y and turns, with a velocity
            actuator for each.
        timestep: Time step of the engine, s.

    Raises:
        InvalidParameter: If height or timestep is outside any sensible range.
        InvalidWorld: If the coordinates need more than 64 bits.
    """
    check_between("timestep", timestep, *TIMESTEPS, "s")
    parts = scene(world, destination, height)
    lines = [
        f'<mujoco model="{plain_name(destination)}">',
        '  <compiler angle="radian"/>',
        f'  <option timestep="{decimal(timestep)}"/>',
        *_numbers(world, destination),
        *(_bodies(world, height) if robot else ()),
        "  <worldbody>",
        *_surroundings(parts, height),
        *_marks(world, destination),
        *(line for body in parts.bodies for line in _mocap(body, height)),
        *(
            line
            for number in range(1, len(world.robots) + 1 if robot else 1)
            for line in _robot(world.robots[number - 1], number, destination, height, timestep)
        ),
        "  </worldbody>",
        *(_actuators(world) if robot else ()),
        "</mujoco>",
    ]
    player = player_files(destination, "mujoco_player.py", parts.bodies, height)
    notes = tuple(
        f"{script} moves the cells that change, because a MuJoCo model has no events"
        for script in [*player][:1]
    )
    return Exported({destination.name: ("\n".join(lines) + "\n").encode(), **player}, notes=notes)


def _numbers(world: World, destination: Destination) -> Iterator[str]:
    """Yield facts other than geometry, as numbers that a model can store."""
    x, y = (decimal(value) for value in destination.origin)
    numbers = {
        "cell_size": decimal(world.cell_size),
        "origin": f"{x} {y}",
        "robot_radius": decimal(world.robot_radius),
        "robot_speed": decimal(world.robot_speed),
    }
    if not world.robots[0].is_disc:
        corners = (value for corner in world.robots[0].footprint for value in corner)
        numbers["footprint"] = " ".join(map(decimal, corners))
    yield "  <custom>"
    yield from (f'    <numeric name="{name}" data="{data}"/>' for name, data in numbers.items())
    yield "  </custom>"


def _bodies(world: World, height: float) -> Iterator[str]:
    """Yield the bodies with a footprint as prisms, which MuJoCo takes for their convex hull."""
    half = exact(height) / 4
    meshes = []
    for number, robot in enumerate(world.robots, start=1):
        points = (
            f"{decimal(x)} {decimal(y)} {text(z)}"
            for z in (-half, half)
            for x, y in robot.footprint
        )
        if not robot.is_disc:
            name = numbered("robot", number)
            meshes.append(f'    <mesh name="{name}_body" vertex="{"  ".join(points)}"/>')
    if meshes:
        yield from ("  <asset>", *meshes, "  </asset>")


def _surroundings(parts: SolidScene, height: float) -> Iterator[str]:
    floor = parts.floor
    half = exact(height) / 2
    place = _numbers_of(floor.centre[:2])
    yield (
        f'    <light name="sun" directional="true" pos="{place} {text(4 * half)}" dir="-0.3 '
        f"-0.2 "
        f'-1"/>'
    )
    size = f"{_numbers_of(floor.size[:2], 2)} 1"
    yield (
        f'    <geom name="floor" type="plane" pos="{place} 0" size="{size}" rgba="0.9 0.9 0.9 1"/>'
    )
    for box in parts.still:
        at = f'type="box" pos="{_numbers_of(box.centre)}" size="{_numbers_of(box.size, 2)}"'
        yield f'    <geom name="{box.name}" {at} rgba="0.3 0.3 0.35 1"/>'


def _numbers_of(values: Sequence[Fraction], share: int = 1) -> str:
    """Divide values by a number, because MJCF gives half sizes."""
    return " ".join(text(value / share) for value in values)


def _marks(world: World, destination: Destination) -> Iterator[str]:
    """Yield starts and targets as sites, which are drawn, but not hit by rays and bodies."""
    for number, robot in enumerate(world.robots, start=1):
        start = robot.start
        target = robot.target
        for name, x, y, radius, more in (
            (
                "start",
                start.x,
                start.y,
                robot.radius,
                f'euler="0 0 {decimal(start.heading)}" rgba="0.1 0.4 0.9 0.6"',
            ),
            ("target", target.x, target.y, target.radius, 'rgba="0.1 0.7 0.2 0.6"'),
        ):
            place = f"{destination.x(x)} {destination.y(y)} {_THIN}"
            if name == "start" and not robot.is_disc:
                yield from _outline(robot, numbered(name, number), place, more)
                continue
            yield (
                f'    <site name="{numbered(name, number)}" type="cylinder" pos="{place}" '
                f'size="{decimal(radius)} {_THIN}" {more}/>'
            )


def _outline(robot: Robot, name: str, place: str, more: str) -> Iterator[str]:
    """Yield a footprint at the start as thin rods along its sides; a site cannot be a mesh."""
    turn, _, paint = more.partition(" rgba")
    yield f'    <body name="{name}" pos="{place}" {turn}>'
    ends = (*robot.footprint[1:], robot.footprint[0])
    for side, corners in enumerate(zip(robot.footprint, ends, strict=True), start=1):
        line = " 0 ".join(f"{decimal(x)} {decimal(y)}" for x, y in corners)
        rod = f'type="capsule" fromto="{line} 0" size="{decimal(robot.radius / 50)}" rgba{paint}'
        yield f'      <site name="{name}_side_{side}" {rod}/>'
    yield "    </body>"


def _mocap(body: Body, height: float) -> Iterator[str]:
    """Yield a cell that the script moves.

    It is solid, or a site if it burns, because fire does not stop anything.
    """
    *place, z = body.box.centre
    at = _numbers_of((*place, z if body.shown else -exact(height)))
    yield f'    <body name="{body.name}" mocap="true" pos="{at}">'
    kind, colour = ("site", "1 0.4 0.1 0.7") if body.burning else ("geom", "0.5 0.4 0.3 1")
    yield (
        f'      <{kind} name="{body.name}" type="box" size="{_numbers_of(body.box.size, 2)}" '
        f'rgba="{colour}"/>'
    )
    yield "    </body>"


def _robot(
    robot: Robot, number: int, destination: Destination, height: float, timestep: float
) -> Iterator[str]:
    """Yield a body that hovers, so that the floor's friction does not act on it.

    Its coordinates are in the file's frame.
    """
    name = numbered("robot", number)
    x = destination.x(robot.start.x)
    y = destination.y(robot.start.y)
    heading = decimal(robot.start.heading)
    half = exact(height) / 2
    # The stiffest contact that MuJoCo keeps stable: two steps.
    stiff = text(2 * exact(timestep))
    yield f'    <body name="{name}" pos="{x} {y} {text(half)}">'
    yield f'      <joint name="{name}_x" type="slide" axis="1 0 0" ref="{x}"/>'
    yield f'      <joint name="{name}_y" type="slide" axis="0 1 0" ref="{y}"/>'
    yield f'      <inertial pos="0 0 0" mass="{_MASS}" diaginertia="0.001 0.001 0.001"/>'
    yield f'      <body name="{name}_disc" euler="0 0 {heading}">'
    yield f'        <joint name="{name}_heading" type="hinge" axis="0 0 1" ref="{heading}"/>'
    shape = f'type="cylinder" size="{decimal(robot.radius)} {text(half / 2)}"'
    if not robot.is_disc:
        shape = f'type="mesh" mesh="{name}_body"'
    yield (
        f'        <geom name="{name}" {shape} mass="{_MASS}" condim="1" '
        f'priority="1" '
        f'solref="{stiff} 1" rgba="0.1 0.4 0.9 1"/>'
    )
    nose = text(exact(robot.inner_radius or robot.radius) / 2)
    front = f'type="sphere" pos="{nose} 0 {text(half / 2)}" size="{nose}"'
    yield f'        <site name="{name}_front" {front} rgba="1 1 1 1"/>'
    yield "      </body>"
    yield "    </body>"


def _actuators(world: World) -> Iterator[str]:
    """Yield a velocity actuator per joint: along x and y, m/s, and turning, rad/s."""
    yield "  <actuator>"
    for number, robot in enumerate(world.robots, start=1):
        yield from _velocities(numbered("robot", number), decimal(robot.speed))
    yield "  </actuator>"


def _velocities(name: str, fastest: str) -> Iterator[str]:
    for axis in ("x", "y"):
        yield (
            f'    <velocity name="{name}_v{axis}" joint="{name}_{axis}" kv="20" '
            f'ctrlrange="-{fastest} {fastest}" '
            'ctrllimited="true"/>'
        )
    yield f'    <velocity name="{name}_turn" joint="{name}_heading" kv="0.1"/>'


mjcf = Format(
    "mjcf",
    "MuJoCo model, .xml",
    (".xml",),
    write=write_mjcf,
    holds=PLAIN_FACTS | {"footprint"},
    changes=True,
    robots=True,
    client="MuJoCo",
)
