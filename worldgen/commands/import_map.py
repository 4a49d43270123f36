"""``worldgen import``: turn a foreign map into a world with start, target and a proof."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from worldgen.cli.output import PATH, SEED, emit_json, force_option, json_option, note, say
from worldgen.cli.robot_options import note_axle, robot_options
from worldgen.cli.usage import Instead
from worldgen.support.plain_text import stacked
from worldgen.support.progress import working

EXAMPLES = (
    "\b\n  worldgen import arena.map --out w.grid\n"
    "  worldgen import arena.map --scen arena.map.scen --row 12 --out w.grid\n"
    "  worldgen import old.gex --out w.grid\n"
    "  worldgen import office.yaml --radius 0.2 --start 1.5,2.0 --out w.grid\n"
    "  worldgen import office.yaml --near 1.5,2.0 --clearance 0.4 --out w.grid\n"
    "  worldgen import office.yaml --footprint 0.62x0.9 --out w.grid\n"
    "  worldgen import plan.dxf --layer 'A-WALL*' --free A-DOOR --unit mm --out w.grid\n"
    "  worldgen import building.glb --from glb+slice_height=0.2 --cell 0.05 --out w.grid"
)


@click.command("import", epilog=EXAMPLES)
@click.argument("path", type=PATH)
@click.option("--out", "-o", type=PATH, required=True, help="The .grid file to write.")
@click.option(
    "--from",
    "name",
    metavar="FORMAT[+OPTION=VALUE]",
    help="Format of PATH, recognised if omitted, and its options: glb+slice_height=0.2, "
    "ros+unknown=free. `worldgen formats NAME` lists them.",
)
@click.option(
    "--radius",
    type=float,
    help="Robot's radius, m.  [default: the file's, or a common one for such maps]",
)
@click.option("--speed", type=float, help="Robot's top speed, m/s.  [default: 2.0]")
@click.option(
    "--start",
    metavar="X,Y[,HEADING]",
    help="Start pose, m and rad; placed automatically if omitted.",
)
@click.option(
    "--target",
    metavar="X,Y[,RADIUS]",
    help="Target, m; placed automatically if omitted, with the robot's radius.",
)
@click.option(
    "--near",
    metavar="X,Y",
    help="Place the start as near to this point as there is room, or the target if you give --start.",
)
@click.option(
    "--clearance",
    type=float,
    help="Least distance, m, from a place that is chosen to the nearest wall.  [default: the radius]",
)
@click.option(
    "--frame",
    type=click.Choice(["corner", "map", "picture"]),
    default="corner",
    show_default=True,
    help="Frame of the places that you give and read: from the lower-left corner, or in the file's "
    "own coordinates, such as ROS's map frame. picture is for a ROS map with a yaw: it leaves the "
    "cells as in the picture, unturned, and measures places from its lower-left corner.",
)
@click.option("--scen", type=PATH, help="MovingAI scenario file for start and target.")
@click.option(
    "--row",
    type=click.IntRange(1),
    default=1,
    show_default=True,
    help="Number of the problem in --scen.",
)
@click.option(
    "--robots",
    type=click.IntRange(1, 1000),
    help="Use this many problems of --scen, starting at --row, as the robots of one world.  "
    "[default: 1, or all robots of an exported map]",
)
@click.option(
    "--cell-size",
    "--cell",
    "cell_size",
    type=float,
    help="Side of a cell, m, of a map without units, or of a mesh.  [default: 0.1; 0.05]",
)
@click.option(
    "--layer",
    metavar="NAME,...",
    help="Layers of a drawing or a Tiled map that are walls.  [default: a drawing's all, a Tiled "
    "map's that are called walls]",
)
@click.option("--free", metavar="NAME,...", help="Layers that robots drive through, such as doors.")
@click.option(
    "--unit",
    metavar="UNIT",
    help="Unit of a drawing: m, cm, mm, in, ft, deg in GeoJSON, or a number of metres.  "
    "[default: the file's]",
)
@click.option(
    "--seed", type=SEED, help="Seed of the search for places that are far apart.  [default: 0]"
)
@click.option(
    "--ignore-unread",
    "--ignore-meshes",
    "ignore_unread",
    is_flag=True,
    help="Judge the world without what cannot be read, such as meshes.",
)
@robot_options
@force_option
@json_option
def import_map(
    path: Path,
    out: Path,
    name: str | None,
    radius: float | None,
    speed: float | None,
    start: str | None,
    target: str | None,
    near: str | None,
    clearance: float | None,
    frame: str,
    scen: Path | None,
    row: int,
    robots: int | None,
    seed: int | None,
    ignore_unread: bool,
    force: bool,
    as_json: bool,
    cell_size: float | None,
    layer: str | None,
    free: str | None,
    unit: str | None,
    **overrides: Any,
) -> None:
    """Make a world from another program's map.

    PATH is a file of any format that `worldgen formats` lists: maps of ROS and Nav2, MovingAI,
    worlds of robot simulators, pictures, drawings, meshes, or a .grid, which keeps its own start
    and target unless you give others. A mesh is cut at slice_height, where the lidar is. If
    neither you nor the file gives a start and a target, they are placed far apart in the largest
    region the robot can drive through, with room to turn.

    Exits with 0 if the target can be reached, with 1 if it cannot, or if it is undecided. If the
    file has elements that cannot be read, such as a mesh, they might block the path: the world is
    written without a proof, and the exit code is 2; --ignore-unread judges it without them.
    """
    from worldgen import interop
    from worldgen.files.grid import write_world
    from worldgen.robot_overrides import RobotOverrides

    # Collect what the user gave.
    kind = RobotOverrides.of(overrides)
    note_axle(kind)
    to = None if target is None else interop.parse_point("target", target, "RADIUS")
    if to is not None and len(to) > 2 and kind.target_radius is not None:
        raise Instead("use --target X,Y,RADIUS or --target-radius, not both", "--target-radius")
    robot = interop.ImportedRobot(
        None if start is None else interop.parse_point("start", start, "HEADING"),
        to,
        radius, speed, scen, row, seed, ignore_unread, robots, frame == "map", kind,
        None if near is None else interop.parse_point("near", near), clearance,
    )  # fmt: skip
    given = {"cell_size": cell_size, "layer": layer, "free": free, "unit": unit}
    asked: dict[str, Any] = {option: value for option, value in given.items() if value is not None}
    if frame == "picture":
        known = interop.find_format(path, name and name.partition("+")[0])
        if all(option.name != "frame" for option in known.read_options):
            raise click.UsageError("--frame picture is for ROS maps, whose pictures may be turned")
        asked["frame"] = frame
    # Import the map and decide the world.
    with working(f"reading {path}, placing the robot and deciding whether it can arrive"):
        imported = interop.import_world(path, robot, name=name, options=asked)
    file = str(out)
    write_world(imported.world, out, force=force)
    for sentence in imported.notes:
        note(sentence)
    for sentence in imported.warnings:
        note(f"warning: {sentence}")
    # Report the result; the exit code shows whether the target can be reached.
    if as_json:
        emit_json(interop.as_json(file, imported))
    else:
        say(stacked(interop.describe(file, imported)))
    if imported.withheld:
        note(
            f"{out} has no proof, because not everything was read; if the rest cannot block the "
            f"robot, add --ignore-unread --force",
            always=True,
        )
        raise click.exceptions.Exit(2)
    if imported.decision.result != "reachable":
        raise click.exceptions.Exit(1)
