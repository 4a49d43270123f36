"""``worldgen show``: draw a world in the terminal, or as a picture file."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import click

from worldgen.cli.output import PATH, emit_json, force_option, json_option, note
from worldgen.files.whole import write_bytes
from worldgen.support.progress import working

if TYPE_CHECKING:
    from worldgen.world import Certificate, FailureRecord, Robot, World

T = TypeVar("T")

EXAMPLES = "\b\n  worldgen show w.grid\n  worldgen show w.grid --png w.png"


@click.command(epilog=EXAMPLES)
@click.argument("path", type=PATH)
@click.option("--png", type=PATH, metavar="OUT", help="Write a PNG picture.")
@click.option("--svg", type=PATH, metavar="OUT", help="Write an SVG picture.")
@click.option(
    "--html", type=PATH, metavar="OUT", help="Write an HTML page with the picture and the facts."
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
    png: Path | None,
    svg: Path | None,
    html: Path | None,
    pixels: int,
    signal: bool,
    witness: bool,
    as_json: bool,
    force: bool,
) -> None:
    """Draw a world in the terminal, or as PNG, SVG or HTML.

    With --png, --svg or --html nothing is drawn in the terminal; they can be combined. With --json
    the world's facts are printed instead of a drawing.
    """
    from worldgen import render
    from worldgen.files.grid import read_world

    world = read_world(path)

    def look(draw: Callable[..., T]) -> T:
        with working(f"drawing {path}"):
            return draw(world, signal=signal, witness=witness, title=path.name, pixels=pixels)

    # Draw all pictures before any is written.
    pictures: list[tuple[Path, bytes]] = []
    if png is not None:
        pictures.append((png, look(render.draw_png)))
    if svg is not None:
        pictures.append((svg, look(render.draw_svg).encode()))
    if html is not None:
        pictures.append((html, look(render.draw_html).encode()))
    for out, data in pictures:
        write_bytes(out, data, force=force)
        note(f"wrote {out}")
    # Print facts, or the drawing if there are no pictures.
    if as_json:
        emit_json(_facts(world, path, [out for out, _ in pictures]))
        return
    if not pictures:
        color = render.wants_color(sys.stdout)
        click.echo(render.draw_terminal(world, color=color), nl=False, color=color)
    if world.failure is not None:
        click.echo(_failure_lines(world.failure, path))


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
    } | ({"robots": [_robot_facts(robot) for robot in world.robots]} if world.others else {})


def _kind(certificate: Certificate) -> str:
    return "cut" if type(certificate).__name__ == "Cut" else "witness"


def _robot_facts(robot: Robot) -> dict[str, object]:
    return {
        "start": [robot.start.x, robot.start.y, robot.start.heading],
        "target": [robot.target.x, robot.target.y, robot.target.radius],
        "radius": robot.radius,
        "speed": robot.speed,
    }


def _failure_lines(failure: FailureRecord, path: Path) -> str:
    evidence = ", ".join(f"{key} {value}" for key, value in failure.evidence.items())
    what = f"{failure.controller} under {failure.motion}: {failure.verdict}" + (
        f" ({evidence})" if evidence else ""
    )
    return f"failure: {what}\nreplay:  worldgen replay {shlex.quote(str(path))}"
