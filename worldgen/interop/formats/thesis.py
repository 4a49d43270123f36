"""Map files of the thesis's simulator (``.gex``, ``.map``): the signal of every cell, row by row.

A cell is -2 for a wall, 0 for the target, and otherwise its squared distance to the target in
cells, which the map editor's noise filter may have changed. The file has no header: the map is a
square, y down.

Source: the thesis's listing, ``fileOps.saveFile``, ``loadFile``, ``Grid.lightGridGenrtr`` and
``simWorldCreator.noiseMapGen``; bytes as in files that its save routine wrote.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

import numpy as np

from worldgen.errors import FormatError, InvalidWorld, Note
from worldgen.interop.format import Destination, Exported, Format
from worldgen.interop.format.foreign_map import ForeignMap, ForeignRobot, read_bounded
from worldgen.interop.readers.java_stream import Ints, read_ints, stream_bytes, write_ints
from worldgen.lattice import (
    UNIT,
    heading_to_lattice,
    in_cells,
    lattice_to_metres,
    metres_to_lattice,
    radius_in_cells,
)
from worldgen.support.arrays import Bools
from worldgen.support.rows import flip_rows
from worldgen.world import DEFAULT_CELL_SIZE, Pose, Value, World

WALL = -2
# Minimum cells per side: a border of walls around one cell.
MIN_SIZE = 3
# Limit on the cells per side; the program itself stops at 100.
MAX_SIZE = 2000
# The number of cells per side must be even.
_LOADABLE = (10, 100)
# Cells around a wall whose signal the noise filter changes.
_REACH = 2
# Start, from the left and from the top: 35 px.
_START_CELLS = 3.5
# Heading at the start, rad, clockwise from -x.
_START_HEADING = 4.5
# Diameter 14 px.
_ROBOT_CELLS = 0.7
# Speed in cells/s: 0.2 px/ms.
_SPEED_CELLS = 20.0


def signal(walls: Bools, target: tuple[int, int]) -> Ints:
    """Return the signal in the program's map editor for walls drawn with the noise filter off.

    Args:
        walls: (n, n) bool, top row first.
        target: Column and row, from the top.

    Returns:
        (n, n) int32, top row first.
    """
    values = _light(walls.shape[0], target)
    values[walls] = WALL
    return values


def _light(size: int, target: tuple[int, int]) -> Ints:
    """Return the undisturbed signal inside the border, which is walls."""
    index = np.arange(size, dtype=np.int32)
    values: Ints = (index - target[0])[np.newaxis, :] ** 2 + (index - target[1])[:, np.newaxis] ** 2
    values[[0, -1], :] = WALL
    values[:, [0, -1]] = WALL
    return values


def filtered(values: Ints, target: tuple[int, int]) -> Ints:
    """Return the signal after one pass of the noise filter, in the program's order of walls.

    A wall changes the cells within two of it: a cell that now holds more than the wall's own
    distance gets one and a half times its undisturbed value, any other nine tenths of it unless
    that is 0. A cell's final value depends on the order of the walls around it and on no other
    cell, so all cells are processed together.

    Args:
        values: As :func:`signal` gives them.
        target: Column and row, from the top.
    """
    light = _light(values.shape[0], target)
    inner = np.zeros(values.shape, np.bool_)
    inner[1:-1, 1:-1] = values[1:-1, 1:-1] == WALL
    walls = np.pad(inner, _REACH)
    at_wall = np.pad(light, _REACH)
    raised = (1.5 * light).astype(np.int32)
    lowered = (0.9 * light).astype(np.int32)
    result = values.copy()
    size = values.shape[0]
    # Row and column of the wall relative to the cell, in scan order.
    for down in range(2 * _REACH + 1):
        for right in range(2 * _REACH + 1):
            there = np.s_[down : down + size, right : right + size]
            struck = walls[there] & (result > 0)
            farther = result > at_wall[there]
            result = np.where(struck & farther, raised, result)
            result = np.where(struck & ~farther & (lowered != 0), lowered, result)
    return result


def program_start(size: int, cell_size: float) -> Pose:
    """Return the start of the program's robot: 35 px from the left and top, at 10 px per cell."""
    halves = round(2 * _START_CELLS)
    x, y = (
        lattice_to_metres(cells * UNIT // 2, cell_size) for cells in (halves, 2 * size - halves)
    )
    return Pose(x, y, math.pi - _START_HEADING)


def unloadable(size: int) -> str | None:
    """Return the reason why the program would not load a map of this size, or None if it would."""
    low, high = _LOADABLE
    if low <= size <= high and size % 2 == 0:
        return None
    return (
        f"the thesis's program does not load {size} x {size} cells: it takes even sizes of "
        f"{low} to {high}"
    )


def read_thesis_map(path: Path, *, cell_size: float = DEFAULT_CELL_SIZE) -> ForeignMap:
    """Read a map that the thesis's program saved.

    Args:
        path: The file; the program's own suffix is ``.gex``.
        cell_size: Side of a cell, m; the format has pixels, 10 per cell.

    Raises:
        FormatError: If it isn't a Java stream of bare numbers, or the numbers aren't a map.
    """
    data = read_bounded(path, stream_bytes(MAX_SIZE**2))
    values = _square(read_ints(data))
    _check_values(values)
    target = _target(values)
    params: dict[str, Value] = {}
    notes, warnings = _explain(values, target, params)
    size = values.shape[0]
    start = program_start(size, cell_size)
    halves = (2 * target[0] + 1, 2 * (size - target[1]) - 1, 1)
    x, y, radius = (lattice_to_metres(count * UNIT // 2, cell_size) for count in halves)
    return ForeignMap(
        flip_rows(values == WALL), cell_size, params, notes, warnings,
        robots=(ForeignRobot((start.x, start.y, start.heading), (x, y, radius)),),
    )  # fmt: skip


def _explain(
    values: Ints, target: tuple[int, int], params: dict[str, Value]
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return notes and warnings about size and values; record the noise filter in ``params``."""
    why = unloadable(values.shape[0])
    notes = (why,) if why else ()
    plain = signal(values == WALL, target)
    if np.array_equal(values, plain):
        return notes, ()
    noisy = filtered(plain, target)
    if np.array_equal(values, noisy):
        params["noise"] = True
        return (*notes, _THROUGH_NOISE), ()
    neither = int(np.count_nonzero((values != plain) & (values != noisy)))
    return notes, (
        Note(
            "signal-unknown",
            "the values are neither squared distances to the target nor the result of one pass of "
            "the noise filter over them ({cells} cells fit neither)",
            "walls and target are kept, and export --to thesis will write the plain map",
            at_terminal=True,
            cells=neither,
        ),
    )


_THROUGH_NOISE = Note(
    "noise-filtered",
    "the map has been through the noise filter, which a world cannot store: run it with "
    "thesis-1+noise",
    "export --to thesis filters it again",
    at_terminal=True,
)


def _square(values: Ints) -> Ints:
    if not len(values):
        raise FormatError(
            "empty",
            "the stream holds no numbers; a map of n x n cells has n * n",
            "fetch the file again",
        )
    size = math.isqrt(len(values))
    if size * size != len(values):
        raise FormatError(
            "not-square",
            "{numbers} numbers do not make a square; a map of n x n cells has n * n",
            "fetch the file again",
            numbers=len(values),
        )
    if not MIN_SIZE <= size <= MAX_SIZE:
        raise FormatError(
            "wrong-size",
            "{size} x {size} cells; a map has {min_size} to {max_size} per side",
            "use another file",
            size=size,
            min_size=MIN_SIZE,
            max_size=MAX_SIZE,
        )
    return values.reshape(size, size)


def _check_values(values: Ints) -> None:
    below = values < WALL
    if below.any():
        row, column = (int(index) for index in np.argwhere(below)[0])
        raise FormatError(
            "wrong-values",
            "{value} in column {column}, row {row} from the top; a cell holds a squared "
            "distance, 0 for the target, or {wall} for a wall; this is not a map, or it is damaged",
            value=values[row, column],
            column=column,
            row=row,
            wall=WALL,
        )
    rim = np.ones(values.shape, np.bool_)
    rim[1:-1, 1:-1] = False
    opened = np.argwhere(rim & (values != WALL))
    if len(opened):
        row, column = (int(index) for index in opened[0])
        raise FormatError(
            "open-border",
            "the border is open in column {column}, row {row} from the top; a map has walls all "
            "around",
            "close it in the program's map editor",
            column=column,
            row=row,
        )


def _target(values: Ints) -> tuple[int, int]:
    """Return the column and row of the only target."""
    found = np.argwhere(values == 0)
    if len(found) != 1:
        raise FormatError(
            "wrong-count",
            "{targets} cells hold 0; a map has exactly one target (moving it onto a wall loses it)",
            "place one in the program's map editor",
            targets=len(found),
        )
    row, column = found[0]
    return int(column), int(row)


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


def _check_shape(world: World) -> None:
    if world.width != world.height:
        raise InvalidWorld(
            "not-square",
            "{width} x {height} cells; a thesis map is a square",
            "pad the shorter side with walls",
            width=world.width,
            height=world.height,
        )
    if not MIN_SIZE <= world.width <= MAX_SIZE:
        raise InvalidWorld(
            "wrong-size",
            "{width} x {height} cells; a thesis map has {min_size} to {max_size} cells per side",
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
    """Return the column and row, from the top, of the cell with the target's centre."""
    ix, iy = (
        math.floor(in_cells(value, world.cell_size)) for value in (world.target.x, world.target.y)
    )
    if not (0 <= ix < world.width and 0 <= iy < world.height) or world.walls[iy, ix]:
        raise InvalidWorld(
            "target-in-a-wall",
            "the target ({x:g}, {y:g}) m is in a wall; in a thesis map it is in a free cell",
            "move it into one",
            x=world.target.x,
            y=world.target.y,
        )
    return ix, world.height - 1 - iy


def _altered(world: World, column: int, row: int) -> Iterator[tuple[str, str]]:
    """Yield a note for each fact that the file lacks and its program would assume differently."""
    # The file stores only the target's cell.
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
            "the start pose is not stored; in the program the robot always starts at 35, 35 px, "
            "which is 3.5 cells from the left and the top"
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
