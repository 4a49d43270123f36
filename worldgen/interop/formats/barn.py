"""Worlds in the style of the BARN challenge: Gazebo worlds with a round post for each solid cell.

Source: Daffan/the-barn-challenge, ``jackal_helper/worlds/BARN`` and ``run.py``; the SDFormat
    specification, 1.6.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from worldgen.errors import Note
from worldgen.interop.format import (
    PLAIN_FACTS,
    Destination,
    Exported,
    Format,
    decimal,
    decimal_text,
)
from worldgen.interop.geometry.boxes import closing_boxes
from worldgen.interop.readers.gazebo_world import OURS, grid_line
from worldgen.lattice import exact
from worldgen.world import World

# Posts above which the export warns; BARN's densest world has about 400.
_MANY = 2000
# Height of a post, m.
_HEIGHT = "1"
_HEAD = """\
<?xml version='1.0'?>
<sdf version='1.6' xmlns:worldgen='urn:worldgen:sdf'>
  <world name='default'>
    <light name='sun' type='directional'>
      <pose>0 0 10 0 0 0</pose>
      <direction>-0.5 0.5 -1</direction>
    </light>
    <model name='ground_plane'>
      <static>1</static>
      <link name='link'>
        <collision name='collision'>
          <geometry><plane><normal>0 0 1</normal><size>100 100</size></plane></geometry>
        </collision>
        <visual name='visual'>
          <geometry><plane><normal>0 0 1</normal><size>100 100</size></plane></geometry>
        </visual>
      </link>
    </model>
    <gravity>0 0 -9.8</gravity>
    <physics name='default_physics' default='0' type='ode'>
      <max_step_size>0.001</max_step_size>
      <real_time_factor>1</real_time_factor>
      <real_time_update_rate>1000</real_time_update_rate>
    </physics>"""


def write_barn(world: World, destination: Destination) -> Exported:
    """Return the world file."""
    posts = list(_posts(world))
    lines = [_HEAD, *_numbers(world, destination), *_marks(world, destination)]
    lines += [
        line
        for number, post in enumerate(posts)
        for line in _post(number, post, world, destination)
    ]
    lines += ["  </world>", "</sdf>"]
    x, y = (
        decimal(value, shift)
        for value, shift in zip((world.start.x, world.start.y), destination.origin, strict=True)
    )
    goal = [
        decimal_text(exact(to) - exact(at))
        for to, at in ((world.target.x, world.start.x), (world.target.y, world.start.y))
    ]
    notes = [
        f"in the challenge's run.py: INIT_POSITION = [{x}, {y}, {decimal(world.start.heading)}], "
        f"GOAL_POSITION = [{goal[0]}, {goal[1]}]",
        "posts are round, so there is more room between them, and at the corners of walls, than "
        "between the world's square cells",
    ]
    if len(posts) > _MANY:
        notes.append(
            Note(
                "many-posts",
                "{count} posts: Gazebo takes a long time to load them",
                "--to sdf writes fewer, larger boxes",
                at_terminal=True,
                count=len(posts),
            )
        )
    return Exported({destination.name: ("\n".join(lines) + "\n").encode()}, notes=tuple(notes))


def _posts(world: World) -> Iterator[tuple[int, int]]:
    """Yield the columns and rows of solid cells, and of the ring around an open border."""
    yield from ((int(ix), int(iy)) for iy, ix in np.argwhere(world.walls))
    for left, low, right, high in closing_boxes(world).tolist():
        yield from ((ix, iy) for iy in range(low, high) for ix in range(left, right))


def _numbers(world: World, destination: Destination) -> Iterator[str]:
    """Yield the facts that the format has no element for.

    These are the grid's corner, sides and cell size, and the robot's speed.
    """
    yield grid_line(world, destination)
    yield f"    <{OURS}robot_speed>{decimal(world.robot_speed)}</{OURS}robot_speed>"


def _marks(world: World, destination: Destination) -> Iterator[str]:
    """Yield the robot's disc at its start and the target's disc, both without collision."""
    start = world.start
    target = world.target
    for name, x, y, heading, radius, colour in (
        ("start", start.x, start.y, start.heading, world.robot_radius, "0.1 0.4 0.9 0.6"),
        ("target", target.x, target.y, 0.0, target.radius, "0.1 0.7 0.2 0.6"),
    ):
        pose = f"{destination.x(x)} {destination.y(y)} 0.001 0 0 {decimal(heading)}"
        yield from _model(name, pose, decimal(radius), "0.002", colour, stops=False)


def _post(
    number: int, cell: tuple[int, int], world: World, destination: Destination
) -> Iterator[str]:
    side = exact(world.cell_size)
    x, y = (
        (2 * index + 1) * side / 2 + exact(shift)
        for index, shift in zip(cell, destination.origin, strict=True)
    )
    pose = f"{decimal_text(x)} {decimal_text(y)} 0 0 0 0"
    yield from _model(
        f"unit_cylinder_{number}",
        pose,
        decimal_text(side / 2),
        _HEIGHT,
        "0.152 0.379 0.72 1",
        stops=True,
    )


def _model(
    name: str, pose: str, radius: str, length: str, colour: str, *, stops: bool
) -> Iterator[str]:
    geometry = f"<geometry><cylinder><radius>{radius}</radius><length>{length}</length></cylinder></geometry>"
    yield f"    <model name='{name}'>"
    yield "      <static>1</static>"
    yield f"      <pose>{pose}</pose>"
    yield "      <link name='link'>"
    if stops:
        yield f"        <collision name='collision'>{geometry}</collision>"
    paint = f"<material><ambient>{colour}</ambient><diffuse>{colour}</diffuse></material>"
    yield f"        <visual name='visual'>{geometry}{paint}</visual>"
    yield "      </link>"
    yield "    </model>"


barn = Format(
    "barn",
    "BARN world of posts, .world",
    (".world",),
    write=write_barn,
    holds=PLAIN_FACTS,
    client="Gazebo",
)
