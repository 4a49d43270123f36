"""Maze maps of Gymnasium-Robotics, from which PointMaze and AntMaze build their worlds.

Source: the documentation of gymnasium-robotics, ``maze_map`` of the Maze environments.
"""

from __future__ import annotations

import json
import re

from worldgen.interop.format import Destination, Exported, Format
from worldgen.interop.formats.text import end_cells
from worldgen.interop.geometry.boxes import closing_boxes
from worldgen.support.rows import flip_rows
from worldgen.world import World


def write_pointmaze(world: World, destination: Destination) -> Exported:
    """Return a JSON list of rows, the top one first.

    1 is a wall, 0 is free, "r" the start, "g" the goal, "c" both.

    Args:
        world: The world; if its border is open, a wall one cell thick is added around it.
        destination: Where the file is written.
    """
    cells: list[list[int | str]] = flip_rows(world.walls).astype(int).tolist()
    start, target, altered = end_cells(world)
    # Mark the start and the target; "c" is both.
    for name, (column, row), letter in (("start", start, "r"), ("target", target, "g")):
        if cells[row][column] == 1:
            altered[name] = f"the {name} is not stored, because its cell is solid"
        else:
            cells[row][column] = "c" if cells[row][column] == "r" else letter
    # An open border becomes a wall, because everything outside is solid.
    if len(closing_boxes(world)):
        bar: list[int | str] = [1] * (world.width + 2)
        cells = [bar, *([1, *row, 1] for row in cells), bar]
    rows = ",\n ".join(json.dumps(row) for row in cells)
    notes = (
        "a cell is as large as `maze_size_scaling` there, 1 m in PointMaze, and (0, 0) is the "
        "middle of the map; start and goal are drawn from around the centres of their cells",
    )
    return Exported({destination.name: f"[{rows}]\n".encode()}, altered, notes)


pointmaze = Format(
    "pointmaze",
    "maze_map of Gymnasium-Robotics, .json",
    (".json",),
    re.compile(rb'\s*\[\s*\[\s*(?:[01]|"[rgc]")\s*[,\]]'),
    write=write_pointmaze,
    holds=frozenset({"start", "target"}),
    client="Gymnasium-Robotics",
)
