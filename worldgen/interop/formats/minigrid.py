"""MiniGrid's printed grids: two characters per cell, as ``pprint_grid`` writes them.

Source: Chevalier-Boisvert et al., "Minigrid & Miniworld", 2023, ``MiniGridEnv.pprint_grid``.
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Literal

import numpy as np

from worldgen.errors import FormatError
from worldgen.interop.format import Destination, Exported, Format
from worldgen.interop.format.foreign_map import (
    GRID_AGENT,
    ForeignMap,
    ForeignRobot,
    check_sides,
    read_bounded,
)
from worldgen.interop.formats.text import cell_centre, end_cells, text_rows
from worldgen.support.arrays import Bytes
from worldgen.support.rows import flip_rows
from worldgen.world import DEFAULT_CELL_SIZE, Value, World

_HEADINGS = {b">>": 0.0, b"^^": math.pi / 2, b"<<": math.pi, b"VV": -math.pi / 2}
# Red, green or grey, blue, purple, yellow.
_COLOURS = b"RGBPY"
_FREE = b"  "
_WALL = b"WG"
_GOAL = b"GG"
_WORDS = rb"(?:  |>>|VV|<<|\^\^|__|[WFDLKABGV][" + _COLOURS + rb"])"
_WORD = re.compile(_WORDS)


def read_minigrid(
    path: Path,
    *,
    doors: Literal["free", "solid"] = "free",
    things: Literal["free", "solid"] = "solid",
    cell_size: float = DEFAULT_CELL_SIZE,
) -> ForeignMap:
    """Read a printed grid, the top row first.

    The agent is the robot, with its heading; the first goal is the target.

    Args:
        path: The file; rows whose trailing blanks an editor removed are filled up.
        doors: How to treat closed and locked doors; open ones are free.
        things: How to treat keys, balls and boxes; lava is always solid, floor always free.
        cell_size: Side of a cell, m.

    Raises:
        FormatError: If two characters do not make a cell, or there are two agents.
    """
    # Read the cells, two characters each.
    data = read_bounded(path)
    rows = text_rows(data)
    width = (max(map(len, rows), default=0) + 1) // 2
    check_sides(width, len(rows))
    drawn = np.frombuffer(b"".join(row.ljust(2 * width) for row in rows), np.uint8).reshape(
        len(rows), width, 2
    )
    first = drawn[:, :, 0]
    second = drawn[:, :, 1]
    _check_words(rows)
    # Decide which cells are solid.
    solid = (first == ord("W")) | ((first == ord("V")) & (second != ord("V")))
    shut = np.isin(first, list(b"DL"))
    lying = np.isin(first, list(b"KAB"))
    solid |= (shut & (doors == "solid")) | (lying & (things == "solid"))
    # Find the agent and its goal.
    agents = _agents(drawn)
    goals = np.argwhere(first == ord("G")).tolist()
    if len(agents) > 1:
        raise FormatError(
            "twice", "{agents} agents", "keep one", agents=len(agents), line=agents[1][0] + 1
        )
    # Report the effect of the options.
    notes = _notes(
        {"doors": int(shut.sum()), "things": int(lying.sum())}, {"doors": doors, "things": things}
    )
    if len(goals) > 1:
        notes.append(
            f"there are {len(goals)} goals; the target is the first, row by row from the top"
        )
    start = (
        None
        if not agents
        else (
            *_centre(agents[0], len(rows), cell_size),
            _HEADINGS[drawn[tuple(agents[0])].tobytes()],
        )
    )
    target = _centre(goals[0], len(rows), cell_size) if goals else None
    params: dict[str, Value] = {"doors": doors, "things": things}
    robots = (ForeignRobot(start, target),)
    return ForeignMap(flip_rows(solid), cell_size, params, tuple(notes), robots=robots)


def _check_words(rows: list[bytes]) -> None:
    for number, row in enumerate(rows, 1):
        line = row + b" " * (len(row) % 2)
        if re.fullmatch(_WORDS + b"*", line):
            continue
        at = next(at for at in range(0, len(line), 2) if not _WORD.fullmatch(line, at, at + 2))
        raise FormatError(
            "unknown-sign",
            "{sign!q} in column {column} is not a cell; a cell is two characters: kind and colour "
            "(WG a grey wall, GG a green goal), two blanks, or the agent, >> VV << ^^",
            sign=line[at : at + 2],
            column=at + 1,
            line=number,
        )


def _agents(drawn: Bytes) -> list[list[int]]:
    words = [np.all(drawn == np.frombuffer(word, np.uint8), axis=2) for word in _HEADINGS]
    found: list[list[int]] = np.argwhere(np.logical_or.reduce(words)).tolist()
    return found


def _centre(at: list[int], height: int, cell_size: float) -> tuple[float, float]:
    return cell_centre(at[1], height - 1 - at[0], cell_size)


def _notes(counts: dict[str, int], taken: dict[str, str]) -> list[str]:
    words = {"doors": "closed doors", "things": "keys, balls and boxes"}
    return [
        f"{counts[name]} cells are {words[name]}; they count as {taken[name]}; change this with "
        f"+{name}="
        for name in counts
        if counts[name]
    ]


def write_minigrid(world: World, destination: Destination) -> Exported:
    """Write a printed grid of grey walls, one agent and one green goal, the top row first."""
    # Draw floor and walls.
    walls = flip_rows(world.walls)
    cells = np.empty((*walls.shape, 2), np.uint8)
    cells[:] = np.frombuffer(_FREE, np.uint8)
    cells[walls] = np.frombuffer(_WALL, np.uint8)
    # Draw the goal and the agent, and report what gets lost.
    start, target, altered = end_cells(world)
    turned = math.remainder(world.start.heading, 2 * math.pi)
    nearest = min(
        _HEADINGS, key=lambda word: abs(math.remainder(turned - _HEADINGS[word], 2 * math.pi))
    )
    # The agent is drawn on top.
    for name, (column, row), word in (("target", target, _GOAL), ("start", start, nearest)):
        if walls[row, column]:
            altered[name] = f"the {name} is not drawn, because its cell is solid"
        else:
            cells[row, column] = np.frombuffer(word, np.uint8)
    if start == target:
        altered["target"] = "the target is not drawn, because its cell is the start's"
    if _HEADINGS[nearest] != world.start.heading or walls[start[1], start[0]]:
        altered["heading"] = (
            f"the heading, {world.start.heading:g} rad, is stored as the nearest quarter turn"
        )
    # Warn about an open border.
    notes: tuple[str, ...] = ()
    if not (walls[0].all() and walls[-1].all() and walls[:, 0].all() and walls[:, -1].all()):
        notes = ("the border is open; MiniGrid's own agents fail where they leave the grid",)
    return Exported(
        {destination.name: b"".join(row.tobytes() + b"\n" for row in cells)}, altered, notes
    )


minigrid = Format(
    "minigrid",
    "printed grid of MiniGrid, two characters per cell, .minigrid",
    # Also .txt; the contents distinguish it from a drawing.
    (".minigrid",),
    re.compile(
        rb"(?=[^#]*?W[" + _COLOURS + rb"])" + _WORDS + rb"+ ?\r?\n" + _WORDS + rb"+ ?(?:\r?\n|\Z)"
    ),
    read_minigrid,
    write_minigrid,
    holds=frozenset({"start", "heading", "target"}),
    client="MiniGrid",
    usual_robot=GRID_AGENT,
)
