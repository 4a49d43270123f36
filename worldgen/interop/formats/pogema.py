"""POGEMA's text maps: ``#`` is a wall, ``a`` an agent and ``A`` its target.

``@`` and ``$`` are free cells, not walls.

Source: Skrynnik et al., "POGEMA: A Benchmark Platform for Cooperative Multi-Agent Pathfinding",
    2024, ``GridConfig``.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import numpy.typing as npt

from worldgen.errors import FormatError, InvalidParameter
from worldgen.interop.foreign_map import GRID_AGENT, ForeignMap, digest, read_bounded, unix_text
from worldgen.interop.format import Destination, Exported, Format
from worldgen.interop.formats.text import cell_centre, cell_of, equal_rows, off_centre
from worldgen.support.rows import flip_rows
from worldgen.world import DEFAULT_CELL_SIZE, Value, World

__all__ = ["pogema", "read_pogema", "write_pogema"]

_WALL = b"#"
# Free for anything; only agents may begin; only targets may be; neither may be.
_FREE = b".@$!"
# Robot radius of GridConfig, cells.
_MAX_SIDE = 4096
_CELL = rb"[.#a-zA-Z@$!]"


def read_pogema(
    path: Path, *, agent: str = "a", cell_size: float = DEFAULT_CELL_SIZE
) -> ForeignMap:
    """Read a map in the form GridConfig takes, the top row first.

    One agent is the robot; other agents and their targets are free cells.

    Args:
        path: The file; white space around rows and empty rows are ignored.
        agent: Letter of the agent that is the robot, lower case; its target is the same letter in
            upper case.
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
    agents = [letter for letter in letters if letter.islower()]
    if agents and agent not in agents:
        raise InvalidParameter(
            "unknown-name",
            "{source}: there is no agent {agent!r}",
            "there are {known!l}",
            source=source,
            agent=agent,
            known=sorted(agents),
        )
    places = [
        cell_centre(letters[name][1], drawn.shape[0] - 1 - letters[name][0], cell_size)
        if name in letters
        else None
        for name in (agent, agent.upper())
    ]
    notes = (
        ()
        if len(agents) < 2
        else (f"the robot is agent {agent} of {len(agents)}; the others are not there",)
    )
    params: dict[str, Value] = {
        "format": "pogema",
        "source": path.name,
        "sha256": digest(data),
        "agent": agent,
    }
    return ForeignMap(
        flip_rows(drawn == _WALL[0]), cell_size, params, notes, start=places[0], target=places[1]
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
                "{letter} is there twice; each agent has one place, so take one out",
                letter=letter,
                line=numbers[row],
                source=source,
            )
        found[letter] = (row, column)
    return found


def write_pogema(world: World, destination: Destination) -> Exported:
    """Return a map with one agent, ``a`` to ``A``, the top row first.

    Args:
        world: The world.
        destination: Where the file is written.
    """
    # Draw the agent and its target, unless they share a cell or a wall is in the way.
    cells = np.where(flip_rows(world.walls), np.uint8(_WALL[0]), np.uint8(_FREE[0]))
    start = cell_of(world, world.start.x, world.start.y)
    target = cell_of(world, world.target.x, world.target.y)
    altered = off_centre(world, (start, target))
    if start == target or _WALL[0] in (cells[start[1], start[0]], cells[target[1], target[0]]):
        because = "they are one cell" if start == target else "one of them is in a wall"
        why = f"start and target are not drawn, for {because}"
        altered = {"start": why, "target": why}
    else:
        cells[start[1], start[0]], cells[target[1], target[0]] = b"aA"
    notes: tuple[str, ...] = ()
    if max(world.width, world.height) > _MAX_SIDE:
        notes = (f"POGEMA itself takes maps of up to {_MAX_SIDE} cells a side",)
    return Exported(
        {destination.name: b"".join(row.tobytes() + b"\n" for row in cells)}, altered, notes
    )


pogema = Format(
    "pogema",
    "map of POGEMA, a character a cell, .pogema",
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
    client="POGEMA",
    usual_robot=GRID_AGENT,
)
