"""``worldgen show``: draw a world in the terminal, or as a picture file."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING

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
from worldgen.support.progress import working
from worldgen.support.results import results

if TYPE_CHECKING:
    from worldgen.world import Certificate, FailureRecord, Robot, Target, World

# Function of render for each kind of picture; imported when used, because it needs Pillow.
_DRAWN_BY = {".png": "draw_png", ".svg": "draw_svg", ".html": "draw_html"}
EXAMPLES = "\b\n  worldgen show w.grid\n  worldgen show w.grid --picture w.png"


@click.command(epilog=EXAMPLES)
@click.argument("path", type=PATH)
@click.option(
    "--picture",
    "outs",
    type=PATH,
    multiple=True,
    metavar="OUT",
    help="Write a picture instead: .png, .svg, or .html, a page with the facts. May be repeated.",
)
@click.option(
    "--pixels",
    type=int,
    default=900,
    show_default=True,
    help="Longer side of the map in a picture, px.",
)
@click.option("--signal/--no-signal", default=True, help="Tint the floor by the target's signal.")
@click.option(
    "--witness/--no-witness", default=True, help="Draw the path, or the cut, that proves the world."
)
@json_option
@force_option
def show(
    path: Path,
    outs: tuple[Path, ...],
    pixels: int,
    signal: bool,
    witness: bool,
    as_json: bool,
    force: bool,
) -> None:
    """Draw a world in the terminal, or as PNG, SVG or HTML.

    With --json the world's facts are printed instead of a drawing.
    """
    from worldgen import render
    from worldgen.files.grid import read_world
    from worldgen.reach.decision import unread_reason

    # Refuse bad output before the work.
    outs = tuple(dict.fromkeys(outs))
    for out in outs:
        check_out("--picture", out, *_DRAWN_BY, force=force)
    # Draw all pictures before any is written.
    world = read_world(path)
    if world.unread:
        note(f"warning: {unread_reason(world.unread)}")
    pictures: list[tuple[Path, bytes]] = []
    for out in outs:
        with working(f"drawing {path}"):
            draw = getattr(render, _DRAWN_BY[out.suffix])
            drawn = draw(world, signal=signal, witness=witness, title=path.name, pixels=pixels)
        pictures.append((out, drawn if isinstance(drawn, bytes) else drawn.encode()))
    for out, data in pictures:
        write_out(out, data, force=force)
    # Print facts, or the drawing if there are no pictures.
    if as_json:
        emit_json(_facts(world, path, list(outs)))
        return
    if not pictures:
        color = render.wants_color(results())
        say(render.draw_terminal(world, color=color), nl=False, color=color)
    if world.failure is not None:
        say(f"failure: {_failure_words(world.failure)}")
        say(f"replay:  worldgen replay {shlex.quote(str(path))}")


def _facts(world: World, path: Path, pictures: list[Path]) -> dict[str, object]:
    failure = world.failure
    certificate = world.certificate
    return {
        "file": str(path),
        "width": world.width,
        "height": world.height,
        "cell_size": world.cell_size,
        "solid_cells": world.solid_cells,
        "changes": world.is_dynamic,
        "start": [world.start.x, world.start.y, world.start.heading],
        "target": [world.target.x, world.target.y, world.target.radius],
        **_goal_facts(world.target),
        **_waypoint_facts(world.robots[0]),
        "robot_radius": world.robot_radius,
        "robot_speed": world.robot_speed,
        "certificate": None if certificate is None else _kind(certificate),
        "failure": None
        if failure is None
        else {
            "controller": failure.controller,
            "motion": failure.motion,
            "verdict": failure.verdict,
            "evidence": dict(failure.evidence),
        },
        "pictures": [str(picture) for picture in pictures],
    } | ({"robots": [_robot_facts(robot) for robot in world.robots]} if world.is_fleet else {})


def _kind(certificate: Certificate) -> str:
    return "cut" if type(certificate).__name__ == "Cut" else "witness"


def _robot_facts(robot: Robot) -> dict[str, object]:
    return {
        "start": [robot.start.x, robot.start.y, robot.start.heading],
        "target": [robot.target.x, robot.target.y, robot.target.radius],
        **_goal_facts(robot.target),
        **_waypoint_facts(robot),
        "radius": robot.radius,
        "speed": robot.speed,
    }


def _waypoint_facts(robot: Robot) -> dict[str, object]:
    """Return the goals before the target, in order; nothing if there are none."""
    found = [
        {"target": [goal.x, goal.y, goal.radius], **_goal_facts(goal)} for goal in robot.waypoints
    ]
    return {"waypoints": found} if found else {}


def _goal_facts(goal: Target) -> dict[str, object]:
    """Return what a goal asks for besides a touch; nothing if that is all."""
    heading = {}
    if goal.heading is not None:
        heading = {"target_heading": goal.heading, "heading_tolerance": goal.heading_tolerance}
    rest = {"arrival": goal.arrival, "contact": goal.contact}
    return {} if goal.is_plain else {**heading, **rest}


def _failure_words(failure: FailureRecord) -> str:
    evidence = ", ".join(f"{key} {value}" for key, value in failure.evidence.items())
    return f"{failure.who}: {failure.verdict}" + (f" ({evidence})" if evidence else "")
