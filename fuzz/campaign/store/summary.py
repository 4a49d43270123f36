"""A campaign in numbers: ``.campaign/summary.json``, written and read here."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from worldgen.errors import FormatError
from worldgen.files.whole import read_text

__all__ = [
    "MEMORY",
    "OVERVIEW_FILE",
    "SUMMARY_FILE",
    "Archive",
    "BucketTotals",
    "StrategyTotals",
    "Summary",
    "read_summary",
]

# Name of the store's folder in a campaign's folder.
MEMORY = ".campaign"
SUMMARY_FILE = "summary.json"
OVERVIEW_FILE = "overview.json"  # written and read by fuzz.overview
_VERSION = 2
_MOST_ROWS = 100_000
_STATUSES = ("", "running", "done", "stopped", "failed")


@dataclass(frozen=True)
class StrategyTotals:
    """Totals of one strategy.

    ``classes`` counts those that it was the first to find.
    """

    strategy: str
    units: int
    worlds: int
    steps: int
    failures: int
    classes: int


@dataclass(frozen=True)
class BucketTotals:
    """A class found for the first time, or in a smaller world.

    ``worlds`` and the following fields are totals up to then.
    """

    unit: int
    strategy: str
    bucket: str
    solid_cells: int
    worlds: int
    steps: int
    seconds: float
    file: str = ""

    def row(self) -> dict[str, Any]:
        """Return its part of the file."""
        return {
            "unit": self.unit,
            "strategy": self.strategy,
            "class": self.bucket,
            "solid_cells": self.solid_cells,
            "worlds": self.worlds,
            "steps": self.steps,
            "seconds": round(self.seconds, 3),
            "file": self.file,
        }


@dataclass(frozen=True)
class Archive:
    """The behaviours found, by two numbers.

    Args:
        names: Names of the two numbers.
        edges: For each number, the values that separate neighbouring cells, one fewer than there
            are cells.
        cells: Index along each axis, quality and verdict of the best run of each kind.
    """

    names: tuple[str, str]
    edges: tuple[list[float], list[float]]
    cells: list[tuple[int, int, float, str]]

    def table(self) -> dict[str, Any]:
        """Return its part of the file."""
        axes = [
            {"name": name, "edges": edges}
            for name, edges in zip(self.names, self.edges, strict=True)
        ]
        return {"axes": axes, "cells": [list(cell) for cell in self.cells]}


@dataclass(frozen=True)
class Summary:
    """A campaign in numbers.

    Args:
        folder: Folder of its failures.
        controller: Name of the controller.
        motion: Name of the motion model.
        seed: Seed of the campaign.
        status: ``running``, ``done``, ``stopped`` or ``failed``; empty if an earlier version wrote
            it.
        units: Units of work done.
        worlds: Worlds tried.
        steps: Steps simulated.
        seconds: Time spent.
        verdicts: Counts of each verdict in screening.
        met: Counts of each class.
        known: The same, for known classes.
        strategies: Totals of each strategy.
        found: Finds, in order of time.
        archive: Behaviours found, if there is an archive.
        units_cut: Units cut short, not counted in ``units``.
        units_too_early: Units done before a cut one that they learn from, not counted in ``units``.
        times: Seconds of the last run, by part.
        controller_share: Share of the last run's work spent in a user's class or program.
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
    strategies: list[StrategyTotals] = field(default_factory=list)
    found: list[BucketTotals] = field(default_factory=list)
    archive: Archive | None = None
    units_cut: int = 0
    units_too_early: int = 0
    times: dict[str, float] = field(default_factory=dict)
    controller_share: float | None = None

    def table(self) -> dict[str, Any]:
        """Return the file's contents; ``docs/howto/campaigns.md`` describes each part."""
        share = (
            {}
            if self.controller_share is None
            else {"controller_share": round(self.controller_share, 3)}
        )
        return {
            "version": _VERSION,
            "status": self.status,
            "controller": self.controller,
            "motion": self.motion,
            "seed": self.seed,
            "units": self.units,
            "units_cut": self.units_cut,
            "units_too_early": self.units_too_early,
            "worlds": self.worlds,
            "steps": self.steps,
            "seconds": round(self.seconds, 3),
            "times": {name: round(seconds, 3) for name, seconds in self.times.items()},
            **share,
            "verdicts": self.verdicts,
            "met": self.met,
            "known": self.known,
            "strategies": [vars(strategy) for strategy in self.strategies],
            "found": [find.row() for find in self.found],
            "archive": None if self.archive is None else self.archive.table(),
        }


def read_summary(folder: Path) -> Summary | None:
    """Return the summary of the campaign in this folder; ``None`` if there is none.

    Raises:
        FormatError: If it cannot be read, or isn't a summary of version 1.
    """
    path = folder / MEMORY / SUMMARY_FILE
    if not path.is_file():
        return None
    text = read_text(path)
    try:
        return _summary(folder, _SummaryReader(json.loads(text)))
    except (ValueError, OverflowError, RecursionError) as error:
        raise FormatError(
            "invalid-summary",
            "not a campaign summary: {reason}",
            "let the campaign write it again, or delete it",
            reason=str(error),
            source=str(path),
        ) from error


class _Fault(ValueError):
    """Raised if a part of the summary is invalid."""


class _SummaryReader:
    """A JSON object whose values are read by name and type."""

    def __init__(self, values: object) -> None:
        if not isinstance(values, dict):
            raise _Fault("an object is required")
        self._values: dict[str, Any] = values

    def whole(self, name: str) -> int:
        value = self._values.get(name)
        if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value < 2**64:
            raise _Fault(f"{name!r} is not a whole number of 0 or more")
        return value

    def number(self, name: str) -> float:
        return _number(self._values.get(name), name)

    def whole_or_0(self, name: str) -> int:
        return self.whole(name) if name in self._values else 0

    def number_or_none(self, name: str) -> float | None:
        return self.number(name) if name in self._values else None

    def numbers(self, name: str) -> dict[str, float]:
        part = _SummaryReader(self._values.get(name, {}))
        return {key: part.number(key) for key in part._values}

    def text(self, name: str) -> str:
        value = self._values.get(name)
        if not isinstance(value, str) or not value:
            raise _Fault(f"{name!r} is not text, or empty")
        return value

    def text_or_empty(self, name: str) -> str:
        return self.text(name) if name in self._values else ""

    def one_of(self, name: str, known: tuple[str, ...]) -> str:
        value = self._values.get(name, "")
        if value not in known:
            raise _Fault(f"{name!r} is not one of {', '.join(filter(None, known))}")
        return str(value)

    def counts(self, name: str) -> dict[str, int]:
        part = _SummaryReader(self._values.get(name, {}))
        return {key: part.whole(key) for key in part._values}

    def rows(self, name: str) -> list[Any]:
        value = self._values.get(name, [])
        if not isinstance(value, list) or len(value) > _MOST_ROWS:
            raise _Fault(f"{name!r} is not a list of at most {_MOST_ROWS} rows")
        return value

    def part(self, name: str) -> _SummaryReader | None:
        value = self._values.get(name)
        return None if value is None else _SummaryReader(value)


def _summary(folder: Path, said: _SummaryReader) -> Summary:
    if said.whole("version") != _VERSION:
        raise _Fault(
            f"its version is {said.whole('version')}, but this program reads version {_VERSION}"
        )
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
        strategies=[_strategy(_SummaryReader(row)) for row in said.rows("strategies")],
        found=[_find(_SummaryReader(row)) for row in said.rows("found")],
        archive=None if archive is None else _archive(archive),
        units_cut=said.whole_or_0("units_cut"),
        units_too_early=said.whole_or_0("units_too_early"),
        times=said.numbers("times"),
        controller_share=said.number_or_none("controller_share"),
    )


def _strategy(said: _SummaryReader) -> StrategyTotals:
    numbers = (said.whole(name) for name in ("units", "worlds", "steps", "failures", "classes"))
    return StrategyTotals(said.text("strategy"), *numbers)


def _find(said: _SummaryReader) -> BucketTotals:
    return BucketTotals(
        unit=said.whole("unit"),
        strategy=said.text("strategy"),
        bucket=said.text("class"),
        solid_cells=said.whole("solid_cells"),
        worlds=said.whole("worlds"),
        steps=said.whole("steps"),
        seconds=said.number("seconds"),
        file=said.text_or_empty("file"),
    )


def _archive(said: _SummaryReader) -> Archive:
    axes = [_SummaryReader(axis) for axis in said.rows("axes")]
    if len(axes) != 2:
        raise _Fault(f"'axes' has {len(axes)} axes, but must have two")
    edges = [[_number(edge, "edges") for edge in axis.rows("edges")] for axis in axes]
    cells = [_cell(row, len(edges[0]) + 1, len(edges[1]) + 1) for row in said.rows("cells")]
    return Archive((axes[0].text("name"), axes[1].text("name")), (edges[0], edges[1]), cells)


def _cell(row: object, columns: int, rows: int) -> tuple[int, int, float, str]:
    if not isinstance(row, list) or len(row) != 4:
        raise _Fault("a cell of 'archive' is not [i, j, quality, verdict]")
    said = _SummaryReader(dict(zip(("i", "j", "quality", "verdict"), row, strict=True)))
    i = said.whole("i")
    j = said.whole("j")
    if i >= columns or j >= rows:
        raise _Fault(f"cell [{i}, {j}] of 'archive' is outside its {columns} x {rows} cells")
    return i, j, said.number("quality"), said.text("verdict")


def _number(value: object, name: str) -> float:
    if not isinstance(value, int | float) or isinstance(value, bool) or not math.isfinite(value):
        raise _Fault(f"{name!r} is not a finite number")
    return float(value)
