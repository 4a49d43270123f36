"""Micromouse mazes as text: posts ``o``, walls ``---`` and ``|``, start ``S``, goals ``G``.

A maze of n x n squares is a grid of (2n + 1) x (2n + 1) cells: each square, wall and post is one
cell.

Source: the maze files of the micromouse community (github.com/micromouseonline/mazefiles).
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from worldgen.errors import FormatError, InvalidWorld
from worldgen.interop.format import Destination, Exported, Format
from worldgen.interop.format.foreign_map import (
    GRID_AGENT,
    ForeignMap,
    ForeignRobot,
    check_sides,
    read_bounded,
    unix_text,
)
from worldgen.interop.formats.text import cell_centre, end_cells
from worldgen.support.arrays import Bools
from worldgen.support.rows import flip_rows
from worldgen.world import DEFAULT_CELL_SIZE, World

# Large enough for 700 squares per side; a contest's maze has 32.
_MOST_BYTES = 4 << 20
_POSTS = (b"o", b"+")
_PARTS = {b"---": True, b"   ": False, b"|": True, b" ": False}
_SQUARE = re.compile(rb" [SG ] ")


def read_micromouse(path: Path, *, cell_size: float = DEFAULT_CELL_SIZE) -> ForeignMap:
    """Read a maze, the top row first.

    The start is the square with ``S``, the target the first square with ``G``.

    Args:
        path: The file; rows whose trailing blanks an editor removed are filled up.
        cell_size: Side of a cell, m; a square, a wall and a post are one cell each.

    Raises:
        FormatError: If a part isn't a post, wall or square, with line and column, or there are two
            starts.
    """
    # Read the rows; editors may have removed blanks at their ends.
    data = read_bounded(path, _MOST_BYTES)
    rows = [row.rstrip() for row in unix_text(data).split(b"\n")]
    while rows and not rows[-1]:
        rows.pop()
    width = 2 * ((max(map(len, rows), default=0) + 2) // 4) + 1 if rows else 0
    check_sides(width, len(rows))
    if len(rows) % 2 == 0 or width < 3:
        raise FormatError(
            "wrong-size",
            "{rows} rows; a maze of n rows of squares has 2 n + 1, from posts to posts",
            rows=len(rows),
        )
    # Read the walls and the marks.
    walls = np.zeros((len(rows), width), np.bool_)
    marks: dict[str, list[tuple[int, int]]] = {"S": [], "G": []}
    for row, line in enumerate(rows):
        parts = _parts(line.ljust(2 * width - 1), row)
        walls[row] = [solid for solid, _ in parts]
        for column, (_, mark) in enumerate(parts):
            if mark:
                marks[mark].append((row, column))
    # Find the start and the target.
    if len(marks["S"]) > 1:
        raise FormatError(
            "twice",
            "{starts} starts",
            "keep one",
            starts=len(marks["S"]),
            line=marks["S"][1][0] + 1,
        )
    places = [
        cell_centre(found[0][1], len(rows) - 1 - found[0][0], cell_size) if found else None
        for found in (marks["S"], marks["G"])
    ]
    goals = len(marks["G"])
    notes = (
        ()
        if goals < 2
        else (f"there are {goals} goals; the target is the first, row by row from the top",)
    )
    robots = (ForeignRobot(places[0], places[1]),)
    return ForeignMap(flip_rows(walls), cell_size, notes=notes, robots=robots)


def _parts(line: bytes, row: int) -> list[tuple[bool, str]]:
    """Yield, for each cell of a row, whether it is solid, and its mark."""
    parts = []
    # Every four characters are a post and a wall, or a wall and a square.
    for at in range(0, len(line), 4):
        narrow = line[at : at + 1]
        wide = line[at + 1 : at + 4]
        if (narrow not in _PARTS) if row % 2 else (narrow not in _POSTS):
            form = "| or a blank" if row % 2 else "a post, o,"
            raise FormatError(
                "wrong-form",
                "{came!q} in column {column} where {form} belongs; posts are four characters apart",
                came=narrow,
                column=at + 1,
                form=form,
                line=row + 1,
            )
        parts.append((row % 2 == 0 or _PARTS[narrow], ""))
        if wide and not (_SQUARE.fullmatch(wide) if row % 2 else wide in _PARTS):
            form = (
                "a square, S, G or blank between two blanks," if row % 2 else "--- or three blanks"
            )
            raise FormatError(
                "wrong-form",
                "{came!q} in column {column} where {form} belongs",
                came=wide,
                column=at + 2,
                form=form,
                line=row + 1,
            )
        if wide:
            parts.append((row % 2 == 0 and _PARTS[wide], wide.strip().decode() if row % 2 else ""))
    return parts


def write_micromouse(world: World, destination: Destination) -> Exported:
    """Write a maze, the top row first.

    Args:
        world: A world with odd sides. Every cell in an even column and an even row, from 0, is a
            solid post; every cell in an odd column and an odd row is a free square.
        destination: Where the file is written.

    Raises:
        InvalidWorld: If it is not such a maze; the message names a cell at fault.
    """
    _check(world)
    # Mark the cells of start and target, and report what gets lost.
    walls = flip_rows(world.walls)
    start, target, altered = end_cells(world)
    marks = {target: "G", start: "S"}
    for name, (column, row) in (("start", start), ("target", target)):
        if not (column % 2 and row % 2):
            altered[name] = f"the {name} is not drawn, because it is between two squares"
    if start == target:
        altered["target"] = "the target is not drawn, because its square is the start's"
    lines = [_line(walls, row, marks) for row in range(world.height)]
    return Exported({destination.name: "".join(f"{line}\n" for line in lines).encode()}, altered)


def _line(walls: Bools, row: int, marks: dict[tuple[int, int], str]) -> str:
    words = []
    for column, solid in enumerate(walls[row].tolist()):
        if row % 2 == 0:
            words.append("o" if column % 2 == 0 else "---" if solid else "   ")
        elif column % 2 == 0:
            words.append("|" if solid else " ")
        else:
            words.append(f" {marks.get((column, row), ' ')} ")
    return "".join(words)


def _check(world: World) -> None:
    if world.width % 2 == 0 or world.height % 2 == 0 or min(world.width, world.height) < 3:
        raise InvalidWorld(
            "not-a-micromouse-maze",
            "{width} x {height} cells; a micromouse maze of n squares has 2 n + 1 cells per side, "
            "including the walls between them",
            "`worldgen maze --size 17 --radius 0.04` makes such a maze",
            at_terminal=True,
            width=world.width,
            height=world.height,
        )
    wrong = np.zeros(world.walls.shape, np.bool_)
    wrong[::2, ::2] = ~world.walls[::2, ::2]
    wrong[1::2, 1::2] = world.walls[1::2, 1::2]
    if wrong.any():
        iy, ix = (int(index) for index in np.argwhere(wrong)[0])
        is_post = ix % 2 == 0
        raise InvalidWorld(
            "not-a-maze",
            "cell ({ix}, {iy}) is free; in a micromouse maze it is a post and solid"
            if is_post
            else "cell ({ix}, {iy}) is solid; in a micromouse maze it is a square and free",
            "use a maze with walls and corridors of one cell",
            ix=ix,
            iy=iy,
        )


micromouse = Format(
    "micromouse",
    "maze of the micromouse contests as text, .maze",
    # Also .txt; the contents distinguish it from a drawing.
    (".maze",),
    re.compile(rb"[o+](?:(?:---|   )[o+])+[ \t]*\r?\n[| ]"),
    read_micromouse,
    write_micromouse,
    holds=frozenset({"start", "target"}),
    client="micromouse simulators",
    most_bytes=_MOST_BYTES,
    usual_robot=GRID_AGENT,
)
