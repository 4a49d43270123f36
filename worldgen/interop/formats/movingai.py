"""MovingAI's octile maps (``.map``) and scenarios (``.scen``).

Source: Nathan Sturtevant, "Benchmarks for Grid-Based Pathfinding", 2012, and movingai.com.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import NoReturn

import numpy as np

from worldgen.errors import FormatError, Note
from worldgen.family import check_between
from worldgen.interop.format import Destination, Exported, Format
from worldgen.interop.format.foreign_map import (
    GRID_AGENT,
    ForeignMap,
    ForeignRobot,
    check_sides,
    names_its_file,
    read_bounded,
    unix_text,
)
from worldgen.interop.formats.text import cell_centre, end_cells
from worldgen.lattice import exact, radius_in_cells
from worldgen.support.arrays import Bytes
from worldgen.support.plain_text import quote
from worldgen.support.rows import flip_rows
from worldgen.world import DEFAULT_CELL_SIZE, World

# Swamp can be entered from plain ground, water cannot: it is a wall to a robot that starts on
# ground.
PASSABLE = b".GS"
BLOCKED = b"@OTW"
# Radius in cells; a scenario's robot turns in corridors one cell wide.
SCENARIO_RADIUS = Fraction(4, 10)
# Line of the first row, after type, height, width and map.
_FIRST_ROW = 5
# Limit on the length of a line, bytes; it has nine short fields.
_MAX_SCENARIO_LINE = 4096
_MAX_SCENARIO_BYTES = 64 << 20
# Limit on the problems in a file; the benchmark's largest files have about ten thousand.
_MAX_SCENARIOS = 1_000_000
_LENGTH = re.compile(rb"[0-9]{1,20}(\.[0-9]{0,20})?([eE][+-]?[0-9]{1,2})?")
_BAD = 255

# By character, whether its cell is solid.
_TABLE = np.full(256, _BAD, np.uint8)
_TABLE[list(PASSABLE)] = 0
_TABLE[list(BLOCKED)] = 1


def read_movingai(path: Path, *, cell_size: float = DEFAULT_CELL_SIZE) -> ForeignMap:
    """Read a map of ``type octile``.

    Args:
        path: The ``.map`` file; LF or CRLF.
        cell_size: Side of a cell, m; the format has no units.

    Raises:
        FormatError: If the header is wrong or the rows do not match it, with the line.
    """
    data = read_bounded(path)
    walls = flip_rows(_parse(data) != 0)
    return _with_only_problem(ForeignMap(walls, cell_size), path)


def _with_only_problem(found: ForeignMap, path: Path) -> ForeignMap:
    """Return the map with start and goal of the scenario file next to it.

    The scenario file counts only if it has exactly one problem.

    A benchmark's scenario files have hundreds of problems, and none of them is more likely to be
    meant than another. A file with one problem, as written by ``export``, leaves no choice.
    """
    for name in (f"{path.name}.scen", f"{path.stem}.scen"):
        scenario_file = path.with_name(name)
        try:
            if not scenario_file.is_file() or scenario_contents(scenario_file)[1] != 1:
                continue
            height, width = found.walls.shape
            problem = read_scenario(scenario_file, 1, width, height, found.cell_size)
        except (FormatError, OSError) as error:
            return replace(found, warnings=(f"{name} next to the map was skipped: {error}",))
        note = Note(
            "scenario-beside-used",
            "start and goal come from the only problem in {file}, which belongs to this map",
            "use --seed to choose other places",
            at_terminal=True,
            file=name,
        )
        radius = float(SCENARIO_RADIUS * exact(found.cell_size))
        robots = (ForeignRobot(problem.start, problem.goal, radius),)
        return replace(found, robots=robots, notes=(note,))
    return found


def _parse(data: bytes) -> Bytes:
    """Return the cells, top row first: 1 is solid."""
    head = unix_text(data).split(b"\n", _FIRST_ROW - 1)
    lines = [line.removesuffix(b"\r") for line in head]
    kind = _words(lines, 1, "type").lower()
    if kind != b"octile":
        corners = kind == b"octile-corner"
        raise FormatError(
            "unsupported",
            "type {kind!q} cannot be read; its corner heights are not cells"
            if corners
            else "type {kind!q} cannot be read",
            "use a map of `type octile`",
            kind=kind.decode("utf-8", "backslashreplace"),
            line=1,
        )
    # Some programs write the width first. Each number has its name, so both orders are accepted.
    first, second = (
        ("height", "width")
        if lines[1:2] and lines[1].lower().split()[:1] != [b"width"]
        else ("width", "height")
    )
    sizes = {key: _size(_words(lines, at, key), key, at) for at, key in ((2, first), (3, second))}
    height = sizes["height"]
    width = sizes["width"]
    check_sides(width, height, line=3)
    if len(lines) < 4 or lines[3].lower().split() != [b"map"]:
        _expect(lines, 4, "map")
    return _rows(head[4] if len(head) > 4 else b"", width, height)


def _words(lines: list[bytes], number: int, key: str) -> bytes:
    words = lines[number - 1].split() if len(lines) >= number else []
    if len(words) != 2 or words[0].lower() != key.encode():
        _expect(lines, number, f"{key} {'octile' if key == 'type' else 'N'}")
    return words[1]


def _expect(lines: list[bytes], number: int, form: str) -> NoReturn:
    ended = len(lines) < number or (len(lines) == number and not lines[-1])
    came = "the end of the file" if ended else quote(lines[number - 1])
    raise FormatError(
        "wrong-form",
        "{came} is in place of `{form}`; an octile map begins with the lines type, height, "
        "width, map",
        came=came,
        form=form,
        line=number,
    )


def _size(word: bytes, key: str, number: int) -> int:
    if not re.fullmatch(rb"[0-9]{1,9}", word):
        raise FormatError(
            "not-a-number",
            "{key} {word!q} is not a whole number of cells",
            "write the number that the rows below have",
            key=key,
            word=word,
            line=number,
        )
    return int(word)


def _rows(body: bytes, width: int, height: int) -> Bytes:
    # The header's sizes limit the split, so a file of line ends takes no more memory than its own
    # size.
    rows = [row.rstrip() for row in body.split(b"\n", height)]
    rest = rows.pop() if len(rows) > height else b""
    # An empty last row only means that the file ends with a line end.
    if rows and not rows[-1]:
        rows.pop()
    for index, row in enumerate(rows):
        if len(row) != width:
            _check_characters(row, index)
            raise FormatError(
                "ragged-rows",
                "a row of {cells} cells; the header has width {width}; every row has that many "
                "cells",
                "perhaps its width and height are swapped" if len(row) == height else "",
                cells=len(row),
                width=width,
                line=_FIRST_ROW + index,
            )
    if len(rows) < height:
        raise FormatError(
            "wrong-size",
            "{rows} rows; the header has height {height}",
            "add the missing rows or correct the header",
            rows=len(rows),
            height=height,
            line=_FIRST_ROW + len(rows),
        )
    if rest.strip():
        raise FormatError(
            "wrong-size",
            "more than the {height} rows of the header",
            "correct `height`, or delete the rest",
            height=height,
            line=_FIRST_ROW + height,
        )
    cells = _TABLE[np.frombuffer(b"".join(rows), np.uint8).reshape(height, width)]
    if (cells == _BAD).any():
        index = int(np.argmax(cells == _BAD)) // width
        _check_characters(rows[index], index)
    return cells


def _check_characters(row: bytes, index: int) -> None:
    strange = np.flatnonzero(_TABLE[np.frombuffer(row, np.uint8)] == _BAD)
    if len(strange):
        column = int(strange[0])
        raise FormatError(
            "unknown-sign",
            "character {sign!q} at column {column} is not an octile cell",
            ". G S are passable, @ O T W are blocked",
            sign=row[column : column + 1],
            column=column + 1,
            line=_FIRST_ROW + index,
        )


@dataclass(frozen=True)
class Problem:
    """One problem of a scenario file: start and goal in m, cell centres, y up.

    Args:
        start: (x, y).
        goal: (x, y).
        optimal: Length of the benchmark's shortest path, cells: diagonal steps, no corner cut.
        map_name: The map's name as the file gives it.
    """

    start: tuple[float, float]
    goal: tuple[float, float]
    optimal: float
    map_name: str


@names_its_file
def read_scenario(path: Path, row: int, width: int, height: int, cell_size: float) -> Problem:
    """Read problem number ``row``, counted from 1, of a scenario file.

    Args:
        path: The ``.scen`` file.
        row: Number of the problem.
        width: Cells of the map in x; the file must name the same.
        height: Cells of the map in y; the file must name the same.
        cell_size: m.

    Raises:
        FormatError: If the file or the line is not a scenario, or is for a map of another size.
        InvalidParameter: If ``row`` is below 1 or above the size of any benchmark file.
    """
    # Read the file only up to the problem.
    check_between("row", row, 1, _MAX_SCENARIOS)
    lines = unix_text(read_bounded(path, _MAX_SCENARIO_BYTES)).split(b"\n", row + 1)
    _check_version(lines[0])
    if len(lines) <= row or not lines[row].strip():
        count = sum(1 for line in lines[1:] if line.strip())
        raise FormatError(
            "out-of-range", "has no row {row}", "it has rows 1 to {rows}", row=row, rows=count
        )
    # Check that it is about this map.
    line = lines[row].removesuffix(b"\r")
    fields = _fields(line, row + 1)
    numbers = [int(field) for field in fields[2:8]]
    if numbers[:2] != [width, height]:
        raise FormatError(
            "wrong-size",
            "the problem is for a map of {problem_width} x {problem_height} cells, the map has "
            "{width} x {height}",
            "use the map that it was made for, in that size",
            problem_width=numbers[0],
            problem_height=numbers[1],
            width=width,
            height=height,
            line=row + 1,
        )
    for column, line_from_top in (numbers[2:4], numbers[4:6]):
        if column >= width or line_from_top >= height:
            raise FormatError(
                "outside-grid",
                "cell ({column}, {row}) is outside the map of {width} x {height} cells",
                "correct the line",
                column=column,
                row=line_from_top,
                width=width,
                height=height,
                line=row + 1,
            )
    # Scenarios count rows from the top.
    start, goal = (
        cell_centre(numbers[at], height - 1 - numbers[at + 1], cell_size) for at in (2, 4)
    )
    return Problem(start, goal, float(fields[8]), fields[1].decode("utf-8", "backslashreplace"))


def _check_version(line: bytes) -> None:
    if not re.fullmatch(rb"version\s+1(\.[0-9]+)?", line.lower().strip()):
        raise FormatError(
            "wrong-form",
            "{came!q} is in place of `version 1`",
            "use a scenario file",
            came=line,
            line=1,
        )


@names_its_file
def scenario_contents(path: Path) -> tuple[str, int]:
    """Return the file name of the map that a ``.scen`` file is for, and its number of problems.

    Args:
        path: The scenario file; its first problem names the map.

    Raises:
        FormatError: If it is not a scenario file, or has no problem.
    """
    lines = unix_text(read_bounded(path, _MAX_SCENARIO_BYTES)).split(b"\n", _MAX_SCENARIOS)
    _check_version(lines[0])
    rows = [line for line in lines[1:] if line.strip()]
    if not rows:
        raise FormatError("empty", "has no problem", "use a scenario file that has some")
    return _map_name(_fields(rows[0].removesuffix(b"\r"), 2)[1]), len(rows)


def _map_name(field: bytes) -> str:
    return field.decode("utf-8", "backslashreplace").replace("\\", "/").rpartition("/")[2]


def _fields(line: bytes, number: int) -> list[bytes]:
    """Split a problem into its nine fields.

    Names may contain spaces only if tabs separate the fields.
    """
    too_long = len(line) > _MAX_SCENARIO_LINE
    parts = [] if too_long else line.split(b"\t") if b"\t" in line else line.split()
    fields = [part.strip() for part in parts]
    whole = [re.fullmatch(rb"[0-9]{1,9}", field) for field in fields[2:8]]
    if len(fields) != 9 or not all(whole) or not _LENGTH.fullmatch(fields[8]):
        raise FormatError(
            "wrong-form",
            "{came!q} is not a problem; nine fields: bucket, map, width, height, start x, "
            "start y, goal x, goal y, optimal length",
            came=line,
            line=number,
        )
    return fields


def write_movingai(world: World, destination: Destination) -> Exported:
    """Return a map of ``.`` and ``@``, and a scenario file with a problem for each robot.

    Each leads from the start's cell to the target's. Programs for several robots take the first
    problems of a file as the robots of one task.

    Args:
        world: The world.
        destination: Where the map is written; the scenario file gets ``.scen`` after that name.
    """
    from worldgen.interop.geometry.octile import octile_moves

    # Draw the map.
    cells = np.where(flip_rows(world.walls), np.uint8(BLOCKED[0]), np.uint8(PASSABLE[0]))
    head = f"type octile\nheight {world.height}\nwidth {world.width}\nmap\n".encode()
    files = {destination.name: head + b"".join(row.tobytes() + b"\n" for row in cells)}
    # Write each robot's problem. Other programs split the fields at any white space.
    name = re.sub(r"\s", "_", destination.name)
    rows: list[str] = []
    altered: dict[str, str] = {}
    for number in range(1, len(world.robots) + 1):
        alone = world.alone(number)
        start, goal, moved = end_cells(alone)
        moves = octile_moves(flip_rows(world.walls), start, goal)
        if moves is None:
            why = (
                "no path of cells leads from the start to the target, so there is no scenario file"
            )
            lost = "the robot's radius is not stored"
            return Exported(files, {"start": why, "target": why, "robot_radius": lost})
        # By custom, problems are grouped in buckets by the optimal length, 4 cells each.
        optimal = _decimals(*moves)
        bucket = int(optimal.partition(".")[0]) // 4
        fields = (bucket, name, world.width, world.height, *start, *goal, optimal)
        rows.append("\t".join(map(str, fields)))
        altered |= moved
        if radius_in_cells(alone) != SCENARIO_RADIUS:
            altered["robot_radius"] = (
                "the robot's radius is not stored; a scenario's robot has 0.4 cells"
            )
    text = "".join(f"{row}\n" for row in rows)
    files[f"{destination.name}.scen"] = f"version 1\n{text}".encode()
    return Exported(files, altered)


def _decimals(straight: int, diagonal: int) -> str:
    """Return ``straight + diagonal * sqrt(2)`` with eight decimals.

    It is correctly rounded, as in the benchmark's files.
    """
    twice = 2 * straight * 10**8 + math.isqrt(8 * diagonal * diagonal * 10**16)
    whole, rest = divmod((twice + 1) // 2, 10**8)
    return f"{whole}.{rest:08d}"


movingai = Format(
    "movingai",
    "MovingAI octile map, .map",
    (".map",),
    re.compile(rb"type\s"),
    read_movingai,
    write_movingai,
    holds=frozenset({"start", "target", "robot_radius"}),
    robots=True,
    client="MovingAI benchmarks, HOG2",
    usual_robot=GRID_AGENT,
)
