"""A campaign in numbers: ``.campaign/summary.json``, written and read here."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import msgspec

from fuzz.unit.answer import Answer, AnswerNumbers
from fuzz.unit.result import StrategyYield
from worldgen.files.json_file import JsonFile

# Name of the store's folder in a campaign's folder.
MEMORY = ".campaign"
CAMPAIGN_FILE = "campaign.json"
SUMMARY_FILE = "summary.json"
OVERVIEW_FILE = "overview.json"  # written and read by fuzz.overview
_MOST_ROWS = 100_000

_Count = Annotated[int, msgspec.Meta(ge=0, le=(1 << 63) - 1)]
_Name = Annotated[str, msgspec.Meta(min_length=1)]
_Rows = msgspec.Meta(max_length=_MOST_ROWS)


class Status(StrEnum):
    """A campaign's progress; unknown if an earlier version wrote its summary."""

    UNKNOWN = ""
    RUNNING = "running"
    DONE = "done"
    STOPPED = "stopped"
    FAILED = "failed"


class Find(msgspec.Struct, frozen=True, kw_only=True):
    """A new variant of a cause, or a failure that comes before the known one in order.

    ``worlds``, ``steps`` and ``seconds`` are the campaign's totals when the unit first met such a
    failure.
    """

    unit: _Count
    strategy: _Name
    cause: _Name
    solid_cells: _Count
    worlds: _Count
    steps: _Count
    seconds: float
    file: str = ""


class ArchiveAxis(msgspec.Struct, frozen=True):
    """One of the two numbers by which an archive sorts behaviours.

    Args:
        name: Name of the number.
        edges: The values that separate neighbouring cells, one fewer than there are cells.
    """

    name: _Name
    edges: Annotated[list[float], _Rows]


class Archive(msgspec.Struct, frozen=True):
    """The behaviours found, by two numbers.

    Args:
        axes: The two numbers.
        cells: Index along each axis, quality and verdict of the best run of each kind.
    """

    axes: tuple[ArchiveAxis, ArchiveAxis]
    cells: Annotated[list[tuple[_Count, _Count, float, _Name]], _Rows]

    def __post_init__(self) -> None:
        columns, rows = (len(axis.edges) + 1 for axis in self.axes)
        for i, j, _, _ in self.cells:
            if i >= columns or j >= rows:
                raise ValueError(f"cell [{i}, {j}] is outside the archive's {columns} x {rows}")

    def table(self) -> dict[str, Any]:
        """Return the archive as pages draw it."""
        return {
            "names": [axis.name for axis in self.axes],
            "edges": [axis.edges for axis in self.axes],
            "cells": self.cells,
        }


class Summary(msgspec.Struct, frozen=True, kw_only=True):
    """A campaign in numbers; ``docs/reference/campaign-files.md`` describes each part.

    Args:
        status: Its progress.
        answer: What it answers; not set while it runs.
        answer_reason: The reason, as a sentence without a full stop.
        answer_numbers: The numbers that decide the answer.
        controller: Name of the controller.
        motion: Name of the motion model.
        seed: Seed of the campaign.
        units: Units of work done.
        units_cut: Units cut short, not counted in ``units``.
        units_too_early: Units done before a cut one that they learn from, not counted in ``units``.
        worlds: Worlds tried.
        steps: Steps simulated.
        seconds: Time spent.
        times: Seconds of the last run, by part.
        controller_share: Share of the last run's work spent in a user's class or program.
        survives_reset: State that the controller was found to keep from run to run, in the last
            run of the campaign.
        differs_by: What makes equal runs of the controller differ, in the last run.
        unrun_lines: Lines of a user's class that never ran in any world: ``41-44 (recover)``.
        verdicts: Counts of each verdict in screening.
        tried: Worlds drawn on the user's map, by kind.
        met: Counts of each cause.
        known: The same, for known causes.
        strategies: Totals of each strategy.
        found: Finds, in order of time.
        archive: Behaviours found, if there is an archive.
    """

    status: Status = Status.UNKNOWN
    answer: Answer | msgspec.UnsetType = msgspec.UNSET
    answer_reason: str | msgspec.UnsetType = msgspec.UNSET
    answer_numbers: AnswerNumbers | msgspec.UnsetType = msgspec.UNSET
    controller: _Name
    motion: _Name
    seed: Annotated[int, msgspec.Meta(ge=0)]
    units: _Count
    units_cut: _Count = 0
    units_too_early: _Count = 0
    worlds: _Count
    steps: _Count
    seconds: float
    times: dict[str, float] = {}
    controller_share: float | msgspec.UnsetType = msgspec.UNSET
    survives_reset: list[_Name] | msgspec.UnsetType = msgspec.UNSET
    differs_by: list[_Name] | msgspec.UnsetType = msgspec.UNSET
    unrun_lines: list[_Name] | msgspec.UnsetType = msgspec.UNSET
    verdicts: dict[str, _Count] = {}
    tried: dict[str, _Count] = {}
    met: dict[str, _Count] = {}
    known: dict[str, _Count] = {}
    strategies: Annotated[list[StrategyYield], _Rows] = []
    found: Annotated[list[Find], _Rows] = []
    archive: Archive | None = None

    def __post_init__(self) -> None:
        if self.seed >> 64:
            raise ValueError("the seed is not below 2**64")


SUMMARY = JsonFile(
    Summary,
    version=3,
    code="invalid-summary",
    problem="not a campaign summary: {reason}",
    remedy="resume the campaign to write it again, or delete it",
)
"""The form of the file."""


def read_summary(folder: Path) -> Summary | None:
    """Return the summary of the campaign in this folder; ``None`` if there is none.

    Raises:
        FormatError: If it cannot be read, or isn't a summary of version 3.
    """
    return SUMMARY.find(folder / MEMORY / SUMMARY_FILE)
