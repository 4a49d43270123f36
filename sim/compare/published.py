"""Earlier tables to stand beside a comparison: reading them, and how far the two agree.

``docs/compare.md`` describes the file. Of its columns only world, controller and time are needed.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from sim.compare.comparison import Cell, Comparison, NamedWorld
from sim.scenario import Scenario
from sim.verdict import FAILURES, NEVER, Verdict
from worldgen.errors import FormatError, InvalidParameter

__all__ = [
    "Agreement",
    "Deviation",
    "PublishedRow",
    "agreement",
    "figures_of",
    "read_figures",
    "relative",
]

_NEEDED = ("world", "controller", "time")
_LONGEST = 1e9  # s
_MIDDLE = (0.025, 0.975)  # shares between which the middle 95 % of the seeds lie
_VERDICTS = (Verdict.REACHED, "never", *FAILURES)


@dataclass(frozen=True)
class PublishedRow:
    """One line of an earlier table.

    Args:
        world: Name of the world, as the table has it.
        controller: Its switches included, motion model and time step not.
        verdict: ``reached``, ``never``, or another of the vocabulary's.
        time: s; ``None`` if nothing arrived.
        motion: Motion model; empty if the table does not say.
        time_step: s; ``None`` if the table does not say.
        source: Where the figure comes from.
        note: What else the table says.
        folder: The worlds' folder that the table belongs to; empty for any.
    """

    world: str
    controller: str
    verdict: str
    time: float | None
    motion: str = ""
    time_step: float | None = None
    source: str = ""
    note: str = ""
    folder: str = ""

    @property
    def never(self) -> bool:
        """Whether it says that the robot drives on for ever."""
        return self.verdict in ("never", *NEVER)

    @property
    def rank_time(self) -> float:
        """The time to rank by, s; ``inf`` without arrival."""
        return self.time if self.verdict == Verdict.REACHED and self.time is not None else math.inf

    def is_of(self, world: NamedWorld) -> bool:
        """Whether the figure speaks of this world."""
        return self.world in (world.name, world.stem) and self.folder in ("", world.folder)


@dataclass(frozen=True)
class Deviation:
    """How far our time is from an earlier one: ``relative`` is (ours - theirs) / theirs.

    Times in s.
    """

    world: str
    label: str
    ours: float
    theirs: float
    relative: float


@dataclass(frozen=True)
class Agreement:
    """An earlier table beside ours.

    Args:
        figures: By (row, column); a cell may have several.
        rankings: Worlds in which the order of the controllers is the same, of how many with two or
            more figures.
        never: Cells in which both say never, of how many in which one does.
        within: Earlier times within the middle 95 % of our seeds, of how many.
        largest: The cell without chance whose time deviates most; of several figures the nearest
            counts.
    """

    figures: Mapping[tuple[int, int], tuple[PublishedRow, ...]]
    rankings: tuple[int, int]
    never: tuple[int, int]
    within: tuple[int, int]
    largest: Deviation | None


def read_figures(text: str, source: str, folder: str = "") -> tuple[PublishedRow, ...]:
    """Reads an earlier table.

    Args:
        text: The CSV file.
        source: Its name for messages.
        folder: The worlds' folder that it belongs to; empty for any.

    Raises:
        FormatError: If it is no such table, with the line at fault.
    """
    rows = csv.reader(io.StringIO(text, newline=""), strict=True)
    try:
        header = [name.strip() for name in next(rows, [])]
        missing = [name for name in _NEEDED if header.count(name) != 1]
        if missing:
            raise FormatError(
                "columns-missing",
                "the first line names no column {column!r}, or names it twice",
                "it needs {columns!l}",
                column=missing[0],
                columns=list(_NEEDED),
                line=1,
                source=source,
            )
        return tuple(
            _figure(header, row, rows.line_num, source, folder)
            for row in rows
            if any(map(str.strip, row))
        )
    except csv.Error as error:
        raise FormatError(
            "invalid-csv",
            "no CSV: {reason}",
            "write fields with commas between",
            reason=str(error),
            line=rows.line_num,
            source=source,
        ) from None


def _figure(
    header: Sequence[str], row: Sequence[str], line: int, source: str, folder: str
) -> PublishedRow:
    if len(row) != len(header):
        raise FormatError(
            "wrong-count",
            "{count} fields under a header of {wanted}",
            "give as many",
            count=len(row),
            wanted=len(header),
            line=line,
            source=source,
        )
    values = {name: text.strip() for name, text in zip(header, row, strict=True)}
    if not values["world"] or not values["controller"]:
        raise FormatError(
            "empty-name", "world or controller is empty", "name both", line=line, source=source
        )
    text = values["time"]
    verdict = values.get("verdict", "").lower()
    time = None if text.lower() in ("", "never") else _seconds("time", text, line, source)
    if not verdict:
        verdict = "never" if time is None else Verdict.REACHED
    if verdict not in _VERDICTS:
        raise FormatError(
            "unknown-name",
            "verdict {verdict!r} is none of {known!l}",
            verdict=verdict[:40],
            known=[str(one) for one in _VERDICTS],
            line=line,
            source=source,
        )
    if verdict == Verdict.REACHED and time is None:
        raise FormatError(
            "time-missing",
            "reached, but no time",
            "give seconds, or the verdict never",
            line=line,
            source=source,
        )
    if verdict != Verdict.REACHED:
        time = None  # of those few that arrived all the same
    controller, motion, step = _scenario(values["controller"], values.get("motion", ""))
    if values.get("time_step"):
        step = _seconds("time_step", values["time_step"], line, source)
    return PublishedRow(
        values["world"], controller, verdict, time, motion, step,
        values.get("source", ""), values.get("note", ""), folder,
    )  # fmt: skip


def _scenario(text: str, motion: str) -> tuple[str, str, float | None]:
    """Controller, motion model and time step, however the table spells them."""
    try:
        found = Scenario.parse(text, motion=motion, time_step=math.inf)
    except InvalidParameter:  # a controller of which we know nothing
        return text, motion, None
    step = found.time_step if math.isfinite(found.time_step) else None
    return found.label(found.motion, found.time_step), found.motion, step


def _seconds(name: str, text: str, line: int, source: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value <= _LONGEST:
        raise FormatError(
            "not-a-number",
            "{name} {value!r} is no number of seconds, above 0 and up to {most:g}",
            "write one, or never",
            name=name,
            value=text[:40],
            most=_LONGEST,
            line=line,
            source=source,
        )
    return value


def figures_of(
    figures: Iterable[PublishedRow], world: NamedWorld, scenario: Scenario
) -> tuple[PublishedRow, ...]:
    """The figures for one cell.

    Those of its motion model and time step, if there are any, else all.
    """
    name = scenario.label(scenario.motion, scenario.time_step)
    found = [figure for figure in figures if figure.controller == name and figure.is_of(world)]
    found = [figure for figure in found if figure.motion in ("", scenario.motion)] or found
    found = [figure for figure in found if figure.time_step in (None, scenario.time_step)] or found
    return tuple(found)


def relative(ours: float, theirs: float) -> float:
    """(ours - theirs) / theirs; ``inf`` where theirs is 0 and ours is not."""
    if theirs == 0.0:
        return 0.0 if ours == 0.0 else math.inf
    return (ours - theirs) / theirs


def agreement(comparison: Comparison, figures: Iterable[PublishedRow]) -> Agreement:
    """How far an earlier table and ours agree."""
    known = tuple(figures)
    found: dict[tuple[int, int], tuple[PublishedRow, ...]] = {}
    for row, world in enumerate(comparison.worlds):
        for column, cell in enumerate(comparison.cells[row]):
            own = figures_of(known, world, cell.scenario)
            if own:
                found[row, column] = own
    pairs = [(comparison.cells[row][column], own) for (row, column), own in found.items()]
    return Agreement(
        found, _rankings(comparison, found), _never(pairs), _within(pairs), _largest(pairs)
    )


_Pairs = Sequence[tuple[Cell, tuple[PublishedRow, ...]]]


def _rankings(
    comparison: Comparison, found: Mapping[tuple[int, int], tuple[PublishedRow, ...]]
) -> tuple[int, int]:
    same = total = 0
    for row, cells in enumerate(comparison.cells):
        columns = [column for column in range(len(cells)) if (row, column) in found]
        if len(columns) < 2:
            continue
        total += 1
        ours = _order([cells[column].rank_time for column in columns])
        same += ours == _order([_nearest(cells[column], found[row, column]) for column in columns])
    return same, total


def _nearest(cell: Cell, figures: Sequence[PublishedRow]) -> float:
    """The published time to rank by, s: of several the one nearest to ours."""
    ours = cell.rank_time
    times = sorted(figure.rank_time for figure in figures)
    return min(
        times,
        key=lambda time: (
            0.0 if time == ours else abs(time - ours) if math.isfinite(ours) else -time
        ),
    )


def _order(times: Sequence[float]) -> list[int]:
    """Each time's place, ties sharing one."""
    places = sorted(set(times))
    return [places.index(time) for time in times]


def _never(pairs: _Pairs) -> tuple[int, int]:
    either = [
        (cell.never, any(figure.never for figure in own))
        for cell, own in pairs
        if cell.never or any(figure.never for figure in own)
    ]
    return sum(ours and theirs for ours, theirs in either), len(either)


def _within(pairs: _Pairs) -> tuple[int, int]:
    low, high = _MIDDLE
    inside = [
        cell.share_until(figure.time) >= low and cell.share_before(figure.time) <= high
        for cell, own in pairs
        if cell.random
        for figure in own
        if figure.time is not None
    ]
    return sum(inside), len(inside)


def _largest(pairs: _Pairs) -> Deviation | None:
    deviations = []
    for cell, own in pairs:
        ours = cell.time
        theirs = [figure.time for figure in own if figure.time is not None]
        if cell.random or ours is None or not theirs:
            continue
        nearest = min(theirs, key=lambda time: abs(relative(ours, time)))
        deviations.append(Deviation(cell.world, cell.label, ours, nearest, relative(ours, nearest)))
    return max(deviations, key=lambda deviation: abs(deviation.relative), default=None)
