"""A world as a map file of the thesis's simulator, the bytes that its own save routine would write."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from worldgen.errors import InvalidWorld
from worldgen.interop.exporting import Exported, Exporter, ExportOptions
from worldgen.interop.java_stream import write_ints
from worldgen.interop.thesis_map import MAX_SIZE, MIN_SIZE, filtered, program_start, signal, unloadable
from worldgen.lattice import heading_to_lattice, in_cells, metres_to_lattice, radius_in_cells
from worldgen.rows import flip_rows
from worldgen.world import DEFAULT_CELL_SIZE, World

__all__ = ["thesis"]

_ROBOT_CELLS = 0.7  # 14 px across
_SPEED_CELLS = 20.0  # cells/s: 0.2 px/ms


def _export(world: World, options: ExportOptions) -> Exported:
    """The map file.

    Raises:
        InvalidWorld: If the world is no square of a size that fits, its border is open, or its target lies in a wall.
    """
    _check_shape(world)
    column, row = _target_cell(world)
    noise = _had_noise(world) if options.noise is None else options.noise
    values = signal(flip_rows(world.walls), (column, row))
    if noise:
        values = filtered(values, (column, row))
    return Exported(write_ints(values.ravel()), tuple(_losses(world, column, row)))


thesis = Exporter("thesis", ".gex", "map of the thesis's simulator", _export, ("noise",))


def _had_noise(world: World) -> bool:
    made = world.provenance
    return made is not None and made.family == "import" and made.params.get("noise") is True


def _check_shape(world: World) -> None:
    if world.width != world.height:
        raise InvalidWorld(
            f"{world.width} x {world.height} cells; a thesis map is a square; fill the shorter side up with walls"
        )
    if not MIN_SIZE <= world.width <= MAX_SIZE:
        raise InvalidWorld(
            f"{world.width} x {world.height} cells; a thesis map has {MIN_SIZE} to {MAX_SIZE} a side; "
            "export a smaller or larger world"
        )
    inside = np.zeros(world.walls.shape, np.bool_)
    inside[1:-1, 1:-1] = True
    opened = np.argwhere(~world.walls & ~inside)
    if len(opened):
        iy, ix = (int(index) for index in opened[0])
        raise InvalidWorld(
            f"the border is open at cell ({ix}, {iy}); a thesis map has a wall all round; add a ring of solid cells"
        )


def _target_cell(world: World) -> tuple[int, int]:
    """Column and row, from the top, of the cell that the target's centre lies in."""
    ix, iy = (math.floor(in_cells(value, world.cell_size)) for value in (world.target.x, world.target.y))
    if not (0 <= ix < world.width and 0 <= iy < world.height) or world.walls[iy, ix]:
        raise InvalidWorld(
            f"the target ({world.target.x:g}, {world.target.y:g}) m lies in a wall; a thesis map has it in a free "
            "cell; move it into one"
        )
    return ix, world.height - 1 - iy


def _losses(world: World, column: int, row: int) -> Iterator[str]:
    """What the file does not say and its program would have otherwise."""
    centre = (2 * column + 1, 2 * (world.height - row) - 1, 1)
    target = (world.target.x, world.target.y, world.target.radius)
    if any(2 * in_cells(value, world.cell_size) != halves for value, halves in zip(target, centre, strict=True)):
        yield f"the target is stored as the whole cell in column {column}, row {row} from the top"
    own, start = program_start(world.width, world.cell_size), world.start
    places = [metres_to_lattice(value, world.cell_size) for value in (own.x, start.x, own.y, start.y)]
    turned = heading_to_lattice(start.heading) != heading_to_lattice(own.heading)
    if places[::2] != places[1::2] or turned:
        yield "the start pose is not stored; the program starts at 35, 35 px, 3.5 cells from the left and the top"
    if float(radius_in_cells(world)) != _ROBOT_CELLS:
        yield "the robot's radius is not stored; the program's robot has 0.7 cells"
    if float(in_cells(world.robot_speed, world.cell_size)) != _SPEED_CELLS:
        yield "the robot's speed is not stored; the program's robot drives 20 cells a second"
    if world.cell_size != DEFAULT_CELL_SIZE:
        yield f"the cell size of {world.cell_size:g} m is not stored; give import --cell-size {world.cell_size!r}"
    if world.is_dynamic:
        yield f"the timeline of {len(world.timeline)} changes is not stored; the file has the cells at time 0"
    why = unloadable(world.width)
    if why:
        yield why
