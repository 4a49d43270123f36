"""What a campaign notes of itself for reports: ``.campaign/summary.json`` in its folder."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from worldgen.errors import FormatError
from worldgen.files.whole import read_text

__all__ = ["MEMORY", "Archive", "Find", "Lane", "Summary", "read_summary"]

MEMORY = ".campaign"  # folder, in a campaign's folder, of what it remembers
_FILE = "summary.json"
_VERSION = 1
_MOST_ROWS = 100_000
_STATUSES = ("", "running", "done", "stopped", "failed")


@dataclass(frozen=True)
class Lane:
    """What one way of searching did: ``classes`` counts those that it was the first to find."""

    lane: str
    units: int
    worlds: int
    steps: int
    failures: int
    classes: int


@dataclass(frozen=True)
class Find:
    """A class met for the first time, or in a smaller world; ``worlds`` and what follows are totals up to then."""

    unit: int
    lane: str
    kind: str
    solid_cells: int
    worlds: int
    steps: int
    seconds: float


@dataclass(frozen=True)
class Archive:
    """Behaviours that were met, by two numbers.

    Args:
        names: Of the two numbers.
        edges: Of each number the values that part one cell from the next, so one fewer than there are cells.
        cells: Index along each axis, quality and verdict of the best run of a kind.
    """

    names: tuple[str, str]
    edges: tuple[list[float], list[float]]
    cells: list[tuple[int, int, float, str]]


@dataclass(frozen=True)
class Summary:
    """A campaign in numbers.

    Args:
        folder: Where its failures are.
        controller: Name of the controller.
        motion: Name of the motion model.
        seed: Of all chance.
        status: ``running``, ``done``, ``stopped`` or ``failed``; empty in one of an earlier version.
        units: Units of work done.
        worlds: Worlds tried.
        steps: Steps simulated.
        seconds: Time spent.
        verdicts: How often each verdict was met, at first look.
        met: How often each class was met.
        known: Likewise, of those that were no news.
        lanes: What each lane did.
        found: In order of time.
        archive: Behaviours met, if an archive was kept.
    """

    folder: Path
    controller: str
    motion: str
    seed: int
    units: int
    worlds: int
    steps: int
    seconds: float
    status: str = ""
    verdicts: dict[str, int] = field(default_factory=dict)
    met: dict[str, int] = field(default_factory=dict)
    known: dict[str, int] = field(default_factory=dict)
    lanes: list[Lane] = field(default_factory=list)
    found: list[Find] = field(default_factory=list)
    archive: Archive | None = None


def read_summary(folder: Path) -> Summary | None:
    """The summary of the campaign whose folder this is; ``None`` if there is none.

    Raises:
        FormatError: If it cannot be read, or is no summary of version 1.
    """
    path = folder / MEMORY / _FILE
    if not path.is_file():
        return None
    text = read_text(path)
    try:
        return _summary(folder, _Reader(json.loads(text)))
    except (ValueError, OverflowError, RecursionError) as error:
        raise FormatError(
            "invalid-summary",
            "no summary of a campaign: {reason}",
            "let the campaign write it again, or delete it to do without",
            reason=str(error),
            source=str(path),
        ) from error


class _Fault(ValueError):
    """Something in the summary that is not as it must be."""


class _Reader:
    """A JSON object whose values are asked for by name and kind."""

    def __init__(self, values: object) -> None:
        if not isinstance(values, dict):
            raise _Fault("an object is wanted")
        self._values: dict[str, Any] = values

    def whole(self, name: str) -> int:
        value = self._values.get(name)
        if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value < 2**64:
            raise _Fault(f"{name!r} is no whole number from 0")
        return value

    def number(self, name: str) -> float:
        return _number(self._values.get(name), name)

    def text(self, name: str) -> str:
        value = self._values.get(name)
        if not isinstance(value, str) or not value:
            raise _Fault(f"{name!r} is no text, or empty")
        return value

    def one_of(self, name: str, known: tuple[str, ...]) -> str:
        value = self._values.get(name, "")
        if value not in known:
            raise _Fault(f"{name!r} is none of {', '.join(filter(None, known))}")
        return str(value)

    def counts(self, name: str) -> dict[str, int]:
        part = _Reader(self._values.get(name, {}))
        return {key: part.whole(key) for key in part._values}

    def rows(self, name: str) -> list[Any]:
        value = self._values.get(name, [])
        if not isinstance(value, list) or len(value) > _MOST_ROWS:
            raise _Fault(f"{name!r} is no list of at most {_MOST_ROWS} rows")
        return value

    def part(self, name: str) -> _Reader | None:
        value = self._values.get(name)
        return None if value is None else _Reader(value)


def _summary(folder: Path, said: _Reader) -> Summary:
    if said.whole("version") != _VERSION:
        raise _Fault(f"its version is {said.whole('version')}, and {_VERSION} is known")
    archive = said.part("archive")
    return Summary(
        folder=folder,
        controller=said.text("controller"),
        motion=said.text("motion"),
        seed=said.whole("seed"),
        units=said.whole("units"),
        worlds=said.whole("worlds"),
        steps=said.whole("steps"),
        seconds=said.number("seconds"),
        status=said.one_of("status", _STATUSES),
        verdicts=said.counts("verdicts"),
        met=said.counts("met"),
        known=said.counts("known"),
        lanes=[_lane(_Reader(row)) for row in said.rows("lanes")],
        found=[_find(_Reader(row)) for row in said.rows("found")],
        archive=None if archive is None else _archive(archive),
    )


def _lane(said: _Reader) -> Lane:
    numbers = (said.whole(name) for name in ("units", "worlds", "steps", "failures", "classes"))
    return Lane(said.text("lane"), *numbers)


def _find(said: _Reader) -> Find:
    return Find(
        unit=said.whole("unit"),
        lane=said.text("lane"),
        kind=said.text("class"),
        solid_cells=said.whole("solid_cells"),
        worlds=said.whole("worlds"),
        steps=said.whole("steps"),
        seconds=said.number("seconds"),
    )


def _archive(said: _Reader) -> Archive:
    axes = [_Reader(axis) for axis in said.rows("axes")]
    if len(axes) != 2:
        raise _Fault(f"'axes' has {len(axes)} axes, and two can be drawn")
    edges = [[_number(edge, "edges") for edge in axis.rows("edges")] for axis in axes]
    cells = [_cell(row, len(edges[0]) + 1, len(edges[1]) + 1) for row in said.rows("cells")]
    return Archive((axes[0].text("name"), axes[1].text("name")), (edges[0], edges[1]), cells)


def _cell(row: object, columns: int, rows: int) -> tuple[int, int, float, str]:
    if not isinstance(row, list) or len(row) != 4:
        raise _Fault("a cell of 'archive' is not [i, j, quality, verdict]")
    said = _Reader(dict(zip(("i", "j", "quality", "verdict"), row, strict=True)))
    i, j = said.whole("i"), said.whole("j")
    if i >= columns or j >= rows:
        raise _Fault(f"cell [{i}, {j}] of 'archive' lies outside its {columns} x {rows} cells")
    return i, j, said.number("quality"), said.text("verdict")


def _number(value: object, name: str) -> float:
    if not isinstance(value, int | float) or isinstance(value, bool) or not math.isfinite(value):
        raise _Fault(f"{name!r} is no finite number")
    return float(value)
