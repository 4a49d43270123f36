"""``worldgen audit``: check whether a recorded trajectory, or a plan, is possible in a world."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from worldgen.cli.output import (
    PATH,
    check_out,
    emit_json,
    force_option,
    json_option,
    note,
    say,
    write_out,
)
from worldgen.cli.robot_options import apply, robot_options
from worldgen.support.plain_text import stacked
from worldgen.support.progress import working

if TYPE_CHECKING:
    from sim.audit.judge import Interpolation

EXAMPLES = (
    "\b\n  worldgen audit w.grid recording.csv --picture audit.png\n"
    "  worldgen run w.grid --controller turn-right --trace own.csv; worldgen audit w.grid own.csv\n"
    "  my-simulator | worldgen audit w.grid - --json\n"
    "  worldgen audit w.grid plan.csv --footprint 0.62x0.9 --interpolate arc\n"
    "  worldgen audit office.grid odom.csv --frame map --columns t=stamp:ms,x=px,y=py"
)


@click.command(epilog=EXAMPLES)
@click.argument("world_path", type=PATH, metavar="WORLD")
@click.argument("log_path", type=PATH, metavar="LOG")
@click.option(
    "--frame",
    type=click.Choice(["corner", "map"]),
    help="Frame of the log: from the world's lower-left corner, or that of the map that the world was "
    "imported from.  [default: corner; map for a bag]",
)
@click.option(
    "--columns",
    default="",
    metavar="t=NAME,x=NAME,...",
    help="Columns of the log, by name or number from 1, with their unit if it isn't s, m or rad: "
    "t=stamp:ms,x=px,y=py,yaw=4:deg; also qx to qw. Others are recognised. topic=/odom is for a bag.",
)
@click.option(
    "--tolerance",
    type=float,
    default=1e-6,
    show_default=True,
    metavar="M",
    help="Depth up to which a cut is not reported, m.",
)
@click.option(
    "--slack",
    type=float,
    metavar="M",
    help="Distance by which a step may be longer than the speed allows, m.  [default: cell / 256]",
)
@click.option(
    "--interpolate",
    type=click.Choice(("line", "arc")),
    help=(
        "How the robot moves between two samples: straight, turning on the spot at one of the two, "
        "or on an arc.  [default: arc for a car with recorded headings, otherwise line]"
    ),
)
@click.option(
    "--straight",
    is_flag=True,
    help="Assume that the robot moved exactly so, so that corners cut by these lines count.",
)
@click.option(
    "--from-start", is_flag=True, help="Require that the first sample is the world's start."
)
@click.option(
    "--robot",
    type=click.IntRange(1),
    metavar="N",
    help="Judge only this robot.  [default: every robot of the recording]",
)
@click.option(
    "--picture",
    type=PATH,
    metavar="OUT.png",
    help="Draw the world, the trajectory and the findings.",
)
@robot_options
@json_option
@force_option
def audit(
    world_path: Path,
    log_path: Path,
    frame: str | None,
    columns: str,
    tolerance: float,
    slack: float | None,
    interpolate: Interpolation | None,
    straight: bool,
    from_start: bool,
    robot: int | None,
    picture: Path | None,
    as_json: bool,
    force: bool,
    **overrides: Any,
) -> None:
    """Check whether a trajectory from any simulator was possible, or a plan is.

    LOG is a table with columns t, x, y (s, m, m; x right, y up), heading (rad) if the robot has a
    footprint and, for several robots, robot; or what ROS, ROS 2, TUM or F1TENTH write, or a ROS bag. - is stdin.
    Without times it is a plan. It reports walls that the centre went through (tunnel) or that the
    body cut into (overlap), paths outside the grid, jumps faster than the robot's speed, and
    contact with fire;
    docs/howto/audit.md describes them. Exits with 0 if it was possible, with 1 if not.
    """
    from sim.audit import audit as audit_trajectory
    from sim.audit.frames import MapFrame, doubtful_frame, resampled_note
    from sim.audit.report import as_lines, as_object, draw, fleet_lines, fleet_object
    from worldgen.errors import InvalidParameter
    from worldgen.files.grid import read_world
    from worldgen.logs.reading import read_log

    # Refuse bad output before the work.
    check_out("--picture", picture, ".png", force=force)
    # Read and audit.
    world = apply(read_world(world_path), overrides)
    if robot is not None and robot > len(world.robots):
        raise InvalidParameter(
            "out-of-range",
            "robot {robot} is not in the world, which has {robots}",
            "use a lower number",
            robot=robot,
            robots=len(world.robots),
        )
    # Other programs write anything as headings, so read them only if they matter.
    headings = interpolate == "arc" or any(
        not own.is_disc or own.drive.is_car or any(goal.heading is not None for goal in own.goals)
        for own in world.robots
    )
    log = read_log(log_path, len(world.robots), robot, with_headings=headings, columns=columns)
    if log.read_as:
        note(f"read as {log.read_as}")
    frame = "map" if frame is None and log.in_map_frame else frame
    place = MapFrame.of(world) if frame == "map" else MapFrame()
    trajectories = {number: place.into_world(own) for number, own in log.trajectories.items()}
    driven = {number: world.alone(number) if world.is_fleet else world for number in trajectories}
    judge = partial(
        audit_trajectory,
        tolerance=tolerance,
        slack=slack,
        straight=straight,
        from_start=from_start,
        interpolate=interpolate,
    )
    with working(f"auditing {log_path}"):
        audits = {number: judge(driven[number], own) for number, own in trajectories.items()}
        doubt = None
        if frame != "map":
            doubt = doubtful_frame(world, audits, judge, trajectories)
    if doubt is not None and frame is None:
        raise InvalidParameter.of(doubt)

    # Report; a recording of one robot needs no numbers.
    if len(audits) > 1:
        found = fleet_object(audits, tolerance)
        lines = fleet_lines(world, audits)
    else:
        ((number, result),) = audits.items()
        found = as_object(result, tolerance)
        lines = as_lines(driven[number], result)
    if as_json:
        emit_json(found)
    else:
        say(stacked(lines))
    if doubt is not None:
        note(f"note: {doubt.problem}")
    if not all(result.ok for result in audits.values()) and (remark := resampled_note(world)):
        note(f"note: {remark}")

    # Draw; the exit code tells whether the trajectories were possible.
    if picture is not None:
        recorded = {number: (trajectories[number], audits[number]) for number in audits}
        write_out(picture, draw(world, recorded, log_path.name), force=force)
    if not all(result.ok for result in audits.values()):
        raise SystemExit(1)
