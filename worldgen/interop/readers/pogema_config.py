"""Read POGEMA's YAML files: a configuration with the agents' places, or a file of named maps.

POGEMA counts positions as row and column from the top left. Source: Skrynnik et al., "POGEMA: A
Benchmark Platform for Cooperative Multi-Agent Pathfinding", 2024, ``GridConfig``; pogema-toolbox,
``maps.yaml``.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from worldgen.errors import FormatError
from worldgen.interop.readers.yaml_table import YamlTable, read_yaml

# A map's rows have no colon.
KEY_LINE = re.compile(rb"(?m)^[ \t]*[^\s:#.@$!][^:\n]*:(?:[ \t\r\n]|\Z)")
_EXAMPLE = "a configuration of POGEMA has `map: |-` and, below it, the map's rows"
# Keys of GridConfig besides the map; a file with one of them is a configuration.
_KEYS = frozenset({
    "agents_xy", "targets_xy", "possible_agents_xy", "possible_targets_xy", "num_agents", "seed",
    "size", "width", "height", "density", "obs_radius", "on_target", "collision_system",
    "observation_type", "max_episode_steps", "integration", "persistent", "auto_reset", "map_name",
})  # fmt: skip
_Cell = tuple[int, int]


@dataclass(frozen=True)
class PogemaTask:
    """The contents of a YAML file.

    Args:
        rows: Line number and text of each row of the map, the top row first.
        starts: Row and column of each agent's start.
        targets: Row and column of each agent's target.
        places_needed: True if agents must have places, here or as letters in the map.
        map_name: Name of the map, if the file has named maps.
    """

    rows: list[tuple[int, bytes]]
    starts: tuple[_Cell, ...] = ()
    targets: tuple[_Cell, ...] = ()
    places_needed: bool = False
    map_name: str | None = None


def read_configuration(text: bytes, map_name: str) -> PogemaTask:
    """Read a configuration, or one map of a file of named maps.

    Args:
        text: The file.
        map_name: Name of the map in a file of named maps; may be empty if there is only one.

    Raises:
        FormatError: If a key has a wrong value, or POGEMA itself would choose a place or a map.
    """
    top = read_yaml(text, _EXAMPLE)
    if not _KEYS.intersection(top):
        return _named_map(top, map_name)

    # A configuration needs its own map.
    if map_name:
        raise FormatError(
            "unknown-name",
            "it is a configuration, which has one map, so there is no map {name!q}",
            "omit map_name",
            name=map_name,
        )
    if "map" not in top or top.is_null("map"):
        raise FormatError(
            "random-map",
            "it has no map, so POGEMA draws one at random or uses one of its own",
            "write its rows below `map: |-`",
            line=1,
        )
    if "on_target" in top and top.word("on_target") == "restart":
        raise FormatError(
            "random-places",
            "with on_target: restart, POGEMA draws a new target whenever an agent arrives",
            "choose `finish` or `nothing`",
            line=top.line_of("on_target"),
        )

    # Either all agents have places, or none.
    given = [key for key in ("agents_xy", "targets_xy") if key in top and not top.is_null(key)]
    if len(given) == 1:
        raise FormatError(
            "random-places",
            "{key} is given without the other, so POGEMA draws the other places at random",
            "use agents_xy and targets_xy",
            key=given[0],
            line=top.line_of(given[0]),
        )
    rows = _rows(top, "map")
    if not given:
        return PogemaTask(rows, places_needed=True)
    starts, targets = (_cells(top, key, rows) for key in given)
    return PogemaTask(rows, *_agents(top, starts, targets))


def _named_map(top: YamlTable, map_name: str) -> PogemaTask:
    names = list(top)
    if map_name not in top and (map_name or len(names) != 1):
        raise FormatError(
            "unknown-name",
            "it has {count} maps, but none is named {name!q}"
            if map_name
            else "it has {count} maps",
            "choose one with --from pogema+map_name=NAME: {known!l}",
            at_terminal=True,
            count=len(names),
            name=map_name,
            known=names[:10] + ["..."] * (len(names) > 10),
            line=1,
        )
    name = map_name or names[0]
    top.pass_over()  # the other maps are not part of this one
    return PogemaTask(_rows(top, name), map_name=name)


def _rows(top: YamlTable, key: str) -> list[tuple[int, bytes]]:
    """Return the rows of a map, which is a text or lists of 0 and 1."""
    lines = top.lines(key)
    if lines is not None:
        return [(number, word.encode()) for number, line in lines for word in line.split()]
    line = top.line_of(key)
    rows = []
    for row in top.rows(key):
        if any(value not in (0, 1) for value in row):
            raise FormatError(
                "unknown-sign", "a cell of {key} is neither 0 nor 1", key=key, line=top.line_of(key)
            )
        rows.append((line, b"".join(b"#" if value else b"." for value in row)))
    return rows


def _cells(top: YamlTable, key: str, rows: list[tuple[int, bytes]]) -> tuple[_Cell, ...]:
    """Return the cells of a list of positions, all of them in the map."""
    height = len(rows)
    width = len(rows[0][1]) if rows else 0
    cells = []
    for place in top.rows(key):
        if len(place) != 2 or any(value.denominator != 1 for value in place):
            raise FormatError(
                "wrong-count",
                "{key} must be a list of [row, column], one place for each agent",
                key=key,
                line=top.line_of(key),
            )
        row, column = (int(value) for value in place)
        if not (0 <= row < height and 0 <= column < width):
            raise FormatError(
                "outside-grid",
                "{key}: [{row}, {column}] is outside the map of {height} rows and {width} columns",
                "correct it; rows and columns count from 0",
                key=key,
                row=row,
                column=column,
                height=height,
                width=width,
                line=top.line_of(key),
            )
        cells.append((row, column))
    return tuple(cells)


def _agents(
    top: YamlTable, starts: tuple[_Cell, ...], targets: tuple[_Cell, ...]
) -> tuple[tuple[_Cell, ...], tuple[_Cell, ...]]:
    """Return as many starts and targets as there are agents."""
    counted = "num_agents" in top and not top.is_null("num_agents")
    count = int(top.number("num_agents")) if counted else len(starts)
    for key, cells in (("agents_xy", starts), ("targets_xy", targets)):
        # Without their number, every start has a target.
        if len(cells) < count or not (counted or len(cells) == count):
            raise FormatError(
                "wrong-count",
                "{key} has {found} places for {count} agents",
                "give each agent a start and a target",
                key=key,
                found=len(cells),
                count=count,
                line=top.line_of(key),
            )
    if count < 1:
        raise FormatError(
            "empty", "there is no agent", "add at least one", line=top.line_of("num_agents")
        )
    return starts[:count], targets[:count]
