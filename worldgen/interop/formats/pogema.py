"""POGEMA's text maps and configurations: ``#`` is a wall, ``a`` an agent and ``A`` its target.

``@`` and ``$`` are free cells, not walls.

Source: Skrynnik et al., "POGEMA: A Benchmark Platform for Cooperative Multi-Agent Pathfinding",
    2024, ``GridConfig``.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from string import ascii_lowercase, ascii_uppercase
from typing import Literal

import numpy as np

from worldgen.errors import FormatError, InvalidParameter, InvalidWorld
from worldgen.interop.format import Destination, Exported, Format
from worldgen.interop.format.foreign_map import (
    GRID_AGENT,
    ForeignMap,
    ForeignRobot,
    read_bounded,
    unix_text,
)
from worldgen.interop.formats.text import cell_centre, end_cells, equal_rows
from worldgen.interop.readers.pogema_config import KEY_LINE, PogemaTask, read_configuration
from worldgen.support.arrays import Bools, Bytes
from worldgen.support.rows import flip_rows
from worldgen.world import DEFAULT_CELL_SIZE, Value, World

_WALL = b"#"
# Cells that are free for anything, only for agents' starts, only for targets, or for neither.
_FREE = b".@$!"
# Robot radius of GridConfig, cells.
_MAX_SIDE = 4096
_MAX_YAML_BYTES = 16 << 20
_CELL = rb"[.#a-zA-Z@$!]"


def read_pogema(
    path: Path,
    *,
    agent: str = "a",
    agents: Literal["one", "all"] = "one",
    cell_size: float = DEFAULT_CELL_SIZE,
    map_name: str = "",
) -> ForeignMap:
    """Read a map in the form of GridConfig, the top row first, or a YAML file with such maps.

    One agent is the robot, or all agents are robots.

    Args:
        path: The file: a map, in which whitespace around rows and empty rows are ignored; a
            configuration in YAML; or a YAML file of named maps.
        agent: Letter of the agent that is the robot, lower case; its target is the same letter in
            upper case. In a configuration with agents_xy, b is the second agent.
        agents: one: the other agents and their targets are free cells; all: they are robots too,
            in order after the first.
        cell_size: Side of a cell, m.
        map_name: Name of the map, in a file of several.

    Raises:
        FormatError: If rows differ in length, a character is unknown, or a letter occurs twice; or
            if POGEMA places the agents of a configuration at random.
        InvalidParameter: If ``agent`` is not a lower-case letter.
    """
    if not re.fullmatch("[a-z]", agent):
        raise InvalidParameter(
            "wrong-form",
            "agent={agent!r} is not a lower-case letter; agents are a to z",
            agent=agent[:20],
        )
    # Read the rows.
    data = read_bounded(path)
    text = unix_text(data)
    task = _task(text, map_name)
    drawn = _drawn(task.rows)
    walls = drawn == _WALL[0]

    # Find the agents and their targets, by number from 1.
    letters = _letters(drawn, [number for number, _ in task.rows])
    starts = _numbered(letters, ascii_lowercase)
    targets = _numbered(letters, ascii_uppercase)
    warnings: list[str] = []
    if task.starts:
        if letters:
            raise FormatError(
                "twice",
                "the agents' places are given both as letters of the map and as agents_xy",
                "keep one",
            )
        starts = dict(enumerate(task.starts, start=1))
        targets = dict(enumerate(task.targets, start=1))
        warnings += _freed(walls, (*task.starts, *task.targets))
    elif task.places_needed and not starts:
        raise FormatError(
            "random-places",
            "the configuration has no agents_xy and targets_xy, so POGEMA draws the agents' places "
            "at random",
            "write down the places that it drew",
        )
    first = 1 + ascii_lowercase.index(agent)
    if starts and first not in starts:
        raise FormatError(
            "unknown-name",
            "there is no agent {agent!r}",
            "there are {known!l}",
            agent=agent,
            known=[
                ascii_lowercase[number - 1] for number in sorted(starts)[: len(ascii_lowercase)]
            ],
        )

    # Make robots of them.
    def centre(cell: tuple[int, int] | None) -> tuple[float, float] | None:
        return cell and cell_centre(cell[1], drawn.shape[0] - 1 - cell[0], cell_size)

    numbers = [first]
    notes: tuple[str, ...] = ()
    if agents == "all":
        numbers += sorted(starts.keys() - {first})
        absent = [number for number in numbers[1:] if number not in targets]
        if absent:
            letter = ascii_lowercase[absent[0] - 1]
            raise FormatError(
                "missing-target",
                "agent {letter} has no target {target}",
                "draw it, or read one agent only",
                letter=letter,
                target=letter.upper(),
            )
    elif len(starts) > 1:
        notes = (
            f"the robot is agent {agent} of {len(starts)}; the others are ignored; --from "
            f"pogema+agents=all reads them all",
        )
    params: dict[str, Value] = {"agent": agent}
    if task.map_name is not None:
        params["map_name"] = task.map_name
    return ForeignMap(
        flip_rows(walls), cell_size, params, notes, tuple(warnings),
        robots=tuple(
            ForeignRobot(centre(starts.get(number)), centre(targets.get(number)))
            for number in numbers
        ),
        numbers=tuple(numbers),
    )  # fmt: skip


def _task(text: bytes, map_name: str) -> PogemaTask:
    """Return the map's rows and, of a YAML file, the agents."""
    if KEY_LINE.search(text):
        if len(text) > _MAX_YAML_BYTES:
            raise FormatError(
                "too-large",
                "is larger than {most} bytes",
                "cut a smaller map out of it",
                most=_MAX_YAML_BYTES,
            )
        return read_configuration(text, map_name)
    if map_name:
        raise FormatError(
            "unknown-name",
            "it is a map itself, so there is no map {name!q}",
            "omit map_name",
            name=map_name,
        )
    lines = enumerate(text.split(b"\n"), 1)
    return PogemaTask([(number, line.strip()) for number, line in lines if line.strip()])


def _drawn(rows: list[tuple[int, bytes]]) -> Bytes:
    """Return the characters of the rows, all of which are cells."""
    drawn = equal_rows(rows)
    for (number, line), row in zip(rows, drawn, strict=True):
        if not re.fullmatch(_CELL + b"*", line):
            column = next(at for at in range(len(row)) if not re.match(_CELL, line[at : at + 1]))
            raise FormatError(
                "unknown-sign",
                "{sign!q} in column {column} is not a cell; # is a wall, . @ $ ! are free, "
                "letters are agents and their targets",
                sign=line[column : column + 1],
                column=column + 1,
                line=number,
            )
    return drawn


def _numbered(letters: Mapping[str, tuple[int, int]], alphabet: str) -> dict[int, tuple[int, int]]:
    """Return the cells of an alphabet's letters by the letters' numbers, from 1."""
    return {
        number: letters[letter] for number, letter in enumerate(alphabet, 1) if letter in letters
    }


def _freed(walls: Bools, places: Iterable[tuple[int, int]]) -> Iterator[str]:
    """Free the cells of agents and targets that are solid, as POGEMA does, and report it."""
    solid = {place for place in places if walls[place]}
    for place in solid:
        walls[place] = False
    if solid:
        yield (
            f"cells with an agent or a target that are walls in the map: {len(solid)}; they are "
            f"free, as in POGEMA"
        )


def _letters(drawn: Bytes, numbers: list[int]) -> dict[str, tuple[int, int]]:
    """Return the row and column of each letter."""
    found: dict[str, tuple[int, int]] = {}
    for row, column in np.argwhere(
        (drawn | 0x20 >= ord("a")) & (drawn | 0x20 <= ord("z"))
    ).tolist():
        letter = chr(drawn[row, column])
        if letter in found:
            raise FormatError(
                "twice",
                "{letter} occurs twice; each agent has only one place, so remove one",
                letter=letter,
                line=numbers[row],
            )
        found[letter] = (row, column)
    return found


def write_pogema(world: World, destination: Destination) -> Exported:
    """Return a map with an agent for each robot, ``a`` to ``A`` and so on, the top row first.

    More robots than there are letters make a configuration in YAML.
    """
    # Choose the form: letters, as long as there are enough.
    notes: tuple[str, ...] = ()
    if max(world.width, world.height) > _MAX_SIDE:
        notes = (f"POGEMA itself takes maps of up to {_MAX_SIDE} cells a side",)
    cells = np.where(flip_rows(world.walls), np.uint8(_WALL[0]), np.uint8(_FREE[0]))
    if len(world.robots) > len(ascii_lowercase):
        return _configuration(world, cells, destination, notes)
    altered: dict[str, str] = {}
    # Draw each agent and its target, unless they share a cell or a wall is in the way.
    for number, letter in enumerate(ascii_lowercase[: len(world.robots)], start=1):
        alone = world.alone(number)
        start, target, moved = end_cells(alone)
        taken = [int(cells[row, column]) for column, row in (start, target)]
        if start != target and taken == [_FREE[0]] * 2:
            altered |= moved
            cells[start[1], start[0]] = ord(letter)
            cells[target[1], target[0]] = ord(letter.upper())
        elif world.is_fleet:
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
    return Exported(
        {destination.name: b"".join(row.tobytes() + b"\n" for row in cells)}, altered, notes
    )


def _configuration(
    world: World, cells: Bytes, destination: Destination, notes: tuple[str, ...]
) -> Exported:
    """Return a configuration, which holds any number of agents."""
    altered: dict[str, str] = {}
    starts: dict[tuple[int, int], int] = {}
    targets: dict[tuple[int, int], int] = {}
    for number in range(1, len(world.robots) + 1):
        alone = world.alone(number)
        start, target, moved = end_cells(alone)
        # Agents may not begin in one cell, or have the same target.
        free = [int(cells[row, column]) for column, row in (start, target)] == [_FREE[0]] * 2
        if not free or starts.setdefault(start, number) + targets.setdefault(target, number) != (
            2 * number
        ):
            raise InvalidWorld(
                "cells-taken",
                "robot {number}: the cell of its start or target is in a wall, or belongs to "
                "another robot",
                "export it as movingai",
                number=number,
            )
        altered |= moved
    lines = ["# A world made by worldgen for POGEMA; positions are [row, column].", "map: |-"]
    lines += [f"  {row.tobytes().decode()}" for row in cells]
    lines.append(f"num_agents: {len(world.robots)}")
    for name, places in (("agents_xy", starts), ("targets_xy", targets)):
        lines += [f"{name}:", *(f"  - [{row}, {column}]" for column, row in places)]
    return Exported({destination.name: ("\n".join(lines) + "\n").encode()}, altered, notes)


# What agents see, do and score.
_HARMLESS = frozenset({
    "possible_agents_xy", "possible_targets_xy", "num_agents", "seed", "size", "width", "height", "density",
    "obs_radius", "on_target", "collision_system", "observation_type", "max_episode_steps", "integration",
    "persistent", "auto_reset", "map_name",
})  # fmt: skip

pogema = Format(
    "pogema",
    "map or configuration of POGEMA, .pogema",
    # Also .txt; the contents distinguish it from a drawing.
    (".pogema",),
    re.compile(
        rb"(?=[.#A-Z@$!\s]*[a-z@$!])(?:\s*(?=[a-zA-Z@$!]*[.#])"
        + _CELL
        + rb"+[ \t]*(?:\r?\n)){1,2}\s*"
        rb"(?=[a-zA-Z@$!]*[.#])" + _CELL + rb"+[ \t]*(?:\r?\n|\Z)"
        # A configuration, or a file of maps: rows of cells in a block below a key.
        rb"|(?s:.*\n)?[^\s:#][^:\n]*:[ \t]*\|[-+]?[ \t]*\r?\n(?:[ \t]+"
        rb"(?=[a-zA-Z@$!]*[.#])" + _CELL + rb"+[ \t]*(?:\r?\n|\Z)){2}"
        rb"|(?s:.*\n)?agents_xy[ \t]*:"
    ),
    read_pogema,
    write_pogema,
    holds=frozenset({"start", "target"}),
    robots=True,
    client="POGEMA",
    harmless=_HARMLESS,
    usual_robot=GRID_AGENT,
)
