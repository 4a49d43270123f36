"""Stage worlds: a text file of models, and the floor plan as a picture.

Source: rtv/Stage 4.3, ``worldfile.cc``, ``blockgroup.cc`` and ``model_position.cc``.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np

from worldgen.errors import InvalidParameter
from worldgen.interop.format import (
    HELD,
    Destination,
    Exported,
    Format,
    decimal,
    decimal_text,
    degrees_text,
)
from worldgen.interop.format.foreign_map import FLOOR_ROBOT
from worldgen.interop.geometry.boxes import closing_boxes
from worldgen.interop.geometry.solid_scene import numbered
from worldgen.interop.readers.grey_image import walls_png
from worldgen.interop.readers.stage_world import RINGED, TARGET, read_stage
from worldgen.lattice import exact
from worldgen.world import Robot, World

# Stage's own map.inc lets robots drive through a floor plan (obstacle_return 0) and adds its own
# box (boundary 1).
_WALLS = """\
define floorplan model
(
  color "gray30"
  boundary 0
  gui_nose 0
  gui_grid 0
  gui_move 0
  gui_outline 0
  obstacle_return 1
  ranger_return 1
  fiducial_return 0
  gripper_return 0
)
"""
_TARGET = """\
define goal model
(
  color "green"
  gui_nose 0
  gui_outline 0
  obstacle_return 0
  ranger_return -1
  fiducial_return 0
  gripper_return 0
)
"""
# A polygon of 16 corners in the robot's disc; four are on the axes, so that Stage stretches it to
# exactly the right size.
_QUADRANT = (("1", "0"), ("0.9238", "0.3826"), ("0.7071", "0.7071"), ("0.3826", "0.9238"))
# Height of walls and robot, m; a ranger is mounted on top of its robot and must not see over walls.
_TALL = "0.8"
_LOW = "0.2"
# Turn rate, degrees/s; our worlds have no limit.
_TURN_RATE = "360"


def write_stage(world: World, destination: Destination, *, lidar: bool = False) -> Exported:
    """Return the world file and the picture of the walls.

    Args:
        world: The world.
        destination: Where the file is written.
        lidar: True to give the robot a ranger with 257 beams over a full turn (the last one equals
            the first) and a range of 10 m.

    Raises:
        InvalidParameter: If the file's name has a quotation mark, which Stage cannot escape.
    """
    ringed = len(closing_boxes(world)) > 0
    picture = destination.sibling_file(".png")
    if '"' in picture:
        raise InvalidParameter(
            "not-a-file-name",
            "{picture} has a quotation mark, which Stage cannot read",
            "use a name without one",
            picture=picture,
        )
    lines = [
        "# A world made by worldgen for Stage; m, degrees.",
        "# Walls and rays are exact to this, a tenth of a cell.",
        f"resolution {decimal_text(exact(world.cell_size) / 10)}",
        "",
        _WALLS,
        _disc(),
        _TARGET,
        *_floor_plan(world, destination, picture, ringed),
    ]
    for number, robot in enumerate(world.robots, start=1):
        lines += _robot(robot, number, destination, lidar)
        lines += _target(robot, number, destination)
    solid = np.pad(world.walls, 1, constant_values=True) if ringed else world.walls
    files = {destination.name: ("\n".join(lines)).encode(), picture: walls_png(solid)}
    return Exported(files)


def _disc() -> str:
    """Return the definition of a round robot."""
    points = [(x, y) for x, y in _QUADRANT]
    for _ in range(3):
        points += [(_minus(y), x) for x, y in points[-len(_QUADRANT) :]]
    corners = "\n".join(f"    point[{index}] [ {x} {y} ]" for index, (x, y) in enumerate(points))
    return f"""\
define disc position
(
  color "red"
  drive "diff"
  localization "gps"
  localization_origin [ 0 0 0 0 ]
  obstacle_return 1
  ranger_return 1
  block
  (
    points {len(points)}
{corners}
    z [ 0 1 ]
  )
)
"""


def _minus(number: str) -> str:
    return number[1:] if number.startswith("-") else number if number == "0" else f"-{number}"


def _floor_plan(
    world: World, destination: Destination, picture: str, ringed: bool
) -> Iterator[str]:
    side = exact(world.cell_size)
    ring = 2 if ringed else 0
    width, height = (decimal_text((count + ring) * side) for count in (world.width, world.height))
    middle = [
        decimal_text(count * side / 2 + exact(shift))
        for count, shift in zip((world.width, world.height), destination.origin, strict=True)
    ]
    yield "floorplan"
    yield "("
    yield f'  name "{RINGED if ringed else "walls"}"'
    yield f'  bitmap "{picture}"'
    yield f"  size [ {width} {height} {_TALL} ]"
    yield f"  pose [ {middle[0]} {middle[1]} 0 0 ]"
    yield ")\n"


def _robot(robot: Robot, number: int, destination: Destination, lidar: bool) -> Iterator[str]:
    start = robot.start
    speed = decimal(robot.speed)
    across = decimal_text(2 * exact(robot.radius))
    yield "disc"
    yield "("
    yield f'  name "{numbered("robot", number)}"'
    yield f"  size [ {across} {across} {_LOW} ]"
    yield (
        f"  pose [ {destination.x(start.x)} {destination.y(start.y)} 0 "
        f"{degrees_text(start.heading)} ]"
    )
    yield f"  velocity_bounds [ -{speed} {speed} 0 0 0 0 -{_TURN_RATE} {_TURN_RATE} ]"
    if lidar:
        yield "  ranger ( sensor ( range [ 0 10 ] fov 360 samples 257 ) )"
    yield ")\n"


def _target(robot: Robot, number: int, destination: Destination) -> Iterator[str]:
    target = robot.target
    across = decimal_text(2 * exact(target.radius))
    yield "goal"
    yield "("
    yield f'  name "{numbered(TARGET, number)}"'
    yield f"  size [ {across} {across} 0.01 ]"
    yield f"  pose [ {destination.x(target.x)} {destination.y(target.y)} 0 0 ]"
    yield ")\n"


stage = Format(
    "stage",
    "Stage world, .world with .png",
    (".world",),
    re.compile(
        rb"(?s)(?!\s*<)(.*\n)?[ \t]*(define[ \t]+[\w.-]+[ \t]+[\w.-]+|include[ "
        rb"\t]+\"[^\"\n]*\"|floorplan)"
        rb"[ \t]*(#[^\n]*)?(\r?\n|\(|\Z)"
    ),
    read_stage,
    write_stage,
    holds=frozenset(HELD),
    robots=True,
    client="Stage",
    usual_robot=FLOOR_ROBOT,
)
