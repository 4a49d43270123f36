"""Export a world as SDFormat 1.9, for Gazebo and other programs that read it.

The world is a static model of boxes, with a floor, marks and a robot. A world file has no clock, so
cells that change with time become models that a script moves.

Source: the SDFormat 1.9 specification.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from importlib import resources
from typing import Literal

from worldgen.interop.format import HELD, Destination, Exported, Format, decimal
from worldgen.interop.format import decimal_text as text
from worldgen.interop.geometry.placed_boxes import PlacedBox
from worldgen.interop.geometry.solid_scene import (
    TIMESTEPS,
    Body,
    events_file,
    numbered,
    plain_name,
    scene,
)
from worldgen.interop.players.sdf_robot import SYSTEMS, robot_lines
from worldgen.interop.readers.gazebo_world import grid_line
from worldgen.lattice import exact
from worldgen.support.bounds import check_between
from worldgen.world import World

__all__ = ["sdf", "write_sdf"]

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
}


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
        *(f'    <plugin filename="{file}" name="{system}"/>' for file, system in SYSTEMS[plugins]),
        *_light(parts.floor, tall),
        *_ground(parts.floor),
        *_walls(parts.still),
        *_marks(world, destination),
        *(line for body in parts.bodies for line in _moving(body, tall)),
        *(robot_lines(world, destination, plugins) if robot else ()),
        "  </world>",
        "</sdf>",
    ]
    # Add the player if something changes.
    files = {destination.name: ("\n".join(lines) + "\n").encode()}
    notes = []
    if parts.bodies:
        script = destination.sibling_file("_player.py")
        table = destination.sibling_file("_events.json")
        files[script] = (
            resources.files("worldgen.interop").joinpath("players", "gazebo_player.py").read_bytes()
        )
        files[table] = events_file(destination.name, parts.bodies, height, world=name)
        notes.append(f"{script} moves the cells that change, because a world file has no events")
    # Many boxes make Gazebo slow.
    boxes = len(parts.still) + len(parts.bodies)
    if boxes > _MANY:
        notes.append(
            f"{boxes} boxes: Gazebo falls behind real time; doubling the boxes makes a step take "
            f"four times as long"
        )
    return Exported(files, notes=tuple(notes))


def _head(world: World, destination: Destination, timestep: float) -> Iterator[str]:
    """Yield physics, gravity and the grid's frame, and our own elements for facts SDFormat lacks."""
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


def _light(floor: PlacedBox, tall: Fraction) -> Iterator[str]:
    yield from (
        '    <light type="directional" name="sun">',
        f"      <pose>{_pose(floor, 10 * tall)}</pose>",
        "      <cast_shadows>true</cast_shadows>",
        "      <diffuse>0.8 0.8 0.8 1</diffuse>",
        "      <direction>-0.3 -0.2 -1</direction>",
        "    </light>",
    )


def _shapes(kind: str, name: str, geometry: str, colour: str, pose: str = "") -> Iterator[str]:
    """Yield a shape; ``kind`` makes it solid or only visible."""
    inside = f"{f'<pose>{pose}</pose>' if pose else ''}<geometry>{geometry}</geometry>"
    if kind == "solid":
        yield f'        <collision name="{name}">{inside}</collision>'
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
    """Yield starts and targets as discs that are only visible; a start's shows the heading."""
    for number, robot in enumerate(world.robots, start=1):
        start = robot.start
        target = robot.target
        for name, x, y, heading, radius in (
            ("start", start.x, start.y, start.heading, robot.radius),
            ("target", target.x, target.y, 0.0, target.radius),
        ):
            pose = f"{destination.x(x)} {destination.y(y)} {text(_THIN / 2)} 0 0 {decimal(heading)}"
            size = f"<radius>{decimal(radius)}</radius><length>{text(_THIN)}</length>"
            disc = f"<cylinder>{size}</cylinder>"
            shapes = _shapes("seen", "disc", disc, _COLOURS[name])
            yield from _model(numbered(name, number), pose, shapes)


def _moving(body: Body, tall: Fraction) -> Iterator[str]:
    """Yield a cell that the script moves.

    A burning cell has no collision, because fire does not stop anything.
    """
    pose = _pose(body.box, body.box.centre[2] if body.shown else -tall)
    kind, colour = ("seen", _COLOURS["fire"]) if body.burning else ("solid", _COLOURS["cell"])
    yield from _model(body.name, pose, _shapes(kind, "box", _cuboid(body.box), colour))


sdf = Format(
    "sdf",
    "world of Gazebo, SDFormat 1.9, .sdf",
    (".sdf",),
    write=write_sdf,
    holds=frozenset(HELD),
    changes=True,
    robots=True,
    client="Gazebo, PyBullet",
)
