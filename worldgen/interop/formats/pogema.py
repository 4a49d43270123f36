"""POGEMA's text maps: ``#`` is a wall, ``a`` an agent and ``A`` its target.

``@`` and ``$`` are free cells, not walls.

Source: Skrynnik et al., "POGEMA: A Benchmark Platform for Cooperative Multi-Agent Pathfinding",
    2024, ``GridConfig``.
"""

from __future__ import annotations

import re
from pathlib import Path
from string import ascii_lowercase
from typing import Literal

import numpy as np
import numpy.typing as npt

from worldgen.errors import FormatError, InvalidParameter, InvalidWorld
from worldgen.interop.foreign_map import (
    GRID_AGENT,
    ForeignMap,
    ForeignRobot,
    digest,
    read_bounded,
    unix_text,
)
from worldgen.interop.format import Destination, Exported, Format
from worldgen.interop.formats.text import cell_centre, cell_of, equal_rows, off_centre
from worldgen.support.rows import flip_rows
from worldgen.world import DEFAULT_CELL_SIZE, Value, World

__all__ = ["pogema", "read_pogema", "write_pogema"]

_WALL = b"#"
# Cells that are free for anything, only for starts of agents, only for targets, or for neither.
_FREE = b".@$!"
# Robot radius of GridConfig, cells.
_MAX_SIDE = 4096
_CELL = rb"[.#a-zA-Z@$!]"


def read_pogema(
    path: Path,
    *,
    agent: str = "a",
    agents: Literal["one", "all"] = "one",
    cell_size: float = DEFAULT_CELL_SIZE,
) -> ForeignMap:
    """Read a map in the form GridConfig takes, the top row first.

    One agent is the robot, or all agents are robots.

    Args:
        path: The file; white space around rows and empty rows are ignored.
        agent: Letter of the agent that is the robot, lower case; its target is the same letter in
            upper case.
        agents: one: the other agents and their targets are free cells; all: they are robots too,
            by letter after the first.
        cell_size: Side of a cell, m.

    Raises:
        FormatError: If rows differ in length, a character is unknown, or a letter occurs twice.
        InvalidParameter: If ``agent`` is not a lower-case letter, or is missing from a map that has
            others.
    """
    if not re.fullmatch("[a-z]", agent):
        raise InvalidParameter(
            "wrong-form",
            "agent={agent!r} is not a lower-case letter; agents are a to z",
            agent=agent[:20],
        )
    # Read the rows.
    data = read_bounded(path)
    source = str(path)
    lines = [
        (number, line.strip())
        for number, line in enumerate(unix_text(data).split(b"\n"), 1)
        if line.strip()
    ]
    drawn = equal_rows(lines, source)
    for (number, line), row in zip(lines, drawn, strict=True):
        if not re.fullmatch(_CELL + b"*", line):
            column = next(at for at in range(len(row)) if not re.match(_CELL, line[at : at + 1]))
            raise FormatError(
                "unknown-sign",
                "{sign!q} in column {column} is not a cell; # is a wall, . @ $ ! are free, "
                "letters are agents and their targets",
                sign=line[column : column + 1],
                column=column + 1,
                line=number,
                source=source,
            )
    # Find the agents and their targets.
    letters = _letters(drawn, [number for number, _ in lines], source)
    lower = [letter for letter in letters if letter.islower()]
    if lower and agent not in lower:
        raise FormatError(
            "unknown-name",
            "there is no agent {agent!r}",
            "there are {known!l}",
            agent=agent,
            known=sorted(lower),
            source=source,
        )
    centres = {
        letter: cell_centre(column, drawn.shape[0] - 1 - row, cell_size)
        for letter, (row, column) in letters.items()
    }
    others: list[ForeignRobot] = []
    read = [agent]
    notes: tuple[str, ...] = ()
    if agents == "all":
        for letter in sorted(set(lower) - {agent}):
            if letter.upper() not in centres:
                raise FormatError(
                    "missing-target",
                    "agent {letter} has no target {target}",
                    "draw it, or read one agent only",
                    letter=letter,
                    target=letter.upper(),
                    source=source,
                )
            others.append(ForeignRobot(centres[letter], centres[letter.upper()]))
            read.append(letter)
    elif len(lower) > 1:
        notes = (
            f"the robot is agent {agent} of {len(lower)}; the others are ignored; --from "
            f"pogema+agents=all reads them all",
        )
    params: dict[str, Value] = {
        "format": "pogema",
        "source": path.name,
        "sha256": digest(data),
        "agent": agent,
    }
    return ForeignMap(
        flip_rows(drawn == _WALL[0]), cell_size, params, notes,
        start=centres.get(agent), target=centres.get(agent.upper()), others=tuple(others),
        numbers=tuple(1 + ascii_lowercase.index(letter) for letter in read),
    )  # fmt: skip


def _letters(
    drawn: npt.NDArray[np.uint8], numbers: list[int], source: str
) -> dict[str, tuple[int, int]]:
    """Return the row and column of each letter."""
    found: dict[str, tuple[int, int]] = {}
    for row, column in np.argwhere(
        (drawn | 0x20 >= ord("a")) & (drawn | 0x20 <= ord("z"))
    ).tolist():
        letter = chr(drawn[row, column])
        if letter in found:
            raise FormatError(
                "twice",
                "{letter} occurs twice; each agent has one place, so remove one",
                letter=letter,
                line=numbers[row],
                source=source,
            )
        found[letter] = (row, column)
    return found


def write_pogema(world: World, destination: Destination) -> Exported:
    """Return a map with an agent for each robot, ``a`` to ``A`` and so on, the top row first.

    Args:
        world: The world.
        destination: Where the file is written.
    """
    # An agent is a letter, so their number has a limit.
    if len(world.robots) > len(ascii_lowercase):
        raise InvalidWorld(
            "too-many-robots",
            "{count} robots; a map of POGEMA has letters for {most}",
            "export it as movingai",
            count=len(world.robots),
            most=len(ascii_lowercase),
        )
    # Draw each agent and its target, unless they share a cell or a wall is in the way.
    cells = np.where(flip_rows(world.walls), np.uint8(_WALL[0]), np.uint8(_FREE[0]))
    altered: dict[str, str] = {}
    for number, letter in enumerate(ascii_lowercase[: len(world.robots)], start=1):
        alone = world.alone(number) if world.others else world
        start = cell_of(alone, alone.start.x, alone.start.y)
        target = cell_of(alone, alone.target.x, alone.target.y)
        taken = [int(cells[row, column]) for column, row in (start, target)]
        if start != target and taken == [_FREE[0]] * 2:
            altered |= off_centre(alone, (start, target))
            cells[start[1], start[0]] = ord(letter)
            cells[target[1], target[0]] = ord(letter.upper())
        elif world.others:
            raise InvalidWorld(
                "cells-taken",
                "robot {number}: a cell holds one letter, but the cells of its start and target "
                "coincide, are in a wall, or belong to another robot",
                "export it as movingai",
                number=number,
            )
        else:
            because = "they are the same cell" if start == target else "one of them is in a wall"
            why = f"start and target are not drawn, because {because}"
            altered = {"start": why, "target": why}
    notes: tuple[str, ...] = ()
    if max(world.width, world.height) > _MAX_SIDE:
        notes = (f"POGEMA itself takes maps of up to {_MAX_SIDE} cells a side",)
    return Exported(
        {destination.name: b"".join(row.tobytes() + b"\n" for row in cells)}, altered, notes
    )


pogema = Format(
    "pogema",
    "map of POGEMA, one character per cell, .pogema",
    # Also .txt; the contents tell it from a drawing.
    (".pogema",),
    re.compile(
        rb"(?=[.#A-Z@$!\s]*[a-z@$!])(?:\s*(?=[a-zA-Z@$!]*[.#])"
        + _CELL
        + rb"+[ \t]*(?:\r?\n)){1,2}\s*"
        rb"(?=[a-zA-Z@$!]*[.#])" + _CELL + rb"+[ \t]*(?:\r?\n|\Z)"
    ),
    read_pogema,
    write_pogema,
    holds=frozenset({"start", "target"}),
    robots=True,
    client="POGEMA",
    usual_robot=GRID_AGENT,
)
