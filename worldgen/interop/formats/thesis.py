"""Map files of the thesis's simulator, with the bytes that its own save routine would write."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import Literal

import numpy as np

from worldgen.errors import InvalidWorld
from worldgen.interop.format import Destination, Exported, Format
from worldgen.interop.readers.java_stream import write_ints
from worldgen.interop.readers.thesis_map import (
    MAX_SIZE,
    MIN_SIZE,
    filtered,
    program_start,
    read_thesis_map,
    signal,
    unloadable,
)
from worldgen.lattice import heading_to_lattice, in_cells, metres_to_lattice, radius_in_cells
from worldgen.support.rows import flip_rows
from worldgen.world import World

__all__ = ["thesis", "write_thesis_map"]

# Diameter 14 px.
_ROBOT_CELLS = 0.7
# Speed in cells/s: 0.2 px/ms.
_SPEED_CELLS = 20.0


def write_thesis_map(
    world: World,
    destination: Destination,
    *,
    noise: Literal["as-imported", "on", "off"] = "as-imported",
) -> Exported:
    """Return the map file, with the cells at time 0.

    Args:
        world: A square with walls on all sides.
        destination: Where the file is written.
        noise: True to apply the program's noise filter; ``as-imported`` does so if the imported map
            had it.

    Raises:
        InvalidWorld: If the world isn't a square of a size that fits, its border is open, or its
            target is in a wall.
    """
    _check_shape(world)
    column, row = _target_cell(world)
    values = signal(flip_rows(world.walls), (column, row))
    made = world.provenance
    had_noise = made is not None and made.family == "import" and made.params.get("noise") is True
    if noise == "on" or (noise == "as-imported" and had_noise):
        values = filtered(values, (column, row))
    why = unloadable(world.width)
    altered = dict(_altered(world, column, row))
    return Exported({destination.name: write_ints(values.ravel())}, altered, (why,) if why else ())


thesis = Format(
    "thesis",
    "map of the thesis's simulator, .gex",
    (".gex",),
    re.compile(rb"\xac\xed"),
    read_thesis_map,
    write_thesis_map,
    holds=frozenset({"start", "heading", "target", "target_radius", "robot_radius", "robot_speed"}),
    client="the thesis's simulator",
)


def _check_shape(world: World) -> None:
    if world.width != world.height:
        raise InvalidWorld(
            "not-square",
            "{width} x {height} cells; a thesis map is a square",
            "fill up the shorter side with walls",
            width=world.width,
            height=world.height,
        )
    if not MIN_SIZE <= world.width <= MAX_SIZE:
        raise InvalidWorld(
            "wrong-size",
            "{width} x {height} cells; a thesis map has {min_size} to {max_size} per side",
            "export a smaller or larger world",
            width=world.width,
            height=world.height,
            min_size=MIN_SIZE,
            max_size=MAX_SIZE,
        )
    inside = np.zeros(world.walls.shape, np.bool_)
    inside[1:-1, 1:-1] = True
    opened = np.argwhere(~world.walls & ~inside)
    if len(opened):
        iy, ix = (int(index) for index in opened[0])
        raise InvalidWorld(
            "open-border",
            "the border is open at cell ({ix}, {iy}); a thesis map has a wall all around",
            "add a ring of solid cells",
            ix=ix,
            iy=iy,
        )


def _target_cell(world: World) -> tuple[int, int]:
    """Return column and row, from the top, of the cell that contains the target's centre."""
    ix, iy = (
        math.floor(in_cells(value, world.cell_size)) for value in (world.target.x, world.target.y)
    )
    if not (0 <= ix < world.width and 0 <= iy < world.height) or world.walls[iy, ix]:
        raise InvalidWorld(
            "target-in-a-wall",
            "the target ({x:g}, {y:g}) m is in a wall; a thesis map has it in a free cell",
            "move it into one",
            x=world.target.x,
            y=world.target.y,
        )
    return ix, world.height - 1 - iy


def _altered(world: World, column: int, row: int) -> Iterator[tuple[str, str]]:
    """Yield a note for each fact that the file lacks and that its program would assume differently."""
    # The file knows only the target's cell.
    centre = (2 * column + 1, 2 * (world.height - row) - 1)
    x, y = (2 * in_cells(value, world.cell_size) for value in (world.target.x, world.target.y))
    if x != centre[0] or y != centre[1] or 2 * in_cells(world.target.radius, world.cell_size) != 1:
        sentence = (
            f"the target is stored as the whole cell in column {column}, row {row} from the top"
        )
        yield "target", sentence
        yield "target_radius", sentence
    # Its program has its own start and robot.
    own = program_start(world.width, world.cell_size)
    start = world.start
    places = [
        metres_to_lattice(value, world.cell_size) for value in (own.x, start.x, own.y, start.y)
    ]
    turned = heading_to_lattice(start.heading) != heading_to_lattice(own.heading)
    if places[::2] != places[1::2] or turned:
        sentence = (
            "the start pose is not stored; the program always starts at 35, 35 px, which is 3.5 "
            "cells from the left and the top"
        )
        yield "start", sentence
        yield "heading", sentence
    if float(radius_in_cells(world)) != _ROBOT_CELLS:
        yield "robot_radius", "the robot's radius is not stored; the program's robot has 0.7 cells"
    if float(in_cells(world.robot_speed, world.cell_size)) != _SPEED_CELLS:
        yield (
            "robot_speed",
            "the robot's speed is not stored; the program's robot drives at 20 cells per second",
        )
